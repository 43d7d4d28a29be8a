//! Extends bases: how far, and in which order.

use super::{Command, Steering};
use crate::claims::Stretch;
use crate::roads::Leg;

/// How far along a route to look for an open place, in metres. Where there is none, robots may wait at nodes.
const OPEN_WITHIN: f32 = 12.0;
/// The shortest extension that is worth an order, in metres.
const LEAST: f32 = 0.05;
/// How much longer than needed an extension is, in metres: otherwise there would be one in every cycle.
const CHUNK: f32 = 0.5;

/// A way to extend a base.
#[derive(Clone, Debug, Default)]
pub(super) struct Extension {
    /// What to claim, in driving order; empty if nothing can be claimed.
    pub stretches: Vec<Stretch>,
    /// Legs of the horizon that become part of the base.
    pub legs: usize,
    /// Who is in the way of more, and on which edge.
    pub blocker: Option<(u32, u32)>,
}

/// The best place so far to end a base at.
struct Place {
    stretches: usize,
    legs: usize,
    to: f32,
}

impl Steering {
    /// Extends the bases of robots that come near to their ends; who has waited the longest goes first.
    pub(super) fn extend_bases(&mut self, passed: f32) {
        let mut due: Vec<(f64, u32)> = Vec::new();
        for (robot, state) in (0..).zip(&self.robots) {
            let Some(state) = state else { continue };
            if state.goal.is_some() && !state.needs_route && !state.is_adopted && !self.is_base_whole(robot) {
                due.push((state.waiting_since, robot));
            }
        }
        due.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        due.into_iter().for_each(|(_, robot)| self.extend_base(robot, passed));
    }

    /// Whether a robot's base reaches the end of its route.
    fn is_base_whole(&self, robot: u32) -> bool {
        let is_done = self.robots[robot as usize].as_ref().is_none_or(|state| state.horizon.is_empty());
        is_done && self.claims.end(robot).is_none_or(|end| end.to >= self.roads.conflicts().length(end.track))
    }

    fn extend_base(&mut self, robot: u32, passed: f32) {
        self.turn_back(robot);
        let Some(state) = &self.robots[robot as usize] else { return };
        let speed = state.horizon.front().map_or(state.speed, |&leg| self.roads.speed(&state.class, leg));
        let wanted =
            state.braking_distance() + state.speed.max(speed) * self.settings.latency_secs + self.settings.lead;
        let left = self.left(robot);
        if left >= wanted {
            return self.note(robot, None, passed);
        }
        let extension = self.find_extension(robot, wanted - left + CHUNK);
        let is_granted = !extension.stretches.is_empty() && self.grant(robot, &extension);
        self.note(robot, extension.blocker.filter(|_| !is_granted), passed);
    }

    /// Claims an extension and orders it, unless that would close a ring of waiters.
    fn grant(&mut self, robot: u32, extension: &Extension) -> bool {
        let before = (self.claims.of(robot).len(), self.claims.end(robot).map_or(0.0, |end| end.to));
        for stretch in &extension.stretches {
            self.claims.grant(&self.roads, robot, *stretch);
        }
        let Some(state) = &mut self.robots[robot as usize] else { return false };
        let entered: Vec<Leg> = state.horizon.drain(..extension.legs).collect();
        if self.settings.ring_guard && self.closes_ring(robot) {
            if let Some(state) = &mut self.robots[robot as usize] {
                entered.into_iter().rev().for_each(|leg| state.horizon.push_front(leg));
            }
            self.claims.roll_back(&self.roads, robot, before.0, before.1);
            self.counts.guarded += 1;
            return false;
        }
        entered.iter().for_each(|leg| self.congestion.leave(leg.edge()));
        self.counts.grants += 1;
        if let Some(Stretch { leg: Some(leg), to, .. }) = extension.stretches.last().copied() {
            let is_whole = to >= self.roads.edge(leg.edge()).length;
            self.commands.push(Command::Release { robot, leg, metres: if is_whole { f32::INFINITY } else { to } });
        }
        true
    }

    /// Records who is in a robot's way, and the time that it loses.
    fn note(&mut self, robot: u32, blocker: Option<(u32, u32)>, passed: f32) {
        let now = self.now;
        let Some(state) = &mut self.robots[robot as usize] else { return };
        state.blocker = blocker.map(|(robot, _)| robot);
        let stands = state.speed == 0.0 && blocker.is_some();
        state.waiting_since = if stands { state.waiting_since.min(now) } else { f64::INFINITY };
        if let Some((_, edge)) = blocker.filter(|_| stands) {
            self.congestion.lose(edge, passed);
        }
    }

