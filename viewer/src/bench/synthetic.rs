//! A synthetic fleet on straight rows, of any size.

use glam::Vec2;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines};
use regatta_plugin::traffic::{EdgeTraffic, TrafficHeader};
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_plugin::{Frame, Traffic, World};
use regatta_scene::camera::Bounds;

/// The distance between neighbouring robots, in metres.
const SPACING: f32 = 2.4;

/// Robots in straight rows that alternate between two frames.
pub struct SyntheticFleet {
    robots: usize,
    frames: [(FrameHeader, Vec<Line>); 2],
}

impl SyntheticFleet {
    pub fn new(robots: usize) -> Self {
        let frames = [0.0, 0.05].map(|step| {
            let mut lines = vec![Line::default(); frame_lines(robots)];
            let columns = ColumnsMut::split(&mut lines, robots);
            for i in 0..robots {
                let (row, place) = (i / side(robots), i % side(robots));
                columns.x[i] = place as f32 * SPACING + step;
                columns.y[i] = row as f32 * SPACING;
                columns.theta[i] = if row % 2 == 0 { 0.0 } else { std::f32::consts::PI };
                columns.speed[i] = (i % 21) as f32 * 0.1;
                columns.edge[i] = NO_EDGE;
                columns.state[i] = 1;
            }
            let (robots, stride_lines) = (robots as u32, stride_lines(robots) as u32);
            (FrameHeader { run_id: 1, robots, stride_lines, ..FrameHeader::default() }, lines)
        });
        Self { robots, frames }
    }

    pub fn bounds(&self) -> Bounds {
        Bounds { low: Vec2::ZERO, high: Vec2::splat(side(self.robots) as f32 * SPACING) }
    }

    /// Returns a graph with an edge for every ten robots, at most 100,000 edges.
    pub fn graph(&self) -> WorldData {
        let (side, length) = (side(self.robots) as f32 * SPACING, 10.0 * SPACING);
        let per_row = (side / length).ceil().max(1.0) as u32;
        let rows = (side / SPACING).ceil() as u32;
        let mut world = WorldData::default();
        for i in 0..(per_row * rows).min(100_000) {
            let (x, y) = ((i % per_row) as f32 * length, (i / per_row) as f32 * SPACING);
            world.nodes.push(NodeRecord { id: i, x, y, ..NodeRecord::default() });
            let edge = EdgeRecord {
                id: i,
                origin: i,
                destination: i,
                length,
                speed: 1.0,
                ..EdgeRecord::default()
            };
            world.add_edge(edge, [CurveRecord::straight([x, y], [x + length, y])]);
        }
        world
    }

    /// Returns one of the two frames by turns.
    pub fn frame(&self, number: usize) -> Frame<'_> {
        let (header, lines) = &self.frames[number % 2];
        Frame::new(header, lines).expect("a complete frame")
    }
}

/// Figures of the traffic on each edge.
pub struct SyntheticTraffic {
    header: TrafficHeader,
    edges: Vec<EdgeTraffic>,
}

impl SyntheticTraffic {
    pub fn view(&self) -> Traffic<'_> {
        Traffic { header: &self.header, periods: [&self.edges; 3], missed: 0 }
    }
}

/// Returns figures for every edge, which differ from edge to edge.
pub fn traffic(world: &World<'_>) -> SyntheticTraffic {
    let edges = (0..world.edges().len()).map(|edge| {
        let value = (edge % 97) as f32 / 97.0;
        EdgeTraffic {
            occupancy: 3.0 * value,
            entered_per_hour: 900.0 * value,
            relative_speed: value,
            waiting_secs: 60.0 * value,
            contact_secs: value,
            released: value,
            planned: value,
        }
    });
    SyntheticTraffic { header: TrafficHeader::default(), edges: edges.collect() }
}

/// The number of rows, and of robots in a row.
fn side(robots: usize) -> usize {
    (robots as f64).sqrt().ceil() as usize
}
