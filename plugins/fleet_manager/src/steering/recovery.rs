//! Recovery: takes rings of waiting robots apart.

use super::Steering;
use crate::planner::Search;
use crate::roads::Leg;

/// How long robots wait before a ring of them is taken apart, in seconds.
const PATIENCE_SECS: f64 = 3.0;

impl Steering {
    /// Finds rings of robots that wait for each other, and sends one of each another way.
    pub(super) fn recover(&mut self) {
        if !self.settings.recovery {
            return;
        }
        let mut mark = vec![0_u32; self.robots.len()];
        for robot in 0..self.robots.len() as u32 {
            let mut current = robot;
            while mark[current as usize] == 0 {
                mark[current as usize] = robot + 1;
                let Some(next) = self.waits_for(current) else { break };
                current = next;
                if mark[current as usize] == robot + 1 {
                    self.counts.rings += 1;
                    self.take_apart(current);
                    break;
                }
            }
        }
    }

    /// Who a robot has been waiting for.
    fn waits_for(&self, robot: u32) -> Option<u32> {
        let state = self.robot(robot)?;
        let is_patient = self.now - state.waiting_since < PATIENCE_SECS;
        state.blocker.filter(|blocker| !is_patient && self.robot(*blocker).is_some())
    }

    /// Sends a robot of a ring another way: the first that can drive on there at once.
    fn take_apart(&mut self, first: u32) {
        let mut ring = vec![first];
        while let Some(next) = ring.last().and_then(|&robot| self.waits_for(robot)).filter(|&next| next != first) {
            ring.push(next);
        }
        ring.sort_unstable_by(|&a, &b| self.waiting_since(a).total_cmp(&self.waiting_since(b)).then(a.cmp(&b)));
        for robot in ring {
            if self.detour(robot) {
                self.counts.detours += 1;
                return;
            }
        }
    }

    fn waiting_since(&self, robot: u32) -> f64 {
        self.robot(robot).map_or(f64::INFINITY, |state| state.waiting_since)
    }

    /// Sends a robot another way, if there is one on which it can drive at once.
    fn detour(&mut self, robot: u32) -> bool {
        let Some(state) = self.robot(robot) else { return false };
        let (Some(&avoid), Some(goal), (Some(last), start)) = (state.horizon.front(), state.goal, self.base_end(robot))
        else {
            return false;
        };
        let (class, before) = (state.class, state.horizon.clone());
        let (congestion, claims) = (&self.congestion, &self.claims);
        let is_closed = |leg: Leg| leg == avoid || leg.is_reverse() || claims.holds(robot, leg.edge());
        let found = self.router.route(&self.roads, &class, Search { last: Some(last), start, goal }, |leg| {
            (!is_closed(leg)).then(|| congestion.delay(leg.edge()))
        });
        let Some(legs) = found else { return false };
        if let Some(state) = &mut self.robots[robot as usize] {
            state.horizon = legs.clone().into();
        }
        let can_drive = !self.find_extension(robot, 0.1).stretches.is_empty();
        if let Some(state) = &mut self.robots[robot as usize] {
            state.horizon = before;
        }
        if can_drive {
            self.set_route(robot, legs);
        }
        can_drive
    }
}
