//! Regions: robots that stand, and the stands round them.

use std::collections::{BTreeMap, VecDeque};

use super::alone;
use super::case::Search;
use super::exclusive::Exclusive;
use super::lacam::{self, Problem, Way};
use super::standing::is_movable;
use super::ways::{Path, Stand, Stops, paths, stretches};
use crate::claims::{Claims, Stretch};
use crate::planner::DrivingTimes;
use crate::roads::{Leg, Roads};
use crate::traffic::Traffic;

/// The limits on the size of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// The number of ways from standing robots to the farthest stand.
    pub ways: u32,
    /// Stands.
    pub stands: usize,
    /// Robots.
    pub members: usize,
    /// The ends of legs that are stands.
    pub stops: Stops,
}

/// A region.
#[derive(Debug)]
pub struct Region {
    /// By stand: where it is.
    pub stands: Vec<Stand>,
    /// By stand: the ways that leave it, as in the problem.
    pub paths: Vec<Vec<Path>>,
    /// Robots that are led; agents of the problem.
    pub members: Vec<u32>,
    /// By member: where it is.
    pub starts: Vec<Stand>,
    /// The ways, and where members are; without targets.
    problem: Problem,
    /// The ends of legs that are stands.
    pub stops: Stops,
    /// Those of members that were sent the longest ago come first.
    targets: Vec<Target>,
}

/// The stands to which a member is to come.
#[derive(Debug)]
struct Target {
    member: usize,
    stands: Vec<u16>,
    /// Whether no other one before has the same stands.
    is_first: bool,
}

/// A region in the making.
struct Draft<'a> {
    traffic: &'a Traffic<'a>,
    stops: Stops,
    stands: Vec<Stand>,
    paths: Vec<Vec<Path>>,
    /// By leg: the stand at its end.
    ends: BTreeMap<Leg, u16>,
}

impl Region {
    /// Makes the region round some robots; `None` if it would be larger, or no robot in it could be
    /// led.
    pub fn around(traffic: &Traffic<'_>, robots: &[u32], size: Size) -> Option<Self> {
        let mut draft = Draft {
            traffic,
            stops: size.stops,
            stands: Vec::new(),
            paths: Vec::new(),
            ends: BTreeMap::new(),
        };
        let seeds: Vec<Stand> =
            robots.iter().filter_map(|&robot| Stand::of(traffic, robot)).collect();
        draft.spread(&seeds, size);
        let (members, starts) = draft.members();
        if members.is_empty() || members.len() > size.members {
            return None;
        }
        let ways = draft.ways(&members);
        let Draft { stands, paths, mut ends, .. } = draft;
        let mut problem = Problem { ways, targets: vec![Vec::new(); starts.len()], starts };
        let starts = problem.starts.iter().map(|&start| stands[usize::from(start)]).collect();
        let alike = alike(traffic.roads, &stands, &paths, &problem.ways);
        join(&mut problem, &alike);
        for stand in ends.values_mut() {
            *stand = alike[usize::from(*stand)];
        }
        let (stops, targets) = (size.stops, Vec::new());
        let mut region = Self { stands, paths, members, starts, problem, stops, targets };
        region.find_targets(traffic, &ends);
        Some(region)
    }

    /// Begins the search of an attempt: with the targets of all members, then of half of them,
    /// those that were sent the longest ago, and so on. Where all ends of legs are stands, at last
    /// with the target of one after the other. `None` if there are no more attempts.
    pub fn search(&self, attempt: usize) -> Option<Search> {
        if let Some(alone) = attempt.checked_sub(self.joint_attempts()) {
            let target = self.targets.get(alone).filter(|_| self.stops == Stops::All)?;
            return Some(Search::Alone(alone::Search::new(self.problem([target]))));
        }
        let different = self.targets.iter().filter(|target| target.is_first);
        let count = different.clone().count() >> attempt;
        let problem = self.problem(different.take(count));
        Some(Search::Joint(lacam::Search::new(problem)))
    }

    /// The number of attempts with several targets, or where not all ends of legs are stands, with
    /// the first one.
    fn joint_attempts(&self) -> usize {
        let count = self.targets.iter().filter(|target| target.is_first).count();
        let least = if self.stops == Stops::All { 2 } else { 1 };
        (0..usize::BITS).take_while(|halvings| count >> halvings >= least).count()
    }

    /// Whether no attempt follows one.
    pub fn is_last(&self, attempt: usize) -> bool {
        let alone = if self.stops == Stops::All { self.targets.len() } else { 0 };
        attempt + 1 >= self.joint_attempts() + alone
    }

