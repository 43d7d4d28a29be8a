//! Robots that have stood for long, and will go on standing.

use std::collections::BTreeSet;

use super::ways::{Stand, Stops, paths, stretches};
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};
use crate::traffic::{Errand, Robot, Traffic};

/// The number of legs ahead that are searched for a blocker.
const LEGS_AHEAD: usize = 24;

/// The time since which a robot stands.
#[derive(Clone, Copy, Debug)]
struct Since {
    secs: f64,
    /// Its claim, and when it was sent to its goal: if one changes, it doesn't stand.
    extent: Extent,
    sent: f64,
    /// The version of its claim: as long as it is the same, so is the claim.
    version: u64,
}

/// The first and the last stretch of a claim. Its version says less: it changes, too, when the ring
/// guard takes a claim back.
pub type Extent = Option<(Stretch, Stretch)>;

/// The claim of a robot.
pub fn extent(traffic: &Traffic<'_>, robot: u32) -> Extent {
    let claim = traffic.claims.of(robot);
    Some((*claim.front()?, *claim.back()?))
}

/// The times since which robots stand.
#[derive(Debug, Default)]
pub struct Standing {
    /// By robot.
    robots: Vec<Option<Since>>,
}

impl Standing {
    /// Updates the times since which robots stand.
    pub fn observe(&mut self, traffic: &Traffic<'_>) {
        self.robots.resize(traffic.robots.len(), None);
        for (robot, since) in (0..).zip(&mut self.robots) {
            let Some(state) = traffic.robot(robot) else {
                *since = None;
                continue;
            };
            let (version, sent) = (traffic.claims.version(robot), state.sent);
            if state.speed == 0.0
                && since.is_some_and(|since| (since.version, since.sent) == (version, sent))
            {
                continue;
            }
            let extent = extent(traffic, robot);
            let stands = state.speed == 0.0
                && since.is_some_and(|since| (since.extent, since.sent) == (extent, sent));
            match since.as_mut().filter(|_| stands) {
                Some(since) => since.version = version,
                None => *since = Some(Since { secs: traffic.now, extent, sent, version }),
            }
        }
    }

    /// Lets robots count as standing from now on only: they wait for something that ends.
    pub fn restart(&mut self, robots: &[u32], now: f64) {
        for &robot in robots {
            if let Some(Some(since)) = self.robots.get_mut(robot as usize) {
                since.secs = now;
            }
        }
    }

    /// The time since which a robot stands, in simulated seconds; infinity for an unknown one.
    fn since(&self, robot: u32) -> f64 {
        self.robots.get(robot as usize).copied().flatten().map_or(f64::INFINITY, |since| since.secs)
    }

    /// Whether robots want to drive on, and none has driven or handled a stop for some seconds. A
    /// robot that is held or broken may be what they wait for: then it is none.
    pub fn is_standstill(&self, traffic: &Traffic<'_>, secs: f64) -> bool {
        let mut is_wanted = false;
        for (robot, state) in traffic.robots() {
            let is_short = traffic.now - self.since(robot) < secs;
            if is_short || state.is_pinned() || state.stuck_since.is_finite() {
                return false;
            }
            is_wanted |= is_under_way(traffic, robot, state) && !state.is_unreachable();
        }
        is_wanted
    }

    /// Whether all robots stand, and none is at a stop.
    pub fn all_stand(&self, traffic: &Traffic<'_>) -> bool {
        traffic.robots().all(|(_, state)| state.speed == 0.0 && !state.is_pinned())
    }

    /// Finds the robots that have stood for some seconds and wait for each other, in groups that
    /// don't wait for each other.
    pub fn groups(&self, traffic: &Traffic<'_>, secs: f64) -> Vec<Vec<u32>> {
        // An idle robot ends a chain.
        let mut ends: BTreeSet<u32> = BTreeSet::new();
        let mut waits: Vec<(u32, Vec<u32>)> = Vec::new();
        for (robot, state) in traffic.robots() {
            if traffic.now - self.since(robot) < secs {
                continue;
            }
            if is_movable(state) && state.is_idle() {
                ends.insert(robot);
            }
            if is_under_way(traffic, robot, state) {
                waits.push((robot, blockers(traffic, robot)));
            }
        }
        loop {
            let stuck: BTreeSet<u32> =
                waits.iter().map(|(robot, _)| *robot).chain(ends.iter().copied()).collect();
            let before = waits.len();
            waits.retain(|(_, blockers)| blockers.iter().any(|blocker| stuck.contains(blocker)));
            if waits.len() == before {
                for (_, blockers) in &mut waits {
                    blockers.retain(|blocker| stuck.contains(blocker));
                }
                return joined(&waits);
            }
        }
    }
}

