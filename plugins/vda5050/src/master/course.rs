//! The course of a robot: where it is, and the legs ahead of it, as commands make them.
//!
//! Legs are counted from the first one that the robot was given, so that orders and states refer to
//! them by their numbers.

use std::collections::VecDeque;

use regatta_base::graph::Leg;
use regatta_plugin::event::Refusal;

use super::roads::Roads;

/// The distance from the end of a leg at which it counts as driven, in metres.
const AT_END: f64 = 2e-3;

/// A leg ahead of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The leg.
    pub leg: Leg,
    /// Whether it belongs to the base.
    pub released: bool,
}

/// A refused command: the reason, and the id that it named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The reason.
    pub reason: Refusal,
    /// The id.
    pub id: u32,
}

/// The course of a robot.
#[derive(Clone, Debug)]
pub struct Course {
    /// The leg that it is on.
    leg: Leg,
    /// Metres from where that leg is entered.
    travelled: f64,
    /// Whether the rest of that leg belongs to the base.
    rest: bool,
    /// The legs after it.
    ahead: VecDeque<Step>,
    /// The number of the first leg ahead.
    next: u64,
}

impl Course {
    /// Begins where a robot stands.
    pub fn at(leg: Leg, travelled: f64) -> Self {
        Self { leg, travelled, rest: false, ahead: VecDeque::new(), next: 1 }
    }

    /// The leg that the robot is on, and the metres from where it is entered.
    pub fn place(&self) -> (Leg, f64) {
        (self.leg, self.travelled)
    }

    /// The legs ahead.
    pub fn ahead(&self) -> &VecDeque<Step> {
        &self.ahead
    }

    /// The number of the leg that the robot drives, or drives next.
    pub fn first(&self, roads: &Roads) -> u64 {
        if self.is_at_end(roads) { self.next } else { self.next - 1 }
    }

    /// The number of the leg after the base.
    pub fn base_end(&self, roads: &Roads) -> u64 {
        match self.released() {
            0 if !self.rest && !self.is_at_end(roads) => self.next - 1,
            released => self.next + released as u64,
        }
    }

    /// The leg with a number, if it is still there.
    pub fn leg(&self, number: u64) -> Option<Leg> {
        match number.checked_sub(self.next) {
            Some(place) => self.ahead.get(place as usize).map(|step| step.leg),
            None => (number + 1 == self.next).then_some(self.leg),
        }
    }

    /// Whether the leg that the robot is on is driven to its end.
    pub fn is_at_end(&self, roads: &Roads) -> bool {
        self.travelled >= roads.length(self.leg) - AT_END
    }

    /// Whether the robot may drive on.
    pub fn may_drive(&self, roads: &Roads) -> bool {
        self.base_end(roads) > self.first(roads)
    }

    /// Whether a leg ahead is released.
    pub fn has_base_ahead(&self) -> bool {
        self.released() > 0
    }

    /// The number of released legs ahead.
    fn released(&self) -> usize {
        self.ahead.iter().take_while(|step| step.released).count()
    }

    /// The node at the end of the base, where further legs begin.
    fn end_node(&self, roads: &Roads) -> u32 {
        let last = self.released().checked_sub(1).map_or(self.leg, |last| self.ahead[last].leg);
        roads.end(last)
    }

    /// Replaces the horizon by legs. The first ones may be released.
    pub fn extend(&mut self, legs: &[Step], roads: &Roads) -> Result<(), Refused> {
        let refused = |reason, leg: Leg| Refused { reason, id: roads.edge(leg).number };
        let mut at = self.end_node(roads);
        for Step { leg, .. } in legs {
            if roads.start(*leg) != at {
                return Err(refused(Refusal::NotConnected, *leg));
            }
            if !roads.is_drivable(*leg) {
                return Err(refused(Refusal::NoReverse, *leg));
            }
            at = roads.end(*leg);
        }
        let is_mixed = legs.windows(2).any(|pair| pair[1].released && !pair[0].released);
        if legs.is_empty() || is_mixed {
            return Err(Refused { reason: Refusal::MalformedRoute, id: 0 });
        }
        self.rest |= legs[0].released;
        self.drop_horizon();
        self.ahead.extend(legs);
        Ok(())
    }

    /// Releases legs up to one, of which `metres` are released: nothing of it if that isn't all,
    /// since vehicles stop at nodes only.
    pub fn release(&mut self, leg: Leg, metres: f64, roads: &Roads) -> Result<(), Refused> {
        let is_whole = metres >= roads.length(leg) - AT_END;
        let released = self.released();
        if released == 0 && self.leg == leg && !self.rest && !self.is_at_end(roads) {
            self.rest = is_whole;
            return Ok(());
        }
        let found = self.ahead.iter().skip(released).position(|step| step.leg == leg);
        let Some(found) = found else {
            let is_there =
                self.leg == leg || self.ahead.iter().take(released).any(|step| step.leg == leg);
            let id = roads.edge(leg).number;
            return if is_there { Ok(()) } else { Err(Refused { reason: Refusal::NotAhead, id }) };
        };
        let count = released + found + usize::from(is_whole);
        self.ahead.iter_mut().take(count).for_each(|step| step.released = true);
        self.rest |= count > 0;
        Ok(())
    }

    /// Drops what isn't released.
    pub fn drop_horizon(&mut self) {
        let released = self.released();
        self.ahead.truncate(released);
    }

    /// Drops all legs ahead: the robot stays on the leg that it is on, and where it stands.
    pub fn drop_base(&mut self) {
        self.ahead.clear();
        self.rest = false;
    }

    /// Takes legs before a number as driven. Calls `reached` with the node at the end of each.
    pub fn finish(&mut self, number: u64, roads: &Roads, mut reached: impl FnMut(u32)) {
        if number >= self.next && !self.is_at_end(roads) {
            self.travelled = roads.length(self.leg);
            reached(roads.end(self.leg));
        }
        while self.next < number
            && let Some(step) = self.ahead.pop_front()
        {
            (self.leg, self.travelled, self.rest) = (step.leg, roads.length(step.leg), true);
            self.next += 1;
            reached(roads.end(step.leg));
        }
    }

    /// Takes the robot as being some metres on the leg with a number. It never goes back, and
    /// reaches no node by this.
    pub fn drive(&mut self, number: u64, travelled: f64, roads: &Roads) {
        if number == self.next
            && travelled > 0.0
            && let Some(step) = self.ahead.pop_front_if(|step| step.released)
        {
            (self.leg, self.travelled, self.rest) = (step.leg, 0.0, true);
            self.next += 1;
        }
        if number + 1 == self.next && !self.is_at_end(roads) {
            let most = roads.length(self.leg) - 2.0 * AT_END;
            self.travelled = travelled.min(most).max(self.travelled);
        }
    }
}
