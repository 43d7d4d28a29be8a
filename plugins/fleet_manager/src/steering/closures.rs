//! Closures: legs that robots out of service block, edges that a command closes, and nodes that
//! robots could not leave again.

use regatta_base::components::{largest, strong_components};
use regatta_base::rows::Rows;
use regatta_plugin::closure::ClosedEdge;

use super::Steering;
use crate::claims::Claims;
use crate::roads::{Leg, Roads};

/// The time that a robot is held or broken before the roads that it blocks are closed, in seconds.
const CLOSE_AFTER_SECS: f64 = 10.0;

impl Steering {
    /// Whether a robot has been held or broken for so long that others are routed round it.
    pub fn is_out_of_service(&self, robot: u32) -> bool {
        self.robot(robot).is_some_and(|state| self.now - state.stuck_since >= CLOSE_AFTER_SECS)
    }

    /// Whether closures have cut a node off from the main component: robots there can't leave.
    pub fn is_cut_off(&self, node: u32) -> bool {
        self.closures.cut_off.get(node as usize).is_some_and(|cut_off| *cut_off)
    }

    /// Whether closures keep robots from coming to a node from the main component; robots that are
    /// there already may leave.
    pub fn is_out_of_reach(&self, node: u32) -> bool {
        self.closures.out_of_reach.get(node as usize).is_some_and(|out_of_reach| *out_of_reach)
    }

    /// Whether any roads are closed, or were until now: robots whose ways are open again have no
    /// routes yet.
    pub fn has_closures(&self) -> bool {
        !self.blockers.is_empty() || !self.closed_edges.is_empty() || self.is_closed_anew
    }

    /// Takes the edges that the engine keeps closed, sorted by id. Robots enter none of them any
    /// more: those whose bases lead there are stopped before it, and get another route.
    pub fn close_edges(&mut self, closed: &[ClosedEdge]) {
        if self.closed_by_command == closed {
            return;
        }
        self.closed_by_command = closed.to_vec();
        self.closed_edges.clear();
        for (index, edge) in (0..).zip(self.roads.edges()) {
            if closed.binary_search(&ClosedEdge { edge: edge.id }).is_ok() {
                self.closed_edges.push(index);
            }
        }
        self.next_check = self.now;
        self.is_closed_anew = true;
        for robot in 0..self.robots.len() as u32 {
            let ahead = self.claims.of(robot).iter().skip(1).filter_map(|stretch| stretch.leg);
            if ahead.into_iter().any(|leg| self.closed_edges.binary_search(&leg.edge()).is_ok()) {
                self.adopt(robot);
            }
        }
        for state in self.robots.iter_mut().flatten() {
            // If no other way leads to its goal, it would keep this one: no broken robot stands
            // there and stops it.
            if state.horizon.iter().any(|leg| self.closed_edges.binary_search(&leg.edge()).is_ok())
            {
                state.horizon.clear();
                state.replan();
            }
        }
    }

    /// The number of times that legs were closed or opened.
    pub fn closure_changes(&self) -> u64 {
        self.closure_changes
    }

    /// Whether a robot that blocked legs is in service again. It can get an order in this cycle,
    /// and has a way then.
    pub(super) fn is_blocker_back(&self) -> bool {
        self.blockers.iter().any(|(robot, _)| !self.is_out_of_service(*robot))
    }

    /// Closes the legs that robots out of service block, and opens those that they have left.
    pub(super) fn close_roads(&mut self) {
        let blockers: Vec<(u32, u64)> = (0..self.robots.len() as u32)
            .filter(|robot| self.is_out_of_service(*robot))
            .map(|robot| (robot, self.claims.version(robot)))
            .collect();
        if blockers == self.blockers && !std::mem::take(&mut self.is_closed_anew) {
            return;
        }
        let robots: Vec<u32> = blockers.iter().map(|(robot, _)| *robot).collect();
        self.blockers = blockers;
        let closures = Closures::of(&self.roads, &self.claims, &robots, &self.closed_edges);
        if closures.legs != self.closures.legs {
            self.closures = closures;
            self.closure_changes += 1;
            self.route_anew();
        }
    }

    /// Drops the routes that lead along closed legs, and those of robots whose goal couldn't be
    /// reached.
    fn route_anew(&mut self) {
        for state in self.robots.iter_mut().flatten() {
            let is_closed = state.horizon.iter().any(|leg| self.closures.legs[leg.index()]);
            if is_closed || state.is_unreachable() {
                state.replan();
            }
        }
    }
}

