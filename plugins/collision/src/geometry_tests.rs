//! The geometry against other ways to work it out: corner by corner, instant by instant, along the true curves.

use proptest::prelude::*;
use regatta_plugin::world::EdgeRecord;

use crate::body::{Body, gap, meeting_place};
use crate::bounds::Bounds;
use crate::footprint::CIRCLE;
use crate::heading::heading;
use crate::meeting::{ALWAYS, Meeting, meet};
use crate::path::Paths;
use crate::prediction::{Drive, Piece, predict};
use crate::way::{Approach, Way};

type Point = [f64; 2];

fn bodies() -> impl Strategy<Value = Body> {
    let size = prop_oneof![0.0_f32..0.1, 0.1_f32..2.0, 5.0_f32..20.0];
    let place = prop_oneof![-3.0_f32..3.0, -15.0_f32..15.0];
    let axis = (0_u32..8).prop_map(|eighth| eighth as f32 * std::f32::consts::FRAC_PI_4);
    let theta = prop_oneof![-3.2_f32..3.2, axis];
    ([place.clone(), place], theta, size.clone(), prop_oneof![size, Just(CIRCLE)]).prop_map(
        |(place, theta, half_length, half_width)| {
            let heading = heading(theta);
            Body { place, heading, half_length, half_width }
        },
    )
}

/// A footprint as a polygon and what is to be added all around it: a circle is a point with a lot around it.
fn outline(body: &Body, place: Point, [cos, sin]: [f32; 2]) -> (Vec<Point>, f64) {
    let (cos, sin, length, width) =
        (f64::from(cos), f64::from(sin), f64::from(body.half_length), f64::from(body.half_width));
    if body.half_width == CIRCLE {
        return (vec![place], length);
    }
    let corners = [[length, width], [-length, width], [-length, -width], [length, -width]];
    (corners.map(|[x, y]| [place[0] + x * cos - y * sin, place[1] + x * sin + y * cos]).to_vec(), 0.0)
}

fn sides(polygon: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(from, to)| (*from, *to))
}

fn to_side(point: Point, (from, to): (Point, Point)) -> f64 {
    let ([x, y], [u, v]) = ([point[0] - from[0], point[1] - from[1]], [to[0] - from[0], to[1] - from[1]]);
    let part = ((x * u + y * v) / (u * u + v * v).max(1e-300)).clamp(0.0, 1.0);
    (x - part * u).hypot(y - part * v)
}

/// How deep a point lies in a convex polygon that runs counter-clockwise; negative outside.
fn depth(point: Point, polygon: &[Point]) -> f64 {
    let inward = |(from, to): (Point, Point)| {
        let [u, v] = [to[0] - from[0], to[1] - from[1]];
        (u * (point[1] - from[1]) - v * (point[0] - from[0])) / u.hypot(v).max(1e-300)
    };
    sides(polygon).map(inward).fold(f64::INFINITY, f64::min)
}

fn cross(a: (Point, Point), b: (Point, Point)) -> bool {
    let side = |(from, to): (Point, Point), point: Point| {
        (to[0] - from[0]) * (point[1] - from[1]) - (to[1] - from[1]) * (point[0] - from[0])
    };
    side(a, b.0) * side(a, b.1) < 0.0 && side(b, a.0) * side(b, a.1) < 0.0
}

/// Metres between two outlines: 0 if sides cross or one holds a corner of the other.
fn distance((a, around_a): &(Vec<Point>, f64), (b, around_b): &(Vec<Point>, f64)) -> f64 {
    let holds =
        |inner: &[Point], outer: &[Point]| outer.len() > 2 && inner.iter().any(|point| depth(*point, outer) >= 0.0);
    if holds(a, b) || holds(b, a) || sides(a).any(|one| sides(b).any(|other| cross(one, other))) {
        return 0.0;
    }
    let nearest = |from: &[Point], to: &[Point]| {
        from.iter().flat_map(|point| sides(to).map(|side| to_side(*point, side))).fold(f64::INFINITY, f64::min)
    };
    (nearest(a, b).min(nearest(b, a)) - around_a - around_b).max(0.0)
}

