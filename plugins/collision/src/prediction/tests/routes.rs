//! Predictions along routes and forks, and of robots that accelerate and brake.

use proptest::prelude::*;

use regatta_plugin::world::{CurveRecord, Orientation, WorldData};

use super::*;

/// An edge with its control points.
type Edge = (EdgeRecord, [[f32; 2]; 4]);

/// A straight edge from a point to another, at some speed.
fn straight([origin, destination]: [u32; 2], from: [f32; 2], to: [f32; 2], speed: f32) -> Edge {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let edge = EdgeRecord { origin, destination, length, speed, ..EdgeRecord::default() };
    (edge, CurveRecord::straight(from, to).control_points)
}

fn leg_table<const N: usize>(edges: [Edge; N]) -> LegTable {
    LegTable::new(&world(edges).view(1, 1))
}

/// A fork 4 m to the east: edge 1 leads on to the east, edge 2 to the north. Edge 3 leads on to the
/// east, slowly.
fn fork() -> LegTable {
    leg_table([
        straight([0, 1], [0.0, 0.0], [4.0, 0.0], 1.5),
        straight([1, 2], [4.0, 0.0], [8.0, 0.0], 1.5),
        straight([1, 3], [4.0, 0.0], [4.0, 4.0], 1.5),
        straight([2, 4], [8.0, 0.0], [12.0, 0.0], 0.5),
    ])
}

fn robot(x: f32) -> Body {
    Body { position: Vec2::new(x, 0.0), heading: Vec2::X, half_length: 0.45, half_width: 0.3 }
}

fn end(segments: &[Segment]) -> Vec2 {
    let mut start = 0.0;
    for segment in &segments[..segments.len() - 1] {
        start = segment.until;
    }
    segments[segments.len() - 1].end(start)
}

fn near(a: Vec2, b: impl Into<Vec2>) -> bool {
    a.distance(b.into()) < 0.02
}

const LIMITS: Limits = Limits { max_speed: 1.5, max_acceleration: 0.8 };

#[test]
fn without_a_route_a_robot_may_take_any_way_and_with_one_it_takes_that() {
    let motion = Motion { speed: 1.5, s: 2.0, ..FREE };
    let ends: Vec<_> =
        trajectories(&robot(2.0), &motion, &fork()).iter().map(|way| end(way)).collect();
    assert!(
        matches!(ends[..], [east, north] if near(east, [5.0, 0.0]) && near(north, [4.0, 1.0])),
        "{ends:?}"
    );
    for (edge, expected) in [(1, [5.0, 0.0]), (2, [4.0, 1.0])] {
        let legs = [Leg::new(edge, false)];
        let route = Some(RouteAhead {
            reverse: None,
            legs: &legs,
            end: RouteEnd::Open,
            limit: f32::INFINITY,
        });
        let way = trajectory(&robot(2.0), &Motion { route, ..motion }, &fork());
        assert!(near(end(&way), expected), "{:?}", end(&way));
    }
    assert_eq!(
        trajectories(&robot(0.5), &Motion { s: 0.5, ..motion }, &fork()).len(),
        1,
        "the fork is too far away"
    );
}

#[test]
fn a_robot_too_fast_for_a_way_does_not_take_it() {
    let slow = straight([1, 3], [4.0, 0.0], [4.0, 4.0], 0.3);
    let table = leg_table([
        straight([0, 1], [0.0, 0.0], [4.0, 0.0], 1.5),
        straight([1, 2], [4.0, 0.0], [8.0, 0.0], 1.5),
        slow,
    ]);
    let motion = Motion { speed: 1.5, s: 3.5, limits: LIMITS, ..FREE };
    let way = trajectory(&robot(3.5), &motion, &table);
    assert!(near(end(&way), [6.5, 0.0]), "{:?}", end(&way));
    assert_eq!(trajectories(&robot(3.5), &Motion { speed: 0.8, ..motion }, &table).len(), 2);
}

