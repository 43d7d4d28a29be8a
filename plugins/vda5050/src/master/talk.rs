//! The talk with a vehicle: the order that it was told, what it made of it, and what to tell it
//! next. It knows neither brokers nor clocks.

mod hear;
mod say;

use super::orders::{Part, action};
use crate::message::{Action, ActionParameter, Order, State};

/// The time after which a message without an answer is sent again, in seconds.
const ANSWER_SECS: f64 = 2.0;
/// The number of times that a message is sent until the vehicle counts as one that doesn't answer.
const MOST_TRIES: u32 = 4;
/// The time after which a vehicle that has rejected an order gets another one, in seconds.
const RETRY_SECS: f64 = 10.0;

/// A message to a vehicle, without its header.
#[derive(Clone, Debug, PartialEq)]
pub enum Saying {
    /// An order, or an update of one.
    Order(Order),
    /// An action to be carried out at once.
    Instant(Action),
}

/// News from a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// It has rejected an order, for this reason.
    Rejected(String),
    /// It no longer has the order that it was told.
    OrderLost,
    /// It has stopped, as it was asked: it has no order.
    Cancelled(After),
    /// An action has failed: its kind, and the result.
    ActionFailed(String, String),
}

/// The next step after an order was cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// The course ends where the vehicle stops.
    End,
    /// The course goes on, by another order.
    GoOn,
}

/// The talk with a vehicle.
#[derive(Debug)]
pub struct Talk {
    /// The beginning of the ids of its orders and actions.
    prefix: String,
    /// Counts orders and actions.
    count: u32,
    told: Option<Told>,
    cancel: Option<Cancel>,
    /// Actions to carry out where the vehicle stands.
    jobs: Vec<Action>,
    /// The time of the last message about a pause, and about charging.
    pause_sent: f64,
    charge_sent: f64,
    /// The reason of the last rejection, and the time from which on it is tried again.
    rejection: Option<(String, f64)>,
}

/// The order that a vehicle was told.
#[derive(Debug)]
struct Told {
    part: Part,
    message: Order,
    has_horizon: bool,
    sent: f64,
    tries: u32,
    is_taken: bool,
}

/// A request to cancel the order.
#[derive(Debug)]
struct Cancel {
    /// The ids of the actions that asked for it: each time another one.
    ids: Vec<String>,
    after: After,
    sent: f64,
}

impl Talk {
    /// Begins. The ids of all orders and actions begin with `prefix`.
    pub fn new(prefix: String) -> Self {
        let (pause_sent, charge_sent) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        Self {
            prefix,
            count: 0,
            told: None,
            cancel: None,
            jobs: Vec::new(),
            pause_sent,
            charge_sent,
            rejection: None,
        }
    }

    fn next_id(&mut self) -> String {
        self.count += 1;
        format!("{}-{}", self.prefix, self.count)
    }

    /// Lets the vehicle carry out an action where it stands.
    pub fn add_job(&mut self, kind: &str, parameters: Vec<ActionParameter>) {
        let action = action(kind, self.next_id());
        self.jobs.push(Action { action_parameters: parameters, ..action });
    }

    /// Whether the vehicle has an action to carry out where it stands.
    pub fn has_jobs(&self) -> bool {
        !self.jobs.is_empty()
    }

    /// Forgets the order, as the vehicle has.
    pub fn forget(&mut self) {
        (self.told, self.cancel) = (None, None);
    }

    /// Whether the vehicle was told an order that it hasn't lost.
    pub fn has_order(&self) -> bool {
        self.told.is_some()
    }

    /// Whether the vehicle has taken its base up to the leg with a number.
    pub fn has_all(&self, base_end: u64) -> bool {
        self.told.as_ref().is_some_and(|told| told.is_taken && told.part.base_end >= base_end)
    }

    /// Whether the vehicle is to drop its order.
    pub fn is_cancelling(&self) -> bool {
        self.cancel.is_some()
    }

    /// Whether it doesn't answer.
    pub fn is_unanswered(&self) -> bool {
        self.told.as_ref().is_some_and(|told| !told.is_taken && told.tries >= MOST_TRIES)
    }

    /// The reason why it has rejected its order.
    pub fn rejection(&self) -> Option<&str> {
        self.rejection.as_ref().map(|(reason, _)| &**reason)
    }

    /// The number of the leg after the last node that a state says is reached, if the state is one
    /// of the order that the vehicle was told.
    pub fn number(&self, state: &State) -> Option<u64> {
        let told = self.told.as_ref()?;
        let is_of = told.part.order_id == state.order_id;
        is_of.then(|| told.part.start + u64::from(state.last_node_sequence_id) / 2)
    }

    /// Asks the vehicle to drop its order.
    pub fn cancel(&mut self, after: After) {
        if let Some(cancel) = &mut self.cancel {
            cancel.after = if after == After::End { after } else { cancel.after };
            return;
        }
        self.cancel = Some(Cancel { ids: Vec::new(), after, sent: f64::NEG_INFINITY });
    }
}

/// Whether a vehicle has an order that isn't done.
fn has_order(state: &State) -> bool {
    !state.node_states.is_empty()
}
