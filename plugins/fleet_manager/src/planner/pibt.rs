//! The planner `pibt`: priority inheritance with backtracking, for roads where opposing traffic
//! shares one track.
//!
//! K. Okumura, M. Machida, X. Défago, Y. Tamura: Priority Inheritance with Backtracking for
//! Iterative Multi-agent Path Finding, 2019 and 2022.
//!
//! Robots drive from place to place, one *hop* at a time: a place is the end of a leg where a
//! standing robot is only in the way of edges that meet there. A robot near the end of its base
//! chooses the next place by driving time; the one that has been under way the longest chooses
//! first. A robot at the place that another one chooses inherits its priority and has to choose at
//! once, among the places that are left; if it finds none, the other one chooses again. A hop is
//! commanded only when no base ends at its place any more: decisions are made as late as possible.

mod push;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use self::push::Push;
use super::{DrivingTimes, Planner, Plans};
use crate::density::{Density, DensitySettings};
use crate::roads::{Leg, Roads};
use crate::traffic::{Errand, Robot, Traffic};

/// The settings of the planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PibtSettings {
    /// The distance from the end of its base, beyond the braking distance, at which a robot
    /// chooses its next place, in metres.
    pub ahead_metres: f32,
    /// The time from a frame to the moment at which a command that answers it takes effect, in
    /// seconds.
    pub latency_secs: f32,
    /// The limit on robots that drive to their goals at the same time.
    pub density: DensitySettings,
}

impl Default for PibtSettings {
    fn default() -> Self {
        Self {
            ahead_metres: 0.6,
            latency_secs: 0.3,
            density: DensitySettings { waiting_share: 0.1, ..DensitySettings::default() },
        }
    }
}

/// The time that the robot of the highest priority may stand before it loses it, in seconds.
const PATIENCE_SECS: f64 = 5.0;
/// The time for which it has the lowest priority then, in seconds.
const DEMOTED_SECS: f64 = 20.0;

/// The place that a robot takes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stand {
    /// At a place, or nearly: it may choose the next one.
    Ready(u32),
    /// On its way to a place.
    Bound(u32),
    /// Behind others that are bound for the same place: it has none.
    Behind(u32),
}

/// The planner.
#[derive(Debug)]
pub struct Pibt {
    settings: PibtSettings,
    hops: Hops,
    times: DrivingTimes,
    admission: Admission,
    /// By node: the robot whose base ends there, or leads there.
    taken: Vec<Option<u32>>,
    /// By robot.
    stands: BTreeMap<u32, Stand>,
    /// The robot of the highest priority, its place, and since when both hold, in simulated
    /// seconds.
    top: Option<(u32, u32, f64)>,
    /// By robot: until when it has the lowest priority.
    demoted: BTreeMap<u32, f64>,
    hops_commanded: u64,
    pushes: u64,
    backtracks: u64,
    demotions: u64,
}

impl Pibt {
    /// Makes the planner for some roads.
    pub fn new(roads: &Roads, settings: PibtSettings) -> Self {
        Self {
            settings,
            hops: Hops::new(roads),
            times: DrivingTimes::of_forward_gear(),
            admission: Admission::new(roads, settings.density),
            taken: vec![None; roads.nodes() as usize],
            stands: BTreeMap::new(),
            top: None,
            demoted: BTreeMap::new(),
            hops_commanded: 0,
            pushes: 0,
            backtracks: 0,
            demotions: 0,
        }
    }