fn place(body: &Body) -> Point {
    body.place.map(f64::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn gaps_are_distances_of_polygons(a in bodies(), b in bodies()) {
        let (gap_ab, gap_ba) = (gap(&a, &b, f64::INFINITY), gap(&b, &a, f64::INFINITY));
        prop_assert!((gap_ab - gap_ba).abs() < 1e-9, "{gap_ab} {gap_ba}");
        let exact = distance(&outline(&a, place(&a), a.heading), &outline(&b, place(&b), b.heading));
        prop_assert!((gap_ab - exact).abs() < 1e-5, "{gap_ab} {exact}");
    }

    #[test]
    fn a_reach_only_spares_work(a in bodies(), b in bodies(), reach in 0.0_f64..3.0) {
        let (exact, found) = (gap(&a, &b, f64::INFINITY), gap(&a, &b, reach));
        prop_assert!(if exact <= reach { found == exact } else { found > reach }, "{exact} {found} {reach}");
    }

    #[test]
    fn places_of_contacts_are_at_the_contact(a in bodies(), b in bodies()) {
        let [x, y] = meeting_place(&a, &b).map(f64::from);
        let far = |body: &Body| (x - place(body)[0]).hypot(y - place(body)[1]);
        let [one, other] = [place(&a), place(&b)];
        let whole = (one[0] - other[0]).hypot(one[1] - other[1]);
        prop_assert!(far(&a) + far(&b) < whole + 1e-3, "between the two");
    }

}

proptest! {
    #[test]
    fn meetings_are_found_as_by_looking_all_the_time(
        (a, b) in (bodies(), bodies()),
        (way_a, way_b) in (ways(), ways()),
    ) {
        let (pieces_a, pieces_b) = (along(&a, &way_a), along(&b, &way_b));
        let found = meet((&a, &pieces_a), (&b, &pieces_b), ALWAYS, 0.05);
        let [brief_a, brief_b] = [(&a, &pieces_a), (&b, &pieces_b)].map(|(body, pieces)| Way::new(body, pieces, 0, Bounds::NOTHING));
        let approach = Approach::of((&a, &brief_a), (&b, &brief_b));
        let quickly = meet((&a, &pieces_a), (&b, &pieces_b), approach.when_near(0.1), 0.05);
        prop_assert!(found == quickly && (found == Meeting::None || approach.comes_near(0.1, HORIZON)));
        // Every two pieces that share some time, at instants at most 5 ms apart; where one follows another, both count.
        let mut nearest = f64::INFINITY;
        for (from_a, piece_a) in timed(&pieces_a) {
            for (from_b, piece_b) in timed(&pieces_b) {
                let (from, until) = (from_a.max(from_b), f64::from(piece_a.until.min(piece_b.until)));
                let instants = if from <= until { 2 + ((until - from) * 200.0) as u32 } else { 0 };
                for instant in 0..instants {
                    let time = from + (until - from) * f64::from(instant) / f64::from(instants - 1);
                    nearest = nearest.min(distance(&of(&a, piece_a, time - from_a), &of(&b, piece_b, time - from_b)));
                }
            }
        }
        // Between two instants they drive up to 7 cm.
        match found {
            Meeting::Overlap => prop_assert!(nearest < 0.04, "overlap, but {nearest} m apart"),
            Meeting::Near => prop_assert!(nearest > 0.0 && nearest < 0.2, "near, but {nearest} m apart"),
            Meeting::None => prop_assert!(nearest > 0.09, "none, but {nearest} m apart"),
        }
    }
}

const HORIZON: f32 = 2.0;

/// A few pieces: how long each takes of the rest, velocity, heading.
type Legs = Vec<(f32, [f32; 2], f32)>;

fn ways() -> impl Strategy<Value = Legs> {
    let speed = prop_oneof![Just(0.0_f32), -5.0_f32..5.0];
    prop::collection::vec((0.0_f32..1.0, [speed.clone(), speed], -0.3_f32..0.3), 1..5)
}

fn along(body: &Body, way: &Legs) -> Vec<Piece> {
    let (mut now, mut place, mut theta) = (0.0, body.place, body.heading[1].atan2(body.heading[0]));
    let mut pieces = Vec::new();
    for (number, (part, velocity, turn)) in way.iter().enumerate() {
        let until = if number + 1 == way.len() { HORIZON } else { now + part * (HORIZON - now) };
        let heading = if number == 0 { body.heading } else { heading(theta) };
        pieces.push(Piece { until, place, velocity: *velocity, heading });
        place = [place[0] + velocity[0] * (until - now), place[1] + velocity[1] * (until - now)];
        (now, theta) = (until, theta + turn);
    }
    pieces
}

/// Each piece with the time at which it starts.
fn timed(pieces: &[Piece]) -> impl Iterator<Item = (f64, &Piece)> {
    let starts = std::iter::once(0.0).chain(pieces.iter().map(|piece| f64::from(piece.until)));
    starts.zip(pieces)
}

/// What a robot covers some time after a piece has started.
fn of(body: &Body, piece: &Piece, gone: f64) -> (Vec<Point>, f64) {
    let here = |axis: usize| f64::from(piece.place[axis]) + f64::from(piece.velocity[axis]) * gone;
    outline(body, [here(0), here(1)], piece.heading)
}

fn at(body: &Body, pieces: &[Piece], time: f64) -> Vec<Point> {
    let (start, piece) = timed(pieces).find(|(_, piece)| time <= f64::from(piece.until)).expect("within the horizon");
    of(body, piece, time - start).0
}

fn bezier(points: &[[f32; 2]; 4], at: f64) -> Point {
    let weight = [(1.0 - at).powi(3), 3.0 * at * (1.0 - at).powi(2), 3.0 * at * at * (1.0 - at), at.powi(3)];
    let sum = |axis: usize| points.iter().zip(weight).map(|(point, weight)| f64::from(point[axis]) * weight).sum();
    [sum(0), sum(1)]
}

/// Points along a curve, with their distances from its start.
fn rail(points: &[[f32; 2]; 4]) -> Vec<(f64, Point)> {
    let mut rail: Vec<(f64, Point)> = vec![(0.0, bezier(points, 0.0))];
    for step in 1..=4000 {
        let (next, (s, last)) = (bezier(points, f64::from(step) / 4000.0), rail[rail.len() - 1]);
        rail.push((s + (next[0] - last[0]).hypot(next[1] - last[1]), next));
    }
    rail
}

/// The point at `s`; beyond the ends along the tangent. And the heading there.
fn on_rail(rail: &[(f64, Point)], s: f64) -> (Point, f64) {
    let next = rail.partition_point(|(along, _)| *along < s).clamp(1, rail.len() - 1);
    let ((from_s, from), (to_s, to)) = (rail[next - 1], rail[next]);
    let part = (s - from_s) / (to_s - from_s);
    let place = [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])];
    (place, (to[1] - from[1]).atan2(to[0] - from[0]))
}

