//! The channels between the book, which belongs to the manager's tick, and the threads of the store and of the web API.
//! Neither side waits for the other.

use std::sync::Arc;

use serde::Serialize;

use super::figures::Figures;
use super::order::{NewOrder, Order, OrderName};

/// Called once with the result of a request, from any thread.
pub(super) type Reply<T> = Box<dyn FnOnce(T) + Send>;

/// A request that the book takes at its next tick.
pub(super) enum Request {
    /// Valid orders, which are in the store already.
    Post(Vec<NewOrder>),
    /// The withdrawal of an order; `immediate` even if its robot has begun.
    Withdraw { name: OrderName, immediate: bool, reply: Reply<Result<(), WithdrawError>> },
}

/// Why an order can't be withdrawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WithdrawError {
    /// There is no such order, or it is over and forgotten.
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

/// A robot, as the web API shows it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Vehicle {
    /// The robot's id.
    #[serde(skip)]
    pub robot: u32,
    /// What it does, in a word: idle, driving, charging …
    pub state: &'static str,
    /// The node that it reached last, as an index in the world's nodes.
    #[serde(skip)]
    pub node: Option<u32>,
    /// The name of its order.
    pub transport_order: Option<OrderName>,
}

/// What a tick has changed.
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

/// Takes what the ticks have changed.
pub(super) trait Office: Send {
    /// Returns all requests since the last call.
    fn requests(&mut self) -> Vec<Request>;
    /// Passes an update on, without waiting.
    fn publish(&mut self, update: Update);
    /// Whether somebody reads the figures: they take time.
    fn wants_figures(&self) -> bool;
    /// Whether everything that was published is kept.
    fn is_saved(&self) -> bool;
    /// The address of the web API.
    fn address(&self) -> Option<std::net::SocketAddr>;
}
