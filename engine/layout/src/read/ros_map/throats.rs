//! Passages that robots fit through, but where a map is too coarse for a road.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec2;

use super::roadmap::MARGIN;

/// A map is coarse if a passage needs this multiple of the robot's width for a road.
const COARSE: f64 = 2.0;
/// The steps to the cells beside, above and below.
const SIDES: [[isize; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

/// Returns the width in cells from which on a passage surely has a road.
pub fn sure_width(robot_cells: f64) -> f64 {
    robot_cells + 2.0 * (MARGIN + FRAC_1_SQRT_2)
}

/// Whether a passage needs far more than the robot's width for a road.
pub fn is_coarse(robot_cells: f64) -> bool {
    sure_width(robot_cells) > COARSE * robot_cells
}

/// The free space that a robot fits into.
pub struct Throats<'a> {
    /// Squared distances of the centres of cells from the nearest cell that isn't free.
    pub squares: &'a [u32],
    /// The number of columns.
    pub width: usize,
    /// The robot's width in cells.
    pub robot_cells: f64,
}

impl Throats<'_> {
    /// Returns two nodes that no road connects though a robot fits through the free space between
    /// them; `None` if there are none. Nodes are in cells, edges their pairs.
    pub fn between(&self, nodes: &[DVec2], edges: &[[usize; 2]]) -> Option<[DVec2; 2]> {
        let parts = parts(nodes.len(), edges);
        if parts.iter().all(|part| *part == 0) {
            return None;
        }
        let mut seen = vec![false; self.squares.len()];
        for (node, part) in nodes.iter().zip(&parts) {
            if seen[self.cell(*node)] {
                continue;
            }
            let elsewhere: Vec<usize> =
                (0..nodes.len()).filter(|&other| !seen[self.cell(nodes[other])]).collect();
            self.flood(self.cell(*node), &mut seen);
            let others = elsewhere.into_iter().filter(|&other| parts[other] != *part);
            let mut others = others.map(|other| nodes[other]);
            if let Some(other) = others.find(|other| seen[self.cell(*other)]) {
                return Some([*node, other]);
            }
        }
        None
    }

    /// Marks the cells to which a robot can drive from a cell.
    fn flood(&self, start: usize, seen: &mut [bool]) {
        let mut open = vec![start];
        while let Some(cell) = open.pop() {
            if std::mem::replace(&mut seen[cell], true) {
                continue;
            }
            // The border of the map isn't free: what is beside a cell that fits is on the map.
            let beside = SIDES.map(|[x, y]| cell.wrapping_add_signed(x + y * self.width as isize));
            open.extend(beside.into_iter().filter(|&other| !seen[other] && self.fits(other)));
        }
    }

    /// Whether a robot fits onto a cell: half a cell of the distance belongs to the wall.
    fn fits(&self, cell: usize) -> bool {
        f64::from(self.squares[cell]).sqrt() >= self.robot_cells / 2.0 + 0.5
    }

    fn cell(&self, node: DVec2) -> usize {
        node.y as usize * self.width + node.x as usize
    }
}

/// Returns the connected part of each node, by number.
fn parts(nodes: usize, edges: &[[usize; 2]]) -> Vec<usize> {
    let mut neighbours = vec![Vec::new(); nodes];
    for &[from, to] in edges {
        neighbours[from].push(to);
        neighbours[to].push(from);
    }
    let mut parts = vec![usize::MAX; nodes];
    let mut next = 0;
    for node in 0..nodes {
        if parts[node] != usize::MAX {
            continue;
        }
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            if std::mem::replace(&mut parts[node], next) == usize::MAX {
                open.extend(neighbours[node].iter().filter(|&&other| parts[other] == usize::MAX));
            }
        }
        next += 1;
    }
    parts
}
