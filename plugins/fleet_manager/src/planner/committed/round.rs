//! A round: all robots that need a way get one, or make room for those that do.

use super::commit::Start;
use super::{Committed, is_able};
use crate::planner::{Plans, Search};
use crate::roads::Leg;
use crate::traffic::{Errand, Robot, Traffic};

/// The interval between attempts to commit a robot to a way, in seconds.
const ROUND_SECS: f64 = 0.5;
/// The time after which a robot without an errand leaves a place that isn't its own, in seconds.
const IDLE_SECS: f64 = 1.0;
/// The least time after which a robot that can't go to its goal yet drives to the end of its way,
/// in seconds.
const RETREAT_SECS: f64 = 2.0;
/// The time after which a robot that waits looks for another way, in seconds.
const REROUTE_SECS: f64 = 3.0;
/// The time without an arrival after which others let a robot without a way go first, in seconds.
const STARVED_SECS: f64 = 180.0;
/// The number of legs looked at in a round after which the other robots have to wait for the next
/// round: some milliseconds.
const MOST_WORK: u64 = 300_000;

impl Committed {
    /// Gives robots ways: those first that were sent the longest ago.
    pub(super) fn commit_all(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        let mut due = due(traffic);
        let is_round = traffic.now >= self.next_round;
        if is_round {
            self.next_round = traffic.now + ROUND_SECS;
        }
        let starved = self.starved(traffic, &due);
        self.rotate(&mut due);
        let until = self.state.work() + MOST_WORK;
        if is_round {
            self.asked.clear();
            self.asks = None;
            self.wished.retain(|robot, _| traffic.robot(*robot).is_some_and(Robot::is_under_way));
        }
        for (_, robot) in due {
            let Some(state) = traffic.robot(robot) else { continue };
            // Robots are sent at the time of the cycle before.
            let is_new = self.tried.get(&robot).is_none_or(|tried| *tried <= state.sent);
            let has_time = self.state.work() < until;
            if !has_time || (!is_round && !is_new) {
                continue;
            }
            self.wished.remove(&robot);
            let lets_pass = starved.is_some_and(|starved| self.lets_pass(traffic, robot, starved));
            self.tried.insert(robot, traffic.now);
            if let Some(way) = self.commitment(robot)
                && state.needs_route()
                && way.goal == state.goal()
            {
                plans.route(robot, way.way[..way.sent].to_vec());
                continue;
            }
            match self.goes_to_goal(robot, state) {
                true => self.reroute(traffic, robot, state, plans),
                false => {
                    let has_way = !lets_pass && self.commit(traffic, robot, plans);
                    if !has_way && !self.make_room(traffic, robot, state, plans) {
                        self.retreat(traffic, robot, state, plans);
                    }
                }
            }
        }
    }

    /// Puts those behind the first robot first that were tried the longest ago.
    fn rotate(&self, due: &mut [(f64, u32)]) {
        let Some((_, others)) = due.split_first_mut() else { return };
        others.sort_by(|a, b| self.last_tried(a.1).total_cmp(&self.last_tried(b.1)));
    }