fn curves() -> impl Strategy<Value = [[f32; 2]; 4]> {
    // Roads, not scribbles: the inner control points lie about along the way.
    (3.0_f32..20.0, [-0.4_f32..0.4, -0.4_f32..0.4], [0.2_f32..0.5, 0.2_f32..0.5]).prop_map(|(length, bend, handle)| {
        let first = [handle[0] * length, bend[0] * length];
        [[0.0, 0.0], first, [(1.0 - handle[1]) * length, bend[1] * length], [length, 0.0]]
    })
}

proptest! {
    #[test]
    fn predictions_follow_the_edge_and_then_its_tangent(
        control_points in curves(),
        (part, speed, straight) in (0.0_f64..1.0, -3.0_f32..3.0, any::<bool>()),
    ) {
        let control_points = if straight { control_points.map(|[x, _]| [x, 0.0]) } else { control_points };
        let rail = rail(&control_points);
        let length = rail[rail.len() - 1].0;
        let edge = EdgeRecord { control_points, length: length as f32, ..EdgeRecord::default() };
        let paths = Paths::new(&[edge]);
        let s = part * length;
        let (start, theta) = on_rail(&rail, s);
        let heading = heading(theta as f32);
        let body = Body { place: start.map(|x| x as f32), heading, half_length: 0.5, half_width: 0.3 };
        let mut pieces = Vec::new();
        predict(&body, Drive { speed, s: s as f32, chords: paths.of(0) }, HORIZON, &mut pieces);
        prop_assert_eq!(pieces[pieces.len() - 1].until, HORIZON);
        prop_assert!(!straight || pieces.len() == 1);
        for instant in 0..=100 {
            let time = f64::from(instant) / 100.0 * f64::from(HORIZON);
            let (place, theta) = on_rail(&rail, s + f64::from(speed) * time);
            let exact = outline(&body, place, [theta.cos() as f32, theta.sin() as f32]).0;
            let found = at(&body, &pieces, time);
            let far = exact.iter().zip(&found).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max);
            // Chords stray 2 cm and turn by 0.2; beyond its end, the way is off by what the last one turned.
            prop_assert!(far < 0.25, "{far} m off after {time} s");
        }
    }

    #[test]
    fn a_pose_beside_its_edge_stays_beside_it(control_points in curves(), turned in -1.0_f32..1.0, aside in -5.0_f32..5.0) {
        let rail = rail(&control_points);
        let edge = EdgeRecord { control_points, length: rail[rail.len() - 1].0 as f32, ..EdgeRecord::default() };
        let paths = Paths::new(&[edge]);
        let (start, theta) = on_rail(&rail, 1.0);
        let ways = [(0.0, 0.0), (turned, aside)].map(|(turned, aside)| {
            let place = [start[0] as f32 + aside, start[1] as f32 - aside];
            let body = Body { place, heading: heading(theta as f32 + turned), half_length: 0.5, half_width: 0.3 };
            let mut pieces = Vec::new();
            predict(&body, Drive { speed: 2.0, s: 1.0, chords: paths.of(0) }, HORIZON, &mut pieces);
            pieces
        });
        for (on, beside) in ways[0].iter().zip(&ways[1]) {
            prop_assert!((beside.place[0] - on.place[0] - aside).abs() < 1e-4 && (beside.place[1] - on.place[1] + aside).abs() < 1e-4);
            let angle = |piece: &Piece| piece.heading[1].atan2(piece.heading[0]);
            let off = (angle(beside) - angle(on) - turned + 7.0).rem_euclid(std::f32::consts::TAU) - 7.0_f32.rem_euclid(std::f32::consts::TAU);
            prop_assert!(off.abs() < 1e-4, "{off}");
        }
    }
}

