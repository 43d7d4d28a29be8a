//! Planners that take over: one whenever all robots have stood for long, and one that carries
//! clearly more.
//!
//! Each planner has jams that another one resolves. A fleet that can't move under any of them goes
//! round all of them for good. Some jams come later than the end of a rehearsal: under a planner
//! that carries much less than another one for certain, while most robots wait, the other one takes
//! over.

use super::backstop::Standing;
use super::{Planner, PlannerKind, Plans};
use crate::traffic::{Errand, Traffic};

/// The time that all robots stand before another planner takes over, in seconds: longer than the
/// backstop needs.
const STAND_SECS: f64 = 120.0;
/// The time over which the work of a planner is measured, in seconds.
const WINDOW_SECS: f64 = 600.0;
/// The part of the time under way that robots wait for others from which on roads are jammed.
const JAMMED: f64 = 0.3;
/// The parts of a rehearsed and of a measured rate that a planner reaches for certain.
const REHEARSED_FOR_CERTAIN: f64 = 0.6;
const MEASURED_FOR_CERTAIN: f64 = 0.9;

/// Stops that robots handle under a planner, in stops per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Neither rehearsed nor measured.
    Unknown,
    /// In a rehearsal.
    Rehearsed(f64),
    /// In the fleet itself, before another planner took over.
    Measured(f64),
}

impl Rate {
    /// The rate that the planner reaches for certain.
    fn for_certain(self) -> f64 {
        match self {
            Self::Unknown => 0.0,
            Self::Rehearsed(rate) => REHEARSED_FOR_CERTAIN * rate,
            Self::Measured(rate) => MEASURED_FOR_CERTAIN * rate,
        }
    }
}

/// A planner that may take over.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The planner.
    pub kind: PlannerKind,
    /// The stops per second that robots handle under it.
    pub rate: Rate,
}

impl From<PlannerKind> for Candidate {
    fn from(kind: PlannerKind) -> Self {
        Self { kind, rate: Rate::Unknown }
    }
}

/// A planner, and those that take over.
#[derive(Debug)]
pub struct Fallback {
    planner: Box<dyn Planner>,
    /// The planners, in turn.
    candidates: Vec<Candidate>,
    current: usize,
    standing: Standing,
    work: Work,
    /// When the planner took over, in simulated seconds.
    since: f64,
    takeovers: u64,
}

impl Fallback {
    /// Puts planners under one. `candidates` are all of them, that of the first at first.
    pub fn new(planner: Box<dyn Planner>, candidates: Vec<Candidate>) -> Self {
        Self {
            planner,
            candidates,
            current: 0,
            standing: Standing::default(),
            work: Work::default(),
            since: 0.0,
            takeovers: 0,
        }
    }

    /// The planner that is to take over now, if any.
    fn successor(&mut self, traffic: &Traffic<'_>) -> Option<usize> {
        let next = (self.current + 1) % self.candidates.len();
        if traffic.now - self.since > STAND_SECS && self.standing.is_standstill(traffic, STAND_SECS)
        {
            return Some(next);
        }
        let measured = self.work.measured(traffic.now)?;
        let rates = self.candidates.iter().map(|candidate| candidate.rate.for_certain());
        let (best, rate) = rates.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        if !measured.is_jammed || best == self.current || measured.rate >= rate {
            return None;
        }
        self.candidates[self.current].rate = Rate::Measured(measured.rate);
        Some(best)
    }

    /// Lets another planner take over. It plans all routes anew.
    fn take_over(&mut self, successor: usize, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.current = successor;
        self.planner = self.candidates[successor].kind.plain(traffic.roads);
        self.since = traffic.now;
        self.work.restart(traffic.now);
        self.takeovers += 1;
        let sent = traffic.robots().filter(|(_, state)| state.goal().is_some());
        plans.released.extend(sent.map(|(robot, _)| robot));
    }
}

impl Planner for Fallback {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.standing.observe(traffic);
        self.work.observe(traffic);
        match self.successor(traffic) {
            Some(successor) => self.take_over(successor, traffic, plans),
            None => self.planner.plan(traffic, plans),
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

/// The work of a fleet since the beginning of a window of time.
#[derive(Debug, Default)]
struct Work {
    /// By robot: the errand in the cycle before.
    errands: Vec<Errand>,
    begin_secs: f64,
    /// The robots that came to a stop that they were sent to.
    stops: u64,
    /// Robots times cycles: those under way, and those of them that wait for others.
    under_way: u64,
    waiting: u64,
}

/// The work in a window.
struct Measured {
    /// Stops per second.
    rate: f64,
    is_jammed: bool,
}

impl Work {
    fn observe(&mut self, traffic: &Traffic<'_>) {
        self.errands.resize(traffic.robots.len(), Errand::None);
        for (robot, state) in traffic.robots() {
            let before = std::mem::replace(&mut self.errands[robot as usize], state.errand);
            self.stops += u64::from(matches!(before, Errand::Sent(_)) && before != state.errand);
            self.under_way += u64::from(state.is_under_way());
            self.waiting += u64::from(state.is_under_way() && state.waiting_since.is_finite());
        }
    }

    /// The work of a window that has ended. The next window begins.
    fn measured(&mut self, now: f64) -> Option<Measured> {
        let secs = now - self.begin_secs;
        if secs < WINDOW_SECS {
            return None;
        }
        let is_jammed = self.waiting as f64 > JAMMED * self.under_way as f64;
        let rate = self.stops as f64 / secs;
        self.restart(now);
        Some(Measured { rate, is_jammed })
    }

    fn restart(&mut self, now: f64) {
        let errands = std::mem::take(&mut self.errands);
        *self = Self { errands, begin_secs: now, ..Self::default() };
    }
}
