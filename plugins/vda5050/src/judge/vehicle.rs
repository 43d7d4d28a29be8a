//! All that the judge knows about a vehicle.

use super::actions::{self, ANSWER, Actions};
use super::finding::{Finding, Notes, quoted};
use super::header::Headers;
use super::place::Footprint;
use super::route::{Extent, Orders, Showing};
use super::rule::Rule;
use super::{place, progress, rejection};
use crate::message::{Connection, ConnectionState, Factsheet, OperatingMode, State, Visualization};

/// Seconds within which a state has to follow another, in all versions.
const STATE_INTERVAL: f64 = 30.0;
/// Seconds that a state may be late on its way.
const DELAY: f64 = 1.0;
/// Seconds after the first state within which a connection message has to come.
const CONNECTION: f64 = 5.0;
/// Seconds that a vehicle may wait for its horizon.
const HORIZON: f64 = 60.0;

/// A vehicle, by what was seen of it.
#[derive(Debug, Default)]
pub(super) struct Vehicle {
    pub headers: Headers,
    pub link: Link,
    pub orders: Orders,
    pub actions: Actions,
    /// The last state, and when it came.
    pub state: Option<State>,
    pub state_time: f64,
    /// The size, by the factsheet.
    pub footprint: Option<Footprint>,
    /// The findings of the last state, which are told once.
    pub told: Vec<Finding>,
    first_state_time: Option<f64>,
    online_time: f64,
    /// The time since when it waits at the end of its base.
    waiting_since: Option<f64>,
    deadline: Deadline,
}

/// The connection of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Link {
    /// No message told it yet.
    #[default]
    Unknown,
    /// It was never told, and that is a finding already.
    Missing,
    /// It is there.
    Online,
    /// It was ended, or the vehicle sleeps.
    Offline,
    /// It was lost.
    Broken,
    /// It was ended or lost, and the vehicle has gone on: that is a finding already.
    Contradicted,
}

/// Whether the next state is late.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Deadline {
    #[default]
    Ahead,
    Missed,
}

impl Vehicle {
    /// Whether the vehicle has an order to carry out, by its last state.
    pub fn is_under_way(&self) -> bool {
        self.state.as_ref().is_some_and(|state| {
            let mut actions = state.action_states.iter();
            let is_order = !state.order_id.is_empty();
            let works = actions.any(|shown| {
                !shown.action_status.is_over() && !self.actions.is_instant(&shown.action_id)
            });
            !state.node_states.is_empty() || (is_order && works)
        })
    }

    /// Whether the vehicle has an order, or was sent one.
    pub fn has_order(&self) -> bool {
        self.is_under_way() || !self.orders.sent.is_empty()
    }

    /// Takes a connection message.
    pub fn take_connection(&mut self, message: &Connection, now: f64) {
        self.link = match message.connection_state {
            ConnectionState::Online => Link::Online,
            ConnectionState::Offline | ConnectionState::Hibernating => Link::Offline,
            ConnectionState::ConnectionBroken => Link::Broken,
        };
        self.online_time = now;
        self.deadline = Deadline::Ahead;
    }

    /// Takes a factsheet.
    pub fn take_factsheet(&mut self, message: &Factsheet) {
        let (length, width) =
            (message.physical_parameters.length, message.physical_parameters.width);
        self.footprint = Footprint::new(length, width);
    }

    /// Judges a message that a vehicle sends only while it is online.
    fn judge_link(&mut self, notes: &mut Notes<'_>) {
        if matches!(self.link, Link::Offline | Link::Broken) {
            let last = if self.link == Link::Offline { "OFFLINE" } else { "CONNECTIONBROKEN" };
            notes.add(Rule::OfflineGoesOn, format!("a message after {last}, without ONLINE"));
            self.link = Link::Contradicted;
        }
    }

    /// Judges and takes a position.
    pub fn take_visualization(&mut self, message: &Visualization, notes: &mut Notes<'_>) {
        self.judge_link(notes);
        if let Some(state) = &self.state {
            place::judge_visualization(message, state, notes);
        }
    }

