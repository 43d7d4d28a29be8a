//! Takes rings of waiting robots apart.

use super::{Estimates, Lanes, SLACK, Search};
use crate::planner::Plans;
use crate::roads::Leg;
use crate::traffic::Traffic;

/// The time that robots wait before a ring of them is taken apart, in seconds.
const PATIENCE_SECS: f64 = 3.0;

impl Lanes {
    /// Finds rings of robots that wait for each other, and sends one of each another way.
    pub(super) fn take_rings_apart(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        if !self.settings.detours || traffic.now < self.next_rings {
            return;
        }
        self.next_rings = traffic.now + 1.0;
        let mut mark = vec![0_u32; traffic.robots.len()];
        for robot in 0..traffic.robots.len() as u32 {
            let mut current = robot;
            while mark[current as usize] == 0 {
                mark[current as usize] = robot + 1;
                let Some(next) = traffic.waits_for(current, PATIENCE_SECS) else { break };
                current = next;
                if mark[current as usize] == robot + 1 {
                    self.rings += 1;
                    self.take_apart(current, traffic, plans);
                    break;
                }
            }
        }
    }

    /// Sends a robot of a ring another way: the first that can drive on there at once.
    fn take_apart(&mut self, first: u32, traffic: &Traffic<'_>, plans: &mut Plans) {
        let mut ring = Vec::new();
        let mut next = Some(first);
        while let Some(robot) = next {
            let since = traffic.robot(robot).map_or(f64::INFINITY, |state| state.waiting_since);
            ring.push((since, robot));
            next = traffic.waits_for(robot, PATIENCE_SECS).filter(|&next| next != first);
        }
        ring.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, robot) in ring {
            if let Some(legs) = self.detour(robot, traffic) {
                self.detours += 1;
                plans.route(robot, legs);
                return;
            }
        }
    }

    /// Returns another way for a robot, if there is one on which it can drive at once.
    fn detour(&mut self, robot: u32, traffic: &Traffic<'_>) -> Option<Vec<Leg>> {
        let state = traffic.robot(robot)?;
        let (last, _) = traffic.base_end(robot)?;
        let (avoid, goal) = (*state.horizon.front()?, state.goal()?);
        let elsewhere = self.way(robot, traffic, last, goal, |leg| {
            leg != avoid && !traffic.claims.holds(robot, leg.edge())
        });
        if let Some(legs) = elsewhere.filter(|legs| traffic.can_drive(robot, legs)) {
            return Some(legs);
        }
        let round_trip = self.round_trip(robot, traffic, last, avoid)?;
        traffic.can_drive(robot, &round_trip).then_some(round_trip)
    }

    /// Returns a way on which a robot leaves the node before a stub, and comes back: robots that
    /// come out of the stub need the node.
    fn round_trip(
        &mut self,
        robot: u32,
        traffic: &Traffic<'_>,
        last: Leg,
        avoid: Leg,
    ) -> Option<Vec<Leg>> {
        let (roads, goal) = (traffic.roads, traffic.robot(robot)?.goal()?);
        let stubs = roads.stubs();
        if stubs.of(avoid.edge()).is_none() || stubs.of(last.edge()).is_some() {
            return None;
        }
        for &exit in roads.exits(roads.end(last)) {
            if exit == avoid || exit.is_reverse() || stubs.of(exit.edge()).is_some() {
                continue;
            }
            // The robot will have given back its claims when it comes there again.
            if let Some(way) = self.way(robot, traffic, exit, goal, |leg| leg != exit) {
                return Some([vec![exit], way].concat());
            }
        }
        None
    }

    /// Returns the fastest way to a node from the end of a leg, on open legs.
    fn way(
        &mut self,
        robot: u32,
        traffic: &Traffic<'_>,
        last: Leg,
        goal: u32,
        is_open: impl Fn(Leg) -> bool,
    ) -> Option<Vec<Leg>> {
        let state = traffic.robot(robot)?;
        let (start, congestion) = (traffic.roads.end(last), &self.congestion);
        let estimates = Estimates { guide: self.guide.as_ref(), times: &self.times, slack: SLACK };
        let bound = estimates.bound(traffic.roads, goal);
        let search = Search { last: Some(last), start, goal, reverse: false, bound, slack: SLACK };
        self.routers[0].route(traffic.roads, &state.class, search, |leg| {
            (is_open(leg) && !traffic.is_closed(leg)).then(|| congestion.delay(leg.edge()))
        })
    }
}
