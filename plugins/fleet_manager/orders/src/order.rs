//! Transport orders: their content, state and history.

mod name;

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::storages::Lack;

#[cfg(feature = "http")]
pub(crate) use self::name::UNSEEN;
pub use self::name::{NameError, OrderName};

/// The number of an order within a run and its order log, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct OrderId(pub u64);

/// The action of a robot at a stop. It is parsed from its name, in any case. Clients of openTCS may
/// write `NOP` and `MOVE` for none, `Load cargo` and `Unload cargo`.
///
/// ```
/// use regatta_orders::Action;
///
/// assert_eq!("Load cargo".parse(), Ok(Action::Pick));
/// assert_eq!("PARK".parse(), Ok(Action::Park));
/// assert!("lift".parse::<Action>().is_err());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, EnumString)]
#[serde(rename_all = "lowercase")]
#[strum(ascii_case_insensitive, parse_err_ty = UnknownAction, parse_err_fn = unknown_action)]
pub enum Action {
    /// None: the robot only drives there.
    #[default]
    #[strum(serialize = "none", serialize = "nop", serialize = "move")]
    None,
    /// Pick a load up.
    #[strum(serialize = "pick", serialize = "load cargo")]
    Pick,
    /// Drop a load.
    #[strum(serialize = "drop", serialize = "unload cargo")]
    Drop,
    /// Charge.
    Charge,
    /// Park.
    Park,
}

impl Action {
    /// The name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Pick => "pick",
            Self::Drop => "drop",
            Self::Charge => "charge",
            Self::Park => "park",
        }
    }

    /// The names from which actions are parsed.
    #[cfg(feature = "http")]
    pub(crate) const NAMES: [&str; 9] =
        ["none", "nop", "move", "pick", "load cargo", "drop", "unload cargo", "charge", "park"];
}

/// The error of parsing an [`Action`].
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown action `{}`; use none, pick, drop, charge or park", .0.escape_debug())]
pub struct UnknownAction(String);

fn unknown_action(text: &str) -> UnknownAction {
    UnknownAction(text.to_owned())
}

impl<'de> Deserialize<'de> for Action {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

/// A place that a robot drives to, and its action there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Index in the world's nodes. At a storage it is that of [`Places`](crate::Places) until a
    /// place is chosen, which is before a robot can get the order.
    pub node: u32,
    /// The action of the robot.
    pub action: Action,
    /// The duration of the action, in seconds; finite and at least 0.
    pub dwell_secs: f64,
}

/// The valid content of an order: it has at least one stop, and all its times are finite. Checking
/// an [`OrderDraft`](crate::OrderDraft) makes it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewOrder {
    /// The unique name.
    pub name: OrderName,
    /// The stops, in their order; at least one.
    pub stops: Vec<Stop>,
    /// The priority; higher is first.
    pub priority: u8,
    /// No robot gets the order before this simulated time, in seconds.
    pub earliest_secs: f64,
    /// The simulated time, in seconds, at which the order should be finished.
    pub deadline_secs: Option<f64>,
    /// The only robot that may get the order; any may if absent.
    pub intended_robot: Option<u32>,
    /// The types of robots that may get the order, as indices of the world's robot types; any may if
    /// empty.
    pub robot_types: Vec<u32>,
}

/// The state of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum State {
    /// Its earliest start is still to come.
    Created,
    /// It waits for a robot.
    Waiting,
    /// This robot drives to its next stop.
    Travelling(u32),
    /// This robot is at its next stop.
    Handling(u32),
    /// This robot has handled all its stops.
    Finished(u32),
    /// A robot could not carry it out.
    Failed,
    /// A client has withdrawn it.
    Cancelled,
    /// No robot can reach its stops at present.
    Unroutable,
    /// It waits for a place of a storage.
    Unplaced,
}

impl State {
    /// The names of all states, in the order of an order's life.
    pub const NAMES: &[&str] = Self::VARIANTS;

    /// The name, in lower case.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether the state is the order's last one.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Finished(_) | Self::Failed | Self::Cancelled)
    }

    /// The robot that has the order, or has finished it.
    pub fn robot(self) -> Option<u32> {
        match self {
            Self::Travelling(robot) | Self::Handling(robot) | Self::Finished(robot) => Some(robot),
            _ => None,
        }
    }
}