    /// The time at which a robot was tried last; minus infinity if it never was.
    fn last_tried(&self, robot: u32) -> f64 {
        self.tried.get(&robot).copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// Whether a robot is committed to a way to its goal.
    pub(super) fn goes_to_goal(&self, robot: u32, state: &Robot) -> bool {
        self.commitment(robot).is_some_and(|way| way.goal == state.goal() && !state.needs_route())
    }

    /// The robot without a way to its goal that has waited for one the longest, if that is too
    /// long.
    pub(super) fn starved(&self, traffic: &Traffic<'_>, due: &[(f64, u32)]) -> Option<u32> {
        let mut waiting = due.iter().filter(|(sent, _)| goes_first(traffic.now - sent));
        let found = waiting.find(|(_, robot)| {
            traffic.robot(*robot).is_some_and(|state| !self.goes_to_goal(*robot, state))
        });
        found.map(|(_, robot)| *robot)
    }

    /// Whether a robot has to wait until a starved one has a way: it stands, or has the same goal.
    pub(super) fn lets_pass(&self, traffic: &Traffic<'_>, robot: u32, starved: u32) -> bool {
        let goal = |robot: u32| traffic.robot(robot).and_then(Robot::goal);
        let stands = traffic.robot(robot).is_some_and(|state| state.speed == 0.0);
        robot != starved && (stands || goal(robot) == goal(starved))
    }

    /// Looks for another way for a robot that waits.
    pub(super) fn reroute(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        state: &Robot,
        plans: &mut Plans,
    ) {
        let since = state.waiting_since.max(state.planned);
        if traffic.now - since < REROUTE_SECS || state.horizon.is_empty() {
            return;
        }
        let before = self.commitment(robot).cloned();
        if self.commit(traffic, robot, plans) {
            self.counts.detours += 1;
        } else if let Some(commitments) = self.commitments.get_mut(robot as usize) {
            *commitments = before;
        }
    }

    /// Asks the robots that block a way to make room: those that have no way themselves.
    pub(super) fn ask(&mut self, traffic: &Traffic<'_>, robot: u32, way: &[Leg]) {
        // Several at once would send each other to and fro.
        if self.asks.is_some_and(|asks| asks != robot) {
            return;
        }
        self.asks = Some(robot);
        let nodes: Vec<u32> = way.iter().map(|&leg| traffic.roads.end(leg)).collect();
        let legs: Vec<u32> = way.iter().map(|leg| leg.index() as u32).collect();
        for (other, state) in traffic.robots().filter(|(other, _)| *other != robot) {
            let Some(end) = traffic.claims.end(other) else { continue };
            let goes_on = self.goes_on(traffic, other);
            let blocked = self.blocks.of(traffic.roads, state.class.footprint, end);
            if !goes_on && legs.iter().any(|leg| blocked.binary_search(leg).is_ok()) {
                self.asked.entry(other).or_insert_with(|| nodes.clone());
            }
        }
    }

    /// Commits a robot that can't go to its goal yet, and is in the way of one that was sent
    /// before, to a way to a place where it isn't. Returns whether it has one.
    pub(super) fn make_room(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        state: &Robot,
        plans: &mut Plans,
    ) -> bool {
        if traffic.now - state.sent < IDLE_SECS || self.goes_on(traffic, robot) {
            return false;
        }
        let Some(way) = self.way_aside(traffic, robot, state) else { return false };
        let Some((last, node)) = traffic.base_end(robot) else { return false };
        let length = way.len();
        self.take(traffic, &Start { robot, last, node }, way, (length, None), plans)
    }

    /// Returns the way of a robot that is asked to make room to the nearest place that nobody
    /// wants; `None` if it isn't asked, or there is none.
    pub(super) fn way_aside(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        state: &Robot,
    ) -> Option<Vec<Leg>> {
        let avoided = self.asked.get(&robot).cloned()?;
        let (last, node) = traffic.base_end(robot)?;
        let scene = self.scene(traffic, robot, &[]);
        let start = Start { robot, last, node };
        let has_room = self.has_room(traffic, &scene);
        let Self { router, rests, lay_bys, .. } = self;
        let is_free = |node: u32| node != start.node && !scene.is_taken[node as usize];
        let search = start.search(Search::NO_NODE);
        for wanted_too in [false, true] {
            let aside = router.nearest(
                traffic.roads,
                &state.class,
                search,
                |leg| scene.cost(leg),
                |node| {
                    let is_good = is_free(node) && !avoided.contains(&node);
                    rests.contains(node)
                        && is_good
                        && (wanted_too || !scene.is_wanted[node as usize])
                },
            );
            if aside.is_some() {
                return aside;
            }
        }
        if !has_room {
            return None;
        }
        router.nearest(
            traffic.roads,
            &state.class,
            search,
            |leg| scene.cost(leg),
            |node| lay_bys.contains(node) && is_free(node),
        )
    }

    /// Lets a robot that can't go to its goal yet drive to the end of its way, where it is in
    /// nobody's way: at once if another one needs its place, or there are fewer places of rest than
    /// robots.
    pub(super) fn retreat(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        state: &Robot,
        plans: &mut Plans,
    ) {
        let has_route = !state.needs_route() && !state.horizon.is_empty();
        let goes_on = self.goes_on(traffic, robot);
        let waited_secs = traffic.now - state.sent;
        if waited_secs < RETREAT_SECS || has_route || !goes_on {
            return;
        }
        let is_needed = self.rests.len() < traffic.robots().count()
            || self.asked.contains_key(&robot)
            || self.is_in_way(traffic, robot)
            || self.is_in_wished_way(traffic, robot);
        if let Some(goal) = state.goal().filter(|_| !is_needed)
            && waited_secs < self.detour_secs(traffic, robot, goal)
        {
            return;
        }
        if let Some(commitment) = &mut self.commitments[robot as usize]
            && (state.needs_route() || !commitment.way.is_empty())
        {
            commitment.goal = None;
            commitment.sent = commitment.way.len();
            plans.route(robot, commitment.way.clone());
        }
    }

    /// Whether a robot stands where another one would drive that waits for a way.
    fn is_in_wished_way(&mut self, traffic: &Traffic<'_>, robot: u32) -> bool {
        let (Some(state), Some(&end)) = (traffic.robot(robot), traffic.claims.end(robot)) else {
            return false;
        };
        let blocked = self.blocks.of(traffic.roads, state.class.footprint, &end);
        let mut others = self.wished.iter().filter(|(other, _)| **other != robot);
        others.any(|(_, wished)| wished.iter().any(|key| blocked.binary_search(key).is_ok()))
    }

    /// The driving time to a robot's goal that it loses if it drives to the end of its way first,
    /// in seconds. As long as it is in nobody's way, it waits for so long before it drives there:
    /// it loses at most twice as much as if it knew how long it has to wait (A. Karlin et al.:
    /// Competitive snoopy caching, Algorithmica 3, 1988).
    fn detour_secs(&mut self, traffic: &Traffic<'_>, robot: u32, goal: u32) -> f64 {
        let (Some(commitment), Some((_, node))) = (self.commitment(robot), traffic.base_end(robot))
        else {
            return 0.0;
        };
        let end = commitment.end;
        for to in [end, goal] {
            self.times.prepare(traffic.roads, to);
        }
        let [to_end, from_there, direct] = [(node, end), (end, goal), (node, goal)]
            .map(|(from, to)| self.times.between(traffic.roads, from, to));
        match (to_end, from_there, direct) {
            (Some(to_end), Some(from_there), Some(direct)) => to_end + from_there - direct,
            _ => 0.0,
        }
    }

    /// Sends robots without an errand to rest places, and gives those that have something to do
    /// where they stand a way on.
    pub(super) fn settle(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        for (robot, state) in traffic.robots() {
            let is_idle = state.errand == Errand::None && is_able(state);
            let since = match is_idle {
                true => *self.idle_since.entry(robot).or_insert(traffic.now),
                false => {
                    self.idle_since.remove(&robot);
                    traffic.now
                }
            };
            if !is_able(state) || state.goal().is_some() {
                continue;
            }
            if self.commitment(robot).is_none() {
                self.commit_to_rest(traffic, robot, state, plans);
            }
            if !is_idle || traffic.now - since < IDLE_SECS {
                continue;
            }
            let aside = self.way_aside(traffic, robot, state);
            let aside = aside.and_then(|way| Some(traffic.roads.end(*way.last()?)));
            let way_end = self.commitment(robot).filter(|way| !way.way.is_empty());
            if let Some(end) = way_end.map(|way| way.end).or(aside) {
                plans.evicted.push((robot, end));
            }
        }
    }

    pub(super) fn commit_to_rest(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        state: &Robot,
        plans: &mut Plans,
    ) {
        let Some((last, node)) = traffic.base_end(robot) else { return };
        let scene = self.scene(traffic, robot, &[]);
        let start = Start { robot, last, node };
        if let Some(way) = self.tail(traffic, state, &start, &scene) {
            self.take(traffic, &start, way, (0, None), plans);
        }
    }
}

/// The robots that are under way, and when they were sent: the longest ago first.
fn due(traffic: &Traffic<'_>) -> Vec<(f64, u32)> {
    let robots = traffic.robots().filter(|(_, state)| state.is_under_way());
    let mut due: Vec<(f64, u32)> = robots.map(|(robot, state)| (state.sent, robot)).collect();
    due.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    due
}

/// Whether others let a robot without a way go first that has waited for so many seconds: by turns,
/// as it may get no way at all.
fn goes_first(waited_secs: f64) -> bool {
    waited_secs % (2.0 * STARVED_SECS) > STARVED_SECS
}
