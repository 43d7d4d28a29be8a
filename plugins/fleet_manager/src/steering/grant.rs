//! Extends bases, one robot after the other.

use super::{Command, Settings, Steering};
use crate::claims::Stretch;
use crate::roads::Leg;
use crate::traffic::{Blocker, Extension, LEAST, Robot, Traffic};

/// The excess length of an extension in metres. Without it, there would be an extension in every
/// cycle.
const CHUNK: f32 = 0.5;

impl Steering {
    /// Extends the bases of robots that come near to their ends; by default, the robot that was
    /// sent the longest ago comes first.
    pub(super) fn extend_bases(&mut self, passed: f32) {
        self.count_admitted(passed);
        let mut due: Vec<(f64, u32)> = Vec::new();
        for (robot, state) in (0..).zip(&self.robots) {
            let Some(state) = state else { continue };
            let may_grow = state.is_under_way() && !state.needs_route() && !state.permit.is_frozen;
            if may_grow && !self.is_base_whole(robot) {
                let planned = state.permit.precedence.unwrap_or(state.sent);
                due.push((self.precedence(robot, planned), robot));
            }
        }
        due.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, robot) in due {
            self.extend_base(robot);
        }
    }

    /// Extends the base of a robot as soon as there is room, also if it has enough by its own
    /// limits: it may brake more gently.
    pub fn lengthen_base(&mut self, robot: u32) {
        if let Some(state) = self.robot_mut(robot) {
            state.wants_base = true;
        }
    }

    /// Whether a robot's base reaches the end of its route.
    fn is_base_whole(&self, robot: u32) -> bool {
        let is_done =
            self.robots[robot as usize].as_ref().is_none_or(|state| state.horizon.is_empty());
        is_done
            && self
                .claims
                .end(robot)
                .is_none_or(|end| end.to >= self.roads.conflicts().length(end.track))
    }

    fn extend_base(&mut self, robot: u32) {
        // Most robots that stand wait for one that stands, too.
        if self.robot(robot).is_some_and(|state| state.speed == 0.0)
            && let Some(blocked) = self.still_blocked(robot)
        {
            return self.note(robot, &blocked);
        }
        let turned = self.turn_back(robot);
        let grants = self.counts.grants;
        self.try_to_extend(robot);
        // The producer doesn't know of the turn before the leg is released.
        if self.counts.grants == grants
            && let Some((leg, stretch)) = turned
            && let Some(state) = &mut self.robots[robot as usize]
        {
            state.horizon.push_front(leg);
            self.claims.seize(&self.roads, robot, state.class.footprint, stretch);
        }
    }

    fn try_to_extend(&mut self, robot: u32) {
        let Some(state) = &self.robots[robot as usize] else { return };
        let left = self.traffic().left(robot);
        // Most robots have enough at any speed: it isn't worth a look at their routes.
        if !state.wants_base && left >= self.wanted(state, state.class.max_speed) {
            return self.note(robot, &Extension::default());
        }
        let speed =
            state.horizon.front().map_or(state.speed, |&leg| self.roads.speed(&state.class, leg));
        let lacking = self.wanted(state, speed) - left;
        if !state.wants_base && lacking <= 0.0 {
            return self.note(robot, &Extension::default());
        }
        let is_on_roads = self.is_on_roads(robot);
        let may_enter = self.may_enter(robot);
        let mut extension = self.traffic().extension(robot, lacking.max(0.0) + CHUNK, may_enter);
        if !extension.stretches.is_empty() {
            let Some(blocker) = self.grant(robot, &extension) else {
                if !is_on_roads && self.is_on_roads(robot) {
                    self.admission.enter();
                }
                return self.note(robot, &Extension::default());
            };
            extension.blocker = Some(blocker);
        }
        self.note(robot, &extension);
        self.remember_blocker(robot, &extension);
    }

    /// The metres of base that a robot needs so as not to brake, at its speed or the one to come.
    fn wanted(&self, state: &Robot, speed: f32) -> f32 {
        state.braking_distance()
            + state.speed.max(speed) * self.settings.latency_secs
            + self.settings.lead
    }

    /// Returns the extension of a robot whose blocker hasn't moved: none.
    fn still_blocked(&self, robot: u32) -> Option<Extension> {
        let (blocker, version) = self.robot(robot)?.blocked_by?;
        let is_same = self.claims.version(blocker.robot) == version;
        is_same.then(|| Extension { blocker: Some(blocker), ..Extension::default() })
    }

    fn remember_blocker(&mut self, robot: u32, extension: &Extension) {
        let claims = &self.claims;
        if let Some(state) = &mut self.robots[robot as usize] {
            let blocker =
                extension.blocker.filter(|_| extension.stretches.is_empty() && state.speed == 0.0);
            state.blocked_by = blocker.map(|blocker| (blocker, claims.version(blocker.robot)));
        }
    }

    /// Claims an extension and commands it, unless that would close a ring of waiters or the planner
    /// doesn't admit it: then it returns the blocker that the robot waits for.
    fn grant(&mut self, robot: u32, extension: &Extension) -> Option<Blocker> {
        let claimed = self.claims.of(robot).len();
        let claimed_to = self.claims.end(robot).map_or(0.0, |end| end.to);
        for stretch in &extension.stretches {
            self.claims.grant(&self.roads, robot, *stretch);
        }
        let state = self.robots[robot as usize].as_mut()?;
        let entered: Vec<Leg> = state.horizon.drain(..extension.legs).collect();
        if let Some(blocker) = self.objection(robot, extension) {
            if let Some(state) = &mut self.robots[robot as usize] {
                for leg in entered.into_iter().rev() {
                    state.horizon.push_front(leg);
                }
            }
            self.claims.roll_back(&self.roads, robot, claimed, claimed_to);
            self.counts.guarded += 1;
            return Some(blocker);
        }
        if let Some(state) = &mut self.robots[robot as usize] {
            (state.is_fresh, state.wants_base) = (false, false);
            state.blocked_by = None;
            state.unentered = None;
        }
        self.counts.grants += 1;
        if let Some(Stretch { leg: Some(leg), to, .. }) = extension.stretches.last().copied() {
            let is_whole = to >= self.roads.edge(leg.edge()).length;
            self.commands.push(Command::Release {
                robot,
                leg,
                metres: if is_whole { f32::INFINITY } else { to },
            });
        }
        None
    }

    /// Returns the robot for which a robot has to wait instead of keeping the extension that it has
    /// just claimed.
    fn objection(&mut self, robot: u32, extension: &Extension) -> Option<Blocker> {
        if self.planner.guards_rings()
            && let Some(blocker) = self.closes_ring(robot)
        {
            return Some(blocker);
        }
        // Not `self.traffic()`, which would borrow the planner, too.
        let Self { roads, claims, robots, closures, now, .. } = self;
        let (closed, Settings { stub_guard, ends, .. }) = (&closures.legs, self.settings);
        let traffic = Traffic { roads, claims, robots, closed, stub_guard, ends, now: *now };
        let other = self.planner.objection(&traffic, robot)?;
        let edge = extension.stretches.iter().find_map(|stretch| stretch.leg).map_or(0, Leg::edge);
        Some(Blocker { robot: other, edge })
    }

    /// Records the blocker of a robot, and since when it waits.
    fn note(&mut self, robot: u32, extension: &Extension) {
        let now = self.now;
        let Some(state) = &mut self.robots[robot as usize] else { return };
        state.blocker = extension.blocker;
        state.is_held = extension.is_held;
        let stands = state.speed == 0.0 && (state.is_held || state.blocker.is_some());
        state.waiting_since = if stands { state.waiting_since.min(now) } else { f64::INFINITY };
    }

    /// Lets a robot that stands at the end of an edge, and goes back along it in the other gear,
    /// claim it as that leg. Returns the leg, and what it claimed before.
    fn turn_back(&mut self, robot: u32) -> Option<(Leg, Stretch)> {
        let state = self.robots[robot as usize].as_mut()?;
        let claim = self.claims.of(robot);
        if claim.len() != 1 || state.speed != 0.0 {
            return None;
        }
        let may_enter = state.permit.max_legs.min(state.permit.max_legs_outside) > 0;
        let (&next, &only) = (state.horizon.front().filter(|_| may_enter)?, claim.front()?);
        let stands = only.to - only.from < LEAST;
        let at_end = only.to >= self.roads.edge(next.edge()).length - LEAST;
        if !stands || !at_end || only.track != next.edge() || only.leg == Some(next) {
            return None;
        }
        state.horizon.pop_front();
        let length = self.roads.edge(next.edge()).length;
        let back =
            Stretch { leg: Some(next), from: length - only.to, to: length - only.to, ..only };
        self.claims.seize(&self.roads, robot, state.class.footprint, back);
        Some((next, only))
    }
}

/// The length of the longest ring that is found, in robots.
const LONGEST_RING: usize = 128;

impl Steering {
    /// Returns the blocker of a robot at the end of its base, if both are in a ring of robots that
    /// wait for each other.
    pub(super) fn closes_ring(&self, robot: u32) -> Option<Blocker> {
        let (mut current, mut first) = (robot, None);
        for _ in 0..LONGEST_RING {
            let extension = self.traffic().extension_later(current, 0.1);
            let blocker = extension.blocker.filter(|_| extension.stretches.is_empty())?;
            let first = *first.get_or_insert(blocker);
            if blocker.robot == robot {
                return Some(first);
            }
            let goes_on = self.robot(blocker.robot).is_some_and(|state| !state.horizon.is_empty());
            if !goes_on || blocker.robot == current {
                return None;
            }
            current = blocker.robot;
        }
        None
    }
}
