//! The choice of the next place of each robot: the recursion of priority inheritance with
//! backtracking.

use std::collections::BTreeMap;

use super::Stand;
use super::hops::{Hop, Hops};
use crate::planner::DrivingTimes;
use crate::traffic::Traffic;

/// The longest chain of robots that push each other.
const LONGEST_CHAIN: usize = 200;

/// Whether a robot that is in the way will be out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// It has chosen another place.
    Leaves,
    /// Not now: it has to arrive first, or waits for one that has.
    Later,
    /// It can go nowhere.
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
    /// By place that somebody has chosen: the robot.
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

    /// Chooses the next place of a robot. One that is pushed can't stay, and had better not go
    /// where the other goes on to.
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

    /// Asks a robot to leave its place, for one that goes on to another place.
    fn make_way(&mut self, robot: u32, place: u32, next: Option<u32>) -> Outcome {
        let Some(state) = self.traffic.robot(robot) else { return Outcome::Later };
        if state.is_pinned() || state.is_adopted() || self.chain.len() > LONGEST_CHAIN {
            return Outcome::Stuck;
        }
        // Idle robots are sent away when somebody waits for them; who has just reached its goal
        // gets another one first.
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
        let secs = |hop: &Hop| {
            self.times.between(self.traffic.roads, hop.place, goal).map(|secs| secs + hop.secs)
        };
        let hops = self.hops.from(place).iter().filter_map(|hop| Some((secs(hop)?, hop.place)));
        hops.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, place)| place)
    }

    /// The places that a robot may choose, with who is there, best first; no hop stands for
    /// staying.
    fn options(
        &self,
        robot: u32,
        place: u32,
        pushed_to: Option<u32>,
    ) -> Vec<(Option<Hop>, Option<u32>)> {
        let Some(goal) = self.goal(robot) else { return Vec::new() };
        let between = |node: u32| self.times.between(self.traffic.roads, node, goal);
        let mut options: Vec<(bool, f64, bool, Option<&Hop>)> = Vec::new();
        options.extend(between(place).map(|secs| (false, secs, false, None)));
        for hop in self.hops.from(place) {
            let is_open = hop.legs.iter().all(|&leg| {
                !self.traffic.is_closed(leg) && !self.traffic.claims.holds(robot, leg.edge())
            });
            if let Some(secs) = between(hop.place).filter(|_| is_open) {
                let is_free = self.taken[hop.place as usize].is_none();
                options.push((pushed_to == Some(hop.place), secs + hop.secs, !is_free, Some(hop)));
            }
        }
        // A robot that isn't pushed only leaves for a place nearer to its goal.
        let stay = between(place).unwrap_or(f64::INFINITY);
        options.retain(|option| {
            pushed_to.is_some() || option.3.is_none_or(|hop| option.1 - hop.secs < stay)
        });
        options.sort_by(|a, b| {
            a.0.cmp(&b.0)
                .then((a.3.is_none()).cmp(&b.3.is_none()))
                .then(a.1.total_cmp(&b.1))
                .then(a.2.cmp(&b.2))
        });
        let who = |hop: &Hop| self.taken[hop.place as usize].filter(|other| *other != robot);
        options.into_iter().map(|option| (option.3.cloned(), option.3.and_then(who))).collect()
    }
}
