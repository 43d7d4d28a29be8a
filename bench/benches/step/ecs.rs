//! A simulation with an entity-component system, for comparison: an entity per robot in bevy_ecs,
//! one system over a query, and libm's atan2.
//!
//! It drives along the same pieces of the same graph, but publishes no frames and has no events, no
//! commands and no fixed-point distances.

use std::sync::Arc;

use bevy_ecs::prelude::{Component, Query, Res, Resource, Schedule, World};
use regatta_layout::{EdgeIndex, Gear, Leg, RouteGraph};
use regatta_motion::Tracks;

#[derive(Component)]
struct Location {
    edge: u32,
    piece: u32,
    /// Metres from the end of the piece, ≤ 0.
    w: f32,
    speed: f32,
}

#[derive(Component, Default)]
#[expect(dead_code, reason = "only a viewer would read it")]
struct Pose {
    x: f32,
    y: f32,
    theta: f32,
    s: f32,
}

/// The state of an xorshift generator.
#[derive(Component)]
struct Random(u32);

#[derive(Resource)]
struct CompiledGraph {
    graph: Arc<RouteGraph>,
    tracks: Arc<Tracks>,
    /// The edges that start where each edge ends.
    next_edges: Vec<Vec<u32>>,
    seconds: f32,
}

pub struct EcsSimulation {
    world: World,
    schedule: Schedule,
}

impl EcsSimulation {
    /// Creates `robots` robots, spread over all edges.
    pub fn new(bench: &regatta_bench::World, robots: usize) -> Self {
        let (graph, tracks) = (bench.graph.clone(), bench.tracks.clone());
        let exits = |edge: &regatta_layout::Edge| {
            let forward =
                graph.departures(edge.destination).iter().filter(|leg| leg.gear == Gear::Forward);
            forward.map(|leg| leg.edge.0).collect()
        };
        let next_edges = graph.edges().iter().map(exits).collect();
        let mut world = World::new();
        let seconds = regatta_bench::TICK.as_secs_f32();
        let compiled = CompiledGraph { graph: graph.clone(), tracks, next_edges, seconds };
        for robot in 0..robots {
            let edge = (robot * 2_654_435_769 % graph.edges().len()) as u32;
            let (piece, length, speed) = compiled.enter(edge);
            let fraction = (robot as f32 * 0.618_034).fract();
            let location = Location { edge, piece, w: -fraction * length, speed };
            world.spawn((location, Pose::default(), Random(robot as u32 * 2 + 1)));
        }
        world.insert_resource(compiled);
        let mut schedule = Schedule::default();
        schedule.add_systems(drive);
        Self { world, schedule }
    }

    /// Simulates one tick.
    pub fn step(&mut self) {
        self.schedule.run(&mut self.world);
    }
}

impl CompiledGraph {
    /// Returns the first piece of an edge, the piece's length, and the edge's speed.
    fn enter(&self, edge: u32) -> (u32, f32, f32) {
        let leg = Leg { edge: EdgeIndex(edge), gear: Gear::Forward };
        let first = self.tracks.track(leg).expect("forward is always allowed").first_piece;
        (first, self.length(first), self.graph.edge(leg.edge).speed as f32)
    }

    fn length(&self, piece: u32) -> f32 {
        self.tracks.infos()[piece as usize].length.to_metres() as f32
    }

    fn advance_to_next_piece(&self, location: &mut Location, random: &mut Random) {
        let leg = Leg { edge: EdgeIndex(location.edge), gear: Gear::Forward };
        if location.piece < self.tracks.track(leg).expect("forward is always allowed").last_piece()
        {
            location.piece += 1;
            location.w -= self.length(location.piece);
            return;
        }
        random.0 ^= random.0 << 13;
        random.0 ^= random.0 >> 17;
        random.0 ^= random.0 << 5;
        let choices = &self.next_edges[location.edge as usize];
        location.edge = choices[random.0 as usize % choices.len()];
        let (piece, length, speed) = self.enter(location.edge);
        location.piece = piece;
        location.w -= length;
        location.speed = speed;
    }
}

fn drive(compiled: Res<CompiledGraph>, mut robots: Query<(&mut Location, &mut Pose, &mut Random)>) {
    for (mut location, mut pose, mut random) in &mut robots {
        location.w += location.speed * compiled.seconds;
        while location.w >= 0.0 {
            compiled.advance_to_next_piece(&mut location, &mut random);
        }
        let piece = &compiled.tracks.pieces()[location.piece as usize];
        let (position, direction) = (piece.position(location.w), piece.derivative(location.w));
        *pose = Pose {
            x: position.x,
            y: position.y,
            theta: direction.y.atan2(direction.x),
            s: compiled.tracks.infos()[location.piece as usize].s_end + location.w,
        };
    }
}