#[test]
fn edges_that_are_none_have_no_chords() {
    let good = EdgeRecord {
        control_points: [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]],
        length: 3.0,
        ..EdgeRecord::default()
    };
    let bad = [
        EdgeRecord { length: f32::NAN, ..good },
        EdgeRecord { length: 0.0, ..good },
        EdgeRecord { control_points: [[0.0, f32::INFINITY]; 4], ..good },
        EdgeRecord { control_points: [[1.0, 1.0]; 4], ..good },
        good,
    ];
    let paths = Paths::new(&bad);
    assert_eq!([0, 1, 2, 3, 4, 5, u32::MAX].map(|edge| paths.of(edge).len()), [0, 0, 0, 0, 1, 0, 0]);
}

#[test]
fn robots_that_stay_put_or_have_no_edge_go_straight() {
    let body = Body { place: [1.0, 2.0], heading: [0.0, 1.0], half_length: 0.5, half_width: 0.3 };
    for (speed, s, expected) in [(0.0, 0.0, [0.0, 0.0]), (2.0, 0.0, [0.0, 2.0]), (-1.0, f32::NAN, [0.0, -1.0])] {
        let mut pieces = Vec::new();
        predict(&body, Drive { speed, s, chords: &[] }, HORIZON, &mut pieces);
        assert_eq!(pieces, [Piece { until: HORIZON, place: body.place, velocity: expected, heading: body.heading }]);
    }
}
