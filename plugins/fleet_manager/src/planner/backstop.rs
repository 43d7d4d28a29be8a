//! The backstop: resolves standstills, under any planner.
//!
//! Robots that have stood for a minute because each waits for another one, and the stands round
//! them, are a *region*. No other robot is admitted to it; LaCAM finds hops that lead its robots to
//! their goals or out of it, and they drive in that order. A robot that has made its last hop is
//! left to the planner again. While nothing stands, the planner's plans stay as they are.
//!
//! If all robots stand, and the roads aren't large, all of the roads are one region, in which
//! robots may stand at each end of a leg. If LaCAM doesn't bring several robots to their goals soon,
//! one after the other is tried alone, in a search that also proves that there is no way. Robots
//! that drive without arriving are stopped and led in the same way.

mod alone;
mod case;
mod course;
mod exclusive;
mod lacam;
mod region;
mod standing;
#[cfg(test)]
mod tests;
mod ways;

use std::collections::{BTreeMap, BTreeSet};

use self::case::{Case, Phase};
use self::course::Course;
use self::lacam::Outcome;
use self::region::{Region, Size};
pub(super) use self::standing::Standing;
use self::standing::is_movable;
use self::ways::{Stand, Stops};
use super::{Planner, Plans};
use crate::roads::Leg;
use crate::traffic::Traffic;

/// The settings of the backstop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackstopSettings {
    /// The time that robots stand before they are helped, in seconds: longer than planners take to
    /// resolve a conflict themselves, and longer than most stops.
    pub stand_secs: f64,
    /// The time that all robots stand before all of them are helped at the same time, in seconds.
    pub all_stand_secs: f64,
    /// The number of ways that a region reaches from robots that stand; doubled if there is no
    /// solution.
    pub ways: u32,
    /// The largest number of stands of a region.
    pub stands: usize,
    /// The largest number of robots of a region.
    pub members: usize,
    /// The number of choices that a search tries in one cycle.
    pub work_per_cycle: u64,
    /// The number of choices that a search tries before some robots lose their targets.
    pub work: u64,
}

impl Default for BackstopSettings {
    fn default() -> Self {
        Self {
            stand_secs: 60.0,
            all_stand_secs: 15.0,
            ways: 4,
            stands: 300,
            members: 40,
            work_per_cycle: 5_000,
            work: 100_000,
        }
    }
}

impl BackstopSettings {
    /// The number of choices of an attempt.
    fn work(&self, region: &Region, attempt: usize) -> u64 {
        match region.stops {
            // The last attempt may take longer.
            Stops::Places if region.is_last(attempt) => LAST_ATTEMPT * self.work,
            Stops::Places | Stops::All => self.work,
        }
    }

    /// For a planner that resolves jams of some robots itself.
    pub fn of_last_resort() -> Self {
        Self { stand_secs: f64::INFINITY, all_stand_secs: 5.0, ..Self::default() }
    }
}

/// The interval between searches for robots that stand, in seconds.
const CHECK_SECS: f64 = 1.0;
/// The legs ahead in which a robot is kept out of a region.
const LEGS_AHEAD: usize = 24;
/// The factor by which the last search, with one robot's target only, may exceed the others.
const LAST_ATTEMPT: u64 = 4;
/// The time after which a standstill of all robots that couldn't be helped is looked at again, in
/// seconds: doubled each time, up to the longest one.
const PAUSE_SECS: f64 = 60.0;
const LONGEST_PAUSE_SECS: f64 = 960.0;
/// The time without any movement after which robots aren't led any more, in seconds.
const STUCK_SECS: f64 = 60.0;
/// The largest number of robots of a chain around which a region is made.
const MOST_SEEDS: usize = 12;
/// The time for which robots are led one after the other where none arrived any more, in seconds;
/// doubled, up to the longest one, if they jam again soon.
const JAM_SECS: f64 = 120.0;
const LONGEST_JAM_SECS: f64 = 1920.0;
/// The time within which another jam is one that the planner can't resolve, in seconds.
const AGAIN_SECS: f64 = 300.0;

