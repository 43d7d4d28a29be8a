//! Graphs, fleets and frames for tests.

use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;
use regatta_layout::{CubicBezier, Edge, EdgeIndex, Gear, Leg, Node, NodeIndex, RouteGraph};
use regatta_motion::Isa;
use regatta_plugin::frame::{Columns, ColumnsMut, Line, frame_lines};
use regatta_scenario::{RobotType, Shape};

use crate::fleet::{EventBuffer, Fleet, FleetConfig};

/// Returns a grid of `side` × `side` nodes, `spacing` metres apart, with bent edges between
/// neighbours both ways. Every third edge may be driven backwards. Ids are indices plus 100 for
/// nodes and plus 1000 for edges.
pub fn town(side: u32, spacing: f64) -> Arc<RouteGraph> {
    let at = |i: u32, j: u32| DVec2::new(f64::from(i), f64::from(j)) * spacing;
    let cells = || (0..side).flat_map(move |j| (0..side).map(move |i| (i, j)));
    let nodes = cells().map(|(i, j)| Node::new(100 + j * side + i, at(i, j), 0.3)).collect();
    let mut edges = Vec::new();
    for (i, j) in cells() {
        let beside = [(i + 1, j), (i, j + 1)].into_iter().filter(|&(i, j)| i < side && j < side);
        for (k, l) in beside {
            push_bent_edge(&mut edges, (j * side + i, at(i, j)), (l * side + k, at(k, l)));
            push_bent_edge(&mut edges, (l * side + k, at(k, l)), (j * side + i, at(i, j)));
        }
    }
    Arc::new(RouteGraph::from_valid_parts(nodes, edges))
}

/// Returns straight edges of these lengths (metres) and speeds, one after the other along x; all
/// may be driven backwards.
pub fn chain(parts: &[(f64, f64)]) -> Arc<RouteGraph> {
    let mut x = 0.0;
    let mut nodes = vec![Node::new(100, DVec2::ZERO, 0.0)];
    let mut edges = Vec::new();
    for (number, &(length, speed)) in (0..).zip(parts) {
        let (from, to) = (DVec2::new(x, 0.0), DVec2::new(x + length, 0.0));
        x += length;
        nodes.push(Node::new(101 + number, to, 0.0));
        let path = CubicBezier {
            control_points: [from, from.lerp(to, 1.0 / 3.0), from.lerp(to, 2.0 / 3.0), to],
        };
        let (from, to) = (NodeIndex(number), NodeIndex(number + 1));
        let reverse_speed = Some(0.5 * speed);
        edges.push(Edge { reverse_speed, ..Edge::new(1000 + number, from, to, path, speed) });
    }
    Arc::new(RouteGraph::from_valid_parts(nodes, edges))
}

fn push_bent_edge(
    edges: &mut Vec<Edge>,
    (origin, from): (u32, DVec2),
    (destination, to): (u32, DVec2),
) {
    let number = edges.len() as u32;
    let side = (to - from).perp() * 0.08;
    let path = CubicBezier {
        control_points: [from, from.lerp(to, 0.35) - side, from.lerp(to, 0.7) - side, to],
    };
    let (speed, reverse_speed) =
        (0.5 + 0.4 * f64::from(number % 5), number.is_multiple_of(3).then_some(0.7));
    let (from, to) = (NodeIndex(origin), NodeIndex(destination));
    edges.push(Edge { reverse_speed, ..Edge::new(1000 + number, from, to, path, speed) });
}

pub fn forward(edge: u32) -> Leg {
    Leg { edge: EdgeIndex(edge), gear: Gear::Forward }
}

pub fn reverse(edge: u32) -> Leg {
    Leg { edge: EdgeIndex(edge), gear: Gear::Reverse }
}

pub fn robot_type(max_speed: f32, max_acceleration: f32) -> RobotType {
    RobotType {
        name: "test".into(),
        shape: Shape::Rectangle,
        length: 1.0,
        width: 0.6,
        max_speed,
        max_acceleration,
        max_rotation_speed: 0.0,
        max_rotation_acceleration: f32::INFINITY,
        battery: None,
    }
}

pub fn config(types: Vec<RobotType>) -> FleetConfig {
    FleetConfig {
        types,
        tick_period: Duration::from_millis(20),
        seed: 1,
        isa: Isa::detect(),
        threads: 1,
        most_robots: 1 << 24,
    }
}

pub fn fleet(graph: &Arc<RouteGraph>, config: FleetConfig) -> Fleet {
    Fleet::new(graph.clone(), Arc::new(crate::arc_length::compile(graph)), config)
        .expect("a valid fleet")
}

pub fn events() -> EventBuffer {
    EventBuffer::new(1 << 16)
}

/// A frame in ordinary memory.
pub struct Frame {
    pub lines: Vec<Line>,
    robots: usize,
}

impl Frame {
    /// Makes a frame of arbitrary values, so that tests find what isn't written.
    pub fn of(fleet: &Fleet) -> Self {
        Self { lines: vec![Line([-7e7; 16]); frame_lines(fleet.robots())], robots: fleet.robots() }
    }

    pub fn columns_mut(&mut self) -> ColumnsMut<'_> {
        ColumnsMut::split(&mut self.lines, self.robots)
    }

    pub fn columns(&self) -> Columns<'_> {
        Columns::split(&self.lines, self.robots).expect("a whole frame")
    }
}

/// Makes one tick and returns its frame.
pub fn step(fleet: &mut Fleet, events: &mut EventBuffer) -> Frame {
    let mut frame = Frame::of(fleet);
    fleet.step(Some(frame.columns_mut()), events);
    frame
}

/// Returns the poses as they are.
pub fn poses(fleet: &mut Fleet) -> Frame {
    let mut frame = Frame::of(fleet);
    fleet.write(frame.columns_mut());
    frame
}

/// Returns every bit of a frame, including padding.
pub fn bits(frame: &Frame) -> &[u8] {
    bytemuck::cast_slice(&frame.lines)
}