    /// The problem to solve, with some targets.
    fn problem<'a>(&self, targets: impl IntoIterator<Item = &'a Target>) -> Problem {
        let mut problem = self.problem.clone();
        for target in targets {
            problem.targets[target.member].clone_from(&target.stands);
        }
        problem
    }

    /// Whether all members are where they have been when the region was made.
    pub fn is_as_before(&self, traffic: &Traffic<'_>) -> bool {
        self.members.iter().zip(&self.starts).all(|(&robot, &start)| {
            let is_there = Stand::of(traffic, robot) == Some(start);
            is_there && traffic.robot(robot).is_some_and(is_movable)
        })
    }

    /// Finds the targets of members: their goals, or the stands nearest to these.
    fn find_targets(&mut self, traffic: &Traffic<'_>, ends: &BTreeMap<Leg, u16>) {
        let roads = traffic.roads;
        let mut times = DrivingTimes::default();
        let mut ranked: Vec<(f64, usize)> = Vec::new();
        for (member, robot) in self.members.iter().enumerate() {
            ranked.push((traffic.robot(*robot).map_or(f64::INFINITY, |state| state.sent), member));
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut nodes: BTreeMap<u32, Vec<u16>> = BTreeMap::new();
        for (leg, stand) in ends {
            nodes.entry(roads.end(*leg)).or_default().push(*stand);
        }
        for stands in nodes.values_mut() {
            stands.sort_unstable();
            stands.dedup();
        }
        for (_, member) in ranked {
            let state = traffic.robot(self.members[member]).filter(|state| !state.is_unreachable());
            let Some(goal) = state.and_then(|state| state.goal()) else { continue };
            times.prepare(roads, goal);
            let start = usize::from(self.problem.starts[member]);
            let nearest = if nodes.contains_key(&goal) {
                Some(goal)
            } else {
                let secs = nodes
                    .keys()
                    .map(|&node| (times.between(roads, node, goal).unwrap_or(f64::INFINITY), node));
                secs.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, node)| node)
            };
            if let Some(stands) = nearest.and_then(|node| nodes.get(&node))
                && self.problem.secs_to(stands)[start].is_finite()
            {
                let is_first = self.targets.iter().all(|target| target.stands != *stands);
                self.targets.push(Target { member, stands: stands.clone(), is_first });
            }
        }
    }
}

impl Draft<'_> {
    /// Adds the stands round some, up to a number of ways away.
    fn spread(&mut self, seeds: &[Stand], size: Size) {
        let mut open: VecDeque<(u16, u32)> =
            seeds.iter().map(|seed| (self.stand(*seed), 0)).collect();
        while let Some((stand, depth)) = open.pop_front() {
            if depth == size.ways {
                continue;
            }
            for index in 0..self.paths[usize::from(stand)].len() {
                let to = self.paths[usize::from(stand)][index].to;
                if !self.ends.contains_key(&to) && self.stands.len() < size.stands {
                    open.push_back((self.stand(Stand::at_end(self.traffic.roads, to)), depth + 1));
                }
            }
        }
    }

    /// The number of a stand, which is added if it isn't there yet.
    fn stand(&mut self, stand: Stand) -> u16 {
        let is_stop = stand.is_stop(self.traffic.roads, self.stops);
        let known = if is_stop {
            self.ends.get(&stand.leg).copied()
        } else {
            (0..).zip(&self.stands).find(|(_, known)| **known == stand).map(|(number, _)| number)
        };
        known.unwrap_or_else(|| {
            let number = self.stands.len() as u16;
            self.stands.push(stand);
            self.paths.push(paths(self.traffic, stand, self.stops));
            if is_stop {
                self.ends.insert(stand.leg, number);
            }
            number
        })
    }

    /// The robots that can be led, and where they are: those whose bases end on legs of the region.
    fn members(&mut self) -> (Vec<u32>, Vec<u16>) {
        let ends = &self.ends;
        let paths = self.paths.iter().flatten().filter(|path| ends.contains_key(&path.to));
        let mut legs: Vec<Leg> =
            paths.flat_map(|path| path.legs.iter().copied().chain([path.to])).collect();
        legs.extend(self.stands.iter().map(|stand| stand.leg));
        legs.sort_unstable();
        legs.dedup();
        let mut members = (Vec::new(), Vec::new());
        for (robot, state) in self.traffic.robots().filter(|(_, state)| is_movable(state)) {
            let Some(stand) = Stand::of(self.traffic, robot) else { continue };
            if legs.binary_search(&stand.leg).is_ok()
                && state.class.footprint < self.traffic.roads.footprints().len()
            {
                members.0.push(robot);
                members.1.push(self.stand(stand));
            }
        }
        members
    }

    /// The ways of the region that no robot blocks that can't be led, with the stands that block
    /// each.
    fn ways(&mut self, members: &[u32]) -> Vec<Vec<Way>> {
        let Self { traffic, stands, paths, ends, .. } = self;
        let (roads, count) = (traffic.roads, stands.len());
        let states = members.iter().map(|robot| traffic.robot(*robot));
        let mut footprints: Vec<usize> =
            states.map(|state| state.map_or(0, |state| state.class.footprint)).collect();
        footprints.sort_unstable();
        footprints.dedup();
        let field = field(traffic, stands, &footprints, members);
        let is_fixed = |robot: &u32| {
            members.binary_search(robot).is_err() && !traffic.robot(*robot).is_some_and(is_movable)
        };
        let exclusive = Exclusive::new(roads, stands, &claims_of_others(traffic, members));
        let way = |number: u16, path: &Path| {
            let mut blocked_by: Vec<u16> = vec![*ends.get(&path.to)?];
            for stretch in stretches(roads, stands[usize::from(number)], &path.legs) {
                for &footprint in &footprints {
                    if traffic.claims.in_way(roads, footprint, &stretch).iter().any(is_fixed) {
                        return None;
                    }
                    for holder in field.in_way(roads, footprint, &stretch) {
                        let stand = holder as usize / footprints.len();
                        if stand >= count {
                            return None;
                        }
                        blocked_by.push(stand as u16);
                    }
                }
            }
            blocked_by.extend(exclusive.in_way(roads, stands[usize::from(number)], &path.legs)?);
            blocked_by.sort_unstable();
            blocked_by.dedup();
            blocked_by.retain(|&stand| stand != number);
            Some(Way { to: *ends.get(&path.to)?, blocked_by, secs: path.secs })
        };
        let mut all = Vec::new();
        for (number, paths) in (0..).zip(paths) {
            let ways: Vec<Option<Way>> = paths.iter().map(|path| way(number, path)).collect();
            let mut is_kept = ways.iter().map(Option::is_some);
            paths.retain(|_| is_kept.next().unwrap_or(false));
            all.push(ways.into_iter().flatten().collect());
        }
        all
    }
}

