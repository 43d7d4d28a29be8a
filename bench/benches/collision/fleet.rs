//! Moving fleets of a given size, at one robot per 4 m².

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use regatta_base::random::mix;
use regatta_collision::FrameInput;
use regatta_plugin::frame::Columns;
use regatta_plugin::world::{CurveRecord, EdgeRecord, RobotTypeRecord, Shape, WorldData};

/// Area per robot, in square metres.
const AREA: f32 = 4.0;
/// Number of frames of a fleet, [`SECONDS`] apart.
const FRAMES: usize = 8;
/// Time between two frames, in seconds: 60 Hz.
const SECONDS: f32 = 1.0 / 60.0;
/// Number of edges that robots drive on.
const EDGES: usize = 4096;

/// Shape, length and width of each robot type, in metres.
const TYPES: [(Shape, f32, f32); 4] = [
    (Shape::Rectangle, LENGTH, WIDTH),
    (Shape::Circle, 0.7, 0.0),
    (Shape::Rectangle, 1.2, 0.8),
    (Shape::Rectangle, 0.5, 0.4),
];
/// Length and width of the first type, in metres.
pub const LENGTH: f32 = 0.9;
pub const WIDTH: f32 = 0.6;

/// Robots at random positions in a square, three in five on straight edges, the others on curves of
/// 1 to 6 m radius. One robot in ten stands, the others drive at 0.5 to 1.5 m/s.
pub struct Fleet {
    pub world: WorldData,
    robot_type_column: Vec<f32>,
    frames: Vec<Frame>,
    next: usize,
}

#[derive(Default)]
struct Frame {
    x: Vec<f32>,
    y: Vec<f32>,
    theta: Vec<f32>,
    speed: Vec<f32>,
    s: Vec<f32>,
    edge: Vec<u32>,
    state: Vec<u8>,
}

/// An edge that is simple to evaluate: an arc that starts at its origin.
#[derive(Clone, Copy)]
struct Arc {
    length: f32,
    /// Curvature, in radians per metre; 0 if straight.
    curvature: f32,
    heading: f32,
}

impl Arc {
    /// Returns the heading at the distance `s` along the arc, and the displacement from the origin.
    fn at(&self, s: f32) -> (f32, [f32; 2]) {
        let heading = self.heading + self.curvature * s;
        if self.curvature == 0.0 {
            return (heading, [s * heading.cos(), s * heading.sin()]);
        }
        let displacement = [heading.sin() - self.heading.sin(), self.heading.cos() - heading.cos()];
        (heading, displacement.map(|part| part / self.curvature))
    }

    /// Returns the arc as a Bézier curve, exact to a thousandth up to a quarter of a circle.
    fn record(&self) -> CurveRecord {
        let (end_heading, end) = self.at(self.length);
        let turn = self.curvature * self.length;
        let handle = if turn == 0.0 {
            self.length / 3.0
        } else {
            4.0 / 3.0 * (turn / 4.0).tan() / self.curvature
        };
        let first = [handle * self.heading.cos(), handle * self.heading.sin()];
        let second = [end[0] - handle * end_heading.cos(), end[1] - handle * end_heading.sin()];
        CurveRecord { control_points: [[0.0; 2], first, second, end] }
    }
}

/// A generator of numbers from 0 to 1, which holds the number of draws.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 += 1;
        (mix(self.0) >> 40) as f32 / (1 << 24) as f32
    }
}

impl Fleet {
    /// Creates a fleet of the first `types` of [`TYPES`], in turn.
    pub fn new(robots: usize, types: usize) -> Self {
        let mut random = Random(1);
        let arcs: Vec<_> = (0..EDGES).map(|_| arc(&mut random)).collect();
        let robot_types = TYPES[..types].iter().map(robot_type).collect();
        let mut world = WorldData { robot_types, ..WorldData::default() };
        for (id, arc) in (0..).zip(&arcs) {
            world.add_edge(
                EdgeRecord { id, length: arc.length, ..EdgeRecord::default() },
                [arc.record()],
            );
        }
        let side = (robots as f32 * AREA).sqrt();
        let mut frames: Vec<Frame> = Vec::new();
        frames.resize_with(FRAMES, Frame::default);
        for _ in 0..robots {
            let edge = ((random.unit() * EDGES as f32) as usize).min(EDGES - 1);
            let origin = [random.unit() * side, random.unit() * side];
            let speed = if random.unit() < 0.1 { 0.0 } else { 0.5 + random.unit() };
            let start = random.unit() * arcs[edge].length;
            for (number, frame) in frames.iter_mut().enumerate() {
                frame.push(
                    origin,
                    (edge, arcs[edge]),
                    start + speed * SECONDS * number as f32,
                    speed,
                );
            }
        }
        let robot_type_column = (0..robots).map(|robot| (robot % types) as f32).collect();
        Self { world, robot_type_column, frames, next: 0 }
    }

    /// Returns the next frame. After the last frame, the frames run backwards.
    pub fn input(&mut self) -> FrameInput<'_> {
        self.next += 1;
        let turn = self.next % (2 * FRAMES - 2);
        let frame = &self.frames[turn.min(2 * FRAMES - 2 - turn)];
        FrameInput {
            run_id: 1,
            tick: self.next as u64,
            sim_time_nanos: self.next as u64 * 16_666_667,
            columns: frame.columns(),
            robot_types: &self.robot_type_column,
        }
    }
}

fn robot_type(&(shape, length, width): &(Shape, f32, f32)) -> RobotTypeRecord {
    RobotTypeRecord { shape: shape as u32, ..RobotTypeRecord::new("type", length, width) }
}

fn arc(random: &mut Random) -> Arc {
    let heading = random.unit() * TAU - PI;
    if random.unit() < 0.6 {
        return Arc { length: 2.0 + 8.0 * random.unit(), curvature: 0.0, heading };
    }
    let (radius, turn) = (1.0 + 5.0 * random.unit(), FRAC_PI_2 * (0.3 + 0.7 * random.unit()));
    let curvature = if random.unit() < 0.5 { 1.0 / radius } else { -1.0 / radius };
    Arc { length: radius * turn, curvature, heading }
}

impl Frame {
    fn push(&mut self, origin: [f32; 2], (edge, arc): (usize, Arc), s: f32, speed: f32) {
        let (heading, displacement) = arc.at(s.min(arc.length));
        let beyond = (s - arc.length).max(0.0);
        self.x.push(origin[0] + displacement[0] + beyond * heading.cos());
        self.y.push(origin[1] + displacement[1] + beyond * heading.sin());
        self.theta.push((heading + PI).rem_euclid(TAU) - PI);
        self.speed.push(speed);
        self.s.push(s);
        self.edge.push(edge as u32);
        self.state.push(u8::from(speed > 0.0));
    }

    fn columns(&self) -> Columns<'_> {
        let Self { x, y, theta, speed, s, edge, state } = self;
        Columns { x, y, theta, speed, s, edge, state }
    }
}
