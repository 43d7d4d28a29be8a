//! Continuous collision detection against sampling: every pair of segments at many instants.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec2;
use proptest::prelude::*;

use super::*;
use crate::bounds::Bounds;
use crate::geometry_reference::{HORIZON, bodies, distance, outline_at, timed};
use crate::heading::heading;
use crate::swept_path::{Approach, SweptPath};

proptest! {
    #[test]
    fn the_proximity_agrees_with_sampling(
        (a, b) in (bodies(), bodies()),
        (legs_a, legs_b) in (legs(), legs()),
    ) {
        let (segments_a, segments_b) = (trajectory(&a, &legs_a), trajectory(&b, &legs_b));
        let found = closest_proximity((&a, &segments_a), (&b, &segments_b), ALWAYS, 0.05);
        let [swept_a, swept_b] = [(&a, &segments_a), (&b, &segments_b)]
            .map(|(body, segments)| SweptPath::new(body, segments, 0, Bounds::NOTHING));
        let approach = Approach::of((&a, &swept_a), (&b, &swept_b));
        let in_window = closest_proximity((&a, &segments_a), (&b, &segments_b), approach.when_near(0.1), 0.05);
        prop_assert!(found == in_window && (found == Proximity::Apart || approach.comes_near(0.1, HORIZON)));
        agrees(found, (&a, &segments_a), (&b, &segments_b))?;
    }
}

/// Compares a proximity with the distances at many instants.
fn agrees(
    found: Proximity,
    a: (&Body, &[Segment]),
    b: (&Body, &[Segment]),
) -> Result<(), TestCaseError> {
    let nearest = nearest(a, b);
    // Between two instants they move up to 7 cm.
    match found {
        Proximity::Overlap => prop_assert!(nearest < 0.04, "overlap, but {nearest} m apart"),
        Proximity::Near => {
            prop_assert!(nearest < 0.2, "near, but {nearest} m apart");
            prop_assert!(nearest > 0.0 || is_grazing(a, b), "near, but they overlap");
        }
        Proximity::Apart => prop_assert!(nearest > 0.09, "apart, but {nearest} m apart"),
    }
    Ok(())
}

/// Whether a robot turns, and they overlap by less than the distance to which turning robots are
/// exact.
fn is_grazing((a, segments_a): (&Body, &[Segment]), (b, segments_b): (&Body, &[Segment])) -> bool {
    let turns = segments_a.iter().chain(segments_b).any(|segment| segment.turn_rate != 0.0);
    let smaller = smaller(a).zip(smaller(b));
    turns && smaller.is_none_or(|(a, b)| nearest((&a, segments_a), (&b, segments_b)) > 0.0)
}

/// Returns a body without a margin of [`MAX_TURN_ERROR`]; `None` if nothing is left.
fn smaller(body: &Body) -> Option<Body> {
    let smaller = |half: f32| Some(half - MAX_TURN_ERROR as f32).filter(|half| *half > 0.0);
    let half_width = if body.is_circle() { body.half_width } else { smaller(body.half_width)? };
    Some(Body { half_length: smaller(body.half_length)?, half_width, ..*body })
}

/// Returns the least distance of every two segments that share some time, at instants at most 5 ms
/// apart. Where one segment follows another, both count.
fn nearest((a, segments_a): (&Body, &[Segment]), (b, segments_b): (&Body, &[Segment])) -> f64 {
    let mut nearest = f64::INFINITY;
    for (from_a, segment_a) in timed(segments_a) {
        for (from_b, segment_b) in timed(segments_b) {
            let (from, until) =
                (from_a.max(from_b), f64::from(segment_a.until.min(segment_b.until)));
            let instants = if from <= until { 2 + ((until - from) * 200.0) as u32 } else { 0 };
            for instant in 0..instants {
                let time = from + (until - from) * f64::from(instant) / f64::from(instants - 1);
                let outline_a = outline_at(a, segment_a, time - from_a);
                let outline_b = outline_at(b, segment_b, time - from_b);
                nearest = nearest.min(distance(&outline_a, &outline_b));
            }
        }
    }
    nearest
}

/// A long robot turns on the spot, and its end comes to overlap another by less than a centimetre.
#[test]
fn robots_that_graze_each_other_in_a_turn_are_near() {
    let a = Body {
        position: Vec2::new(-0.55521053, 2.7036357),
        heading: Vec2::new(-FRAC_1_SQRT_2, FRAC_1_SQRT_2),
        half_length: 0.030419556,
        half_width: 0.260784,
    };
    let b = Body {
        position: Vec2::new(-2.8873036, -13.966499),
        heading: Vec2::new(0.9883831, -0.15198308),
        half_length: 0.05246069,
        half_width: 17.943045,
    };
    let leg = |turn| vec![(0.0, [0.0, 0.0], turn)];
    let (segments_a, segments_b) = (trajectory(&a, &leg(0.0)), trajectory(&b, &leg(-0.037801787)));
    let (a, b) = ((&a, segments_a.as_slice()), (&b, segments_b.as_slice()));
    let found = closest_proximity(a, b, ALWAYS, 0.05);
    assert_eq!((found, nearest(a, b)), (Proximity::Near, 0.0));
    agrees(found, a, b).expect("less than a centimetre");
}

/// A robot that is wide and short turns by more than its length, so that nothing of it stays where
/// it is: its corners don't count as hit.
#[test]
fn a_robot_that_passes_the_end_of_a_turning_thin_one_does_not_overlap() {
    let a = Body {
        position: Vec2::new(4.6396704, 0.23609333),
        heading: Vec2::Y,
        half_length: 0.0782725,
        half_width: 11.594244,
    };
    let b = Body {
        position: Vec2::new(-6.0047026, -1.5025936),
        heading: Vec2::X,
        half_length: 1.2120137,
        half_width: -1.0,
    };
    let segments_a = trajectory(&a, &vec![(0.0, [0.0, 0.4276619], 0.1823942)]);
    let segments_b = trajectory(&b, &vec![(0.0, [2.261487, 0.0], 0.0)]);
    let (a, b) = ((&a, segments_a.as_slice()), (&b, segments_b.as_slice()));
    assert_eq!(closest_proximity(a, b, ALWAYS, 0.05), Proximity::Near);
    agrees(Proximity::Near, a, b).expect("8 cm apart");
}

/// The legs of a trajectory: the fraction of the remaining time, the velocity, and the turn after
/// it.
type Legs = Vec<(f32, [f32; 2], f32)>;

fn legs() -> impl Strategy<Value = Legs> {
    let speed = prop_oneof![Just(0.0_f32), -5.0_f32..5.0];
    prop::collection::vec((0.0_f32..1.0, [speed.clone(), speed], -0.3_f32..0.3), 1..5)
}

fn trajectory(body: &Body, legs: &Legs) -> Vec<Segment> {
    let (mut now, mut position, mut theta) =
        (0.0, body.position, body.heading.y.atan2(body.heading.x));
    let mut segments = Vec::new();
    for (number, (part, velocity, turn)) in legs.iter().enumerate() {
        let until = if number + 1 == legs.len() { HORIZON } else { now + part * (HORIZON - now) };
        let heading = if number == 0 { body.heading } else { heading(theta) };
        segments.push(Segment {
            until,
            position,
            velocity: Vec2::from(*velocity),
            heading,
            turn_rate: turn / HORIZON,
        });
        position += Vec2::from(*velocity) * (until - now);
        (now, theta) = (until, theta + turn);
    }
    segments
}