/// The largest number of edges of roads on which robots that don't arrive are looked for.
const MOST_EDGES: usize = 1_000;
/// The time that a robot may take to its goal, in seconds, and as a multiple of the longest way.
const LATE_SECS: f64 = 60.0;
const LATE_WAYS: f64 = 4.0;

/// Whether robots have goals, and none of them will arrive, as all of them are under way for far
/// longer than any way takes.
pub fn is_livelock(traffic: &Traffic<'_>) -> bool {
    let mut is_wanted = false;
    if traffic.roads.edges().len() > MOST_EDGES {
        return false;
    }
    for (_, state) in traffic.robots() {
        if state.is_pinned() || !is_movable(state) {
            return false;
        }
        let Errand::Sent(goal) = state.errand else { continue };
        let late_secs = traffic.now - state.sent - LATE_SECS;
        if state.is_unreachable() {
            continue;
        }
        if late_secs < 0.0 || late_secs < LATE_WAYS * longest_secs(traffic.roads, goal) {
            return false;
        }
        is_wanted = true;
    }
    is_wanted
}

/// The longest driving time to a goal, in seconds.
fn longest_secs(roads: &Roads, goal: u32) -> f64 {
    let reached = roads.millis_to(goal).iter().filter(|millis| **millis != u32::MAX);
    f64::from(reached.max().copied().unwrap_or(0)) / 1000.0
}

/// Whether a robot can be sent elsewhere.
pub fn is_movable(state: &Robot) -> bool {
    !state.is_pinned() && !state.is_adopted() && state.stuck_since.is_infinite()
}

/// Whether a robot wants to drive on.
fn is_under_way(traffic: &Traffic<'_>, robot: u32, state: &Robot) -> bool {
    let is_there = traffic.base_end(robot).is_none_or(|(_, node)| state.goal() == Some(node));
    is_movable(state)
        && !state.is_idle()
        && !state.is_held
        && (!is_there || state.blocker.is_some())
}

/// The robots that block a robot: the one that steering has found, or those that its planner may
/// have it wait for.
fn blockers(traffic: &Traffic<'_>, robot: u32) -> Vec<u32> {
    let (Some(state), Some(stand)) = (traffic.robot(robot), Stand::of(traffic, robot)) else {
        return Vec::new();
    };
    if let Some(blocker) = state.blocker.filter(|_| state.waiting_since.is_finite()) {
        return vec![blocker.robot];
    }
    let in_way =
        |stretch: &Stretch| traffic.claims.in_way(traffic.roads, state.class.footprint, stretch);
    let near = paths(traffic, stand, Stops::Places)
        .into_iter()
        .flat_map(|path| stretches(traffic.roads, stand, &path.legs));
    let mut robots: Vec<u32> = near.flat_map(|stretch| in_way(&stretch)).collect();
    // The ring guard looks farther ahead.
    let route: Vec<Leg> = state.horizon.iter().copied().take(LEGS_AHEAD).collect();
    let ahead = stretches(traffic.roads, stand, &route);
    let first = ahead.iter().map(in_way).find(|others| others.iter().any(|other| *other != robot));
    robots.extend(first.into_iter().flatten());
    robots.sort_unstable();
    robots.dedup();
    robots.retain(|other| *other != robot);
    robots
}

/// Groups robots with the robots that they wait for, in ascending order.
fn joined(waits: &[(u32, Vec<u32>)]) -> Vec<Vec<u32>> {
    let mut groups: Vec<BTreeSet<u32>> = Vec::new();
    for (robot, blockers) in waits {
        let mut joined: BTreeSet<u32> = blockers.iter().copied().chain([*robot]).collect();
        groups.retain(|group| {
            let is_apart = group.is_disjoint(&joined);
            if !is_apart {
                joined.extend(group);
            }
            is_apart
        });
        groups.push(joined);
    }
    let mut groups: Vec<Vec<u32>> =
        groups.into_iter().map(|group| group.into_iter().collect()).collect();
    groups.sort_unstable();
    groups
}
