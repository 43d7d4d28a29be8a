//! The messages between the pool, which belongs to the manager's tick, and the threads of the store
//! and of the web API.

use std::sync::Arc;

use super::figures::Figures;
use super::order::{NewOrder, Order, OrderName};

/// Called once with the result of a request, from any thread.
pub(super) type Reply<T> = Box<dyn FnOnce(T) + Send>;

/// A request that the pool takes at its next tick.
pub(super) enum Request {
    /// Valid orders, which are in the store already, and the simulated time in seconds at which
    /// they came.
    Post { orders: Vec<NewOrder>, created_secs: f64 },
    /// The withdrawal of an order; `immediate` even if its robot has begun.
    Withdraw { name: OrderName, immediate: bool, reply: Reply<Result<(), WithdrawError>> },
}

/// The error of withdrawing an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WithdrawError {
    /// There is no such order, or it is closed and no longer in memory.
    #[error("there is no open order with this name")]
    Unknown,
    /// It is finished, failed or cancelled.
    #[error("the order is over")]
    Over,
    /// Its robot has handled its first stop.
    #[error(
        "its robot has handled the first stop already; withdraw it with `immediate=true` if its load may stay on the robot"
    )]
    Begun,
}

/// The state of a robot that has left the fleet.
pub(super) const ABSENT: &str = "absent";

/// A robot, as the web API shows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// The robot's id.
    pub robot: u32,
    /// Its state in a word: idle, driving, held …; `absent` if it has left the fleet.
    pub state: &'static str,
    /// Its activity, as the column `activity` has it.
    pub activity: &'static str,
    /// The node that it reached last, as an index in the world's nodes.
    pub node: Option<u32>,
    /// The id of the edge that it is on.
    pub edge: Option<u32>,
    /// Metres east and north of the world's origin.
    pub position: [f32; 2],
    /// Its battery's charge in per cent, if it has one.
    pub energy_level: Option<u8>,
    /// The name of its order.
    pub transport_order: Option<OrderName>,
}

/// The changes of a tick.
#[derive(Default)]
pub(super) struct Update {
    pub(super) now_secs: f64,
    pub(super) orders: Vec<Arc<Order>>,
    pub(super) vehicles: Vec<Vehicle>,
    /// From time to time.
    pub(super) figures: Option<Figures>,
    /// Called when the changes are kept.
    pub(super) done: Vec<Reply<()>>,
}
