//! Commits one robot to a way.

use super::commitment::Commitment;
use super::scene::Scene;
use super::{Committed, keys_of};
use crate::claims::Stretch;
use crate::planner::{Bound, Plans, Search};
use crate::roads::Leg;
use crate::traffic::{Robot, Traffic};

/// The time by which waiting near a taken goal has to be nearer to it than the robot is, in
/// seconds.
const NEARER_SECS: f64 = 8.0;
/// The number of shorter ways that are tried if a robot can't be committed to the whole one.
const MOST_TRIES: usize = 4;

impl Committed {
    /// Tries to commit a robot to a way to its goal, or nearer to it. Returns whether it has one.
    pub(super) fn commit(&mut self, traffic: &Traffic<'_>, robot: u32, plans: &mut Plans) -> bool {
        let (Some(state), Some((last, node))) = (traffic.robot(robot), traffic.base_end(robot))
        else {
            return false;
        };
        let Some(goal) = state.goal() else { return false };
        let start = Start { robot, last, node };
        let scene = self.scene(traffic, robot, &[]);
        if scene.is_taken[goal as usize] {
            if self.exchange(traffic, robot, plans) {
                return true;
            }
            if let Some(way) = self.route_past_robots(traffic, state, &start, goal) {
                self.ask(traffic, robot, &way);
                self.wish(traffic, robot, &way);
            }
            return self.wait_near(traffic, robot, goal, &scene, plans);
        }
        let Some(way) = self.route(traffic, state, &start, goal, &scene) else {
            return self.commit_past(traffic, robot, &start, goal, &scene, plans);
        };
        let last = way.last().copied().unwrap_or(last);
        let from = Start { robot, last, node: goal };
        if let Some(tail) = self.tail(traffic, state, &from, &scene) {
            let sent = way.len();
            let whole: Vec<Leg> = way.iter().copied().chain(tail).collect();
            if self.take(traffic, &start, whole, (sent, Some(goal)), plans) {
                return true;
            }
        }
        self.wish(traffic, robot, &way);
        self.commit_part(traffic, &start, &way, &scene, plans)
    }

    /// Notes the way of a robot that waits for it.
    fn wish(&mut self, traffic: &Traffic<'_>, robot: u32, way: &[Leg]) {
        let keys = way.iter().flat_map(|&leg| keys_of(traffic.roads, leg)).collect();
        self.wished.insert(robot, keys);
    }

    /// Commits a robot to a part of its way, which robots without ways block, and asks
    /// them to make room. Returns whether it has a part.
    pub(super) fn commit_past(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        start: &Start,
        goal: u32,
        scene: &Scene,
        plans: &mut Plans,
    ) -> bool {
        let Some(state) = traffic.robot(robot) else { return false };
        let Some(way) = self.route_past_robots(traffic, state, start, goal) else {
            plans.unreachable(robot);
            return false;
        };
        self.ask(traffic, robot, &way);
        self.wish(traffic, robot, &way);
        let free = way.iter().take_while(|leg| scene.cost(**leg).is_some()).count();
        // The robots in the way stand behind its end.
        self.commit_part(traffic, start, &way[..(free + 1).min(way.len())], scene, plans)
    }

    /// Tries to commit a robot to a part of a way that leads to a rest place, the longest first.
    pub(super) fn commit_part(
        &mut self,
        traffic: &Traffic<'_>,
        start: &Start,
        way: &[Leg],
        scene: &Scene,
        plans: &mut Plans,
    ) -> bool {
        let has_room = self.has_room(traffic, scene);
        let is_end = |leg: &Leg| self.is_place(traffic.roads.end(*leg), scene, has_room);
        let lengths: Vec<usize> = (1..way.len())
            .rev()
            .filter(|&count| is_end(&way[count - 1]))
            .take(MOST_TRIES)
            .collect();
        for length in lengths {
            if self.take(traffic, start, way[..length].to_vec(), (length, None), plans) {
                return true;
            }
        }
        false
    }

    /// Tries to commit a robot to a way to the rest place that is nearest to its taken goal.
    pub(super) fn wait_near(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        goal: u32,
        scene: &Scene,
        plans: &mut Plans,
    ) -> bool {
        let (Some(state), Some((last, node))) = (traffic.robot(robot), traffic.base_end(robot))
        else {
            return false;
        };
        self.times.prepare(traffic.roads, goal);
        let secs = |from: u32| self.times.between(traffic.roads, from, goal);
        let Some(own_secs) = secs(node) else { return false };
        let has_room = self.has_room(traffic, scene);
        let mut near: Vec<(f64, u32)> = (0..traffic.roads.nodes())
            .filter(|&rest| rest != goal && self.is_place(rest, scene, has_room))
            .filter_map(|rest| Some((secs(rest)?, rest)))
            .filter(|(secs, _)| secs + NEARER_SECS < own_secs)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let start = Start { robot, last, node };
        let nearest = near.first().map(|(_, nearest)| *nearest);
        if let Some(way) = &mut self.commitments[robot as usize]
            && Some(way.end) == nearest
            && way.goal.is_none()
        {
            if state.needs_route() {
                way.sent = way.way.len();
                plans.route(robot, way.way.clone());
            }
            return true;
        }
        for (_, rest) in near.into_iter().take(MOST_TRIES) {
            if let Some(way) = self.route(traffic, state, &start, rest, scene) {
                let length = way.len();
                if self.take(traffic, &start, way, (length, None), plans) {
                    return true;
                }
            }
        }
        false
    }