    /// Finds how far a base can be extended: to the first good place at least `wanted` metres on, or else to the last one
    /// before.
    pub(super) fn find_extension(&self, robot: u32, wanted: f32) -> Extension {
        let (Some(state), Some(&end)) = (&self.robots[robot as usize], self.claims.end(robot)) else {
            return Extension::default();
        };
        let Some(first) = end.leg else { return Extension::default() };
        let footprint = state.class.footprint;
        let allows_sidings = !self.has_open_place(robot, first, end.to);
        let (mut stretches, mut best, mut blocker): (Vec<Stretch>, Option<Place>, _) = (Vec::new(), None, None);
        let (mut leg, mut from, mut so_far) = (first, end.to, 0.0);
        for number in 0..=state.horizon.len() {
            let length = self.roads.edge(leg.edge()).length;
            let reach = self.claims.reach(&self.roads, robot, footprint, leg.edge(), Some(leg), [from, length]);
            let to = reach.metres;
            if to < from {
                blocker = reach.blocker.map(|blocker| (blocker, leg.edge()));
                break;
            }
            let next = state.horizon.get(number);
            stretches.push(Stretch { track: leg.edge(), leg: Some(leg), from, to });
            if let Some(place) = self.place(footprint, leg, [from, to], wanted - so_far, (next, allows_sidings)) {
                best = Some(Place { stretches: stretches.len(), legs: number, to: place });
                if so_far + place - from >= wanted {
                    break;
                }
            }
            if to < length {
                blocker = reach.blocker.map(|blocker| (blocker, leg.edge()));
                break;
            }
            so_far += length - from;
            let Some(&next) = next else { break };
            if let Err(by) = self.pass_node(robot, [leg, next], &mut stretches) {
                blocker = by.map(|by| (by, next.edge()));
                break;
            }
            (leg, from) = (next, 0.0);
        }
        let (legs, kept, to) = best.map_or((0, 0, 0.0), |best| (best.legs, best.stretches, best.to));
        stretches.truncate(kept);
        if let Some(last) = stretches.last_mut() {
            last.to = to;
        }
        // A few millimetres are no extension, unless they are the rest of an edge.
        let length = self.roads.conflicts().length(end.track);
        let is_tiny = |only: &Stretch| only.to <= end.to || (only.to < end.to + LEAST && only.to < length);
        if matches!(stretches.as_slice(), [only] if is_tiny(only)) {
            stretches.clear();
        }
        Extension { stretches, legs, blocker }
    }

    /// Returns the place on a leg to end a base at: the first good one at least `wanted` metres on, or else the last before.
    fn place(
        &self,
        footprint: usize,
        leg: Leg,
        [from, to]: [f32; 2],
        wanted: f32,
        (next, allows_sidings): (Option<&Leg>, bool),
    ) -> Option<f32> {
        let length = self.roads.edge(leg.edge()).length;
        let stops = self.roads.stops(footprint);
        let at_end = to >= length && (next.is_none() || (allows_sidings && stops.is_siding(leg)));
        // The very start of a leg counts as the end of the one before it.
        let least = if from > 0.0 { from } else { LEAST.min(length) };
        let cap = (from + wanted).max(least).min(to);
        let further = stops.next_open(leg, length, cap).filter(|place| *place <= to);
        let place = further.or(at_end.then_some(length)).or_else(|| stops.last_open(leg, length, from, cap));
        place.filter(|place| *place >= least)
    }

    /// Claims the place of a node where the robot turns on the spot. Fails, maybe because of a robot, if the next leg can't
    /// be entered.
    fn pass_node(&self, robot: u32, [leg, next]: [Leg; 2], stretches: &mut Vec<Stretch>) -> Result<(), Option<u32>> {
        let Some(state) = &self.robots[robot as usize] else { return Err(None) };
        // An edge is claimed once: what is given back behind the robot must not be ahead of it, too.
        if self.claims.holds(robot, next.edge()) || stretches.iter().any(|stretch| stretch.track == next.edge()) {
            return Err(None);
        }
        if state.class.turns && self.roads.is_turn(leg, next) {
            let disc = self.roads.disc(self.roads.end(leg));
            let reach = self.claims.reach(&self.roads, robot, state.class.footprint, disc, None, [0.0, 0.0]);
            if reach.blocker.is_some() {
                return Err(reach.blocker);
            }
            stretches.push(Stretch { track: disc, leg: None, from: 0.0, to: 0.0 });
        }
        Ok(())
    }

    /// Whether there is an open place, or the goal, not far along a robot's route.
    fn has_open_place(&self, robot: u32, first: Leg, from: f32) -> bool {
        let Some(state) = &self.robots[robot as usize] else { return false };
        let stops = self.roads.stops(state.class.footprint);
        let (mut leg, mut from, mut so_far) = (first, from + LEAST, 0.0);
        for next in state.horizon.iter().map(Some).chain([None]) {
            let length = self.roads.edge(leg.edge()).length;
            if next.is_none() || stops.last_open(leg, length, from, length).is_some() {
                return true;
            }
            so_far += length - from;
            if so_far > OPEN_WITHIN {
                return false;
            }
            if let Some(&next) = next {
                (leg, from) = (next, 0.0);
            }
        }
        false
    }

    /// Lets a robot that stands at the end of an edge, and goes back along it in the other gear, claim it as that leg.
    fn turn_back(&mut self, robot: u32) {
        let Some(state) = &mut self.robots[robot as usize] else { return };
        let claim = self.claims.of(robot);
        let (Some(&next), Some(&only)) = (state.horizon.front(), claim.front()) else { return };
        let stands = claim.len() == 1 && state.speed == 0.0 && only.to - only.from < LEAST;
        let at_end = only.to >= self.roads.edge(next.edge()).length - LEAST;
        if stands && at_end && only.track == next.edge() && only.leg != Some(next) {
            state.horizon.pop_front();
            self.congestion.leave(next.edge());
            let length = self.roads.edge(next.edge()).length;
            let back = Stretch { leg: Some(next), from: length - only.to, to: length - only.to, ..only };
            self.claims.seize(&self.roads, robot, state.class.footprint, back);
        }
    }
}