#[test]
fn a_robot_stops_within_a_leg_where_its_base_ends() {
    let next = [Leg::new(1, false)];
    for (legs, limit, place) in [(&next[..], 0.75, 4.75), (&[], 3.25, 3.25)] {
        for limits in [LIMITS, Limits::NONE] {
            let route = Some(RouteAhead { reverse: None, legs, end: RouteEnd::Stop, limit });
            let motion = Motion { speed: 1.5, s: 3.0, limits, route, ..FREE };
            let way = trajectory(&robot(3.0), &motion, &fork());
            assert!(near(end(&way), [place, 0.0]), "{:?}", end(&way));
        }
    }
}

#[test]
fn a_robot_stops_at_the_end_of_its_released_base() {
    for limits in [LIMITS, Limits::NONE] {
        let route = Some(RouteAhead {
            reverse: None,
            legs: &[],
            end: RouteEnd::Stop,
            limit: f32::INFINITY,
        });
        let motion = Motion { speed: 1.5, s: 2.4, limits, route, ..FREE };
        let way = trajectory(&robot(2.4), &motion, &fork());
        assert!(near(end(&way), [4.0, 0.0]), "{:?}", end(&way));
    }
}

#[test]
fn a_held_robot_brakes_and_stands_at_once_without_a_limit() {
    let motion = Motion { speed: 1.5, s: 0.0, limits: LIMITS, intent: Intent::Hold, ..FREE };
    let way = trajectory(&robot(0.0), &motion, &fork());
    assert!(near(end(&way), [1.5 * 1.5 / 1.6, 0.0]), "{:?}", end(&way));
    let way = trajectory(&robot(0.0), &Motion { limits: Limits::NONE, ..motion }, &fork());
    assert_eq!(end(&way), Vec2::ZERO);
}

#[test]
fn a_robot_in_reverse_gear_follows_its_route_into_the_other_gear() {
    let mut edges = [
        straight([0, 1], [0.0, 0.0], [4.0, 0.0], 1.0),
        straight([0, 2], [0.0, 0.0], [0.0, 4.0], 1.0),
    ];
    edges[0].0.reverse_speed = 0.5;
    let legs = [Leg::new(1, false)];
    let route = Some(RouteAhead {
        reverse: Some(true),
        legs: &legs,
        end: RouteEnd::Stop,
        limit: f32::INFINITY,
    });
    let motion = Motion { speed: -0.5, s: 0.5, route, ..FREE };
    let way = trajectory(&robot(0.5), &motion, &leg_table(edges));
    assert!(
        near(end(&way), [0.0, 1.0]),
        "half a metre back in a second, then a metre to the north: {:?}",
        end(&way)
    );
}

#[test]
fn a_robot_follows_all_curves_of_an_edge_with_the_heading_of_its_orientation() {
    let line = CurveRecord::straight;
    for orientation in [Orientation::Tangential, Orientation::Offset(1.0), Orientation::Fixed(-2.0)]
    {
        let mut world = WorldData::default();
        let edge = EdgeRecord { length: 4.0, destination: 1, speed: 1.5, ..EdgeRecord::default() };
        let curves = [
            line([0.0, 0.0], [1.0, 0.0]),
            line([1.0, 0.0], [2.0, 0.0]),
            line([2.0, 0.0], [2.0, 2.0]),
        ];
        world.add_edge(edge.with_orientation(orientation), curves);
        let facing = |tangent: f32| heading(orientation.heading(tangent));
        let body = Body { heading: facing(0.0), ..robot(0.5) };
        let motion = Motion { speed: 1.5, s: 0.5, ..FREE };
        let way = trajectory(&body, &motion, &LegTable::new(&world.view(1, 1)));
        assert!(near(end(&way), [2.0, 1.5]), "{orientation:?}: {way:?}");
        let last = way[way.len() - 1].heading;
        assert!(near(last, facing(std::f32::consts::FRAC_PI_2)), "{orientation:?}: {last:?}");
    }
}