    /// Commits a robot to a way, if the state stays completable, also when it has driven the first
    /// leg. `sent` legs of it lead to `goal`, or towards the robot's goal if that is `None`.
    pub(super) fn take(
        &mut self,
        traffic: &Traffic<'_>,
        start: &Start,
        way: Vec<Leg>,
        (sent, goal): (usize, Option<u32>),
        plans: &mut Plans,
    ) -> bool {
        let Start { robot, last, node } = *start;
        let Some(&end) = traffic.claims.end(robot) else { return false };
        let place = Stretch { from: end.to, ..end };
        self.set_state(traffic, Some((robot, place, &way)));
        if !self.state.complete(traffic.roads, &mut self.blocks, Some(robot)).is_empty() {
            return false;
        }
        if let Some((&first, rest)) = way.split_first() {
            let place = Stretch::at(first, traffic.roads.edge(first.edge()).length);
            self.set_state(traffic, Some((robot, place, rest)));
            if !self.state.complete(traffic.roads, &mut self.blocks, Some(robot)).is_empty() {
                return false;
            }
        }
        let end = way.last().map_or(node, |&leg| traffic.roads.end(leg));
        let legs = way[..sent].to_vec();
        self.commitments[robot as usize] = Some(Commitment { from: last, way, sent, end, goal });
        self.counts.commitments += 1;
        if traffic.robot(robot).is_some_and(|state| state.goal().is_some()) {
            plans.route(robot, legs);
        }
        true
    }

    /// Returns the way on from a goal to a place where the robot may stay: a rest place, or else a
    /// lay-by.
    pub(super) fn tail(
        &mut self,
        traffic: &Traffic<'_>,
        state: &Robot,
        from: &Start,
        scene: &Scene,
    ) -> Option<Vec<Leg>> {
        let is_goal = state.goal() == Some(from.node);
        if is_goal && self.rests.contains(from.node) && !scene.is_taken[from.node as usize] {
            return Some(Vec::new());
        }
        let tail = self.nearest_rest(traffic, state, from, scene);
        if tail.is_some() || !self.has_room(traffic, scene) {
            return tail;
        }
        let Self { router, lay_bys, .. } = self;
        let is_free = |node: u32| lay_bys.contains(node) && !scene.is_taken[node as usize];
        if is_free(from.node) {
            return Some(Vec::new());
        }
        router.nearest(
            traffic.roads,
            &state.class,
            from.search(Search::NO_NODE),
            |leg| scene.cost(leg),
            is_free,
        )
    }

    /// Returns the way to the nearest rest place that nobody else takes.
    pub(super) fn nearest_rest(
        &mut self,
        traffic: &Traffic<'_>,
        state: &Robot,
        start: &Start,
        scene: &Scene,
    ) -> Option<Vec<Leg>> {
        let Self { router, rests, .. } = self;
        let search = start.search(Search::NO_NODE);
        for wanted_too in [false, true] {
            let is_free = |node: u32| {
                let is_good = wanted_too || !scene.is_wanted[node as usize];
                rests.contains(node) && !scene.is_taken[node as usize] && is_good
            };
            if is_free(start.node) {
                return Some(Vec::new());
            }
            let way =
                router.nearest(traffic.roads, &state.class, search, |leg| scene.cost(leg), is_free);
            if way.is_some() {
                return way;
            }
        }
        None
    }

    pub(super) fn route(
        &mut self,
        traffic: &Traffic<'_>,
        state: &Robot,
        start: &Start,
        goal: u32,
        scene: &Scene,
    ) -> Option<Vec<Leg>> {
        if start.node == goal {
            return Some(Vec::new());
        }
        self.router.route(traffic.roads, &state.class, start.search(goal), |leg| scene.cost(leg))
    }

    /// Returns the way that there would be if no other robot were on the roads.
    pub(super) fn route_past_robots(
        &mut self,
        traffic: &Traffic<'_>,
        state: &Robot,
        start: &Start,
        goal: u32,
    ) -> Option<Vec<Leg>> {
        let cost = |leg| (!traffic.is_closed(leg)).then_some(0.0);
        self.router.route(traffic.roads, &state.class, start.search(goal), cost)
    }

    /// Whether robots may wait at lay-bys: there are too few rest places for all robots, and room
    /// at lay-bys.
    pub(super) fn has_room(&self, traffic: &Traffic<'_>, scene: &Scene) -> bool {
        self.rests.len() < traffic.robots().count() && self.lay_bys.has_room(&scene.is_taken)
    }

    /// Whether a robot may wait at a node for longer: at a rest place that nobody wants, or a
    /// lay-by if there is room.
    pub(super) fn is_place(&self, node: u32, scene: &Scene, has_room: bool) -> bool {
        let is_place = self.rests.contains(node) || (has_room && self.lay_bys.contains(node));
        is_place && !scene.is_taken[node as usize] && !scene.is_wanted[node as usize]
    }
}

/// The start of a way.
#[derive(Clone, Copy)]
pub struct Start {
    pub robot: u32,
    /// The leg that the robot's base ends on.
    pub last: Leg,
    pub node: u32,
}

impl Start {
    pub(super) fn search(&self, goal: u32) -> Search<'static> {
        Search {
            last: Some(self.last),
            start: self.node,
            goal,
            reverse: true,
            bound: Bound::Distance,
            slack: 0.0,
        }
    }
}
