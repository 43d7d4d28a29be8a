//! Takes rings of waiting robots apart.

use super::guide::Guide;
use super::{Lanes, SLACK, Search};
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
        let next_of = |robot: u32| traffic.waits_for(robot, PATIENCE_SECS);
        let mut ring = vec![first];
        while let Some(next) =
            ring.last().and_then(|&robot| next_of(robot)).filter(|&next| next != first)
        {
            ring.push(next);
        }
        let since =
            |robot: u32| traffic.robot(robot).map_or(f64::INFINITY, |state| state.waiting_since);
        ring.sort_unstable_by(|&a, &b| since(a).total_cmp(&since(b)).then(a.cmp(&b)));
        let detour = ring.into_iter().find_map(|robot| Some((robot, self.detour(robot, traffic)?)));
        if let Some((robot, legs)) = detour {
            self.detours += 1;
            plans.route(robot, legs);
        }
    }

    /// Returns another way for a robot, if there is one on which it can drive at once.
    fn detour(&mut self, robot: u32, traffic: &Traffic<'_>) -> Option<Vec<Leg>> {
        let state = traffic.robot(robot)?;
        let (last, _) = traffic.base_end(robot)?;
        let (avoid, goal) = (*state.horizon.front()?, state.goal()?);
        let is_open = |leg: Leg| leg != avoid && !traffic.claims.holds(robot, leg.edge());
        let elsewhere = self.way(robot, traffic, last, goal, is_open);
        let can_drive = |legs: &Vec<Leg>| traffic.can_drive(robot, legs);
        elsewhere
            .filter(can_drive)
            .or_else(|| self.round_trip(robot, traffic, [last, avoid]).filter(can_drive))
    }

    /// Returns a way on which a robot leaves the node before a stub, and comes back: who comes out
    /// of the stub needs the node.
    fn round_trip(
        &mut self,
        robot: u32,
        traffic: &Traffic<'_>,
        [last, avoid]: [Leg; 2],
    ) -> Option<Vec<Leg>> {
        let (roads, goal) = (traffic.roads, traffic.robot(robot)?.goal()?);
        let is_stub = |leg: Leg| roads.stubs().of(leg.edge()).is_some();
        let exits =
            roads.exits(roads.end(last)).iter().filter(|_| is_stub(avoid) && !is_stub(last));
        exits
            .copied()
            .filter(|&exit| exit != avoid && !exit.is_reverse() && !is_stub(exit))
            .find_map(|exit| {
                let mut legs = vec![exit];
                // The robot will have given back its claims when it comes there again.
                legs.extend(self.way(robot, traffic, exit, goal, |leg| leg != exit)?);
                Some(legs)
            })
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
        let landmarks = self.guide.as_ref().map(Guide::landmarks);
        let search =
            Search { last: Some(last), start, goal, reverse: false, landmarks, slack: SLACK[0] };
        self.routers[0].route(traffic.roads, &state.class, search, |leg| {
            (is_open(leg) && !traffic.is_closed(leg)).then(|| congestion.delay(leg.edge()))
        })
    }
}
