//! A kinematic model of a fleet, for tests: robots that are late, slow and stall at random. None
//! may ever touch another.

mod body;
pub mod managed;
pub mod worlds;

use crate::steering::AdmissionSettings;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec2;
use parking_lot::Mutex;
use regatta_base::sweep::Rectangle;
use regatta_plugin::World;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::WorldData;

use self::body::{Body, Outlines};
use crate::planner::{Planner, Plans};
use crate::roads::{Leg, Roads};
use crate::steering::{Command, Settings, Steering};
use crate::traffic::{Seen, Traffic};

/// Simulated seconds of a cycle.
pub const TICK_SECS: f32 = 0.1;
/// When robots break down, in ticks.
const BREAKDOWN: u32 = 100;

/// A source of random numbers that tests can repeat.
pub struct Random(pub u64);

impl Random {
    /// A number below `count`.
    pub fn below(&mut self, count: u32) -> u32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(count)) as u32
    }
}

/// The time that a planner has taken.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spent {
    pub cycles: u32,
    pub sum: Duration,
    pub longest: Duration,
}

/// A planner whose time is taken.
#[derive(Debug)]
struct Timed(Box<dyn Planner>, Measured);

/// The time that a planner has taken, and its figures.
type Measured = Arc<Mutex<(Spent, Vec<(&'static str, u64)>)>>;

impl Planner for Timed {
    fn plan(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        let start = Instant::now();
        self.0.plan(traffic, plans);
        let passed = start.elapsed();
        let (spent, counts) = &mut *self.1.lock();
        *spent = Spent {
            cycles: spent.cycles + 1,
            sum: spent.sum + passed,
            longest: spent.longest.max(passed),
        };
        *counts = self.0.counts();
    }

    fn objection(&mut self, traffic: &Traffic<'_>, robot: u32) -> Option<u32> {
        self.0.objection(traffic, robot)
    }

    fn guards_rings(&self) -> bool {
        self.0.guards_rings()
    }
}

/// A fleet that drives to random goals.
pub struct Model {
    pub roads: Arc<Roads>,
    pub steering: Steering,
    outlines: Outlines,
    /// Of each zone: how many robots may be on its edges at the same time.
    zones: Vec<(u32, Vec<u32>)>,
    bodies: Vec<Body>,
    pub goals: Vec<Option<u32>>,
    /// Nodes that robots are sent to.
    pub stops: Vec<u32>,
    random: Random,
    /// Of 1,000 robots, how many stall in a tick, for up to eight seconds.
    pub stalls: u32,
    /// The number of robots that break down after [`BREAKDOWN`].
    pub broken: usize,
    /// The number of robots that have something to do where they start.
    pub pinned: usize,
    tick: u32,
    sent: Vec<u32>,
    /// By robot.
    pub arrivals: Vec<u32>,
    /// The longest time from goal to goal, in ticks.
    pub longest: u32,
    measured: Measured,
}

impl Model {
    /// Puts robots on legs, at a distance from where these are entered.
    pub fn new(
        world: &WorldData,
        starts: &[(Leg, f32)],
        seed: u64,
        settings: Settings,
        planner: impl FnOnce(&Roads) -> Box<dyn Planner>,
    ) -> Self {
        let view = world.view(1, 1);
        let roads = Arc::new(Roads::new(&view));
        let measured = Measured::default();
        let timed = Timed(planner(&roads), Arc::clone(&measured));
        let outlines = Outlines::new(&view);
        let bodies: Vec<Body> =
            starts.iter().map(|&(leg, place)| Body::new(&outlines, leg, place)).collect();
        let count = bodies.len();
        Self {
            steering: Steering::new(roads.clone(), Box::new(timed), settings),
            stops: (0..roads.nodes()).filter(|&node| roads.arrival(node).is_some()).collect(),
            roads,
            outlines,
            zones: zones(&view),
            bodies,
            goals: vec![None; count],
            random: Random(seed),
            stalls: 0,
            broken: 0,
            pinned: 0,
            tick: 0,
            sent: vec![0; count],
            arrivals: vec![0; count],
            longest: 0,
            measured,
        }
    }

    /// The time that the planner has taken.
    pub fn spent(&self) -> Spent {
        self.measured.lock().0
    }

    /// The planner's figures.
    pub fn counts(&self) -> Vec<(&'static str, u64)> {
        self.measured.lock().1.clone()
    }

    /// Goals in all.
    pub fn total(&self) -> u32 {
        self.arrivals.iter().sum()
    }

    /// Drives for some ticks. A robot that has arrived gets another goal.
    ///
    /// # Panics
    /// If two robots touch, or more are in a zone than have room.
    pub fn run(&mut self, ticks: u32) {
        for _ in 0..ticks {
            self.cycle();
            self.check();
        }
    }

    fn cycle(&mut self) {
        for (robot, body) in (0..).zip(&self.bodies) {
            let mut seen = body.seen(&self.outlines, &self.roads);
            if self.is_broken(robot as usize) {
                (seen.state, seen.speed) = (RobotState::Broken, 0.0);
            }
            self.steering.see(robot, &seen);
        }
        for robot in 0..self.bodies.len() {
            self.send(robot);
        }
        for command in self.steering.step(f64::from(self.tick) * f64::from(TICK_SECS)) {
            self.bodies[command.robot() as usize].obey(command, &self.roads);
        }
        let broken = if self.tick >= BREAKDOWN { self.broken } else { 0 };
        for body in self.bodies.iter_mut().skip(broken) {
            if self.stalls > 0 && self.random.below(1_000) < self.stalls {
                body.stalled = self.random.below(80);
            }
            body.drive(&self.outlines, &self.roads, 0.7 + 0.3 * self.random.below(2) as f32);
        }
        self.tick += 1;
    }

    fn send(&mut self, robot: usize) {
        if robot < self.pinned {
            if self.tick == 0 {
                self.steering.stay(robot as u32);
            }
            return;
        }
        let goal = self.goals[robot];
        let has_arrived = goal.is_some_and(|goal| self.steering.has_arrived(robot as u32, goal));
        if goal.is_some() && !has_arrived && !self.steering.is_unreachable(robot as u32) {
            return;
        }
        if has_arrived {
            self.arrivals[robot] += 1;
            self.longest = self.longest.max(self.tick - self.sent[robot]);
        }
        self.sent[robot] = self.tick;
        let goal = self.stops[self.random.below(self.stops.len() as u32) as usize];
        self.goals[robot] = Some(goal);
        self.steering.send(robot as u32, goal);
    }

    fn is_broken(&self, robot: usize) -> bool {
        robot < self.broken && self.tick >= BREAKDOWN
    }

    /// The longest time from goal to goal, or since the last one, in simulated seconds.
    pub fn longest_secs(&self) -> f32 {
        let open = self.sent.iter().map(|&sent| self.tick - sent).max().unwrap_or(0);
        TICK_SECS * self.longest.max(open) as f32
    }

    fn check(&self) {
        self.check_zones();
        let outlines: Vec<Rectangle> =
            self.bodies.iter().map(|body| body.outline(&self.outlines)).collect();
        for (a, b) in (0..outlines.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let touch = outlines[a].touches(&outlines[b]);
            assert!(
                !touch,
                "tick {}: {a} {:?} and {b} {:?}",
                self.tick, self.bodies[a], self.bodies[b]
            );
        }
    }

    fn check_zones(&self) {
        for (capacity, edges) in &self.zones {
            let seen = self.bodies.iter().map(|body| body.seen(&self.outlines, &self.roads));
            let inside = seen.filter(|seen| {
                let Some(edge) = seen.edge.filter(|edge| edges.contains(edge)) else {
                    return false;
                };
                seen.s > 0.01 && seen.s < self.roads.edge(edge).length - 0.01
            });
            let inside = inside.count();
            assert!(inside <= *capacity as usize, "tick {}: {inside} in {edges:?}", self.tick);
        }
    }
}

/// The capacities and edges of the zones of a world.
fn zones(world: &World<'_>) -> Vec<(u32, Vec<u32>)> {
    let zones = world.zones().iter();
    zones.map(|zone| (zone.capacity, world.zone_edges(zone).to_vec())).collect()
}

/// The places where robots can stand at the start: the ends of edges, no two of which touch, in
/// random order.
pub fn places(world: &WorldData, count: usize, seed: u64) -> Vec<(Leg, f32)> {
    let view = world.view(1, 1);
    let roads = Roads::new(&view);
    let outlines = Outlines::new(&view);
    let mut edges: Vec<u32> = (0..roads.edges().len() as u32).collect();
    let mut random = Random(seed);
    for index in (1..edges.len()).rev() {
        edges.swap(index, random.below(index as u32 + 1) as usize);
    }
    let mut taken: Vec<Rectangle> = Vec::new();
    let mut starts = Vec::new();
    for edge in edges {
        let (leg, length) = (Leg::new(edge, false), roads.edge(edge).length);
        let mut outline = outlines.at(leg, length);
        outline.half += 0.05;
        if starts.len() < count && taken.iter().all(|other| !other.touches(&outline)) {
            taken.push(outline);
            starts.push((leg, length));
        }
    }
    assert_eq!(starts.len(), count, "so many robots don't fit");
    starts
}

/// A robot that stands or drives on an edge, as a frame shows it.
fn seen(edge: u32, s: f32, speed: f32, position: Vec2) -> Seen {
    Seen { robot_type: 0, edge: Some(edge), s, speed, position, state: RobotState::Idle }
}

/// Makes a planner.
pub type Maker = fn(&Roads) -> Box<dyn Planner>;

/// Drives robots from random node to random node for some simulated seconds, all of them admitted.
pub fn drive(
    name: &str,
    world: &WorldData,
    (robots, seed): (usize, u64),
    secs: u32,
    planner: Maker,
) -> Model {
    let settings = Settings { admission: AdmissionSettings::unlimited(), ..Settings::default() };
    let mut model = Model::new(world, &places(world, robots, seed), seed, settings, planner);
    model.run((secs as f32 / TICK_SECS) as u32);
    let Spent { cycles, sum, longest } = model.spent();
    println!(
        "{name}, {robots} robots, {secs} s: {} goals, fewest {:?}, longest {:.0} s; {:.2} ms a \
         cycle, longest {:.1} ms; {:?}",
        model.total(),
        model.arrivals.iter().min(),
        model.longest_secs(),
        1e3 * sum.as_secs_f64() / f64::from(cycles),
        1e3 * longest.as_secs_f64(),
        model.counts()
    );
    model
}
