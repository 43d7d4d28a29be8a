//! Fleets for the detector's tests, and random frames.

use proptest::prelude::*;
use regatta_plugin::frame::{Columns, NO_EDGE};
use regatta_plugin::world::{EdgeRecord, Orientation, RobotTypeRecord, Shape, WorldData};

use crate::detector::{Detector, FrameInput};
use crate::geometry_reference::world;

/// A robot as a row of a frame, which is easier to write down than columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Robot {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub speed: f32,
    pub s: f32,
    pub edge: u32,
    pub state: u8,
    pub robot_type: f32,
}

impl Robot {
    pub(super) const IDLE: Self = Self {
        x: 0.0,
        y: 0.0,
        theta: 0.0,
        speed: 0.0,
        s: 0.0,
        edge: NO_EDGE,
        state: 0,
        robot_type: 0.0,
    };
}

/// Returns robot types, with and without limits: usual ones, huge and tiny ones, and an invalid
/// one.
pub(super) fn robot_types() -> Vec<RobotTypeRecord> {
    let unlimited = |shape: Shape, length: f32, width: f32| RobotTypeRecord {
        shape: shape as u32,
        ..RobotTypeRecord::new("type", length, width)
    };
    let limited = |max_acceleration: f32, robot_type| RobotTypeRecord {
        max_speed: 1.5,
        max_acceleration,
        ..robot_type
    };
    vec![
        unlimited(Shape::Rectangle, 0.9, 0.6),
        limited(0.8, unlimited(Shape::Circle, 0.5, 0.0)),
        limited(0.3, unlimited(Shape::Rectangle, 25.0, 8.0)),
        limited(9.0, unlimited(Shape::Rectangle, 0.02, 0.01)),
        unlimited(Shape::Circle, 40.0, 0.0),
        unlimited(Shape::Rectangle, f32::NAN, 1.0),
    ]
}

/// Returns the robot types, and edges between three nodes, of which one isn't a curve. Two leave
/// the second node, one in reverse gear; on that one, robots drive sideways.
pub(super) fn test_world() -> WorldData {
    let edge = |[origin, destination]: [u32; 2],
                [forward, backwards]: [f32; 2],
                control_points,
                length| {
        let (speed, reverse_speed) = (forward, backwards);
        let edge = EdgeRecord {
            origin,
            destination,
            speed,
            reverse_speed,
            length,
            ..EdgeRecord::default()
        };
        (edge, control_points)
    };
    let mut edges = [
        edge([0, 1], [1.5, 0.0], [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [6.0, 0.0]], 6.0),
        edge([1, 2], [0.6, 0.3], [[0.0, 0.0], [1.1, 0.0], [2.0, 0.9], [2.0, 2.0]], 3.2),
        edge([1, 1], [0.0, 0.0], [[0.0, 0.0], [5.0, 0.0], [-5.0, 5.0], [8.0, 5.0]], 13.0),
        edge([2, 0], [1.0, 1.0], [[f32::NAN; 2]; 4], 5.0),
    ];
    edges[1].0 = edges[1].0.with_orientation(Orientation::Offset(1.5));
    WorldData { robot_types: robot_types(), ..world(edges) }
}

/// Passes a frame of these robots to a detector.
pub(super) fn update(detector: &mut Detector, robots: &[Robot], tick: u64) {
    let column = |of: fn(&Robot) -> f32| robots.iter().map(of).collect::<Vec<_>>();
    let [x, y, theta] =
        [column(|robot| robot.x), column(|robot| robot.y), column(|robot| robot.theta)];
    let [speed, s, robot_types] =
        [column(|robot| robot.speed), column(|robot| robot.s), column(|robot| robot.robot_type)];
    let edge: Vec<_> = robots.iter().map(|robot| robot.edge).collect();
    let state: Vec<_> = robots.iter().map(|robot| robot.state).collect();
    let columns =
        Columns { x: &x, y: &y, theta: &theta, speed: &speed, s: &s, edge: &edge, state: &state };
    detector.update(&FrameInput {
        run_id: 1,
        tick,
        sim_time_nanos: tick * 1_000_000_000,
        columns,
        robot_types: &robot_types,
    });
}

/// The layout of a random frame: robots in a box, on one spot, in a row or a column, far from the
/// origin, in a lattice.
#[derive(Clone, Copy, Debug)]
enum Layout {
    Box(f32),
    Spot,
    Row(f32),
    Column(f32),
    Corner(f32),
    Lattice(f32),
}

