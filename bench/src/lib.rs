//! Shared parts of the benchmarks: a warehouse to drive in, fleets, and frames as the publisher
//! loans them.

use std::sync::Arc;
use std::time::Duration;

use regatta_engine::arc_length;
use regatta_engine::fleet::{EventBuffer, Fleet, FleetConfig, Placement, RouteSource};
use regatta_layout::generate::Warehouse;
use regatta_layout::{EdgeIndex, ReadOptions, RouteGraph, parse};
use regatta_motion::{Isa, Tracks};
use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};
use regatta_scenario::{RobotType, Shape};

/// The simulated time per tick: 60 Hz.
pub const TICK: Duration = Duration::from_nanos(16_666_667);

/// A route graph with its compiled tracks.
#[derive(Debug)]
pub struct World {
    /// The route graph.
    pub graph: Arc<RouteGraph>,
    /// The tracks of its legs.
    pub tracks: Arc<Tracks>,
}

impl World {
    /// Generates a warehouse with some 6,000 edges.
    ///
    /// # Panics
    /// If the reader rejects the generated graph.
    pub fn new() -> Self {
        let yaml = Warehouse { aisles: 24, rows: 18, bays: 6 }.generate().expect("a valid size");
        let (graph, _) = parse(&yaml, "warehouse", &ReadOptions::default()).expect("a valid graph");
        let tracks = Arc::new(arc_length::compile(&graph));
        Self { graph: Arc::new(graph), tracks }
    }

    /// Returns a fleet of `robots` robots on random walks, spread over all edges.
    ///
    /// # Panics
    /// If this machine doesn't support the instruction set.
    pub fn fleet(&self, robots: usize, isa: Isa, threads: usize, max_acceleration: f32) -> Fleet {
        let robot_type = RobotType {
            name: "cart".into(),
            shape: Shape::Rectangle,
            length: 1.0,
            width: 0.7,
            max_speed: f32::INFINITY,
            max_acceleration,
            max_rotation_speed: 0.0,
            max_rotation_acceleration: f32::INFINITY,
            battery: None,
        };
        let config = FleetConfig {
            types: vec![robot_type],
            tick_period: TICK,
            seed: 1,
            isa,
            threads,
            most_robots: robots as u32,
        };
        let mut fleet =
            Fleet::new(self.graph.clone(), self.tracks.clone(), config).expect("a valid fleet");
        fleet.reserve(robots);
        let mut events = unread_events();
        let edges = self.graph.edges().len();
        for robot in 0..robots {
            // Multiples of the golden ratio are evenly distributed.
            let edge = EdgeIndex((robot * 2_654_435_769 % edges) as u32);
            let fraction = (robot as f64 * 0.618_033_988_75).fract();
            let s = (fraction * self.tracks.edge_length(edge)) as f32;
            fleet
                .spawn(Placement::Edge(edge, s), 0, RouteSource::Random, 0, &mut events)
                .expect("a free place");
        }
        fleet
    }
}

impl Default for World {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns an event buffer without readers.
pub fn unread_events() -> EventBuffer {
    let mut events = EventBuffer::new(0);
    events.set_wanted(false);
    events
}

/// Three frames that are loaned in turn, as by a publisher with one reader.
#[derive(Debug)]
pub struct FrameRing {
    frames: [Vec<Line>; 3],
    next: usize,
    robots: usize,
}

impl FrameRing {
    /// Allocates frames for `robots` robots.
    pub fn new(robots: usize) -> Self {
        Self {
            frames: [(); 3].map(|()| vec![Line::default(); frame_lines(robots)]),
            next: 0,
            robots,
        }
    }

    /// Returns the columns of the next frame to write.
    pub fn loan(&mut self) -> ColumnsMut<'_> {
        self.next = (self.next + 1) % self.frames.len();
        ColumnsMut::split(&mut self.frames[self.next], self.robots)
    }
}
