//! The talk with a vehicle: the order that it was told, what it made of it, and what to tell it
//! next. It knows neither brokers nor clocks.

use super::course::Course;
use super::orders::{Part, action};
use super::roads::Roads;
use crate::message::{
    Action, ActionParameter, ActionState, ActionStatus, BlockingType, Error, Order, State,
};

/// The time after which a message without an answer is sent again, in seconds.
const ANSWER_SECS: f64 = 2.0;
/// The number of times that a message is sent until the vehicle counts as one that doesn't answer.
const MOST_TRIES: u32 = 4;
/// The time after which a vehicle that has rejected an order gets another one, in seconds.
const RETRY_SECS: f64 = 10.0;
/// The types of errors about orders, in 2.x and in 3.0.
const REJECTIONS: [&str; 14] = [
    "validationError",
    "orderError",
    "orderUpdateError",
    "noRouteError",
    "VALIDATION_FAILURE",
    "INVALID_ORDER",
    "UNSUPPORTED_PARAMETER",
    "OTHER_ORDER_ACTIVE",
    "OUTDATED_ORDER_UPDATE",
    "SAME_ORDER_UPDATE_ID",
    "ORDER_UPDATE_FOLLOWING_CANCEL",
    "START_NODE_OUT_OF_RANGE",
    "NO_ROUTE_TO_TARGET",
    "INVALID_ORDER_ACTION",
];

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

/// What comes after an order was cancelled.
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
    jobs: Vec<Job>,
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

/// An action to carry out where the vehicle stands.
#[derive(Debug)]
struct Job {
    action: Action,
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
        self.jobs.push(Job { action: Action { action_parameters: parameters, ..action } });
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

    /// Takes a state.
    pub fn take(&mut self, state: &State, now: f64) -> Vec<News> {
        let mut news = Vec::new();
        self.take_jobs(state, &mut news);
        if self.cancel.as_ref().is_some_and(|cancel| cancel.is_done(state))
            && let Some(cancel) = self.cancel.take()
        {
            self.told = None;
            news.push(News::Cancelled(cancel.after));
            return news;
        }
        let Some(told) = &mut self.told else { return news };
        let is_of = told.part.order_id == state.order_id;
        if is_of && state.order_update_id >= told.part.update_id {
            if !told.is_taken {
                self.rejection = None;
            }
            told.is_taken = true;
            if state.node_states.is_empty() && told.is_unreached(state) {
                news.push(News::OrderLost);
            }
        } else if told.is_taken {
            news.push(News::OrderLost);
        } else if let Some(error) = state.errors.iter().find(|error| told.is_rejected_by(error)) {
            news.push(self.reject(error, state, now));
        }
        if news.contains(&News::OrderLost) {
            self.told = None;
        }
        news
    }

    fn reject(&mut self, error: &Error, state: &State, now: f64) -> News {
        let text = error.error_description.clone().unwrap_or_default();
        let reason = format!("{}: {text}", error.error_type);
        self.rejection = Some((reason.clone(), now + RETRY_SECS));
        self.told = None;
        // An action id stands for one action of one order.
        let id = self.next_id();
        if let Some(job) = self.jobs.first_mut() {
            job.action.action_id = id;
        }
        if has_order(state) {
            self.cancel(After::GoOn);
        }
        News::Rejected(reason)
    }

    /// Takes the ends of actions where the vehicle stands.
    fn take_jobs(&mut self, state: &State, news: &mut Vec<News>) {
        self.jobs.retain(|job| {
            let found = state.action_states.iter().find(|it| it.action_id == job.action.action_id);
            let Some(found) = found.filter(|it| it.action_status.is_over()) else { return true };
            if found.action_status == ActionStatus::Failed {
                let result = found.action_result.clone().unwrap_or_default();
                news.push(News::ActionFailed(job.action.action_type.clone(), result));
            }
            false
        });
    }

    /// Returns what to tell a vehicle that has sent this state. `wants_pause` says whether it is to
    /// stand.
    pub fn say(
        &mut self,
        state: &State,
        course: &Course,
        roads: &Roads,
        wants_pause: bool,
        now: f64,
    ) -> Option<Saying> {
        if self.told.is_none() && self.cancel.is_none() && has_order(state) {
            self.cancel(After::GoOn);
        }
        if self.cancel.is_some() {
            return self.say_cancel(now).map(Saying::Instant);
        }
        if state.paused.unwrap_or(false) != wants_pause && now - self.pause_sent >= ANSWER_SECS {
            self.pause_sent = now;
            let kind = if wants_pause { "startPause" } else { "stopPause" };
            return Some(Saying::Instant(self.instant(kind)));
        }
        if let Some(told) = self.told.as_mut().filter(|told| !told.is_taken) {
            return told.say_again(now).map(Saying::Order);
        }
        if self.rejection.as_ref().is_some_and(|(_, retry_at)| now < *retry_at) {
            return None;
        }
        self.say_order(state, course, roads, now)
    }

    /// An action to be carried out at once.
    pub fn instant(&mut self, kind: &str) -> Action {
        let id = self.next_id();
        Action { blocking_type: BlockingType::None, ..action(kind, id) }
    }

    fn say_cancel(&mut self, now: f64) -> Option<Action> {
        if self.cancel.as_ref().is_none_or(|cancel| now - cancel.sent < ANSWER_SECS) {
            return None;
        }
        let action = self.instant("cancelOrder");
        if let Some(cancel) = &mut self.cancel {
            cancel.sent = now;
            cancel.ids.push(action.action_id.clone());
        }
        Some(action)
    }

