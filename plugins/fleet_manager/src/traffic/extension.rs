//! Extensions of a robot's base.

use std::collections::VecDeque;

use regatta_base::sweep::Span;

use super::{BaseEnds, Blocker, Traffic};
use crate::claims::Stretch;
use crate::roads::Leg;

/// The distance along a route within which an open place is looked for, in metres. If there is
/// none, robots may wait at nodes.
const OPEN_WITHIN: f32 = 12.0;
/// The least distance from the end of a leg of a base that doesn't end there, in metres.
const AT_END: f32 = 2e-3;
/// The shortest extension that is worth a command, in metres.
pub const LEAST: f32 = 0.05;

/// A way to extend a base.
#[derive(Clone, Debug, Default)]
pub struct Extension {
    /// The stretches to claim, in driving order; empty if nothing can be claimed.
    pub stretches: Vec<Stretch>,
    /// Legs of the horizon that become part of the base.
    pub legs: usize,
    /// The robot that is in the way of a longer one.
    pub blocker: Option<Blocker>,
    /// Whether it ends where the robot waits for admission to the roads.
    pub is_held: bool,
}

/// The places at which a base may end on a leg.
struct Ends<'a> {
    /// The leg after it.
    next: Option<&'a Leg>,
    /// Whether it may end at a siding.
    allows_sidings: bool,
    /// Whether it may end anywhere.
    anywhere: bool,
}

/// The best place so far to end a base at.
struct Place {
    stretches: usize,
    legs: usize,
    to: f32,
}