/// The claims of robots that aren't members.
fn claims_of_others(traffic: &Traffic<'_>, members: &[u32]) -> Vec<Stretch> {
    let others = traffic.robots().filter(|(robot, _)| members.binary_search(robot).is_err());
    others.flat_map(|(robot, _)| traffic.claims.of(robot).iter().copied()).collect()
}

/// Claims of a robot on each stand, for each footprint, and of all robots that aren't members,
/// where their bases end.
fn field(traffic: &Traffic<'_>, stands: &[Stand], footprints: &[usize], members: &[u32]) -> Claims {
    let mut field = Claims::new(traffic.roads, true);
    let mut number = 0;
    for stand in stands {
        for &footprint in footprints {
            field.seize(traffic.roads, number, footprint, stand.stretch());
            number += 1;
        }
    }
    for (robot, state) in
        traffic.robots().filter(|(robot, _)| members.binary_search(robot).is_err())
    {
        if let Some(stand) = Stand::of(traffic, robot) {
            field.seize(traffic.roads, number, state.class.footprint, stand.stretch());
            number += 1;
        }
    }
    field
}

/// The properties that equivalent stands share.
#[derive(PartialEq)]
struct Kind {
    node: u32,
    /// The ways that leave the stand: their stretches and last legs.
    leaving: Vec<(Vec<Stretch>, Leg)>,
    /// The ways past the stand that a robot there blocks: the stands that they leave and their
    /// indices.
    past: Vec<(u16, u16)>,
}

/// Returns the first equivalent stand of each stand.
fn alike(roads: &Roads, stands: &[Stand], paths: &[Vec<Path>], ways: &[Vec<Way>]) -> Vec<u16> {
    let nodes: Vec<u32> = stands.iter().map(|stand| roads.end(stand.leg)).collect();
    let mut past: Vec<Vec<(u16, u16)>> = vec![Vec::new(); stands.len()];
    for (from, ways) in (0..).zip(ways) {
        for (index, way) in (0..).zip(ways) {
            // A robot at an end of a way blocks it in any case.
            let ends = [nodes[usize::from(from)], nodes[usize::from(way.to)]];
            for &stand in &way.blocked_by {
                if !ends.contains(&nodes[usize::from(stand)]) {
                    past[usize::from(stand)].push((from, index));
                }
            }
        }
    }
    let mut kinds: Vec<(Kind, u16)> = Vec::new();
    let mut alike = Vec::new();
    for (number, past) in (0..).zip(past) {
        let (stand, paths) = (stands[usize::from(number)], &paths[usize::from(number)]);
        let leaving =
            paths.iter().map(|path| (stretches(roads, stand, &path.legs), path.to)).collect();
        let kind = Kind { node: nodes[usize::from(number)], leaving, past };
        let known = kinds
            .iter()
            .find(|(known, _)| stand.is_at_end(roads) && *known == kind)
            .map(|(_, first)| *first);
        alike.push(known.unwrap_or(number));
        if known.is_none() && stand.is_at_end(roads) {
            kinds.push((kind, number));
        }
    }
    alike
}

/// Replaces stands by the first ones that are like them.
fn join(problem: &mut Problem, alike: &[u16]) {
    for (number, ways) in problem.ways.iter_mut().enumerate() {
        for way in ways {
            way.to = alike[usize::from(way.to)];
            for stand in &mut way.blocked_by {
                *stand = alike[usize::from(*stand)];
            }
            way.blocked_by.sort_unstable();
            way.blocked_by.dedup();
            way.blocked_by.retain(|&stand| stand != alike[number]);
        }
    }
    for start in &mut problem.starts {
        *start = alike[usize::from(*start)];
    }
}