    fn say_order(
        &mut self,
        state: &State,
        course: &Course,
        roads: &Roads,
        now: f64,
    ) -> Option<Saying> {
        let (first, base_end) = (course.first(roads), course.base_end(roads));
        let is_done = self.told.as_ref().is_none_or(|_| is_done(state));
        if let Some(told) = self.told.as_ref().filter(|_| !is_done) {
            let is_longer = base_end > told.part.base_end;
            // Without legs ahead, the horizon that the vehicle knows is none any more.
            let is_stale = told.has_horizon
                && course.leg(told.part.base_end).is_none()
                && first == told.part.base_end;
            if !is_longer && !is_stale {
                return None;
            }
            // An order of one node is continued from there, by the name that it had.
            let is_one_node = told.part.base_end == told.part.start;
            let part = Part {
                update_id: told.part.update_id + 1,
                from: told.part.base_end,
                base_end: base_end.max(told.part.base_end),
                action: None,
                first_id: told.part.first_id.clone().filter(|_| is_one_node),
                deviation: None,
                ..told.part.clone()
            };
            return Some(self.tell(part, course, roads, now));
        }
        let action = self.jobs.first().map(|job| job.action.clone());
        if base_end <= first && action.is_none() {
            return None;
        }
        if action.is_none() && state.power_supply.charging && self.stops_charging(now) {
            return Some(Saying::Instant(self.instant("stopCharging")));
        }
        let base_end = if action.is_some() { first } else { base_end };
        let order_id = self.next_id();
        let part = Part {
            order_id,
            update_id: 0,
            start: first,
            from: first,
            base_end,
            action,
            first_id: first_id(state, course, roads),
            deviation: deviation(state, course, roads),
        };
        Some(self.tell(part, course, roads, now))
    }

    /// Whether the vehicle is to be asked to stop charging, before it drives: once.
    fn stops_charging(&mut self, now: f64) -> bool {
        let is_first = now - self.charge_sent > RETRY_SECS;
        if is_first {
            self.charge_sent = now;
        }
        is_first
    }

    fn tell(&mut self, part: Part, course: &Course, roads: &Roads, now: f64) -> Saying {
        let (message, has_horizon) = part.order(course, roads);
        let (sent, tries, is_taken) = (now, 1, false);
        self.told =
            Some(Told { part, message: message.clone(), has_horizon, sent, tries, is_taken });
        Saying::Order(message)
    }
}

impl Told {
    /// Returns the message again, if it is time.
    fn say_again(&mut self, now: f64) -> Option<Order> {
        let patience = if self.tries < MOST_TRIES { ANSWER_SECS } else { RETRY_SECS };
        (now - self.sent >= patience).then(|| {
            (self.sent, self.tries) = (now, self.tries + 1);
            self.message.clone()
        })
    }

    /// Whether the base isn't driven to its end.
    fn is_unreached(&self, state: &State) -> bool {
        self.part.start + u64::from(state.last_node_sequence_id) / 2 < self.part.base_end
    }

    /// Whether an error is about this order.
    fn is_rejected_by(&self, error: &Error) -> bool {
        let value = |key: &str| {
            let found = error.error_references.iter().find(|it| it.reference_key == key);
            found.map(|reference| reference.reference_value.as_str())
        };
        let is_update =
            value("orderUpdateId").is_none_or(|update| update == self.part.update_id.to_string());
        let is_order = value("orderId").map_or_else(
            || REJECTIONS.contains(&error.error_type.as_str()) && self.tries == 1,
            |order| order == self.part.order_id,
        );
        is_order && is_update
    }
}

impl Cancel {
    /// Whether the vehicle has stopped, or had no order.
    fn is_done(&self, state: &State) -> bool {
        let has_stopped = !state.driving && state.node_states.is_empty();
        let mut found = self.ids.iter().filter_map(|id| find_action(state, id));
        found.any(|action| match action.action_status {
            ActionStatus::Failed => true,
            ActionStatus::Finished => has_stopped,
            _ => false,
        })
    }
}

fn find_action<'a>(state: &'a State, id: &str) -> Option<&'a ActionState> {
    let instant = state.instant_action_states.iter().flatten();
    state.action_states.iter().chain(instant).find(|action| action.action_id == id)
}

/// Whether a vehicle has an order that isn't done.
fn has_order(state: &State) -> bool {
    !state.node_states.is_empty()
}

/// Whether a vehicle has done its order.
fn is_done(state: &State) -> bool {
    let is_over = |action: &ActionState| action.action_status.is_over();
    state.node_states.is_empty() && !state.driving && state.action_states.iter().all(is_over)
}

/// The id by which the vehicle knows the node where it is, if that is the first node of its course.
fn first_id(state: &State, course: &Course, roads: &Roads) -> Option<String> {
    let node = roads.map().find_node(&state.last_node_id)?;
    (node == first_node(course, roads)).then(|| state.last_node_id.clone())
}

/// The node where the next order begins.
fn first_node(course: &Course, roads: &Roads) -> u32 {
    let leg = course.place().0;
    if course.is_at_end(roads) { roads.end(leg) } else { roads.start(leg) }
}

/// The metres from the first node within which a vehicle may be that stands within an edge.
fn deviation(state: &State, course: &Course, roads: &Roads) -> Option<f64> {
    /// The metres beyond its distance.
    const MARGIN: f64 = 0.5;
    if course.is_at_end(roads) {
        return None;
    }
    let node = roads.node(first_node(course, roads));
    let position = state.mobile_robot_position.as_ref()?;
    Some((position.x - node.x).hypot(position.y - node.y) + MARGIN)
}
