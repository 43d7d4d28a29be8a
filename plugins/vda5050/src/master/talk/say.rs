//! The next message to a vehicle.

use super::super::course::Course;
use super::super::orders::{Part, action};
use super::super::roads::Roads;
use super::{ANSWER_SECS, After, MOST_TRIES, RETRY_SECS, Saying, Talk, Told, has_order};
use crate::message::{Action, ActionState, BlockingType, Order, State};

impl Talk {
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

    /// The next order, or the next update of the one that the vehicle has.
    fn say_order(
        &mut self,
        state: &State,
        course: &Course,
        roads: &Roads,
        now: f64,
    ) -> Option<Saying> {
        if let Some(told) = self.told.as_ref().filter(|_| !is_done(state)) {
            let part = told.update(course, roads)?;
            return Some(self.tell(part, course, roads, now));
        }
        if self.jobs.is_empty() && !course.may_drive(roads) {
            return None;
        }
        if self.jobs.is_empty() && state.power_supply.charging && self.stops_charging(now) {
            return Some(Saying::Instant(self.instant("stopCharging")));
        }
        let part = self.new_order(state, course, roads);
        Some(self.tell(part, course, roads, now))
    }

    /// The next order: an action where the vehicle stands, or the base of its course.
    fn new_order(&mut self, state: &State, course: &Course, roads: &Roads) -> Part {
        let first = course.first(roads);
        let action = self.jobs.first().cloned();
        Part {
            order_id: self.next_id(),
            update_id: 0,
            start: first,
            from: first,
            base_end: if action.is_some() { first } else { course.base_end(roads) },
            action,
            first_id: first_id(state, course, roads),
            deviation: deviation(state, course, roads),
        }
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
    /// The next update: a longer base, or no horizon where the course has none any more.
    fn update(&self, course: &Course, roads: &Roads) -> Option<Part> {
        let Part { base_end: told_end, start, .. } = self.part;
        let base_end = course.base_end(roads);
        let is_longer = base_end > told_end;
        let is_stale =
            self.has_horizon && course.leg(told_end).is_none() && course.first(roads) == told_end;
        // An order of one node is continued from there, by the name that it had.
        let is_one_node = told_end == start;
        (is_longer || is_stale).then(|| Part {
            update_id: self.part.update_id + 1,
            from: told_end,
            base_end: base_end.max(told_end),
            action: None,
            first_id: self.part.first_id.clone().filter(|_| is_one_node),
            deviation: None,
            ..self.part.clone()
        })
    }

    /// Returns the message again, if it is time.
    fn say_again(&mut self, now: f64) -> Option<Order> {
        let patience = if self.tries < MOST_TRIES { ANSWER_SECS } else { RETRY_SECS };
        (now - self.sent >= patience).then(|| {
            (self.sent, self.tries) = (now, self.tries + 1);
            self.message.clone()
        })
    }
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