/// The closures that robots out of service and commands cause.
#[derive(Debug)]
pub(super) struct Closures {
    /// By leg: whether a command closes it, a robot on it would touch one out of service, or all
    /// ways back from it are closed.
    pub legs: Vec<bool>,
    /// By node: whether robots there can't come back; empty without closures.
    cut_off: Vec<bool>,
    /// By node: whether robots can't come there; empty without closures.
    out_of_reach: Vec<bool>,
}

impl Closures {
    /// The closures of roads on which all legs are open.
    pub fn none(roads: &Roads) -> Self {
        let legs = vec![false; 2 * roads.edges().len()];
        Self { legs, cut_off: Vec::new(), out_of_reach: Vec::new() }
    }

    fn of(roads: &Roads, claims: &Claims, blockers: &[u32], edges: &[u32]) -> Self {
        if blockers.is_empty() && edges.is_empty() {
            return Self::none(roads);
        }
        let mut legs = vec![false; 2 * roads.edges().len()];
        let open = Main::of(roads, &legs);
        for track in claims.tracks_near(roads, blockers) {
            for leg in [Leg::new(track, false), Leg::new(track, true)] {
                legs[leg.index()] = !claims.lets_pass(roads, leg, blockers);
            }
        }
        for leg in edges.iter().flat_map(|edge| [Leg::new(*edge, false), Leg::new(*edge, true)]) {
            legs[leg.index()] = true;
        }
        let main = Main::of(roads, &legs);
        // A robot ahead of a broken one still drives on, though no other can follow: only nodes
        // that no robot can leave are closed.
        let cut_off = lost(&open.behind, &main.behind);
        let out_of_reach = lost(&open.ahead, &main.ahead);
        for edge in 0..roads.edges().len() as u32 {
            let leg = Leg::new(edge, false);
            legs[leg.index()] |= cut_off[roads.end(leg) as usize];
        }
        Self { legs, cut_off, out_of_reach }
    }
}

/// Returns for each node whether it was in a set before and isn't now.
fn lost(before: &[bool], now: &[bool]) -> Vec<bool> {
    before.iter().zip(now).map(|(before, now)| *before && !now).collect()
}

/// The main component: the largest set of nodes that can all be reached from each other in forward
/// gear.
struct Main {
    /// By node: whether it can be reached from the component.
    ahead: Vec<bool>,
    /// By node: whether the component can be reached from it.
    behind: Vec<bool>,
}

impl Main {
    fn of(roads: &Roads, closed: &[bool]) -> Self {
        let legs = (0..roads.edges().len() as u32)
            .map(|edge| Leg::new(edge, false))
            .filter(|leg| !closed[leg.index()]);
        let ways: Vec<(u32, u32)> = legs.map(|leg| (roads.start(leg), roads.end(leg))).collect();
        let back = ways.iter().map(|(start, end)| (*end, *start)).collect();
        let nodes = roads.nodes() as usize;
        let (ahead, behind) = (Rows::new(nodes, ways), Rows::new(nodes, back));
        let seed = largest(&strong_components(&ahead));
        Self { ahead: reachable(&ahead, seed), behind: reachable(&behind, seed) }
    }
}