    /// Judges and takes a state.
    pub fn take_state(&mut self, state: State, now: f64, notes: &mut Notes<'_>) {
        self.judge_link(notes);
        self.first_state_time.get_or_insert(now);
        let before = self.state.take();
        rejection::judge(self, &state, before.as_ref(), notes);
        let showing = self.orders.show(&state, before.as_ref());
        judge_showing(showing, &state, notes);
        self.actions.judge(&state, before.as_ref(), notes);
        self.actions.answer(&state);
        let clearing = self.clearing(&state);
        if let Some(route) = &self.orders.shown {
            let step = progress::Step { route, state: &state, before: before.as_ref(), clearing };
            progress::judge(&step, notes);
            place::judge_state(&step, notes);
            actions::judge_complete(route, &state, before.as_ref(), notes);
            if route.extent == Extent::Whole {
                self.actions.judge_known(route, &state, notes);
            }
        }
        progress::judge_driving(&state, before.as_ref(), notes);
        self.orders.forget_behind(state.last_node_sequence_id);
        self.note_waiting(&state, now);
        (self.state_time, self.deadline) = (now, Deadline::Ahead);
        self.state = Some(state);
    }

    /// Whether the order may be gone from the state: cancelled, or cleared by a mode.
    fn clearing(&self, state: &State) -> progress::Clearing {
        let is_manual = matches!(
            state.operating_mode,
            OperatingMode::Manual
                | OperatingMode::Service
                | OperatingMode::TeachIn
                | OperatingMode::Startup
        );
        match (self.orders.cancelling, is_manual) {
            (super::route::Cancelling::No, false) => progress::Clearing::No,
            _ => progress::Clearing::Allowed,
        }
    }

    fn note_waiting(&mut self, state: &State, now: f64) {
        let has_horizon_only = state.node_states.first().is_some_and(|node| !node.released);
        let is_waiting = has_horizon_only
            && !state.driving
            && !state.action_states.iter().any(|shown| !shown.action_status.is_over());
        match is_waiting {
            true => drop(self.waiting_since.get_or_insert(now)),
            false => self.waiting_since = None,
        }
    }

    /// Judges what should have come by now.
    pub fn watch(&mut self, now: f64, notes: &mut Notes<'_>) {
        self.actions.watch(now, notes);
        self.watch_orders(now, notes);
        self.watch_states(now, notes);
        let is_late = self.first_state_time.is_some_and(|first| now - first > CONNECTION);
        if self.link == Link::Unknown && is_late {
            let text = "states came, and no connection message".to_owned();
            notes.add(Rule::NeverOnline, text);
            self.link = Link::Missing;
        }
        if self.waiting_since.is_some_and(|since| now - since > HORIZON) {
            let text = format!("the vehicle waits for its horizon longer than {HORIZON} s");
            notes.add(Rule::HorizonNotReleased, text);
            self.waiting_since = Some(f64::INFINITY);
        }
    }

    fn watch_orders(&mut self, now: f64, notes: &mut Notes<'_>) {
        if matches!(self.link, Link::Offline | Link::Broken) {
            self.orders.sent.clear();
        }
        self.orders.sent.retain(|sent| {
            let is_late = now - sent.time > ANSWER;
            if is_late {
                let (name, update) = (quoted(&sent.order.order_id), sent.order.order_update_id);
                let text = format!("no state shows order {name}, update {update}, or rejects it");
                notes.add(Rule::OrderUnanswered, text);
            }
            !is_late
        });
    }

    fn watch_states(&mut self, now: f64, notes: &mut Notes<'_>) {
        let last = self.state_time.max(self.online_time);
        let is_late = now - last > STATE_INTERVAL + DELAY;
        if self.link == Link::Online && is_late && self.deadline == Deadline::Ahead {
            self.deadline = Deadline::Missed;
            notes.add(Rule::StateOverdue, format!("no state for {:.1} s", now - last));
        }
    }
}

fn judge_showing(showing: Showing, state: &State, notes: &mut Notes<'_>) {
    let (name, update) = (quoted(&state.order_id), state.order_update_id);
    match showing {
        Showing::Same | Showing::Taken | Showing::Unknown => {}
        Showing::NeverSent => {
            notes.add(Rule::OrderNeverSent, format!("order {name} was never sent"));
        }
        Showing::UpdateNeverSent => {
            let text = format!("update {update} of order {name} was never sent");
            notes.add(Rule::UpdateNeverSent, text);
        }
    }
}
