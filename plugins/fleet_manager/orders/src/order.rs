//! Transport orders: their content, state and history.

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantNames};

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
    /// Index in the world's nodes.
    pub node: u32,
    /// The action of the robot.
    pub action: Action,
    /// The duration of the action, in seconds; finite and at least 0.
    pub dwell_secs: f64,
}

/// The unique name of an order: 1 to [`MAX_CHARS`](Self::MAX_CHARS) characters without `/` and control
/// characters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct OrderName(String);

/// The error of parsing an [`OrderName`].
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// Empty or too long.
    #[error(
        "the name of an order has 1 to {max} characters, and this one has {0}",
        max = OrderName::MAX_CHARS
    )]
    Length(usize),
    /// It has an invalid character.
    #[error("the name `{}` has a `/` or a character that can't be seen", .0.escape_default())]
    Character(String),
    /// It would be another path in an address.
    #[error("the name `{}` has `..`, or is `.`", .0.escape_default())]
    Path(String),
    /// It begins with the prefix of generated orders.
    #[error(
        "invalid name `{0}`: names that begin with `{load}` or `{sent}` are reserved for generated \
         orders",
        load = OrderName::GENERATED,
        sent = OrderName::REQUESTED
    )]
    Reserved(String),
}

/// Characters that have no width, or turn the direction of others: with them, a name looks like
/// another one, or like other text.
pub(crate) const UNSEEN: [(char, char); 16] = [
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{200b}', '\u{200f}'),
    ('\u{2028}', '\u{202e}'),
    ('\u{2060}', '\u{206f}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
];

fn is_unseen(c: char) -> bool {
    UNSEEN.iter().any(|(first, last)| (*first..=*last).contains(&c))
}

impl OrderName {
    /// The largest number of characters of a name.
    pub const MAX_CHARS: usize = 128;
    /// The prefix of names that generators give.
    pub const GENERATED: &str = "load:";
    /// The prefix of the names of orders by which robots are sent somewhere on request.
    pub const REQUESTED: &str = "sent:";

    /// Parses a name that a user gives.
    ///
    /// # Errors
    /// [`NameError`] if it is empty, too long, has characters that names don't have, or belongs to
    /// generated orders.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        if [Self::GENERATED, Self::REQUESTED].into_iter().any(|prefix| text.starts_with(prefix)) {
            return Err(NameError::Reserved(text.to_owned()));
        }
        if text == "." || text.contains("..") {
            return Err(NameError::Path(text.to_owned()));
        }
        if text.contains(is_unseen) {
            return Err(NameError::Character(text.to_owned()));
        }
        Self::stored(text)
    }

    /// Parses the name of an order that exists.
    ///
    /// # Errors
    /// [`NameError`] as [`parse`](Self::parse), but names of generated orders are valid, and those
    /// that earlier versions kept: with `..`, or characters that can't be seen.
    pub fn stored(text: &str) -> Result<Self, NameError> {
        let length = text.chars().count();
        if length == 0 || length > Self::MAX_CHARS {
            return Err(NameError::Length(length));
        }
        if text.contains(|c: char| c.is_control() || c == '/') {
            return Err(NameError::Character(text.to_owned()));
        }
        Ok(Self(text.to_owned()))
    }

    /// Returns the name of the order with this number of a generator. From the second run of a
    /// store on it has the run's number, so that it is new.
    pub(super) fn generated(generator: &str, number: u64, run: u64) -> Self {
        match run {
            0 | 1 => Self(format!("{}{generator}-{number}", Self::GENERATED)),
            run => Self(format!("{}{run}:{generator}-{number}", Self::GENERATED)),
        }
    }

    /// The name of the order by which a robot is sent somewhere on request: unique in its run and
    /// among runs.
    pub(super) fn of_request(robot: u32, number: u64, run_id: u64) -> Self {
        Self(format!("{}{robot}-{number}-{run_id:08x}", Self::REQUESTED))
    }

    /// Whether it is the name of an order by which a robot is sent somewhere on request.
    pub(super) fn is_of_request(&self) -> bool {
        self.0.starts_with(Self::REQUESTED)
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl std::fmt::Display for OrderName {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(&self.0)
    }
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
    /// No robot can reach its stops; it waits until it is [reopened](Self::Reopened).
    Unroutable { reason: Unroutable },
    /// Its stops can be reached again.
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
    /// No robot's full battery lasts for it, above the reserve.
    #[serde(rename = "no robot's full battery lasts for it and the way to a charger")]
    #[strum(to_string = "no robot's full battery lasts for it and the way to a charger")]
    Battery,
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
