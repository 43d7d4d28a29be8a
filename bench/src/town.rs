//! A town for the benches: crossings with turns, and two-way roads between them.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;

use regatta_engine::graph::{ReadOptions, RouteGraph, parse};

/// Metres from one crossing to the next.
const BLOCK: f64 = 12.0;
/// Metres from a crossing's middle to where its roads begin.
const REACH: f64 = 2.5;
/// Metres from a road's middle to its lanes.
const LANE: f64 = 0.6;

/// A town of `side` × `side` crossings: four straight roads away from each, as far as there is a neighbour, and turns
/// from every road to every other but the one it came by.
pub fn town(side: u32) -> RouteGraph {
    let mut yaml = Yaml { nodes: String::from("Vertices:\n"), edges: String::from("Edges:\n"), count: 0 };
    for crossing in 0..side * side {
        let (i, j) = (crossing % side, crossing / side);
        let there = |way: u32| match way {
            0 => i + 1 < side,
            1 => j + 1 < side,
            2 => i > 0,
            _ => j > 0,
        };
        for way in (0..4).filter(|&way| there(way)) {
            yaml.gates((i, j), crossing, way);
            let neighbour = [crossing + 1, crossing + side, crossing.wrapping_sub(1), crossing.wrapping_sub(side)];
            yaml.edge(exit(crossing, way), entry(neighbour[way as usize], (way + 2) % 4), "linear", 1.6);
            let others = (0..4).filter(|&other| there(other) && other != way);
            others.for_each(|other| yaml.edge(entry(crossing, way), exit(crossing, other), "spline", 0.8));
        }
    }
    parse(&(yaml.nodes + &yaml.edges), "town", &ReadOptions::default()).expect("a sound town").0
}

/// Node where robots come in by a road.
fn entry(crossing: u32, way: u32) -> u32 {
    8 * crossing + way
}

/// Node where they leave by it.
fn exit(crossing: u32, way: u32) -> u32 {
    8 * crossing + 4 + way
}

struct Yaml {
    nodes: String,
    edges: String,
    count: u32,
}

impl Yaml {
    /// Both ends of a crossing's road.
    fn gates(&mut self, (i, j): (u32, u32), crossing: u32, way: u32) {
        let angle = FRAC_PI_2 * f64::from(way);
        let (sin, cos) = angle.sin_cos();
        let (x, y) = (BLOCK * f64::from(i), BLOCK * f64::from(j));
        let mut node = |id: u32, side: f64, theta: f64| {
            let (x, y) = (x + REACH * cos - side * sin, y + REACH * sin + side * cos);
            writeln!(self.nodes, "- {{Id: {id}, X: {x}, Y: {y}, Theta: {theta}}}").expect("memory");
        };
        node(exit(crossing, way), -LANE, wrap(angle));
        node(entry(crossing, way), LANE, wrap(angle + PI));
    }

    fn edge(&mut self, from: u32, to: u32, curve: &str, speed: f64) {
        self.count += 1;
        let id = self.count;
        let ends = format!("Id: {id}, Origin_ID: {from}, Destination_ID: {to}");
        let rest = format!("CurveType: {curve}, ParamF: 1.5, ParamB: 1.5, VelocityForward: {speed}");
        writeln!(self.edges, "- {{{ends}, {rest}}}").expect("memory");
    }
}

fn wrap(angle: f64) -> f64 {
    if angle > PI { angle - 2.0 * PI } else { angle }
}
