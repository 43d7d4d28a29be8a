//! The threads beside the manager's tick, the store and the web API, and the messages between them
//! and the pool.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use glam::Vec2;

use super::figures::Figures;
use super::order::{NewOrder, Order, OrderName};
use super::store::Writer;
use super::web::Web;

/// The store and the web API of a pool, which run on threads of their own. Neither side waits for
/// the other, except in [`settle`](Self::settle).
pub(super) struct Threads {
    pub(super) requests: Receiver<Request>,
    // The web API ends before the store, which it uses.
    pub(super) web: Option<Web>,
    pub(super) store: Option<Writer>,
}

impl Threads {
    /// Returns all requests since the last call.
    pub(super) fn requests(&mut self) -> Vec<Request> {
        self.requests.try_iter().collect()
    }

    /// Passes an update on, without waiting.
    pub(super) fn publish(&mut self, mut update: Update) {
        let done = std::mem::take(&mut update.done);
        match &self.store {
            Some(store) => store.update(update.orders.clone(), done),
            None => {
                for reply in done {
                    reply(());
                }
            }
        }
        if let Some(web) = &self.web {
            web.publish(update);
        }
    }

    /// Whether the web API needs figures, which take time to compute.
    pub(super) fn wants_figures(&self) -> bool {
        self.web.is_some()
    }

    /// Waits until all published changes are in the store. Returns whether they are.
    pub(super) fn settle(&self) -> bool {
        self.store.as_ref().is_none_or(Writer::settle)
    }

    /// The address of the web API over TCP.
    pub(super) fn address(&self) -> Option<SocketAddr> {
        self.web.as_ref()?.address()
    }
}

/// The channels from the web API to the other threads.
pub(super) struct Channels {
    /// To the store, if there is one.
    pub(super) jobs: Option<Sender<Job>>,
    /// To the pool.
    pub(super) requests: Sender<Request>,
}

/// A job of the thread that writes to the store.
pub(crate) enum Job {
    /// New orders: all, or none.
    Insert { orders: Vec<NewOrder>, created_secs: f64, done: Reply<Result<(), InsertError>> },
    /// Orders as they are now.
    Update { orders: Vec<Arc<Order>>, done: Vec<Reply<()>> },
}

/// The error of storing new orders.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum InsertError {
    /// There has been an order with this name.
    #[error("there is an order `{0}` already")]
    Duplicate(OrderName),
    /// They couldn't be written.
    #[error("the order can't be kept: {0}")]
    Write(String),
}

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
        "its robot has handled the first stop already; withdraw it with `immediate=true` if its \
         load may stay on the robot"
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
    pub position: Vec2,
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