impl Traffic<'_> {
    /// Finds how far a base can be extended: to the first good place at least `wanted` metres on,
    /// or else to the last one before. Unless it `may_enter` the roads, it ends in the reservoir
    /// that the robot is in.
    pub fn extension(&self, robot: u32, wanted: f32, may_enter: bool) -> Extension {
        let legs = self
            .robot(robot)
            .map_or(0, |state| state.permit.max_legs.min(state.permit.max_legs_outside));
        self.extension_by(robot, legs, wanted, may_enter)
    }

    /// As [`extension`](Self::extension), for a robot that may enter the regions that it is kept
    /// out of now.
    pub(crate) fn extension_later(&self, robot: u32, wanted: f32) -> Extension {
        let legs = self.robot(robot).map_or(0, |state| state.permit.max_legs);
        self.extension_by(robot, legs, wanted, true)
    }

    fn extension_by(&self, robot: u32, legs: usize, wanted: f32, may_enter: bool) -> Extension {
        let Some(state) = self.robot(robot) else { return Extension::default() };
        if legs >= state.horizon.len() {
            return self.extension_along(robot, &state.horizon, wanted, may_enter);
        }
        let horizon = state.horizon.iter().take(legs).copied().collect();
        self.extension_along(robot, &horizon, wanted, may_enter)
    }

    pub(super) fn extension_along(
        &self,
        robot: u32,
        horizon: &VecDeque<Leg>,
        wanted: f32,
        may_enter: bool,
    ) -> Extension {
        let (Some(state), Some(&end)) = (self.robot(robot), self.claims.end(robot)) else {
            return Extension::default();
        };
        let Some(first) = end.leg else { return Extension::default() };
        if !may_enter && !self.roads.is_reservoir(first.edge()) {
            return Extension { is_held: true, ..Extension::default() };
        }
        let footprint = state.class.footprint;
        let allows_sidings = !self.has_open_place(footprint, horizon, first, end.to);
        let (mut stretches, mut best, mut blocker): (Vec<Stretch>, Option<Place>, _) =
            (Vec::new(), None, None);
        let (mut leg, mut from, mut so_far, mut ends_held) = (first, end.to, 0.0, false);
        for number in 0..=horizon.len() {
            let length = self.roads.edge(leg.edge()).length;
            let reach = self.claims.reach(
                self.roads,
                robot,
                footprint,
                leg.edge(),
                Some(leg),
                Span::new(from, length),
            );
            // A robot at the end of the leg is there already, even if another one stands at the end
            // of the opposite leg.
            let is_there = number == 0 && from >= length;
            let to = if is_there { length } else { reach.metres };
            if to < from {
                blocker = reach.blocker.map(|robot| Blocker { robot, edge: leg.edge() });
                break;
            }
            let next = horizon.get(number);
            if !is_there {
                stretches.push(Stretch { track: leg.edge(), leg: Some(leg), from, to });
            }
            let occupant = next.and_then(|&next| self.stub_occupant(robot, leg, next));
            let ends = Ends {
                next,
                allows_sidings: allows_sidings && occupant.is_none(),
                anywhere: state.permit.follows,
            };
            let reachable = Span::new(from, to);
            if let Some(place) = self.place(footprint, leg, reachable, wanted - so_far, &ends) {
                best = Some(Place { stretches: stretches.len(), legs: number, to: place });
                if so_far + place - from >= wanted {
                    break;
                }
            }
            if to < length {
                blocker = reach.blocker.map(|robot| Blocker { robot, edge: leg.edge() });
                break;
            }
            so_far += length - from;
            let Some(&next) = next else { break };
            if !may_enter && !self.roads.is_reservoir(next.edge()) {
                ends_held = true;
                break;
            }
            if let Some(occupant) = occupant {
                blocker = Some(Blocker { robot: occupant, edge: next.edge() });
                break;
            }
            if let Err(by) = self.pass_node(robot, leg, next, &mut stretches) {
                blocker = by.map(|robot| Blocker { robot, edge: next.edge() });
                break;
            }
            (leg, from) = (next, 0.0);
        }
        let (legs, kept, to) =
            best.map_or((0, 0, 0.0), |best| (best.legs, best.stretches, best.to));
        stretches.truncate(kept);
        if let Some(last) = stretches.last_mut() {
            last.to = to;
        }
        // A few millimetres don't count as an extension, unless they are the rest of an edge.
        let length = self.roads.conflicts().length(end.track);
        if let [only] = stretches.as_slice()
            && only.leg == end.leg
            && (only.to <= end.to || (only.to < end.to + LEAST && only.to < length))
        {
            stretches.clear();
        }
        Extension { stretches, legs, blocker, is_held: ends_held }
    }

    /// Returns the place on a leg to end a base at: the first good one at least `wanted` metres on,
    /// or else the last before.
    fn place(
        &self,
        footprint: usize,
        leg: Leg,
        Span { low: from, high: to }: Span,
        wanted: f32,
        ends: &Ends<'_>,
    ) -> Option<f32> {
        let length = self.roads.edge(leg.edge()).length;
        let stops = self.roads.stops(footprint);
        let at_end =
            to >= length && (ends.next.is_none() || (ends.allows_sidings && stops.is_siding(leg)));
        if self.ends == BaseEnds::Nodes {
            let is_open = stops.last_open(leg, length, length, length).is_some();
            return (at_end || (to >= length && (is_open || ends.anywhere))).then_some(length);
        }
        // The very start of a leg counts as the end of the one before it.
        let least = if from > 0.0 { from } else { LEAST.min(length) };
        let cap = (from + wanted).max(least).min(to);
        let further = stops.next_open(leg, length, cap).filter(|place| *place <= to);
        let place = match further.or(at_end.then_some(length)) {
            Some(place) => place,
            None if ends.anywhere => cap,
            None => stops.last_open(leg, length, from, cap)?,
        };
        // A base that ends too near to the end counts as whole for the producer: then the rest
        // could not be released.
        let place = if place < length { place.min(length - AT_END) } else { place };
        (place >= least).then_some(place)
    }

    /// Claims the place of a node where the robot turns on the spot. Fails, maybe because of a
    /// robot, if the next leg can't be entered.
    fn pass_node(
        &self,
        robot: u32,
        leg: Leg,
        next: Leg,
        stretches: &mut Vec<Stretch>,
    ) -> Result<(), Option<u32>> {
        let Some(state) = self.robot(robot) else { return Err(None) };
        // An edge is claimed once: a stretch that is given back behind the robot must not be ahead
        // of it, too.
        if self.claims.holds(robot, next.edge())
            || stretches.iter().any(|stretch| stretch.track == next.edge())
        {
            return Err(None);
        }
        if state.class.turns && self.roads.is_turn(leg, next) {
            let disc = Stretch::disc(self.roads, self.roads.end(leg));
            let (footprint, place) = (state.class.footprint, Span::new(0.0, 0.0));
            let reach = self.claims.reach(self.roads, robot, footprint, disc.track, None, place);
            if reach.blocker.is_some() {
                return Err(reach.blocker);
            }
            stretches.push(disc);
        }
        Ok(())
    }

    /// Whether there is an open place, or the goal, not far along a robot's route.
    fn has_open_place(
        &self,
        footprint: usize,
        horizon: &VecDeque<Leg>,
        first: Leg,
        from: f32,
    ) -> bool {
        let stops = self.roads.stops(footprint);
        let (mut leg, mut from, mut so_far) = (first, from + LEAST, 0.0);
        for next in horizon.iter().map(Some).chain([None]) {
            let length = self.roads.edge(leg.edge()).length;
            let least = if self.ends == BaseEnds::Nodes { length } else { from };
            if next.is_none() || stops.last_open(leg, length, least, length).is_some() {
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
}