/// Returns for each node whether it can be reached from one, given the neighbours of each.
fn reachable(neighbours: &Rows<u32>, from: u32) -> Vec<bool> {
    let mut is_reached = vec![false; neighbours.len()];
    let mut open = Vec::new();
    if let Some(reached) = is_reached.get_mut(from as usize) {
        *reached = true;
        open.push(from);
    }
    while let Some(node) = open.pop() {
        for &next in neighbours.row(node) {
            if !std::mem::replace(&mut is_reached[next as usize], true) {
                open.push(next);
            }
        }
    }
    is_reached
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{
        CurveRecord, EdgeRecord, NodeRecord, Orientation, RobotTypeRecord, WorldData,
    };

    use super::*;
    use crate::claims::Stretch;
    use crate::model::worlds;

    #[test]
    fn what_can_be_reached() {
        let neighbours = Rows::new(4, vec![(0, 1), (1, 2), (3, 0)]);
        assert_eq!(reachable(&neighbours, 0), [true, true, true, false]);
        assert_eq!(reachable(&neighbours, 3), [true; 4]);
        assert_eq!(reachable(&neighbours, 2), [false, false, true, false]);
    }

    /// A ring of three nodes among many that no road leads to.
    #[test]
    fn the_main_component_is_found_wherever_it_is() {
        let points: Vec<[f32; 2]> = (0..16).map(|node| [10.0 * node as f32, 0.0]).collect();
        let edges = [[1, 3], [3, 5], [5, 1], [1, 7]];
        let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
        let roads = Roads::new(&world.view(1, 1));
        let main = Main::of(&roads, &vec![false; 2 * edges.len()]);
        let nodes = |set: &[bool]| (0..16).filter(|node| set[*node]).collect::<Vec<_>>();
        assert_eq!((nodes(&main.ahead), nodes(&main.behind)), (vec![1, 3, 5, 7], vec![1, 3, 5]));
    }

    /// A loop of three edges, with a spur of two edges from its first node and back.
    fn loop_with_spur() -> WorldData {
        let mut world = WorldData {
            robot_types: vec![RobotTypeRecord::new("", 0.9, 0.6)],
            ..WorldData::default()
        };
        let places = [[0.0, 0.0], [20.0, 0.0], [10.0, 20.0], [-20.0, -10.0]];
        for (id, [x, y]) in (0..).zip(places) {
            world.nodes.push(NodeRecord { id, x, y, ..NodeRecord::default() });
        }
        for (id, (origin, destination)) in (0..).zip([(0, 1), (1, 2), (2, 0), (0, 3), (3, 0)]) {
            let [from, to] = [origin, destination].map(|node: u32| places[node as usize]);
            let bend = if id == 4 { 6.0 } else { 0.0 };
            let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]) - bend];
            let curve = CurveRecord { control_points: [from, middle, middle, to] };
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let edge =
                EdgeRecord { id, origin, destination, length, speed: 1.0, ..EdgeRecord::default() };
            world.add_edge(edge, [curve]);
        }
        world
    }

    #[test]
    fn a_way_that_leads_only_to_a_blocked_one_is_closed_too() {
        let roads = Roads::new(&loop_with_spur().view(1, 1));
        let mut claims = Claims::new(&roads, true);
        let stand = |edge: u32| {
            let middle = 0.5 * roads.edge(edge).length;
            Stretch::at(Leg::new(edge, false), middle)
        };
        claims.seize(&roads, 7, 0, stand(4));
        let closures = Closures::of(&roads, &claims, &[7], &[]);
        let closed: Vec<u32> =
            (0..5).filter(|edge| closures.legs[Leg::new(*edge, false).index()]).collect();
        assert_eq!(
            (closed.as_slice(), closures.cut_off.as_slice()),
            (&[3, 4][..], &[false, false, false, true][..])
        );
        let none = Closures::of(&roads, &claims, &[], &[]);
        assert!(none.legs.iter().all(|closed| !closed));
        let commanded = Closures::of(&roads, &claims, &[], &[4]);
        assert_eq!(
            commanded.cut_off, closures.cut_off,
            "an edge that is closed by a command cuts off the same nodes"
        );
        assert!(
            commanded.legs[Leg::new(3, false).index()] && commanded.legs[Leg::new(4, true).index()]
        );
    }

    #[test]
    fn who_is_ahead_of_a_blocker_may_drive_on() {
        // A loop of three edges, and a second way from its first node to the next: over node 3.
        let points = [[0.0, 0.0], [20.0, 0.0], [10.0, 20.0], [10.0, -20.0]];
        let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [3, 1]];
        let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
        let roads = Roads::new(&world.view(1, 1));
        let closures = |edge: u32| {
            let mut claims = Claims::new(&roads, true);
            let middle = 0.5 * roads.edge(edge).length;
            let stand = Stretch::at(Leg::new(edge, false), middle);
            claims.seize(&roads, 7, 0, stand);
            let Closures { legs, cut_off, out_of_reach } = Closures::of(&roads, &claims, &[7], &[]);
            let closed: Vec<u32> =
                (0..5).filter(|edge| legs[Leg::new(*edge, false).index()]).collect();
            (closed, cut_off[3], out_of_reach[3])
        };
        assert_eq!(closures(3), (vec![3], false, true));
        assert_eq!(closures(4), (vec![3, 4], true, false));
    }
}
