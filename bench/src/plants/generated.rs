//! Generated plants: combs, loops, trees, grids and halls, as tables of nodes and edges in CSV.

use std::fmt::Write as _;
use std::path::Path;

use regatta::experiment::write;
use regatta::failure::Failure;
use regatta_base::random::Random;

use super::manifest::{Kind, Source};

/// The distance between two neighbouring nodes, in metres.
const SPACING: f64 = 4.0;
/// The width of the random offsets of a hall's nodes, in metres.
const JITTER: f64 = 1.2;
/// Of the nodes of a hall: one in so many is a station.
const STATION_EVERY: usize = 5;
/// Of the neighbours that the tree of a hall doesn't join: one in so many is joined, too.
const CHORD_EVERY: usize = 4;

/// A plant in the making. Names of nodes are their numbers.
#[derive(Default)]
struct Table {
    /// Metres east and north, and whether it is a station.
    nodes: Vec<([f64; 2], bool)>,
    edges: Vec<[usize; 2]>,
}

/// The name of a generated plant, and how it is made.
struct Recipe {
    name: &'static str,
    table: fn() -> Table,
}

/// Each has a name that tells its size: docks, nodes around, levels, columns and rows, nodes.
const RECIPES: &[Recipe] = &[
    Recipe { name: "comb-6", table: || comb(6, 1) },
    Recipe { name: "comb-12", table: || comb(12, 1) },
    Recipe { name: "comb-20", table: || comb(20, 1) },
    Recipe { name: "comb-12-deep", table: || comb(12, 3) },
    Recipe { name: "loop-8", table: || ring(8, 0) },
    Recipe { name: "loop-24", table: || ring(24, 0) },
    Recipe { name: "loop-60", table: || ring(60, 0) },
    Recipe { name: "loop-16-docks", table: || ring(16, 1) },
    Recipe { name: "loop-32-docks", table: || ring(32, 2) },
    Recipe { name: "tree-3", table: || tree(3) },
    Recipe { name: "tree-4", table: || tree(4) },
    Recipe { name: "tree-6", table: || tree(6) },
    Recipe { name: "grid-4x4", table: || grid(4, 4, Ways::Both) },
    Recipe { name: "grid-8x8", table: || grid(8, 8, Ways::Both) },
    Recipe { name: "grid-6x6-one-way", table: || grid(6, 6, Ways::One) },
    Recipe { name: "grid-12x12-one-way", table: || grid(12, 12, Ways::One) },
    Recipe { name: "hall-7", table: || hall(7) },
    Recipe { name: "hall-20", table: || hall(20) },
    Recipe { name: "hall-60", table: || hall(60) },
    Recipe { name: "hall-200", table: || hall(200) },
    Recipe { name: "hall-600", table: || hall(600) },
    Recipe { name: "hall-2000", table: || hall(2000) },
];

/// The directions in which the aisles of a grid are driven.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ways {
    Both,
    /// Neighbouring aisles in opposite directions.
    One,
}

/// Writes the generated plants to a folder.
pub fn write_generated(folder: &Path) -> Result<Vec<Source>, Failure> {
    let mut sources = Vec::new();
    for Recipe { name, table } in RECIPES {
        let path = folder.join(format!("{name}.csv"));
        write(&path, &table().text())?;
        sources.push(Source { name: format!("generated/{name}"), path, kind: Kind::Generated });
    }
    Ok(sources)
}

impl Table {
    fn node(&mut self, position: [f64; 2], is_station: bool) -> usize {
        self.nodes.push((position, is_station));
        self.nodes.len() - 1
    }

    fn one_way(&mut self, from: usize, to: usize) {
        self.edges.push([from, to]);
    }

    fn two_way(&mut self, a: usize, b: usize) {
        self.edges.extend([[a, b], [b, a]]);
    }

    /// A dead end of two-way track with a dock at its end.
    fn dock(&mut self, spine: usize, [dx, dy]: [f64; 2], edges: usize) {
        let mut from = spine;
        for step in 1..=edges {
            let [x, y] = self.nodes[from].0;
            let next = self.node([x + SPACING * dx, y + SPACING * dy], step == edges);
            self.two_way(from, next);
            from = next;
        }
    }

    /// The text. Stations are picked at and dropped at in turn.
    fn text(&self) -> String {
        let mut text = "id,x,y,role\n".to_owned();
        let mut stations = 0;
        for (id, ([x, y], is_station)) in self.nodes.iter().enumerate() {
            let role = if *is_station { ["pick", "drop"][stations % 2] } else { "" };
            stations += usize::from(*is_station);
            // Writing to a `String` never fails.
            let _ = writeln!(text, "{id},{x},{y},{role}");
        }
        text += "\nfrom,to\n";
        for [from, to] in &self.edges {
            let _ = writeln!(text, "{from},{to}");
        }
        text
    }
}

/// A two-way spine with docks on both sides in turn, each at the end of so many edges.
fn comb(docks: usize, depth: usize) -> Table {
    let mut table = Table::default();
    let spine: Vec<usize> =
        (0..docks).map(|dock| table.node([SPACING * dock as f64, 0.0], false)).collect();
    for pair in spine.windows(2) {
        table.two_way(pair[0], pair[1]);
    }
    for (index, node) in spine.into_iter().enumerate() {
        table.dock(node, [0.0, if index % 2 == 0 { 1.0 } else { -1.0 }], depth);
    }
    table
}

