//! The rival: an entity per robot in bevy_ecs, one system over a query, libm's atan2.
//!
//! It drives the same pieces of the same graph. It keeps its poses to itself: no frame, no events, no orders, no
//! fixed point.

use std::sync::Arc;

use bevy_ecs::prelude::{Component, Query, Res, Resource, Schedule, World};
use regatta_engine::graph::arc_length::Tracks;
use regatta_engine::graph::{EdgeIndex, Gear, Leg, RouteGraph};

#[derive(Component)]
struct Place {
    edge: u32,
    piece: u32,
    /// Metres from the end of the piece, ≤ 0.
    w: f32,
    speed: f32,
}

#[derive(Component, Default)]
#[expect(dead_code, reason = "a viewer would read it")]
struct Pose {
    x: f32,
    y: f32,
    theta: f32,
    s: f32,
}

/// State of an xorshift generator.
#[derive(Component)]
struct Dice(u32);

#[derive(Resource)]
struct Roads {
    graph: Arc<RouteGraph>,
    tracks: Arc<Tracks>,
    /// Edges that start where an edge ends.
    onward: Vec<Vec<u32>>,
    seconds: f32,
}

pub struct Rival {
    world: World,
    schedule: Schedule,
}

impl Rival {
    /// That many robots, spread over all edges.
    pub fn new(bench: &regatta_bench::World, robots: usize) -> Self {
        let (graph, tracks) = (bench.graph.clone(), bench.tracks.clone());
        let exits = |edge: &regatta_engine::graph::Edge| {
            let forward = graph.departures(edge.destination).iter().filter(|leg| leg.gear == Gear::Forward);
            forward.map(|leg| leg.edge.0).collect()
        };
        let onward = graph.edges().iter().map(exits).collect();
        let mut world = World::new();
        let seconds = regatta_bench::TICK.as_secs_f32();
        let roads = Roads { graph: graph.clone(), tracks, onward, seconds };
        for robot in 0..robots {
            let edge = (robot * 2_654_435_769 % graph.edges().len()) as u32;
            let (piece, length, speed) = roads.enter(edge);
            let part = (robot as f32 * 0.618_034).fract();
            let place = Place { edge, piece, w: -part * length, speed };
            world.spawn((place, Pose::default(), Dice(robot as u32 * 2 + 1)));
        }
        world.insert_resource(roads);
        let mut schedule = Schedule::default();
        schedule.add_systems(drive);
        Self { world, schedule }
    }

    /// One tick.
    pub fn step(&mut self) {
        self.schedule.run(&mut self.world);
    }
}

impl Roads {
    /// First piece of an edge, its length, and the edge's speed.
    fn enter(&self, edge: u32) -> (u32, f32, f32) {
        let leg = Leg { edge: EdgeIndex(edge), gear: Gear::Forward };
        let first = self.tracks.track(leg).expect("forward is always allowed").first_piece;
        (first, self.length(first), self.graph.edge(leg.edge).velocity_forward as f32)
    }

    fn length(&self, piece: u32) -> f32 {
        self.tracks.infos()[piece as usize].length.to_metres() as f32
    }

    fn hand_over(&self, place: &mut Place, dice: &mut Dice) {
        let leg = Leg { edge: EdgeIndex(place.edge), gear: Gear::Forward };
        if place.piece < self.tracks.track(leg).expect("forward is always allowed").last_piece() {
            place.piece += 1;
            place.w -= self.length(place.piece);
            return;
        }
        dice.0 ^= dice.0 << 13;
        dice.0 ^= dice.0 >> 17;
        dice.0 ^= dice.0 << 5;
        let choices = &self.onward[place.edge as usize];
        place.edge = choices[dice.0 as usize % choices.len()];
        let (piece, length, speed) = self.enter(place.edge);
        place.piece = piece;
        place.w -= length;
        place.speed = speed;
    }
}

fn drive(roads: Res<Roads>, mut robots: Query<(&mut Place, &mut Pose, &mut Dice)>) {
    for (mut place, mut pose, mut dice) in &mut robots {
        place.w += place.speed * roads.seconds;
        while place.w >= 0.0 {
            roads.hand_over(&mut place, &mut dice);
        }
        let piece = &roads.tracks.pieces()[place.piece as usize];
        let (position, direction) = (piece.position(place.w), piece.derivative(place.w));
        *pose = Pose {
            x: position.x,
            y: position.y,
            theta: direction.y.atan2(direction.x),
            s: roads.tracks.infos()[place.piece as usize].s_end + place.w,
        };
    }
}