fn layouts() -> impl Strategy<Value = Layout> {
    prop_oneof![
        (1.0_f32..60.0).prop_map(Layout::Box),
        Just(Layout::Spot),
        prop::sample::select(vec![0.25, 0.9, 0.6, 100.0, 8_000.0]).prop_map(Layout::Row),
        prop::sample::select(vec![0.25, 0.9, 0.6, 100.0, 8_000.0]).prop_map(Layout::Column),
        prop::sample::select(vec![8_000.0, 999_990.0]).prop_map(Layout::Corner),
        prop::sample::select(vec![2.0, 8.0, 512.0, 65_536.0]).prop_map(Layout::Lattice),
    ]
}

impl Layout {
    fn position(self, number: usize, [u, v]: [f32; 2]) -> [f32; 2] {
        let row = number as f32;
        match self {
            Self::Box(side) => [u * side, v * side],
            Self::Spot => [3.25, -7.5],
            Self::Row(step) => [row * step, v * 0.3],
            Self::Column(step) => [u * 0.3, row * step],
            Self::Corner(far) => [far - u * 4.0, -far + v * 4.0],
            Self::Lattice(step) => [(number % 8) as f32 * step, (number / 8) as f32 * step],
        }
    }
}

fn robots() -> impl Strategy<Value = Robot> {
    let axis = prop::sample::select(vec![0.0, 0.5, 1.0, -0.5])
        .prop_map(|turn| turn * std::f32::consts::PI);
    let theta = prop_oneof![axis, -3.2_f32..3.2];
    let speed = prop_oneof![Just(0.0_f32), -2.0_f32..2.0, Just(1.0)];
    let edge = prop::sample::select(vec![0, 1, 2, 2, 3, 77, NO_EDGE]);
    let state = prop::sample::select(vec![0_u8, 1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 255]);
    let robot_type = prop::sample::select(vec![
        0.0_f32,
        0.0,
        0.0,
        0.0,
        1.0,
        1.0,
        2.0,
        3.0,
        3.0,
        4.0,
        5.0,
        6.0,
        -1.0,
        f32::NAN,
    ]);
    let unit = [0.0_f32..1.0, 0.0_f32..1.0];
    (unit, theta, speed, -1.0_f32..15.0, edge, state, robot_type).prop_map(
        |([x, y], theta, speed, s, edge, state, robot_type)| Robot {
            x,
            y,
            theta,
            speed,
            s,
            edge,
            state,
            robot_type,
        },
    )
}

/// Returns numbers that a faulty producer may send.
fn garbage() -> impl Strategy<Value = f32> {
    prop::sample::select(vec![
        f32::NAN,
        f32::INFINITY,
        -f32::INFINITY,
        f32::MAX,
        -1e7,
        1e-40,
        0.0,
        1000.5,
        f32::MIN_POSITIVE,
    ])
}

/// Returns frames of robots in a layout, of which a few have invalid values.
pub(super) fn frames(max_robots: usize) -> impl Strategy<Value = Vec<Robot>> {
    let faults = prop::collection::vec((any::<prop::sample::Index>(), 0_usize..5, garbage()), 0..4);
    (layouts(), prop::collection::vec(robots(), 1..max_robots), faults).prop_map(
        |(layout, mut robots, faults)| {
            for (number, robot) in robots.iter_mut().enumerate() {
                [robot.x, robot.y] = layout.position(number, [robot.x, robot.y]);
            }
            for (index, column, value) in faults {
                let Robot { x, y, theta, speed, s, .. } = index.get_mut(&mut robots[..]);
                *[x, y, theta, speed, s][column] = value;
            }
            robots
        },
    )
}

/// Returns the robots some time later: all have moved a bit, a few have changed their state, left,
/// or come.
pub(super) fn later(robots: &[Robot], shift: f32) -> Vec<Robot> {
    let mut later = robots.to_vec();
    for (number, robot) in later.iter_mut().enumerate() {
        let step = shift * robot.speed.clamp(-2.0, 2.0);
        robot.x += step * robot.theta.cos();
        robot.y += step * robot.theta.sin();
        robot.s += step;
        robot.theta += 0.3 * shift;
        if (number + (shift * 100.0) as usize).is_multiple_of(7) {
            robot.state = (robot.state % 8 + 1) % 8;
        }
    }
    if shift > 0.5 {
        later.truncate(robots.len() / 2 + 1);
    }
    later
}