/// A change of an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", rename_all_fields = "camelCase", tag = "event")]
#[expect(
    missing_docs,
    reason = "the fields are the same in all variants: a robot's id, a stop's index, the reason"
)]
pub enum Change {
    /// It came into the pool, with these seconds to its deadline. Its stops follow, as many events
    /// [`Stop`](Self::Stop).
    Created {
        priority: u8,
        stops: u32,
        /// The history of an order is shown beside its deadline.
        #[serde(skip)]
        due_secs: Option<f64>,
    },
    /// One of its stops; `node` is an index in the world's nodes. It isn't part of an order's
    /// history.
    Stop { stop: u32, node: u32, action: Action, dwell_secs: f64 },
    /// A robot got it.
    Assigned { robot: u32 },
    /// It was taken from a robot, and waits again.
    Withdrawn { robot: u32 },
    /// Its robot waits in the queue before a stop: at a place of it, or elsewhere until one is
    /// free.
    Queued { robot: u32, stop: u32 },
    /// Its robot came to a stop, where it waits for so long until it is served.
    Arrived {
        robot: u32,
        stop: u32,
        #[serde(skip)]
        wait_secs: f64,
    },
    /// Its robot has handled a stop.
    Handled { robot: u32, stop: u32 },
    /// All its stops are handled.
    Finished { robot: u32 },
    /// It can't be carried out.
    Failed { robot: Option<u32>, reason: String },
    /// A client has withdrawn it for good.
    Cancelled { robot: Option<u32>, reason: String },
    /// No robot can reach its stops, or a storage has no place for it; it waits until it is
    /// [reopened](Self::Reopened).
    Unroutable {
        reason: Unroutable,
        /// The storage that has no place.
        #[serde(skip)]
        lack: Option<Lack>,
    },
    /// Its stops can be reached again, or it has got its places.
    Reopened,
}

/// The reason for which no robot can carry an order out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, strum::Display)]
pub enum Unroutable {
    /// Edges are closed.
    #[serde(rename = "closed roads lead to its stop")]
    #[strum(to_string = "closed roads lead to its stop")]
    ClosedEdges,
    /// The layout has no way to a stop.
    #[serde(rename = "no way leads to its stop")]
    #[strum(to_string = "no way leads to its stop")]
    NoWay,
    /// The layout has no way from a stop to the next one.
    #[serde(rename = "no way leads from a stop to the next one")]
    #[strum(to_string = "no way leads from a stop to the next one")]
    NoWayOn,
    /// The fleet doesn't have the only robot that may get it.
    #[serde(rename = "its robot isn't in the fleet")]
    #[strum(to_string = "its robot isn't in the fleet")]
    NoRobot,
    /// The fleet has no robot of the types that may get it.
    #[serde(rename = "no robot of its types is in the fleet")]
    #[strum(to_string = "no robot of its types is in the fleet")]
    NoType,
    /// No robot's full battery lasts for twice the driving time, above the reserve.
    #[serde(rename = "no robot's full battery lasts for it, planned at twice the driving time")]
    #[strum(to_string = "no robot's full battery lasts for it, planned at twice the driving time")]
    Battery,
    /// A storage has no free place, or no full one.
    #[serde(rename = "its storage has no place for it")]
    #[strum(to_string = "its storage has no place for it")]
    NoPlace,
}

/// A change of an order at a time, for the order log.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderEvent {
    /// Simulated time in seconds.
    pub secs: f64,
    /// The order.
    pub id: OrderId,
    /// The change.
    pub change: Change,
}

/// A line of an order's history.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistoryEntry {
    /// Simulated time in seconds.
    #[serde(rename = "time")]
    pub secs: f64,
    /// The change.
    #[serde(flatten)]
    pub change: Change,
}

/// An order in the pool.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Order {
    /// The number within the run.
    pub id: OrderId,
    /// The order as it was given.
    pub content: NewOrder,
    /// The simulated time, in seconds, at which it came into the pool.
    pub created_secs: f64,
    /// The state.
    pub state: State,
    /// The number of handled stops, which is the index of the one that is next or being handled.
    pub handled_stops: usize,
    /// The reason for a failure, a cancellation or an unreachable stop; empty otherwise.
    pub reason: String,
    /// The changes of the order, the oldest first.
    pub history: Vec<HistoryEntry>,
}

impl Order {
    /// Returns an order without a robot, at the time when it comes.
    pub(super) fn new(id: OrderId, content: NewOrder, created_secs: f64) -> Self {
        Self {
            id,
            content,
            created_secs,
            state: State::Created,
            handled_stops: 0,
            reason: String::new(),
            history: Vec::new(),
        }
    }

    /// The simulated time, in seconds, from which on robots could have it.
    pub fn ready_secs(&self) -> f64 {
        self.created_secs.max(self.content.earliest_secs)
    }

    /// Whether it stays with its robot, because that robot has handled a stop of it.
    pub fn is_bound(&self) -> bool {
        self.handled_stops > 0
    }
}