/// A planner, and the backstop under it.
#[derive(Debug)]
pub struct Backstop {
    settings: BackstopSettings,
    planner: Box<dyn Planner>,
    standing: Standing,
    cases: Vec<Case>,
    next_check: f64,
    /// The time before which a standstill of all robots isn't looked at, in simulated seconds, and
    /// the time until the next look if there is no solution.
    next_for_all: f64,
    pause_secs: f64,
    jam: Jam,
    counts: Counts,
}

/// The time in which robots are led in place of a planner under which none arrives any more.
#[derive(Clone, Copy, Debug)]
struct Jam {
    /// Its end, in simulated seconds.
    until: f64,
    /// Its length, in seconds.
    secs: f64,
}

impl Jam {
    const NONE: Self = Self { until: f64::NEG_INFINITY, secs: 0.0 };

    /// The jam that begins now, with a length of its own unless there was one lately.
    fn next(self, now: f64, secs: f64) -> Self {
        let is_again = now - self.until < AGAIN_SECS;
        let secs =
            if is_again { (2.0 * self.secs).clamp(JAM_SECS, LONGEST_JAM_SECS) } else { secs };
        Self { until: now + secs, secs }
    }
}

/// Figures of the run.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    regions: u64,
    solved: u64,
    given_up: u64,
    broken_off: u64,
    steps: u64,
}

impl Backstop {
    /// Puts the backstop under a planner.
    pub fn new(planner: Box<dyn Planner>, settings: BackstopSettings) -> Self {
        Self {
            settings,
            planner,
            standing: Standing::default(),
            cases: Vec::new(),
            next_check: 0.0,
            next_for_all: 0.0,
            pause_secs: PAUSE_SECS,
            jam: Jam::NONE,
            counts: Counts::default(),
        }
    }

    /// Makes regions round robots that stand.
    fn find_regions(&mut self, traffic: &Traffic<'_>) {
        if self.help_all(traffic) {
            return;
        }
        for group in self.standing.groups(traffic, self.settings.stand_secs) {
            let BackstopSettings { ways, stands, members, .. } = self.settings;
            let size = Size { ways, stands, members, stops: Stops::Places };
            let seeds = if group.len() <= members { group } else { seeds(traffic, &group) };
            match self.case(traffic, seeds.clone(), size) {
                Some(case) => {
                    self.counts.regions += 1;
                    self.cases.push(case);
                }
                None => self.standing.restart(&seeds, traffic.now),
            }
        }
    }

    /// Begins to help all robots if none drives, or none arrives any more. Returns whether it does.
    fn help_all(&mut self, traffic: &Traffic<'_>) -> bool {
        if !self.cases.is_empty() || traffic.now < self.next_for_all {
            return false;
        }
        if self.is_jammed(traffic) {
            return self.standing.all_stand(traffic) && self.lead_all(traffic);
        }
        if self.standing.is_standstill(traffic, self.settings.all_stand_secs) {
            self.jam = self.jam.next(traffic.now, 0.0);
            return self.lead_all(traffic);
        }
        if standing::is_livelock(traffic) {
            self.jam = self.jam.next(traffic.now, JAM_SECS);
        }
        false
    }

    /// Whether robots are led in place of the planner: as long as all of them can drive.
    fn is_jammed(&self, traffic: &Traffic<'_>) -> bool {
        traffic.now < self.jam.until
            && traffic.robots().all(|(_, state)| is_movable(state) || state.is_pinned())
    }

    /// Begins to lead all robots. Returns whether they can be led.
    fn lead_all(&mut self, traffic: &Traffic<'_>) -> bool {
        let Some(case) = Case::of_all(traffic, self.settings.members) else {
            self.next_for_all = traffic.now + PAUSE_SECS;
            self.jam.until = traffic.now;
            return false;
        };
        self.counts.regions += 1;
        self.cases.push(case);
        true
    }

    /// Begins to help robots that stand; `None` if they are in a region already, or can't be
    /// helped.
    fn case(&self, traffic: &Traffic<'_>, seeds: Vec<u32>, size: Size) -> Option<Case> {
        let region = (1..=size.ways)
            .rev()
            .find_map(|ways| Region::around(traffic, &seeds, Size { ways, ..size }))?;
        let mut kept = vec![false; traffic.roads.conflicts().tracks()];
        region.mark(traffic.roads, &mut kept);
        for case in &self.cases {
            let others = case.kept(traffic);
            if kept.iter().zip(others).any(|(own, other)| *own && other)
                || case.robots().any(|robot| region.members.contains(&robot))
            {
                return None;
            }
        }
        Case::new(region, seeds, size)
    }

