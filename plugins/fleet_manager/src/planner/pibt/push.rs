//! The choice of the next place of each robot: the recursion of priority inheritance with
//! backtracking.

use std::collections::BTreeMap;

use super::{Hop, Hops, Stand};
use crate::planner::DrivingTimes;
use crate::traffic::Traffic;

/// The length of the longest chain of robots that push each other.
const LONGEST_CHAIN: usize = 200;

/// Whether a robot that is in the way will be out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// It has chosen another place.
    Leaves,
    /// Not now: it has to arrive first, or waits for one that has.
    Later,
    /// It has no place to go to.
    Stuck,
}

/// The choices of a cycle.
pub(super) struct Push<'a> {
    traffic: &'a Traffic<'a>,
    hops: &'a Hops,
    times: &'a DrivingTimes,
    taken: &'a [Option<u32>],
    stands: &'a BTreeMap<u32, Stand>,
    /// By robot that has chosen: its hop; `None` to stay.
    chosen: BTreeMap<u32, Option<Hop>>,
    /// By place that a robot has chosen: the robot.
    wanted: BTreeMap<u32, u32>,
    /// Places of robots that are pushing.
    chain: Vec<u32>,
    pub pushes: u64,
    pub backtracks: u64,
}

impl<'a> Push<'a> {
    pub(super) fn new(
        traffic: &'a Traffic<'a>,
        hops: &'a Hops,
        times: &'a DrivingTimes,
        taken: &'a [Option<u32>],
        stands: &'a BTreeMap<u32, Stand>,
    ) -> Self {
        let (chosen, wanted, chain) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
        Self {
            traffic,
            hops,
            times,
            taken,
            stands,
            chosen,
            wanted,
            chain,
            pushes: 0,
            backtracks: 0,
        }
    }

    /// Lets a robot choose, in its turn. Returns `false` if it can't reach its goal.
    pub(super) fn start(&mut self, robot: u32) -> bool {
        let (Some(&stand), Some(goal)) = (self.stands.get(&robot), self.goal(robot)) else {
            return true;
        };
        let (Stand::Ready(place) | Stand::Bound(place) | Stand::Behind(place)) = stand;
        if self.times.between(self.traffic.roads, place, goal).is_none() {
            return false;
        }
        match stand {
            Stand::Ready(_) if !self.chosen.contains_key(&robot) => {
                self.choose(robot, place, None);
            }
            // A robot that waits behind another one pushes it.
            Stand::Behind(place) => {
                if let Some(other) = self.taken[place as usize] {
                    self.make_way(other, place, None);
                }
            }
            _ => {}
        }
        true
    }

    /// The hops that robots have chosen.
    pub(super) fn into_chosen(self) -> BTreeMap<u32, Hop> {
        self.chosen.into_iter().filter_map(|(robot, hop)| Some((robot, hop?))).collect()
    }

    fn goal(&self, robot: u32) -> Option<u32> {
        self.traffic.robot(robot)?.goal()
    }

    /// Chooses the next place of a robot. A pushed robot can't stay, and avoids the next place of
    /// the pushing robot.
    fn choose(&mut self, robot: u32, place: u32, pushed_to: Option<u32>) -> Outcome {
        let is_pushed = pushed_to.is_some();
        self.chain.push(place);
        let mut outcome = Outcome::Stuck;
        for (hop, other) in self.options(robot, place, pushed_to) {
            let Some(hop) = hop else {
                if is_pushed {
                    continue;
                }
                break;
            };
            if self.wanted.contains_key(&hop.place) || self.chain.contains(&hop.place) {
                continue;
            }
            self.wanted.insert(hop.place, robot);
            let after =
                other.map(|other| self.make_way(other, hop.place, self.next(robot, hop.place)));
            match after {
                None | Some(Outcome::Leaves) => {
                    self.chosen.insert(robot, Some(hop));
                    outcome = Outcome::Leaves;
                    break;
                }
                Some(Outcome::Later) => {
                    outcome = Outcome::Later;
                    break;
                }
                Some(Outcome::Stuck) => {
                    self.backtracks += 1;
                    self.wanted.remove(&hop.place);
                }
            }
        }
        self.chain.pop();
        if outcome != Outcome::Leaves {
            self.chosen.insert(robot, None);
            // A robot that stays keeps its place.
            self.wanted.entry(place).or_insert(robot);
        }
        outcome
    }