#[test]
fn a_robot_takes_the_heading_of_the_next_edge() {
    let mut edges = [
        straight([0, 1], [0.0, 0.0], [4.0, 0.0], 1.5),
        straight([1, 2], [4.0, 0.0], [8.0, 0.0], 1.5),
    ];
    edges[1].0 = edges[1].0.with_orientation(Orientation::Fixed(2.0));
    let way = trajectory(&robot(3.0), &Motion { speed: 1.5, s: 3.0, ..FREE }, &leg_table(edges));
    assert!(
        near(end(&way), [6.0, 0.0]) && near(way[way.len() - 1].heading, heading(2.0)),
        "{way:?}"
    );
}

proptest! {
    /// The motion that the segments approximate, in small steps as the engine makes them.
    #[test]
    fn segments_stay_near_a_robot_that_accelerates_and_brakes(
        speed in 0.0_f32..1.5,
        s in 0.0_f32..4.0,
        acceleration in 0.2_f32..4.0,
        stops in any::<bool>(),
    ) {
        let limits = Limits { max_speed: 2.0, max_acceleration: acceleration };
        // It can brake for what comes.
        let (legs, last) = ([Leg::new(1, false), Leg::new(3, false)], if stops { 1 } else { 2 });
        let end_x = if stops { 8.0 } else { 12.0 };
        let bound = |x: f32| if stops { (2.0 * acceleration * (8.0 - x).max(0.0)).sqrt() } else if x < 8.0 {
            (0.25 + 2.0 * acceleration * (8.0 - x)).sqrt()
        } else { 0.5 };
        let speed = speed.min(bound(s));
        let end = if stops { RouteEnd::Stop } else { RouteEnd::Open };
        let route = Some(RouteAhead { reverse: None, legs: &legs[..last], end, limit: f32::INFINITY });
        let motion = Motion { speed, s, limits, route, ..FREE };
        let way = trajectory(&robot(s), &motion, &fork());
        let (mut x, mut v) = (s, speed);
        let step = 1e-3_f32;
        for tick in 0..(HORIZON / step) as u32 {
            let time = f64::from(tick) * f64::from(step);
            let corners = corners_at(&robot(0.0), &way, time);
            let found = corners.iter().map(|corner| corner[0]).sum::<f64>() / 4.0;
            prop_assert!((found - f64::from(x)).abs() < 0.04, "{found} {x} after {time} s of {way:?}");
            let wanted = (v + acceleration * step).min(if x < 8.0 { 1.5 } else { 0.5 });
            v = wanted.min(bound(x + 0.5 * (v + wanted) * step)).max(v - 1.5 * acceleration * step);
            x = (x + v * step).min(end_x);
        }
    }
}

proptest! {
    /// A faulty producer may claim any place for a robot, and a faulty manager any end of its base.
    #[test]
    fn no_robot_is_faster_than_its_limits_wherever_it_claims_to_be(
        s in prop_oneof![-20.0_f32..20.0, prop::sample::select(vec![f32::MAX, f32::MIN, 1e9, -1e9])],
        limit in prop_oneof![-20.0_f32..20.0, prop::sample::select(vec![f32::MAX, f32::MIN, f32::INFINITY, f32::NAN])],
        (speed, max_acceleration) in (-3.0_f32..3.0, prop::sample::select(vec![0.3_f32, 9.0, f32::INFINITY])),
        (has_route, has_legs, hold) in any::<(bool, bool, bool)>(),
    ) {
        let next = [Leg::new(1, false)];
        let legs = if has_legs { &next[..] } else { &[] };
        let route = has_route.then_some(RouteAhead { reverse: None, legs, end: RouteEnd::Stop, limit });
        let limits = Limits { max_speed: 1.5, max_acceleration };
        let intent = if hold { Intent::Hold } else { Intent::Drive };
        for way in trajectories(&robot(2.0), &Motion { speed, s, intent, limits, route, ..FREE }, &fork()) {
            for segment in way {
                prop_assert!(segment.velocity.length() <= 1.001 * speed.abs().max(1.5), "{segment:?}");
            }
        }
    }
}
