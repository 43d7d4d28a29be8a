//! A roadmap along the skeleton of the free space.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec2;

use super::chains::{Chains, trace};
use super::grid::Grid;
use super::points::without_chain;
use super::skeleton::{skeleton, squared_distances};
use super::throats::Throats;

/// The margin between the robot's side and the nearest cell that isn't free, in cells, in addition
/// to half a diagonal.
pub const MARGIN: f64 = 1.0;

/// The largest distance in cells of a simplified road from the skeleton.
const TOLERANCE: f64 = 1.0;

/// The interval of clearance checks in cells.
const STEP: f64 = 0.25;

/// The smallest length of a connected part of the roadmap, in widths of the robot.
const LEAST_WIDTHS: f64 = 5.0;

/// Straight roads between nodes, in cells from the corner of the grid. Each bend is a node, where
/// robots can turn.
#[derive(Debug, Default)]
pub struct Roadmap {
    pub nodes: Vec<DVec2>,
    /// Pairs of indices of nodes.
    pub edges: Vec<[usize; 2]>,
    /// The number of connected parts that are left out, and their length in metres.
    pub dropped: usize,
    pub dropped_length: f64,
    /// A place in each free area that has no road, as its skeleton is a point.
    pub points: Vec<DVec2>,
    /// Two nodes that no road connects though a robot fits through the free space between them.
    pub apart: Option<[DVec2; 2]>,
}

impl Roadmap {
    /// Makes a roadmap for robots with a width in metres.
    pub fn new(grid: &Grid, robot_width: f64) -> Self {
        let squares = squared_distances(grid);
        let robot_cells = robot_width / grid.resolution;
        let least =
            (robot_cells / 2.0 + FRAC_1_SQRT_2 + MARGIN).powi(2).ceil().min(f64::from(u32::MAX))
                as u32;
        let cells = skeleton(&squares, grid.width, least);
        let space = Space { squares, width: grid.width, radius: robot_cells / 2.0 };
        let mut chains = Chains { chains: trace(&cells, &space), space: &space };
        chains.prune(robot_cells);
        chains.merge_junctions();
        chains.split_loops();
        let points = without_chain(&cells, grid.width, &chains.chains);
        let points = points.into_iter().map(|cell| space.centre(cell)).collect();
        let least_length = LEAST_WIDTHS * robot_cells;
        let (dropped, dropped_length) = chains.drop_short_parts(least_length);
        let mut roadmap = Self {
            dropped,
            dropped_length: dropped_length * grid.resolution,
            points,
            ..Self::default()
        };
        roadmap.add_roads(&chains.chains, &space);
        let throats = Throats { squares: &space.squares, width: space.width, robot_cells };
        roadmap.apart = throats.between(&roadmap.nodes, &roadmap.edges);
        roadmap
    }

    fn add_roads(&mut self, chains: &[Vec<u32>], space: &Space) {
        let (mut by_cell, mut seen) = (BTreeMap::new(), BTreeSet::new());
        for chain in chains {
            let nodes: Vec<usize> = space
                .simplify(chain)
                .into_iter()
                .map(|cell| {
                    *by_cell.entry(cell).or_insert_with(|| {
                        self.nodes.push(space.centre(cell));
                        self.nodes.len() - 1
                    })
                })
                .collect();
            // Lines to merged junctions have their last cells in common.
            let roads = nodes.windows(2).map(|pair| [pair[0], pair[1]]);
            self.edges
                .extend(roads.filter(|[from, to]| seen.insert([*from.min(to), *from.max(to)])));
        }
    }
}

/// The free space.
pub struct Space {
    /// Squared distances in cells.
    pub squares: Vec<u32>,
    /// The number of columns.
    pub width: usize,
    /// Half the robot's width in cells.
    radius: f64,
}

impl Space {
    pub fn centre(&self, cell: u32) -> DVec2 {
        let cell = cell as usize;
        DVec2::new((cell % self.width) as f64 + 0.5, (cell / self.width) as f64 + 0.5)
    }

    pub fn distance(&self, cell: u32) -> f64 {
        f64::from(self.squares[cell as usize]).sqrt()
    }

    /// Returns whether robots on a segment are clear of all cells that aren't free.
    fn is_clear(&self, start: DVec2, end: DVec2) -> bool {
        let count = (start.distance(end) / STEP).ceil().max(1.0) as u32;
        (0..=count).all(|index| {
            let point = start.lerp(end, f64::from(index) / f64::from(count));
            let cell = point.y as usize * self.width + point.x as usize;
            let to_centre = point.distance(self.centre(cell as u32));
            let clearance = self.distance(cell as u32) - to_centre - FRAC_1_SQRT_2;
            // Between two points, the clearance is less by at most half the step.
            clearance >= self.radius + STEP / 2.0
        })
    }

    /// Returns the cells of a line with fewer bends that is clear (Ramer, Douglas and Peucker).
    fn simplify(&self, chain: &[u32]) -> Vec<u32> {
        let points: Vec<DVec2> = chain.iter().map(|&cell| self.centre(cell)).collect();
        let mut simple = Vec::new();
        let mut parts = vec![(0, points.len() - 1)];
        while let Some((first, last)) = parts.pop() {
            let (start, end) = (points[first], points[last]);
            let farthest = (first + 1..last)
                .map(|index| (index, distance_to_segment(points[index], start, end)))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            match farthest {
                Some((middle, distance)) if distance > TOLERANCE || !self.is_clear(start, end) => {
                    parts.push((middle, last));
                    parts.push((first, middle));
                }
                _ => simple.push(chain[first]),
            }
        }
        simple.extend(chain.last());
        simple
    }
}

fn distance_to_segment(point: DVec2, start: DVec2, end: DVec2) -> f64 {
    let along = end - start;
    let fraction = (point - start).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    point.distance(start + along * fraction.clamp(0.0, 1.0))
}