/// A one-way ring. Each fourth of its nodes is a station, or has one at the end of a dead end of so
/// many edges.
fn ring(nodes: usize, depth: usize) -> Table {
    let mut table = Table::default();
    let radius = SPACING * nodes as f64 / std::f64::consts::TAU;
    for index in 0..nodes {
        let (sin, cos) = (std::f64::consts::TAU * index as f64 / nodes as f64).sin_cos();
        table.node([radius * cos, radius * sin], depth == 0 && index % 4 == 0);
    }
    for index in 0..nodes {
        table.one_way(index, (index + 1) % nodes);
    }
    for index in (0..nodes).step_by(4) {
        let [x, y] = table.nodes[index].0;
        table.dock(index, [x / radius, y / radius], depth);
    }
    table
}

/// A binary tree of two-way tracks with stations at its leaves.
fn tree(levels: u32) -> Table {
    let mut table = Table::default();
    let width = SPACING * (1 << levels) as f64;
    let mut above = vec![table.node([width / 2.0, 0.0], false)];
    for level in 1..=levels {
        let step = width / f64::from(1 << level);
        let y = SPACING * 2.0 * f64::from(level);
        let nodes: Vec<usize> = (0..1 << level)
            .map(|index| table.node([step * (f64::from(index) + 0.5), y], level == levels))
            .collect();
        for (index, node) in nodes.iter().enumerate() {
            table.two_way(above[index / 2], *node);
        }
        above = nodes;
    }
    table
}

/// A grid of aisles. Each third node at its border is a station.
fn grid(columns: usize, rows: usize, ways: Ways) -> Table {
    let mut table = Table::default();
    for row in 0..rows {
        for column in 0..columns {
            let is_border = row % (rows - 1) == 0 || column % (columns - 1) == 0;
            let position = [SPACING * column as f64, SPACING * row as f64];
            table.node(position, is_border && (row + column) % 3 == 0);
        }
    }
    for row in 0..rows {
        for column in 1..columns {
            let east = row * columns + column;
            table.aisle([east - 1, east], row % 2 == 0, ways);
        }
    }
    for column in 0..columns {
        for row in 1..rows {
            let north = row * columns + column;
            table.aisle([north - columns, north], column % 2 == 1, ways);
        }
    }
    table
}

impl Table {
    /// A part of an aisle. One-way aisles lead from the first node to the second if they are
    /// `ahead`.
    fn aisle(&mut self, [first, second]: [usize; 2], ahead: bool, ways: Ways) {
        match (ways, ahead) {
            (Ways::Both, _) => self.two_way(first, second),
            (Ways::One, true) => self.one_way(first, second),
            (Ways::One, false) => self.one_way(second, first),
        }
    }
}

/// A hall with nodes on a jittered grid: a random tree of two-way tracks that joins all, and some
/// tracks more.
fn hall(nodes: usize) -> Table {
    let (mut table, random) = (Table::default(), Random::new(nodes as u64));
    let columns = (nodes as f64).sqrt().ceil() as usize;
    for node in 0..nodes {
        let jitter = [1, 2].map(|draw| JITTER * (random.part(node as u64).unit(draw) - 0.5));
        let [column, row] = [node % columns, node / columns].map(|index| SPACING * index as f64);
        let is_station = node % STATION_EVERY == 0;
        table.node([column + jitter[0], row + jitter[1]], is_station);
    }
    let mut part: Vec<usize> = (0..nodes).collect();
    for (order, [a, b]) in pairs(nodes, columns, random).into_iter().enumerate() {
        let (one, other) = (root(&mut part, a), root(&mut part, b));
        if one != other || order % CHORD_EVERY == 0 {
            table.two_way(a, b);
        }
        part[one] = other;
    }
    table
}

/// Returns all neighbours on a grid, in random order.
fn pairs(nodes: usize, columns: usize, random: Random) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for node in 0..nodes {
        if (node + 1) % columns != 0 && node + 1 < nodes {
            pairs.push([node, node + 1]);
        }
        if node + columns < nodes {
            pairs.push([node, node + columns]);
        }
    }
    for last in (1..pairs.len()).rev() {
        pairs.swap(last, random.below(last as u64, last + 1));
    }
    pairs
}

/// Returns the node that stands for a node's part.
fn root(part: &mut [usize], mut node: usize) -> usize {
    while part[node] != node {
        part[node] = part[part[node]];
        node = part[node];
    }
    node
}

#[cfg(test)]
mod tests {
    use regatta_layout::traffic::MainPart;
    use regatta_layout::{ReadOptions, parse};

    use super::*;

    #[test]
    fn all_nodes_of_a_generated_plant_reach_each_other() {
        for Recipe { name, table } in RECIPES {
            let (table, text) = (table(), table().text());
            let (graph, _) = parse(&text, "plant.csv", &ReadOptions::default()).expect(name);
            let main = MainPart::of(&graph).expect(name);
            assert!(main.left_out.is_empty(), "{name}: {:?}", main.left_out);
            assert_eq!(main.graph.nodes().len(), table.nodes.len(), "{name}");
            let stations = text.matches(",pick").count().min(text.matches(",drop").count());
            assert!(stations > 0, "{name} has no station of a kind");
        }
    }
}