    /// Determines the next place of each robot.
    fn observe(&mut self, traffic: &Traffic<'_>) {
        self.taken.fill(None);
        self.stands.clear();
        self.times.begin();
        let mut bases: Vec<(bool, Leg, f32, u32)> = Vec::new();
        for (robot, state) in traffic.robots() {
            if let Some(goal) = state.goal() {
                self.times.prepare(traffic.roads, goal);
            }
            let (Some((leg, _)), Some(end)) = (traffic.base_end(robot), traffic.claims.end(robot))
            else {
                continue;
            };
            let is_short = end.to < traffic.roads.conflicts().length(end.track);
            bases.push((is_short, leg, end.to, robot));
        }
        // The robot at a place has it; otherwise, the first of those on the way there.
        bases.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(&b.1)).then(b.2.total_cmp(&a.2)));
        for (is_short, leg, _, robot) in bases {
            let Some(state) = traffic.robot(robot) else { continue };
            let is_on_hop = is_short || !traffic.roads.is_place(leg);
            let last = state.horizon.back().filter(|_| is_on_hop);
            let place = traffic.roads.end(*last.unwrap_or(&leg));
            let stand = match self.taken[place as usize] {
                Some(_) => Stand::Behind(place),
                None if last.is_none() && !is_short && self.is_near(traffic, robot, state) => {
                    Stand::Ready(place)
                }
                None => Stand::Bound(place),
            };
            if !matches!(stand, Stand::Behind(_)) {
                self.taken[place as usize] = Some(robot);
            }
            self.stands.insert(robot, stand);
        }
    }

    /// Whether a robot is so near the end of its base that it would have to brake soon.
    fn is_near(&self, traffic: &Traffic<'_>, robot: u32, state: &Robot) -> bool {
        let PibtSettings { ahead_metres, latency_secs, .. } = self.settings;
        traffic.left(robot) < state.braking_distance() + state.speed * latency_secs + ahead_metres
    }

    /// Robots with goals: those first that were sent the longest ago.
    fn ranks(&self, traffic: &Traffic<'_>) -> Vec<u32> {
        let goals = traffic.robots().filter(|(_, state)| state.is_under_way());
        let mut ranks: Vec<(bool, f64, u32)> = goals
            .map(|(robot, state)| (self.demoted.contains_key(&robot), state.sent, robot))
            .collect();
        ranks.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        ranks.into_iter().map(|(_, _, robot)| robot).collect()
    }

    /// Takes its priority from the first robot for a while if it can't go on: all places around it
    /// are taken by robots that could only leave by its own place.
    fn demote(&mut self, traffic: &Traffic<'_>, first: Option<u32>) {
        self.demoted.retain(|_, until| *until > traffic.now);
        let Some((robot, Stand::Ready(place))) =
            first.and_then(|first| Some((first, *self.stands.get(&first)?)))
        else {
            self.top = None;
            return;
        };
        match self.top {
            Some((top, at, since)) if (top, at) == (robot, place) => {
                let is_there = traffic.robot(robot).is_none_or(|state| state.goal() == Some(place));
                if traffic.now - since > PATIENCE_SECS && !is_there {
                    self.demoted.insert(robot, traffic.now + DEMOTED_SECS);
                    self.demotions += 1;
                }
            }
            _ => self.top = Some((robot, place, traffic.now)),
        }
    }

    /// Commands the chosen hops.
    fn command(
        &mut self,
        traffic: &Traffic<'_>,
        ranks: &[u32],
        chosen: &BTreeMap<u32, Hop>,
        plans: &mut Plans,
    ) {
        for (rank, &robot) in ranks.iter().enumerate() {
            let (Some(state), Some(&stand)) = (traffic.robot(robot), self.stands.get(&robot))
            else {
                continue;
            };
            plans.permit(robot).precedence = Some(rank as f64);
            let has_place = match stand {
                Stand::Bound(_) => true,
                Stand::Behind(_) => false,
                Stand::Ready(_) => {
                    chosen.get(&robot).is_some_and(|hop| self.taken[hop.place as usize].is_none())
                }
            };
            // A robot that has left the place ahead has one to go on to: the way there becomes
            // free.
            if has_place {
                plans.permit(robot).follows = true;
            }
            let legs: Vec<Leg> = match (stand, chosen.get(&robot)) {
                (Stand::Bound(_) | Stand::Behind(_), _) => state.horizon.iter().copied().collect(),
                // The robot that is there leaves first.
                (Stand::Ready(_), Some(hop)) if self.may_go(traffic, hop.place) => hop.legs.clone(),
                (Stand::Ready(_), _) => Vec::new(),
            };
            if state.needs_route() || !state.horizon.iter().eq(&legs) {
                self.hops_commanded += u64::from(!legs.is_empty());
                plans.route(robot, legs);
            }
        }
    }

    /// Whether no base ends at a place, but that of an idle robot: it leaves only if another one
    /// waits for it.
    fn may_go(&self, traffic: &Traffic<'_>, place: u32) -> bool {
        let Some(other) = self.taken[place as usize] else { return true };
        traffic.robot(other).is_some_and(|state| state.errand == Errand::None)
    }
}

impl Planner for Pibt {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        self.observe(traffic);
        let ranks = self.ranks(traffic);
        self.demote(traffic, ranks.first().copied());
        self.admission.admit(traffic, &ranks);
        let mut push = Push::new(traffic, &self.hops, &self.times, &self.taken, &self.stands);
        let mut unreachable = Vec::new();
        for &robot in &ranks {
            if self.admission.is_admitted(robot) && !push.start(robot) {
                unreachable.push(robot);
            }
        }
        self.pushes += push.pushes;
        self.backtracks += push.backtracks;
        let chosen = push.into_chosen();
        self.command(traffic, &ranks, &chosen, plans);
        for robot in unreachable {
            plans.unreachable(robot);
        }
    }

    fn counts(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("hops", self.hops_commanded),
            ("pushes", self.pushes),
            ("backtracks", self.backtracks),
            ("demotions", self.demotions),
        ]
    }
}

