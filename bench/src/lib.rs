//! What the benches share: a warehouse to drive in, fleets, and frames as the publisher loans them.

use std::sync::Arc;
use std::time::Duration;

use regatta_engine::fleet::{Events, Fleet, FleetConfig, Placement, RobotType, RouteSource};
use regatta_engine::graph::arc_length::Tracks;
use regatta_engine::graph::generate::Warehouse;
use regatta_engine::graph::{EdgeIndex, ReadOptions, RouteGraph, parse};
use regatta_engine::motion::Isa;
use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};
use regatta_plugin::world::Shape;

/// Simulated time a tick: 60 Hz.
pub const TICK: Duration = Duration::from_nanos(16_666_667);

/// A route graph, compiled.
#[derive(Debug)]
pub struct World {
    /// The graph.
    pub graph: Arc<RouteGraph>,
    /// Its pieces.
    pub tracks: Arc<Tracks>,
}

impl World {
    /// A warehouse with some 6,000 edges.
    ///
    /// # Panics
    /// If the generator and the reader don't agree.
    pub fn new() -> Self {
        let yaml = Warehouse { aisles: 24, rows: 18, bays: 6 }.generate().expect("a sensible size");
        let (graph, _) = parse(&yaml, "warehouse", &ReadOptions::default()).expect("a sound graph");
        let tracks = Arc::new(Tracks::compile(&graph));
        Self { graph: Arc::new(graph), tracks }
    }

    /// That many robots on random walks, spread over all edges.
    ///
    /// # Panics
    /// If this machine can't run the instruction set.
    pub fn fleet(&self, robots: usize, isa: Isa, threads: usize, max_acceleration: f32) -> Fleet {
        let kind = RobotType {
            name: "cart".into(),
            shape: Shape::Rectangle,
            length: 1.0,
            width: 0.7,
            max_speed: f32::INFINITY,
            max_acceleration,
        };
        let config =
            FleetConfig { types: vec![kind], tick_period: TICK, seed: 1, isa, threads, most_robots: robots as u32 };
        let mut fleet = Fleet::new(self.graph.clone(), self.tracks.clone(), config).expect("a sound fleet");
        fleet.reserve(robots);
        let mut events = silence();
        let edges = self.graph.edges().len();
        for robot in 0..robots {
            // Multiples of the golden ratio spread evenly.
            let edge = EdgeIndex((robot * 2_654_435_769 % edges) as u32);
            let part = (robot as f64 * 0.618_033_988_75).fract();
            let s = (part * self.tracks.edge_length(edge)) as f32;
            fleet.spawn(Placement::Edge(edge, s), 0, RouteSource::Random, 0, &mut events).expect("a place");
        }
        fleet
    }
}

impl Default for World {
    fn default() -> Self {
        Self::new()
    }
}

/// Events that nobody listens to.
pub fn silence() -> Events {
    let mut events = Events::new(0);
    events.set_wanted(false);
    events
}

/// Three frames in turn, as a publisher with one reader loans them.
#[derive(Debug)]
pub struct Ring {
    frames: [Vec<Line>; 3],
    next: usize,
    robots: usize,
}

impl Ring {
    /// Frames for that many robots.
    pub fn new(robots: usize) -> Self {
        Self { frames: [(); 3].map(|()| vec![Line::default(); frame_lines(robots)]), next: 0, robots }
    }

    /// The next frame to write.
    pub fn loan(&mut self) -> ColumnsMut<'_> {
        self.next = (self.next + 1) % self.frames.len();
        ColumnsMut::split(&mut self.frames[self.next], self.robots)
    }
}
