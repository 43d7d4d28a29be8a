//! Predictions against the exact motion: a large robot on a curve, and a small one beside it.

use glam::Vec2;
use proptest::prelude::*;
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord, Shape, WorldData};

use super::fleet::{Robot, robot_types, update};
use crate::body::{Body, CIRCLE};
use crate::criteria::Settings;
use crate::detector::Detector;
use crate::geometry_reference::{distance, on_polyline, outline, polyline, world};
use crate::heading::heading;

/// Half of the sizes of the large and the small robot, in metres.
const LARGE: [f32; 2] = [1.5, 0.5];
const SMALL: [f32; 2] = [0.15, 0.1];
/// The largest error of a prediction, in metres: 2 cm of the chords, 1 cm of the turn, and what the
/// robots move between two samples.
const TOLERANCE: f64 = 0.04;
const HORIZON: f32 = 2.0;

fn bends() -> impl Strategy<Value = [[f32; 2]; 4]> {
    // Turns by up to a quarter of a circle, either way, with radii from 1.5 m.
    (1.5_f32..6.0, 0.3_f32..1.0, any::<bool>()).prop_map(|(radius, part, left)| {
        let turn = part * std::f32::consts::FRAC_PI_2;
        let (handle, side) =
            (4.0 / 3.0 * (turn / 4.0).tan() * radius, if left { 1.0 } else { -1.0 });
        let end = [radius * turn.sin(), side * radius * (1.0 - turn.cos())];
        [
            [0.0, 0.0],
            [handle, 0.0],
            [end[0] - handle * turn.cos(), end[1] - side * handle * turn.sin()],
            end,
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn a_large_robot_on_a_curve_hits_a_small_one_if_and_only_if_it_is_predicted(
        control_points in bends(),
        is_circle in any::<bool>(),
        speed in prop_oneof![0.3_f32..3.0, -3.0_f32..-0.3],
        theta in -3.1_f32..3.1,
        along in 0.0_f64..1.0,
        // The corners and the sides of the large robot pass there.
        aside in prop_oneof![-1.2_f64..-0.3, 0.3_f64..1.2],
    ) {
        let curve = polyline(&control_points);
        let length = curve[curve.len() - 1].0;
        let s = if speed > 0.0 { 0.0 } else { length };
        let (start, start_theta) = on_polyline(&curve, s);
        let large = Robot {
            x: start[0] as f32, y: start[1] as f32, theta: start_theta as f32, speed, s: s as f32, edge: 0, state: 1,
            ..Robot::IDLE
        };
        let (beside, beside_theta) = on_polyline(&curve, along * length);
        let position = [beside[0] - aside * beside_theta.sin(), beside[1] + aside * beside_theta.cos()];
        let small = Robot { x: position[0] as f32, y: position[1] as f32, theta, robot_type: 1.0, ..Robot::IDLE };

        let robot_type = |[length, width]: [f32; 2], shape: Shape| {
            RobotTypeRecord { length: 2.0 * length, width: 2.0 * width, shape: shape as u32, ..robot_types()[0] }
        };
        let small_shape = if is_circle { Shape::Circle } else { Shape::Rectangle };
        let mut detector = Detector::new(Settings::new(0.0, HORIZON).expect("valid settings"));
        let edge = EdgeRecord { length: length as f32, destination: 1, ..EdgeRecord::default() };
        let robot_types = vec![robot_type(LARGE, Shape::Rectangle), robot_type(SMALL, small_shape)];
        let world = WorldData { robot_types, ..world([(edge, control_points)]) };
        detector.set_world(&world.view(1, 1));
        update(&mut detector, &[large, small], 1);
        let predicted = detector.levels()[0] > 0.0;

        let body = |robot: &Robot, [half_length, half_width]: [f32; 2]| {
            Body { position: Vec2::new(robot.x, robot.y), heading: heading(robot.theta), half_length, half_width }
        };
        let small_size = |less: f32| [SMALL[0] - less, if is_circle { CIRCLE } else { SMALL[1] - less }];
        // The exact distance, and the distance of footprints that are smaller by the tolerance in
        // all.
        let less = 0.5 * TOLERANCE as f32;
        let (mut nearest, mut nearest_inside) = (f64::INFINITY, f64::INFINITY);
        for instant in 0..=400 {
            let time = f64::from(instant) / 400.0 * f64::from(HORIZON);
            let (at, turned) = on_polyline(&curve, s + f64::from(speed) * time);
            let turned = Vec2::new(turned.cos() as f32, turned.sin() as f32);
            let gap = |large_size: [f32; 2], small_size: [f32; 2]| {
                let small = body(&small, small_size);
                let large = outline(&body(&large, large_size), at, turned);
                distance(&large, &outline(&small, position.map(|axis| f64::from(axis as f32)), small.heading))
            };
            nearest = nearest.min(gap(LARGE, small_size(0.0)));
            nearest_inside = nearest_inside.min(gap(LARGE.map(|half| half - less), small_size(less)));
        }
        if predicted {
            prop_assert!(nearest < TOLERANCE, "predicted, but {nearest} m apart");
        } else {
            prop_assert!(nearest_inside > 0.0, "hits by {TOLERANCE} m, but not predicted");
        }
    }
}