/// The largest number of legs of a hop.
const MOST_LEGS: usize = 6;
/// The largest number of hops that leave a node.
const MOST_HOPS: usize = 24;

/// A way to a place.
#[derive(Clone, Debug, PartialEq)]
struct Hop {
    /// From the place before.
    pub legs: Vec<Leg>,
    /// The node where it ends.
    pub place: u32,
    /// Driving time, in seconds.
    pub secs: f64,
}

/// The hops of some roads.
#[derive(Debug)]
struct Hops {
    /// By node.
    from: Vec<Vec<Hop>>,
}

impl Hops {
    fn new(roads: &Roads) -> Self {
        Self { from: (0..roads.nodes()).map(|node| hops(roads, node)).collect() }
    }

    /// The hops that leave a node.
    fn from(&self, node: u32) -> &[Hop] {
        &self.from[node as usize]
    }
}

/// Finds the hops that leave a node: those of fewer legs come first.
fn hops(roads: &Roads, node: u32) -> Vec<Hop> {
    let mut hops: Vec<Hop> = Vec::new();
    let mut open = vec![Hop { legs: Vec::new(), place: node, secs: 0.0 }];
    while let Some(way) = open.pop() {
        for &leg in roads.exits(way.place).iter().filter(|leg| !leg.is_reverse()) {
            let edge = roads.edge(leg.edge());
            let mut legs = way.legs.clone();
            legs.push(leg);
            let driving = edge.length / edge.speed.max(1e-3) + edge.delay_secs;
            let secs = way.secs + f64::from(driving);
            let hop = Hop { legs, place: roads.end(leg), secs };
            if hop.place == node || hops.len() >= MOST_HOPS {
                continue;
            }
            match roads.is_place(leg) {
                true => hops.push(hop),
                false if hop.legs.len() < MOST_LEGS => open.push(hop),
                false => {}
            }
        }
    }
    hops.sort_by(|a, b| a.legs.len().cmp(&b.legs.len()).then(a.secs.total_cmp(&b.secs)));
    // A place is reached by one of the ways only.
    let mut places: Vec<u32> = Vec::new();
    hops.retain(|hop| {
        let is_new = !places.contains(&hop.place);
        places.push(hop.place);
        is_new
    });
    hops
}

/// The number of places for each robot that is always admitted.
const PLACES_PER_ROBOT: f64 = 20.0;
/// The number of robots that are always admitted if there are four places for each: so few resolve
/// their jams themselves.
const FEW: f64 = 20.0;

/// The robots that are admitted: they drive to their goals.
#[derive(Debug)]
struct Admission {
    density: Density,
    /// By admitted robot: when it was sent to its goal, in simulated seconds. Another goal needs
    /// another admission.
    sent: BTreeMap<u32, f64>,
    last: f64,
}

impl Admission {
    fn new(roads: &Roads, settings: DensitySettings) -> Self {
        let places = f64::from(roads.nodes());
        let density =
            Density::new(settings, (places / PLACES_PER_ROBOT).max(FEW.min(places / 4.0)));
        Self { density, sent: BTreeMap::new(), last: 0.0 }
    }

    /// Admits robots, those first that come first in `ranks`.
    fn admit(&mut self, traffic: &Traffic<'_>, ranks: &[u32]) {
        self.sent.retain(|robot, since| sent(traffic, *robot) == Some(*since));
        let admitted = self.sent.keys().filter_map(|robot| traffic.robot(*robot));
        let waiting = admitted.filter(|state| state.waiting_since.is_finite()).count();
        self.density.adapt(self.sent.len(), waiting, (traffic.now - self.last) as f32);
        self.last = traffic.now;
        for &robot in ranks {
            if !self.density.is_open() {
                return;
            }
            if !self.sent.contains_key(&robot)
                && let Some(since) = sent(traffic, robot)
            {
                self.sent.insert(robot, since);
                self.density.enter();
            }
        }
    }

    /// Whether a robot goes for its goal.
    fn is_admitted(&self, robot: u32) -> bool {
        self.sent.contains_key(&robot)
    }
}

/// The time at which a robot with a goal was sent there, in simulated seconds.
fn sent(traffic: &Traffic<'_>, robot: u32) -> Option<f64> {
    traffic.robot(robot).filter(|state| state.goal().is_some()).map(|state| state.sent)
}