    /// Leads the robots of regions, in place of the planner.
    fn lead(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        let led: BTreeSet<u32> = self.cases.iter().flat_map(Case::robots).collect();
        plans.routes.retain(|(robot, _)| !led.contains(robot));
        plans.evicted.retain(|(robot, _)| !led.contains(robot));
        for &robot in &led {
            let permit = plans.permit(robot);
            permit.precedence = None;
            permit.max_legs = usize::MAX;
            permit.is_frozen = false;
        }
        for _ in 0..self.cases.len() {
            let mut case = self.cases.remove(0);
            self.go_on(&mut case, traffic, plans);
            if !matches!(case.phase, Phase::Over) {
                self.cases.push(case);
            }
        }
        self.keep_others_out(traffic, plans);
    }

    fn go_on(&mut self, case: &mut Case, traffic: &Traffic<'_>, plans: &mut Plans) {
        if let Phase::Search(..) = case.phase {
            self.search(case, traffic);
        }
        match &mut case.phase {
            Phase::Search(..) => {
                for &robot in &case.region.members {
                    plans.permit(robot).is_frozen = true;
                }
            }
            Phase::Drive(course) => {
                let done = course.follow(traffic);
                let is_stuck = traffic.now - course.moved() > STUCK_SECS;
                match done.filter(|_| !is_stuck) {
                    Some(done) => {
                        plans.released.extend(done);
                        course.command(traffic, plans);
                    }
                    None => {
                        self.counts.broken_off += 1;
                        plans.released.extend(course.robots());
                        case.phase = Phase::Over;
                        return;
                    }
                }
                if course.is_over() {
                    case.phase = Phase::Over;
                }
            }
            Phase::Over => {}
        }
    }

    /// Searches on; with fewer targets, or in a larger region, if there is no solution.
    fn search(&mut self, case: &mut Case, traffic: &Traffic<'_>) {
        let Phase::Search(search, attempt) = &mut case.phase else { return };
        if !case.region.is_as_before(traffic) {
            self.counts.broken_off += 1;
            case.phase = Phase::Over;
            return;
        }
        let before = search.steps();
        let outcome = search.advance(self.settings.work_per_cycle);
        self.counts.steps += search.steps() - before;
        let next = *attempt + 1;
        let hops = match outcome {
            Outcome::Open if search.work() < self.settings.work(&case.region, *attempt) => return,
            // If all robots are at their targets, fewer targets don't help.
            Outcome::Found(hops) if hops.is_empty() => return self.enlarge(case, traffic),
            Outcome::Found(hops) => search.shortened(hops, case.region.stops),
            Outcome::Open | Outcome::None => None,
        };
        match (hops, case.region.search(next)) {
            (Some(hops), _) => {
                self.counts.solved += 1;
                self.pause_secs = PAUSE_SECS;
                case.phase = Phase::Drive(Course::new(traffic, &case.region, &hops));
            }
            (None, Some(search)) => case.phase = Phase::Search(Box::new(search), next),
            (None, None) => self.enlarge(case, traffic),
        }
    }

    fn enlarge(&mut self, case: &mut Case, traffic: &Traffic<'_>) {
        match self.larger(case, traffic) {
            Some(larger) => *case = Case { is_enlarged: true, ..larger },
            None => {
                self.counts.given_up += 1;
                match case.size.stops {
                    Stops::Places => self.standing.restart(&case.seeds, traffic.now),
                    Stops::All => {
                        self.jam.until = traffic.now;
                        self.next_for_all = traffic.now + self.pause_secs;
                        self.pause_secs = (2.0 * self.pause_secs).min(LONGEST_PAUSE_SECS);
                    }
                }
                case.phase = Phase::Over;
            }
        }
    }

    /// Begins to help the robots of a case in a region of twice the size; `None` if there is none.
    fn larger(&self, case: &Case, traffic: &Traffic<'_>) -> Option<Case> {
        if case.is_enlarged || case.size.stops == Stops::All {
            return None;
        }
        let Size { ways, stands, members, stops } = case.size;
        let size = Size { ways: 2 * ways, stands: 2 * stands, members: 2 * members, stops };
        let larger = self.case(traffic, case.seeds.clone(), size)?;
        // A region that contains all roads can't grow.
        (larger.region.stands.len() > case.region.stands.len()).then_some(larger)
    }

