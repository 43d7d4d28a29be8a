//! The place of a vehicle on the roads.

use regatta_base::graph::Leg;

use super::super::course::Course;
use super::super::roads::{Roads, distance};
use super::super::trouble::Trouble;
use super::{Limits, Vehicle};

/// The distance from a node at which a vehicle that names it is there in any case, in metres.
const AT_NODE: f64 = 0.5;
/// The metres from a node up to which a vehicle counts as standing there.
const STILL_AT_NODE: f64 = 0.05;

impl Vehicle {
    /// Moves the robot along its course to where the vehicle is.
    pub(super) fn follow(&mut self, roads: &Roads) {
        let (Some(course), Some(state)) = (&mut self.course, &self.state) else { return };
        // A vehicle that a person drives isn't on its way, even if it is near it.
        if Trouble::of_state(state).is_some_and(|trouble| trouble.is_loose()) {
            return;
        }
        let Some(position) = &self.position else {
            self.off_way = 0.0;
            let told = self.talk.number(state).zip(state.distance_since_last_node);
            if let Some((number, metres)) = told {
                course.drive(number, metres, roads);
            }
            return;
        };
        let position = [position.x, position.y];
        let number = self.talk.number(state).unwrap_or_else(|| course.first(roads));
        if let Some(leg) = course.leg(number) {
            let travelled = roads.nearest_on(leg, position).travelled;
            if travelled > STILL_AT_NODE && course.base_end(roads) > number {
                course.drive(number, travelled, roads);
            }
        }
        self.off_way = off_way(course, position, roads);
    }

    /// Finds the place of a vehicle that isn't where its course says.
    pub(super) fn find_place(&mut self, roads: &Roads, limits: Limits) {
        let Some(state) = &self.state else { return };
        let is_fine = Trouble::of_state(state).is_none();
        let is_away = self.off_way > limits.tolerance || self.stands_elsewhere(roads, limits);
        if !is_fine || !is_away || state.driving {
            self.is_loose &= is_away || !is_fine;
            return;
        }
        let Some((leg, travelled)) = self.place(roads, limits) else { return };
        self.course = Some(Course::at(leg, travelled));
        self.talk.forget();
        (self.off_way, self.is_loose) = (0.0, false);
    }

    /// Whether a vehicle without an order stands elsewhere than where its course has it.
    fn stands_elsewhere(&self, roads: &Roads, limits: Limits) -> bool {
        let (Some(course), Some(position)) = (&self.course, &self.position) else {
            return self.course.is_none();
        };
        let (leg, travelled) = course.place();
        let (position, near) = ([position.x, position.y], AT_NODE.max(limits.tolerance));
        // A person may have driven it along its way: then it isn't astray.
        let is_apart = distance(roads.position(leg, travelled), position) > near;
        let is_past = !course.is_at_end(roads) && self.names(roads.end(leg), roads);
        !self.talk.has_order() && (is_apart || is_past)
    }

    /// Whether the vehicle tells that a node is its last one.
    fn names(&self, node: u32, roads: &Roads) -> bool {
        let named = self.state.as_ref().and_then(|it| roads.map().find_node(&it.last_node_id));
        named == Some(node)
    }

    /// The leg on which the vehicle is, and the metres from its start.
    fn place(&self, roads: &Roads, limits: Limits) -> Option<(Leg, f64)> {
        let state = self.state.as_ref()?;
        let node = roads.map().find_node(&state.last_node_id);
        let Some(position) = &self.position else { return roads.stance(node?) };
        let position = [position.x, position.y];
        let far = |node: u32| {
            let place = roads.node(node);
            distance([place.x, place.y], position)
        };
        if let Some(node) = node.filter(|node| far(*node) <= AT_NODE.max(limits.tolerance)) {
            return roads.stance(node);
        }
        let (leg, found) = roads.nearest_leg(position)?;
        (found.distance <= limits.tolerance).then_some((leg, found.travelled))
    }
}

/// Metres between a position and the way of a course near by: the leg that the robot is on, and the
/// next ones of its base.
fn off_way(course: &Course, position: [f64; 2], roads: &Roads) -> f64 {
    /// The legs after the first that a vehicle may have come to since its last state.
    const LEGS: usize = 3;
    let ahead = course.ahead().iter().take_while(|step| step.released).take(LEGS);
    let legs = core::iter::once(course.place().0).chain(ahead.map(|step| step.leg));
    legs.map(|leg| roads.nearest_on(leg, position).distance).fold(f64::INFINITY, f64::min)
}
