//! Predicted trajectories against densely sampled curves.

mod routes;

use std::f32::consts::TAU;

use proptest::prelude::*;
use regatta_plugin::world::EdgeRecord;

use super::*;
use crate::geometry_reference::{
    HORIZON, Point, on_polyline, outline, outline_at, polyline, timed, world,
};
use crate::heading::heading;
use crate::leg_table::LegTable;

/// Returns the corners of a body at a time of its trajectory, in seconds from now.
fn corners_at(body: &Body, segments: &[Segment], time: f64) -> Vec<Point> {
    let (start, segment) = timed(segments)
        .find(|(_, segment)| time <= f64::from(segment.until))
        .expect("within the horizon");
    outline_at(body, segment, time - start).0
}

/// A robot without limits and without a known route.
const FREE: Motion = Motion {
    speed: 0.0,
    s: 0.0,
    edge: 0,
    intent: Intent::Drive,
    limits: Limits::NONE,
    route: None,
};

/// Returns all trajectories of a robot.
fn trajectories(body: &Body, motion: &Motion, table: &LegTable) -> Vec<Vec<Segment>> {
    let (mut all, mut segments) = (Vec::new(), Vec::new());
    Predictor::default().predict((body, motion), (table, HORIZON), &mut segments, |segments| {
        all.push(std::mem::take(segments));
    });
    all
}

/// Returns the trajectory of a robot that has only one.
fn trajectory(body: &Body, motion: &Motion, table: &LegTable) -> Vec<Segment> {
    let mut all = trajectories(body, motion, table);
    assert_eq!(all.len(), 1);
    all.remove(0)
}

fn curves() -> impl Strategy<Value = [[f32; 2]; 4]> {
    // Curves as roads have them: the inner control points lie roughly between the ends.
    (3.0_f32..20.0, [-0.4_f32..0.4, -0.4_f32..0.4], [0.2_f32..0.5, 0.2_f32..0.5]).prop_map(
        |(length, bend, handle)| {
            let first = [handle[0] * length, bend[0] * length];
            [[0.0, 0.0], first, [(1.0 - handle[1]) * length, bend[1] * length], [length, 0.0]]
        },
    )
}

proptest! {
    #[test]
    fn trajectories_follow_the_edge_and_then_its_tangent(
        control_points in curves(),
        (part, speed, straight) in (0.0_f64..1.0, -3.0_f32..3.0, any::<bool>()),
    ) {
        let control_points = if straight { control_points.map(|[x, _]| [x, 0.0]) } else { control_points };
        let polyline = polyline(&control_points);
        let length = polyline[polyline.len() - 1].0;
        let edge = EdgeRecord { length: length as f32, destination: 1, ..EdgeRecord::default() };
        let table = LegTable::new(&world([(edge, control_points)]).view(1, 1));
        let s = part * length;
        let (start, theta) = on_polyline(&polyline, s);
        let heading = heading(theta as f32);
        let body = Body { position: Vec2::from(start.map(|x| x as f32)), heading, half_length: 0.5, half_width: 0.3 };
        let segments = trajectory(&body, &Motion { speed, s: s as f32, ..FREE }, &table);
        prop_assert_eq!(segments[segments.len() - 1].until, HORIZON);
        prop_assert!(!straight || segments.len() == 1);
        for instant in 0..=100 {
            let time = f64::from(instant) / 100.0 * f64::from(HORIZON);
            let (position, theta) = on_polyline(&polyline, s + f64::from(speed) * time);
            let exact = outline(&body, position, Vec2::new(theta.cos() as f32, theta.sin() as f32)).0;
            let found = corners_at(&body, &segments, time);
            let far = exact.iter().zip(&found).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max);
            // Chords deviate by 2 cm, and turn evenly: in the tightest of these curves, corners are
            // off by 8 cm.
            prop_assert!(far < 0.15, "{far} m off after {time} s");
        }
    }

    #[test]
    fn a_pose_beside_its_edge_stays_beside_it(
        control_points in curves(),
        turned in -1.0_f32..1.0,
        aside in -5.0_f32..5.0,
    ) {
        let polyline = polyline(&control_points);
        let length = polyline[polyline.len() - 1].0 as f32;
        let edge = EdgeRecord { length, destination: 1, ..EdgeRecord::default() };
        let table = LegTable::new(&world([(edge, control_points)]).view(1, 1));
        let (start, theta) = on_polyline(&polyline, 1.0);
        let trajectories = [(0.0, 0.0), (turned, aside)].map(|(turned, aside)| {
            let position = Vec2::new(start[0] as f32 + aside, start[1] as f32 - aside);
            let body = Body { position, heading: heading(theta as f32 + turned), half_length: 0.5, half_width: 0.3 };
            trajectory(&body, &Motion { speed: 2.0, s: 1.0, ..FREE }, &table)
        });
        for (on, beside) in trajectories[0].iter().zip(&trajectories[1]) {
            let offset = beside.position - on.position;
            prop_assert!((offset.x - aside).abs() < 1e-4 && (offset.y + aside).abs() < 1e-4, "{offset:?}");
            let angle = |segment: &Segment| segment.heading.y.atan2(segment.heading.x);
            let off = (angle(beside) - angle(on) - turned + 7.0).rem_euclid(TAU) - 7.0_f32.rem_euclid(TAU);
            prop_assert!(off.abs() < 1e-4, "{off}");
        }
    }
}

#[test]
fn robots_that_stay_put_or_have_no_edge_have_straight_trajectories() {
    let body =
        Body { position: Vec2::new(1.0, 2.0), heading: Vec2::Y, half_length: 0.5, half_width: 0.3 };
    for (speed, s, expected) in
        [(0.0, 0.0, Vec2::ZERO), (2.0, 0.0, 2.0 * Vec2::Y), (-1.0, f32::NAN, -Vec2::Y)]
    {
        let segments = trajectory(&body, &Motion { speed, s, ..FREE }, &LegTable::default());
        let (position, heading) = (body.position, body.heading);
        assert_eq!(
            segments,
            [Segment { until: HORIZON, position, velocity: expected, heading, turn_rate: 0.0 }]
        );
    }
}