    /// Holds all others back at the borders of regions.
    fn keep_others_out(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        let mut kept = vec![false; traffic.roads.conflicts().tracks()];
        for case in &self.cases {
            case.mark(traffic, &mut kept);
        }
        let led: BTreeSet<u32> = self.cases.iter().flat_map(Case::robots).collect();
        let routes: BTreeMap<u32, Option<Vec<Leg>>> = plans.routes.iter().cloned().collect();
        for (robot, state) in traffic.robots().filter(|(robot, _)| !led.contains(robot)) {
            let legs = match routes.get(&robot) {
                Some(Some(legs)) => legs.iter().copied().take(LEGS_AHEAD).collect(),
                _ => state.horizon.iter().copied().take(LEGS_AHEAD).collect::<Vec<Leg>>(),
            };
            let Some(hold) = legs_outside(traffic, robot, &legs, &kept) else { continue };
            match hold {
                None => plans.permit(robot).is_frozen = true,
                Some(legs) => plans.permit(robot).max_legs_outside = legs,
            }
            if hold.is_none_or(|legs| legs == 0) {
                self.standing.restart(&[robot], traffic.now);
            }
        }
    }
}

/// Returns the robots of a large group that can be helped: the ring at the end of the chain of
/// blockers that begins with the robot that was sent the longest ago.
fn seeds(traffic: &Traffic<'_>, group: &[u32]) -> Vec<u32> {
    let sent = group
        .iter()
        .map(|&robot| (traffic.robot(robot).map_or(f64::INFINITY, |state| state.sent), robot));
    let first = sent.min_by(|a, b| a.0.total_cmp(&b.0));
    let mut chain: Vec<u32> = first.map(|(_, robot)| robot).into_iter().collect();
    while let Some(next) =
        chain.last().and_then(|&robot| Some(traffic.robot(robot)?.blocker?.robot))
    {
        if !group.contains(&next) || chain.contains(&next) {
            break;
        }
        chain.push(next);
    }
    chain.split_off(chain.len().saturating_sub(MOST_SEEDS))
}

impl Planner for Backstop {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.planner.plan(traffic, plans);
        self.standing.observe(traffic);
        if traffic.now >= self.next_check {
            self.next_check = traffic.now + CHECK_SECS;
            self.find_regions(traffic);
        }
        if !self.cases.is_empty() {
            self.lead(traffic, plans);
        } else if self.is_jammed(traffic) {
            for (robot, _) in traffic.robots() {
                plans.permit(robot).is_frozen = true;
            }
        }
    }

    fn guards_rings(&self) -> bool {
        self.planner.guards_rings()
    }

    fn objection(&mut self, traffic: &Traffic<'_>, robot: u32) -> Option<u32> {
        let is_led = self.cases.iter().any(|case| case.robots().any(|led| led == robot));
        if is_led { None } else { self.planner.objection(traffic, robot) }
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        let Counts { regions, solved, given_up, broken_off, steps } = self.counts;
        let own = [
            ("regions", regions),
            ("regions solved", solved),
            ("regions given up", given_up),
            ("regions broken off", broken_off),
            ("search steps", steps),
        ];
        self.planner.counts().into_iter().chain(own).collect()
    }
}

/// Returns the number of legs that a robot may drive without coming to kept tracks, up to the last
/// stand before them; `Some(None)` if it must stay, `None` if it comes to no kept track.
fn legs_outside(
    traffic: &Traffic<'_>,
    robot: u32,
    legs: &[Leg],
    kept: &[bool],
) -> Option<Option<usize>> {
    let roads = traffic.roads;
    let stand = Stand::of(traffic, robot)?;
    if kept[stand.leg.edge() as usize] && !stand.is_at_end(roads) {
        return Some(None);
    }
    let first = legs.iter().position(|leg| {
        kept[leg.edge() as usize] || kept[roads.disc(roads.start(*leg)) as usize]
    })?;
    let last = (1..=first).rev().find(|count| roads.is_place(legs[count - 1]));
    Some(Some(last.unwrap_or(0)))
}