    /// Asks a robot to leave its place for a robot that continues to another place.
    fn make_way(&mut self, robot: u32, place: u32, next: Option<u32>) -> Outcome {
        let Some(state) = self.traffic.robot(robot) else { return Outcome::Later };
        if state.is_pinned() || state.is_adopted() || self.chain.len() > LONGEST_CHAIN {
            return Outcome::Stuck;
        }
        // Idle robots are sent away when another robot waits for them; one that has just reached
        // its goal gets another goal first.
        if state.goal().is_none() {
            return Outcome::Leaves;
        }
        if state.goal() == Some(place) || self.stands.get(&robot) != Some(&Stand::Ready(place)) {
            return Outcome::Later;
        }
        if let Some(choice) = self.chosen.get(&robot) {
            return if choice.is_some() { Outcome::Leaves } else { Outcome::Stuck };
        }
        self.pushes += 1;
        self.choose(robot, place, Some(next.unwrap_or(place)))
    }

    /// The next place of a robot that leaves a place.
    fn next(&self, robot: u32, place: u32) -> Option<u32> {
        let goal = self.goal(robot).filter(|goal| *goal != place)?;
        let hops = self.hops.from(place).iter().filter_map(|hop| {
            let secs = self.times.between(self.traffic.roads, hop.place, goal)?;
            Some((secs + hop.secs, hop.place))
        });
        hops.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, place)| place)
    }

    /// The hops that a robot may choose, best first, each with the robot at its place; `None` to
    /// stay.
    fn options(
        &self,
        robot: u32,
        place: u32,
        pushed_to: Option<u32>,
    ) -> Vec<(Option<Hop>, Option<u32>)> {
        let Some(goal) = self.goal(robot) else { return Vec::new() };
        let (roads, times) = (self.traffic.roads, self.times);
        let stay_secs = times.between(roads, place, goal);
        let mut options: Vec<Choice> = Vec::new();
        if let Some(secs) = stay_secs {
            options.push(Choice { is_pushed_to: false, secs, is_taken: false, hop: None });
        }
        for hop in self.hops.from(place) {
            let is_open = hop.legs.iter().all(|&leg| {
                !self.traffic.is_closed(leg) && !self.traffic.claims.holds(robot, leg.edge())
            });
            if let Some(secs) = times.between(roads, hop.place, goal).filter(|_| is_open) {
                options.push(Choice {
                    is_pushed_to: pushed_to == Some(hop.place),
                    secs: secs + hop.secs,
                    is_taken: self.taken[hop.place as usize].is_some(),
                    hop: Some(hop),
                });
            }
        }
        // A robot that isn't pushed only leaves for a place nearer to its goal.
        let stay_secs = stay_secs.unwrap_or(f64::INFINITY);
        options.retain(|option| {
            pushed_to.is_some() || option.hop.is_none_or(|hop| option.secs - hop.secs < stay_secs)
        });
        options.sort_by(Choice::order);
        let mut sorted = Vec::with_capacity(options.len());
        for hop in options.into_iter().map(|option| option.hop) {
            let at_place = hop.and_then(|hop| self.taken[hop.place as usize]);
            sorted.push((hop.cloned(), at_place.filter(|other| *other != robot)));
        }
        sorted
    }
}

/// A hop that a robot may choose, or to stay.
struct Choice<'a> {
    /// Whether it leads to the next place of the pushing robot.
    is_pushed_to: bool,
    /// Seconds to the goal.
    secs: f64,
    is_taken: bool,
    hop: Option<&'a Hop>,
}

impl Choice<'_> {
    /// Compares two choices: the better one is less.
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        (self.is_pushed_to.cmp(&other.is_pushed_to))
            .then(self.hop.is_none().cmp(&other.hop.is_none()))
            .then(self.secs.total_cmp(&other.secs))
            .then(self.is_taken.cmp(&other.is_taken))
    }
}
