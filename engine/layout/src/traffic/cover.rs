//! A bound on the robots that fit on roads, wherever they stop.
//!
//! The roads are cut into short stretches. Of two stretches whose robots touch wherever they are on
//! them, only one can have a robot. A group of stretches, any two of which exclude each other like
//! that, has one robot at most: the number of groups that cover all stretches bounds the number of
//! robots. A group reaches as far as a robot is long, and also over roads beside its own that are
//! too close for two robots.

use regatta_base::cores;
use regatta_base::graph::EdgeIndex;
use regatta_base::sweep::{Footprint, Grid, Rectangle};

use super::conflicts::sweep_with;
use super::levels::Levels;
use super::network::Network;
use super::robot::{RobotType, Turning};

/// The stretches of a robot's length: with more of them, the bound is closer.
const STRETCHES: f64 = 32.0;
/// The most stretches of a layout; with longer roads, stretches are longer.
const MOST_STRETCHES: f64 = 400_000.0;

/// Bounds the number of robots on the roads of the main part.
pub fn most_on_roads(network: &Network<'_>, robot: &RobotType) -> u64 {
    let edges = walk(network);
    let lengths = edges.iter().map(|&edge| network.graph.edge(EdgeIndex(edge)).path.length());
    let metres: f64 = lengths.clone().sum();
    let step = (robot.length() / STRETCHES).max(metres / MOST_STRETCHES);
    let longest = 0.5 * robot.length().min(robot.width());
    if step > longest {
        return lengths.map(|length| in_line(length, robot)).sum();
    }
    let cover = Cover::new(network, robot, &edges, step);
    // A part without edges is a node.
    (cover.groups() + cover.on_others).max(1)
}

/// Returns the edges of the main part in an order in which most follow the one before.
fn walk(network: &Network<'_>) -> Vec<u32> {
    let is_outside = network
        .graph
        .edges()
        .iter()
        .map(|edge| !(network.is_main(edge.origin.0) && network.is_main(edge.destination.0)));
    let mut is_seen: Vec<bool> = is_outside.collect();
    let mut edges = Vec::new();
    for first in 0..is_seen.len() as u32 {
        let mut open = vec![first];
        while let Some(edge) = open.pop() {
            if !std::mem::replace(&mut is_seen[edge as usize], true) {
                edges.push(edge);
                let end = network.graph.edge(EdgeIndex(edge)).destination;
                let ahead = network.departures(end.0).iter().map(|leg| leg.edge.0);
                open.extend(ahead.filter(|&next| !is_seen[next as usize]));
            }
        }
    }
    edges
}

/// A stretch of an edge: robots on it hold its core, wherever they are.
struct Stretch {
    edge: u32,
    core: Rectangle,
}

/// The stretches of an edge.
struct Stretches {
    with_core: Vec<Stretch>,
    /// The robots that fit on those that are too long for a core, as in curves whose parameter
    /// runs unevenly.
    on_others: u64,
}

/// The stretches of roads, in the order of a walk.
struct Cover {
    stretches: Vec<Stretch>,
    /// The robots that fit elsewhere.
    on_others: u64,
    grid: Grid,
    levels: Levels,
}

impl Cover {
    /// Cuts edges into stretches of at most `step` metres, half of a robot's smaller side or less.
    fn new(network: &Network<'_>, robot: &RobotType, edges: &[u32], step: f64) -> Self {
        let footprint = robot.footprint();
        let of_edges =
            cores::map(edges.len(), |index| stretches(network, robot, edges[index], step));
        let on_others = of_edges.iter().map(|of_edge| of_edge.on_others).sum();
        let stretches: Vec<Stretch> =
            of_edges.into_iter().flat_map(|of_edge| of_edge.with_core).collect();
        let cores: Vec<&[Rectangle]> =
            stretches.iter().map(|stretch| std::slice::from_ref(&stretch.core)).collect();
        let grid = Grid::new(&cores, cell(&footprint));
        Self { levels: Levels::new(network.graph), grid, stretches, on_others }
    }

    /// Covers all stretches with groups, each begun at the first one left. Returns their number.
    fn groups(&self) -> u64 {
        let mut is_covered = vec![false; self.stretches.len()];
        let mut groups = 0;
        let mut group: Vec<u32> = Vec::new();
        for first in 0..self.stretches.len() as u32 {
            if is_covered[first as usize] {
                continue;
            }
            groups += 1;
            let ahead = self.run(first, &is_covered);
            group.clear();
            group.extend(first..ahead);
            let near = self.grid.near(&[self.stretches[first as usize].core]);
            for next in near.into_iter().filter(|&next| next > ahead) {
                if !is_covered[next as usize] && self.joins(next, &group) {
                    group.push(next);
                }
            }
            for &member in &group {
                is_covered[member as usize] = true;
            }
        }
        groups
    }

    /// Returns the end of the stretches that follow a first one in a group. The last one that joins
    /// is left to the next group: otherwise, stretches of roads beside it fall between two groups.
    fn run(&self, first: u32, is_covered: &[bool]) -> u32 {
        let mut run = vec![first];
        let all = self.stretches.len() as u32;
        let mut next = first + 1;
        while next < all && !is_covered[next as usize] && self.joins(next, &run) {
            run.push(next);
            next += 1;
        }
        if next < all && run.len() > 2 { next - 1 } else { next }
    }

    /// Whether robots on a stretch touch those on each stretch of a group.
    fn joins(&self, next: u32, group: &[u32]) -> bool {
        let next = &self.stretches[next as usize];
        group.iter().map(|&member| &self.stretches[member as usize]).all(|member| {
            member.core.touches(&next.core) && self.levels.are_shared(member.edge, next.edge)
        })
    }
}

/// The side of the grid's cells in metres: stretches that touch share one.
fn cell(footprint: &Footprint) -> f32 {
    footprint.radius()
}

/// Cuts an edge; robots that turn on the spot do so in the first and the last stretch.
fn stretches(network: &Network<'_>, robot: &RobotType, edge: u32, step: f64) -> Stretches {
    let sweep = sweep_with(network.graph.edge(EdgeIndex(edge)), step);
    let footprint = robot.footprint();
    let (last, turns) = (sweep.boxes().len() - 1, robot.turning() == Turning::OnTheSpot);
    let mut stretches = Stretches { with_core: Vec::new(), on_others: 0 };
    for (place, part) in sweep.boxes().iter().enumerate() {
        let is_end = place == 0 || place == last;
        let part = if is_end && turns { part.of_any_heading() } else { *part };
        match part.core(&footprint) {
            Some(core) => stretches.with_core.push(Stretch { edge, core }),
            None => stretches.on_others += in_line(f64::from(part.s.high - part.s.low), robot),
        }
    }
    stretches
}

/// Bounds the robots on a stretch, both ends included: the middles of robots that don't touch are a
/// smaller side apart.
fn in_line(metres: f64, robot: &RobotType) -> u64 {
    (metres / robot.length().min(robot.width())).ceil() as u64 + 1
}
