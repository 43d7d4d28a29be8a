//! A vehicle as a row of a frame.

use regatta_base::graph::Gear;
use regatta_plugin::event::EventKind;
use regatta_plugin::frame::RobotState;

use super::super::roads::Roads;
use super::{Vehicle, event};
use crate::message::State;

/// A vehicle in a frame. Positions are metres on the map of the layout's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Metres.
    pub position: [f64; 2],
    /// Radians.
    pub theta: f64,
    /// Metres per second.
    pub speed: f64,
    /// The index of the edge, and the metres from its origin.
    pub place: Option<(u32, f64)>,
    /// The state.
    pub state: RobotState,
}
impl Vehicle {
    /// Returns the vehicle as a row of a frame.
    pub fn row(&mut self, roads: &Roads) -> Option<Row> {
        let state = self.state.as_ref().filter(|_| !self.is_removed)?;
        let shown = self.robot_state(state, roads);
        let driving = matches!(shown, RobotState::Driving | RobotState::Held | RobotState::Stalled);
        let speed = self.speed(state, roads);
        let place = self.course.as_ref().map(|course| {
            let (leg, travelled) = course.place();
            let is_reverse = leg.gear == Gear::Reverse;
            let s = if is_reverse { roads.length(leg) - travelled } else { travelled };
            (leg.edge.0, s)
        });
        let node = roads.map().find_node(&state.last_node_id).map(|node| roads.node(node));
        let position = match (&self.position, node) {
            (Some(position), _) => [position.x, position.y],
            (None, Some(node)) => [node.x, node.y],
            (None, None) => [0.0; 2],
        };
        let row = Row {
            position,
            theta: self.position.as_ref().map_or(0.0, |position| position.theta),
            speed: if driving { speed } else { 0.0 },
            place,
            state: shown,
        };
        self.note_change(shown);
        Some(row)
    }

    fn speed(&self, state: &State, roads: &Roads) -> f64 {
        if !state.driving {
            return 0.0;
        }
        let told = self.velocity.and_then(|velocity| {
            let [vx, vy] = [velocity.vx?, velocity.vy.unwrap_or(0.0)];
            Some(vx.hypot(vy).copysign(vx))
        });
        let leg = self.course.as_ref().map(|course| course.place().0);
        told.unwrap_or_else(|| leg.map_or(0.0, |leg| roads.map().speed(leg)))
    }

    fn robot_state(&self, state: &State, roads: &Roads) -> RobotState {
        if self.trouble.is_some() {
            return RobotState::Broken;
        }
        let Some(course) = &self.course else { return RobotState::Faulted };
        if self.is_held {
            RobotState::Held
        } else if self.talk.has_jobs() {
            RobotState::Stalled
        } else if state.driving || course.may_drive(roads) || self.talk.is_cancelling() {
            RobotState::Driving
        } else if course.ahead().is_empty() {
            RobotState::Idle
        } else {
            RobotState::Waiting
        }
    }

    /// Notes the events of a change of state.
    fn note_change(&mut self, shown: RobotState) {
        let before = std::mem::replace(&mut self.shown, shown);
        let kind = match (before, shown) {
            (RobotState::Driving, RobotState::Idle) => EventKind::RouteDone,
            (RobotState::Driving, RobotState::Waiting) => EventKind::WaitingForRelease,
            (RobotState::Held, RobotState::Driving | RobotState::Waiting) => EventKind::Resumed,
            (RobotState::Driving | RobotState::Waiting, RobotState::Held) => EventKind::Held,
            _ => return,
        };
        self.events.push(event(kind, 0));
    }
}
