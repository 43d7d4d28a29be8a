//! Planners of last resort: whenever all robots have stood for long, another planner takes over.
//!
//! Each planner has jams that another one resolves. A fleet that can't move under any of them goes
//! round all of them for good.

use super::backstop::Standing;
use super::{Planner, PlannerKind, Plans};
use crate::traffic::Traffic;

/// The time that all robots stand before another planner takes over, in seconds: longer than the
/// backstop needs.
const STAND_SECS: f64 = 120.0;

/// A planner, and those that take over.
#[derive(Debug)]
pub struct Fallback {
    planner: Box<dyn Planner>,
    /// The kinds of planners, in turn.
    kinds: Vec<PlannerKind>,
    current: usize,
    standing: Standing,
    /// When the planner took over, in simulated seconds.
    since: f64,
    takeovers: u64,
}

impl Fallback {
    /// Puts planners under one. `kinds` are the kinds of all of them, that of the first at first.
    pub fn new(planner: Box<dyn Planner>, kinds: Vec<PlannerKind>) -> Self {
        Self { planner, kinds, current: 0, standing: Standing::default(), since: 0.0, takeovers: 0 }
    }

    /// Lets the next planner take over. It plans all routes anew.
    fn take_over(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.current = (self.current + 1) % self.kinds.len();
        self.planner = self.kinds[self.current].plain(traffic.roads);
        self.since = traffic.now;
        self.takeovers += 1;
        let sent = traffic.robots().filter(|(_, state)| state.goal().is_some());
        plans.released.extend(sent.map(|(robot, _)| robot));
    }
}

impl Planner for Fallback {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.standing.observe(traffic);
        if traffic.now - self.since > STAND_SECS && self.standing.is_standstill(traffic, STAND_SECS)
        {
            self.take_over(traffic, plans);
        } else {
            self.planner.plan(traffic, plans);
        }
    }

    fn objection(&mut self, traffic: &Traffic<'_>, robot: u32) -> Option<u32> {
        self.planner.objection(traffic, robot)
    }

    fn guards_rings(&self) -> bool {
        self.planner.guards_rings()
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let mut counts = self.planner.counts();
        counts.push(("takeovers", self.takeovers));
        counts
    }
}
