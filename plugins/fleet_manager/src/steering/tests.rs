//! Steering against a model of robots that are late, slow and stall at random: none may ever touch another.

use std::sync::Arc;

use proptest::prelude::*;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, RobotTypeRecord, WorldData};

use super::{Command, Seen, Settings, Steering};
use crate::roads::{Leg, Rectangle, Roads};

const SIDE: u32 = 4;
const SPACING: f32 = 3.0;
const SIZE: [f32; 2] = [0.9, 0.6];
const TICK_SECS: f32 = 0.1;

/// One-way streets on a square grid, each row and column against its neighbours.
fn streets(turns: bool) -> WorldData {
    let mut world = WorldData::default();
    let at = |column: u32, row: u32| [SPACING * column as f32, SPACING * row as f32];
    let node = |column: u32, row: u32| row * SIDE + column;
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let [x, y] = at(column, row);
        world.nodes.push(NodeRecord { id: node(column, row), x, y, ..NodeRecord::default() });
    }
    let mut add = |from: (u32, u32), to: (u32, u32)| {
        let [origin, destination] = [from, to].map(|(column, row)| node(column, row));
        let (id, length) = (world.edges.len() as u32, SPACING);
        let edge = EdgeRecord { id, origin, destination, length, velocity_forward: 1.0, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight(at(from.0, from.1), at(to.0, to.1))]);
    };
    for (line, step) in (0..SIDE).flat_map(|line| (0..SIDE - 1).map(move |step| (line, step))) {
        let ends = if line % 2 == 0 { [step, step + 1] } else { [step + 1, step] };
        add((ends[0], line), (ends[1], line));
        add((line, ends[1]), (line, ends[0]));
    }
    let robot_type = RobotTypeRecord::new("", SIZE[0], SIZE[1]);
    world.robot_types = vec![RobotTypeRecord { max_rotation_speed: if turns { 1.0 } else { 0.0 }, ..robot_type }];
    world
}

/// A robot as the engine would move it.
#[derive(Debug)]
struct Body {
    leg: Leg,
    place: f32,
    speed: f32,
    heading: f32,
    legs: Vec<Leg>,
    /// The leg on which its base ends, and where.
    limit: (Leg, f32),
    stalled: u32,
}

impl Body {
    /// Drives for a tick at a speed in metres per second, up to the end of the base. Turns on the spot take whole ticks; the
    /// heading of a robot that doesn't turn jumps.
    fn drive(&mut self, roads: &Roads, speed: f32) {
        self.speed = 0.0;
        if self.stalled > 0 {
            self.stalled -= 1;
            return;
        }
        let length = roads.edge(self.leg.edge()).length;
        let is_last = self.limit.0 == self.leg;
        let end = if is_last { self.limit.1.min(length) } else { length };
        if self.place < end {
            self.speed = speed;
            self.place = (self.place + speed * TICK_SECS).min(end);
        } else if !is_last && let Some(&next) = self.legs.first() {
            let wanted = roads.headings(next)[0];
            let left = (wanted - self.heading + 9.424_778).rem_euclid(core::f32::consts::TAU) - core::f32::consts::PI;
            if roads.classes()[0].turns && left.abs() > 0.11 {
                self.heading += left.signum() * 0.1;
                return;
            }
            self.heading = wanted;
            self.legs.remove(0);
            (self.leg, self.place) = (next, 0.0);
        }
    }

    fn outline(&self, roads: &Roads) -> Rectangle {
        let [from, to] = [roads.start(self.leg), roads.end(self.leg)].map(|node| roads.position(node));
        let share = self.place / roads.edge(self.leg.edge()).length;
        let centre = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        let heading = [self.heading.cos(), self.heading.sin()];
        Rectangle { centre, heading, half: SIZE.map(|size| 0.5 * size) }
    }

    fn obey(&mut self, command: &Command) {
        match command {
            Command::Route { legs, .. } => {
                let kept = self.legs.iter().position(|leg| *leg == self.limit.0).map_or(0, |last| last + 1);
                self.legs.truncate(kept);
                self.legs.extend(legs);
            }
            Command::Release { leg, metres, .. } => {
                assert!(self.leg == *leg || self.legs.contains(leg), "{leg:?} is not ahead of {self:?}");
                self.limit = (*leg, *metres);
            }
            Command::Cancel { .. } => {}
        }
    }
}

/// A source of random numbers that tests can repeat.
struct Random(u64);

impl Random {
    fn below(&mut self, count: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(count)) as u32
    }
}

/// Drives robots to random nodes for some ticks, and returns how often one arrived.
fn drive(robots: u32, seed: u64, turns: bool, stalls: u32, ticks: u32) -> u32 {
    let world = streets(turns);
    let roads = Arc::new(Roads::new(&world.view(1, 1)));
    let mut steering = Steering::new(roads.clone(), Settings { reroute_secs: 5.0, ..Settings::default() });
    let mut random = Random(seed);
    let stand = |edge: u32| {
        let leg = Leg::new(edge, false);
        let place = 0.5 * SPACING;
        Body { leg, place, speed: 0.0, heading: roads.headings(leg)[0], legs: vec![], limit: (leg, place), stalled: 0 }
    };
    let step = roads.edges().len() as u32 / robots;
    let mut bodies: Vec<Body> = (0..robots).map(|robot| stand(robot * step)).collect();
    let mut goals = vec![u32::MAX; robots as usize];
    let mut arrivals = 0;
    for tick in 0..ticks {
        for (robot, body) in (0..).zip(&bodies) {
            let seen = Seen {
                robot_type: 0,
                edge: Some(body.leg.edge()),
                s: body.place,
                speed: body.speed,
                position: body.outline(&roads).centre,
                state: RobotState::Idle,
            };
            steering.see(robot, &seen);
        }
        for robot in 0..robots {
            let goal = &mut goals[robot as usize];
            if *goal == u32::MAX || steering.has_arrived(robot, *goal) {
                arrivals += u32::from(*goal != u32::MAX);
                *goal = random.below(roads.nodes());
                steering.send(robot, *goal);
            }
        }
        for command in steering.step(f64::from(tick) * f64::from(TICK_SECS)).to_vec() {
            let (Command::Route { robot, .. } | Command::Release { robot, .. } | Command::Cancel { robot }) = command;
            bodies[robot as usize].obey(&command);
        }
        for body in &mut bodies {
            if stalls > 0 && random.below(1_000) < stalls {
                body.stalled = random.below(80);
            }
            body.drive(&roads, 0.7 + 0.3 * random.below(2) as f32);
        }
        let outlines: Vec<Rectangle> = bodies.iter().map(|body| body.outline(&roads)).collect();
        for (a, b) in (0..outlines.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            assert!(!outlines[a].touches(&outlines[b]), "tick {tick}: {:?} and {:?}", bodies[a], bodies[b]);
        }
    }
    arrivals
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// However late robots are, whether they turn on the spot or not.
    #[test]
    fn robots_never_touch(robots in 2_u32..20, seed: u64, turns: bool, stalls in 0_u32..30) {
        drive(robots, seed, turns, stalls, 600);
    }
}

#[test]
fn robots_arrive() {
    for turns in [false, true] {
        let arrivals = drive(4, 7, turns, 5, 3_000);
        assert!(arrivals > 40, "{arrivals} arrivals of four robots in five minutes; turns: {turns}");
    }
}
