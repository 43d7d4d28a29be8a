//! Pieces against the exact curve, along the whole edge.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec2;
use proptest::prelude::*;

use super::arc_length::{Distance, Track, Tracks};
use super::*;

/// Metres: the tightest radius of curvature that the bounds hold for. There a unit of distance is 0.014° of heading.
const TIGHTEST: f64 = 30e-6;

fn graph_of(curve: CubicBezier, thetas: [f64; 2]) -> RouteGraph {
    let [p0, .., p3] = curve.control_points;
    let node = |id, position, theta| Node { id, position, theta };
    let edge = Edge {
        id: 1,
        origin: NodeIndex(0),
        destination: NodeIndex(1),
        curve,
        velocity_forward: 1.0,
        velocity_backwards: Some(0.5),
    };
    RouteGraph::from_valid_parts(vec![node(1, p0, thetas[0]), node(2, p3, thetas[1])], vec![edge])
}

/// An edge as a file gives it: two poses and the handles b (at the origin) and f.
fn spline(start: (f64, f64, f64), end: (f64, f64, f64), b: f64, f: f64) -> RouteGraph {
    let (p0, p3) = (DVec2::new(start.0, start.1), DVec2::new(end.0, end.1));
    let (p1, p2) = (p0 + DVec2::from_angle(start.2) * b, p3 - DVec2::from_angle(end.2) * f);
    graph_of(CubicBezier { control_points: [p0, p1, p2, p3] }, [start.2, end.2])
}

fn curve_edge(control_points: [(f64, f64); 4]) -> RouteGraph {
    graph_of(CubicBezier { control_points: control_points.map(|(x, y)| DVec2::new(x, y)) }, [0.0; 2])
}

const FORWARD: Leg = Leg { edge: EdgeIndex(0), gear: Gear::Forward };
const REVERSE: Leg = Leg { edge: EdgeIndex(0), gear: Gear::Reverse };

/// A point of the exact curve.
struct Exact {
    s: f64,
    position: DVec2,
    tangent: DVec2,
    radius: f64,
}

/// Walks the curve in steps that shrink where it is slow, integrating |p'| by Simpson's rule.
fn walk(curve: &CubicBezier, steps: u32) -> Vec<Exact> {
    let steps = if cfg!(miri) { steps.min(60) } else { steps };
    let finest = if cfg!(miri) { 20 } else { 160 };
    let speed = |lambda: f64| curve.derivative(lambda).length();
    let mut cuts: Vec<f64> = (0..=steps).map(|i| f64::from(i) / f64::from(steps)).collect();
    // Geometrically finer towards both ends and towards the slowest places.
    let slowest = (1..steps as usize)
        .filter(|&i| speed(cuts[i]) <= speed(cuts[i - 1]) && speed(cuts[i]) <= speed(cuts[i + 1]))
        .map(|i| minimise(speed, cuts[i - 1], cuts[i + 1]))
        .collect::<Vec<_>>();
    for centre in slowest.into_iter().chain([0.0, 1.0]) {
        let offsets = (0..finest).map(|i| 0.8_f64.powi(i) / f64::from(steps));
        cuts.extend(offsets.flat_map(|offset| [centre - offset, centre + offset]).chain([centre]));
    }
    cuts.retain(|cut| (0.0..=1.0).contains(cut));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let mut s = 0.0;
    let mut previous = 0.0;
    let exact = cuts.into_iter().map(|lambda| {
        s += simpson(&speed, previous, lambda);
        previous = lambda;
        let (first, second) = (curve.derivative(lambda), curve.second_derivative(lambda));
        let radius = first.length().powi(3) / first.perp_dot(second).abs();
        // How far it is to a place where the curve stops; the radius says nothing there.
        let brisk = first.length_squared() / second.length();
        let radius = radius.min(brisk);
        Exact { s, position: curve.position(lambda), tangent: first.normalize_or_zero(), radius }
    });
    exact.collect()
}

fn simpson(speed: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const PANELS: u32 = 4;
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(2 * PANELS);
    let panel = |i: u32| speed(at(2 * i)) + 4.0 * speed(at(2 * i + 1)) + speed(at(2 * i + 2));
    (0..PANELS).map(panel).sum::<f64>() * (to - from) / f64::from(6 * PANELS)
}

/// Ternary search.
fn minimise(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..120 {
        let third = (high - low) / 3.0;
        if value(low + third) < value(high - third) { high -= third } else { low += third }
    }
    (low + high) / 2.0
}

/// The row and `w` of a robot that has driven `s` metres of a track, as the kernel keeps them.
fn locate(tracks: &Tracks, track: &Track, s: f64) -> (usize, f32) {
    let mut left = (s * Distance::PER_METRE).round() as i64;
    let mut row = track.first_piece as usize;
    loop {
        let length = i64::from(tracks.infos()[row].length.0);
        if left <= length || row == track.last_piece() as usize {
            return (row, ((left - length) as f32) * (1.0 / Distance::PER_METRE as f32));
        }
        left -= length;
        row += 1;
    }
}

/// The worst that the pieces of a graph's one edge do, in both gears: metres, radians, |p'| - 1.
fn worst(graph: &RouteGraph, steps: u32) -> [f64; 3] {
    let tracks = Tracks::compile(graph);
    let exact = walk(&graph.edges()[0].curve, steps);
    let length = exact.last().unwrap().s;
    let blind = blind_spots(&exact);
    let mut worst = [0.0_f64; 3];
    for leg in [FORWARD, REVERSE] {
        let track = tracks.track(leg).unwrap();
        assert!((track.length - length).abs() < 1e-6 + 1e-9 * length, "{} m long, not {length}", track.length);
        for point in &exact {
            let (s, sign) = if leg == FORWARD { (point.s, 1.0) } else { (length - point.s, -1.0) };
            let (row, w) = locate(&tracks, track, s);
            let piece = &tracks.pieces()[row];
            worst[0] = worst[0].max(piece.position(w).as_dvec2().distance(point.position));
            if blind.iter().any(|blind| blind.contains(&point.s)) {
                continue;
            }
            let derivative = piece.derivative(w).as_dvec2();
            worst[1] = worst[1].max((derivative * sign).angle_to(point.tangent).abs());
            // A length is rounded to units; with the ends as they are the middle makes up for it.
            let rounding = 1.5 * 0.5 / f64::from(tracks.infos()[row].length.0);
            worst[2] = worst[2].max((derivative.length() - 1.0).abs() - rounding);
        }
    }
    worst
}

/// Where the curve turns too tightly, or stops and turns back, with a micrometre's margin.
fn blind_spots(exact: &[Exact]) -> Vec<Range<f64>> {
    let tight = exact.iter().filter(|point| point.radius.is_nan() || point.radius < TIGHTEST);
    tight.map(|point| point.s - 1e-6..point.s + 1e-6).collect()
}

fn assert_bounds(graph: &RouteGraph, steps: u32) {
    let [position, heading, pace] = worst(graph, steps);
    let heading = heading.to_degrees();
    assert!(
        position <= 1e-3 && heading <= 0.1 && pace <= 1e-3,
        "{position} m, {heading}° and {pace} off: {:?}",
        graph.edges()[0].curve
    );
}

fn pieces(graph: &RouteGraph) -> u32 {
    Tracks::compile(graph).track(FORWARD).unwrap().pieces
}

#[test]
fn a_quarter_turn_takes_three_pieces_and_keeps_the_bounds() {
    for radius in [0.001, 0.1, 1.0] {
        let handle = radius * 0.5523;
        let graph = spline((0.0, 0.0, 0.0), (radius, radius, PI / 2.0), handle, handle);
        assert_eq!(pieces(&graph), 3, "radius {radius}");
        assert_bounds(&graph, 300);
    }
}

#[test]
fn straight_edges_take_a_piece_every_eight_metres() {
    for (length, expected) in [(0.001, 1), (7.5, 1), (8.0, 1), (8.1, 2), (500.0, 63)] {
        let straight = CubicBezier::straight(DVec2::new(-3.0, 7.0), DVec2::new(-3.0 + length, 7.0));
        let graph = graph_of(straight, [0.0; 2]);
        assert_eq!(pieces(&graph), expected, "{length} m");
        assert_bounds(&graph, 100);
    }
}

#[test]
fn long_collinear_splines_are_as_cheap_as_straight_edges() {
    assert_eq!(pieces(&spline((0.0, 0.0, 0.0), (80.0, 0.0, 0.0), 3.0, 60.0)), 10);
}

#[test]
fn a_route_ends_at_the_nodes_exact_pose_in_both_gears() {
    let (start, end) = ((7_405.1, -8_000.0, 2.9), (7_413.77, -7_999.9, -0.3));
    let graph = spline(start, end, 4.0, 3.0);
    let tracks = Tracks::compile(&graph);
    let last = |leg| tracks.pieces()[tracks.track(leg).unwrap().last_piece() as usize];
    let (forward, reverse) = (last(FORWARD), last(REVERSE));
    assert_eq!(forward.x[..2], [end.0 as f32, end.2.cos() as f32]);
    assert_eq!(forward.y[..2], [end.1 as f32, end.2.sin() as f32]);
    assert_eq!(reverse.x[..2], [start.0 as f32, -start.2.cos() as f32]);
    assert_eq!(reverse.y[..2], [start.1 as f32, -start.2.sin() as f32]);
    let standing = tracks.pieces()[tracks.node_piece(NodeIndex(1)) as usize];
    assert_eq!(
        (standing.x[..2].to_vec(), standing.y[..2].to_vec()),
        (forward.x[..2].to_vec(), forward.y[..2].to_vec())
    );
}

#[test]
fn distances_along_the_edge_count_from_its_origin_in_both_gears() {
    let graph = spline((0.0, 0.0, 0.0), (30.0, 12.0, 1.0), 12.0, 12.0);
    let tracks = Tracks::compile(&graph);
    let ends = |leg| {
        let track = tracks.track(leg).unwrap();
        let rows = track.first_piece as usize..=track.last_piece() as usize;
        tracks.infos()[rows].iter().map(|info| info.s_end).collect::<Vec<_>>()
    };
    let (forward, mut reverse) = (ends(FORWARD), ends(REVERSE));
    assert_eq!(*forward.last().unwrap(), tracks.edge_length(EdgeIndex(0)) as f32);
    assert_eq!(reverse.pop(), Some(0.0));
    reverse.reverse();
    assert_eq!(reverse, forward[..forward.len() - 1]);
}

#[test]
fn a_cusp_turns_the_heading_between_two_pieces() {
    let graph = curve_edge([(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0)]);
    let tracks = Tracks::compile(&graph);
    let headings: Vec<_> = joints(&tracks, FORWARD).into_iter().map(|(_, turn)| turn.abs()).collect();
    assert_eq!(headings.iter().filter(|&&turn| (turn - PI).abs() < 1e-5).count(), 1, "{headings:?}");
    assert_eq!(headings.iter().filter(|&&turn| turn > 1e-5).count(), 1, "{headings:?}");
    assert_bounds(&graph, 1000);
}

/// How far apart in metres and in radians the pieces of a leg are where they meet.
fn joints(tracks: &Tracks, leg: Leg) -> Vec<(f64, f64)> {
    let track = tracks.track(leg).unwrap();
    let rows = track.first_piece as usize..track.last_piece() as usize;
    let joint = |row: usize| {
        let (piece, next) = (tracks.pieces()[row], tracks.pieces()[row + 1]);
        let w = -tracks.infos()[row + 1].length.to_metres() as f32;
        let gap = piece.position(0.0).as_dvec2().distance(next.position(w).as_dvec2());
        (gap, piece.derivative(0.0).as_dvec2().angle_to(next.derivative(w).as_dvec2()))
    };
    rows.map(joint).collect()
}

#[test]
#[cfg_attr(miri, ignore = "the oracle would need minutes to be exact enough")]
fn extreme_edges_keep_the_bounds() {
    let far = (-7_990.0, 7_990.0);
    for graph in [
        // Zero handles at one end, at both, and all inner points on one node.
        curve_edge([(0.0, 0.0), (0.0, 0.0), (4.0, 1.0), (4.0, 4.0)]),
        curve_edge([(0.0, 0.0), (0.0, 0.0), (4.0, 4.0), (4.0, 4.0)]),
        curve_edge([(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (4.0, 4.0)]),
        curve_edge([(0.0, 0.0), (1.0, 2.0), (1.0, 2.0), (4.0, 4.0)]),
        // From a place back to itself.
        curve_edge([(0.0, 0.0), (5.0, 1.0), (-5.0, 2.0), (0.0, 0.0)]),
        // Back and forth on one line: two cusps.
        curve_edge([(0.0, 0.0), (2.0, 1.0), (-1.0, -0.5), (1.0, 0.5)]),
        // A loop, and a turn on a coin.
        curve_edge([(0.0, 0.0), (3.0, 1.0), (-2.0, 1.0), (1.0, 0.0)]),
        curve_edge([(0.0, 0.0), (1.0, 1.0), (1e-3, 1.0), (1.0, 0.0)]),
        spline((0.0, 0.0, 0.0), (0.0, 0.05, PI), 1.0, 1.0),
        // Tiny and huge, at the border of the map.
        spline((far.0, far.1, 0.0), (far.0 + 0.001, far.1 + 0.001, 1.0), 0.001, 0.001),
        spline((far.0, far.1, 1.0), (far.0 + 400.0, far.1 - 300.0, -1.0), 1.0, 900.0),
    ] {
        assert_bounds(&graph, 2000);
    }
}

#[test]
fn heading_follows_a_tight_turn_in_small_steps() {
    // The dissertation's fault: a large turn between two close poses made the heading jump.
    let graph = spline((0.0, 0.0, 0.0), (0.0, 0.02, PI), 0.0133, 0.0133);
    let tracks = Tracks::compile(&graph);
    let track = tracks.track(FORWARD).unwrap();
    let heading = |i: u32| {
        let (row, w) = locate(&tracks, track, track.length * f64::from(i) / 1000.0);
        tracks.pieces()[row].derivative(w).as_dvec2()
    };
    let steps: Vec<f64> = (0..1000).map(|i| heading(i).angle_to(heading(i + 1))).collect();
    assert!(steps.iter().all(|step| (0.0..0.01).contains(step)), "{steps:?}");
    assert!((steps.iter().sum::<f64>() - PI).abs() < 1e-6);
}

prop_compose! {
    fn place()(x in -7_900.0..7_900.0, y in -7_900.0..7_900.0, near in any::<bool>()) -> DVec2 {
        DVec2::new(x, y) * if near { 1e-3 } else { 1.0 }
    }
}

prop_compose! {
    /// Between 1 mm and 90 m, every order of magnitude alike.
    fn size()(exponent in -3.0..1.95) -> f64 { 10.0_f64.powf(exponent) }
}

prop_compose! {
    fn random_spline()(
        at in place(), size in size(), towards in -PI..PI, thetas in [-PI..PI, -PI..PI],
        handles in [prop_oneof![0.0..3.0, Just(0.0), 0.0..0.01], prop_oneof![0.0..3.0, Just(0.0), 0.0..0.01]],
    ) -> RouteGraph {
        let end = at + DVec2::from_angle(towards) * size;
        spline((at.x, at.y, thetas[0]), (end.x, end.y, thetas[1]), handles[0] * size, handles[1] * size)
    }
}

prop_compose! {
    /// P1 and P2 crossed so that there is a cusp, and then moved by a little or by nothing.
    fn nearly_cusped()(
        at in place(), size in size(), width in 0.1..2.0, height in 0.1..2.0, nudge in prop_oneof![Just(0.0), -9.0..-1.0],
    ) -> RouteGraph {
        let nudge = if nudge == 0.0 { 0.0 } else { 10.0_f64.powf(nudge) };
        let points = [(0.0, 0.0), (width, height), (nudge, height), (width, 0.0)];
        curve_edge(points.map(|(x, y)| (at.x + x * size, at.y + y * size)))
    }
}

prop_compose! {
    fn any_four_points()(
        at in place(), size in size(), points in [(-1.0..1.0, -1.0..1.0), (-1.0..1.0, -1.0..1.0), (-1.0..1.0, -1.0..1.0)],
    ) -> RouteGraph {
        let [p1, p2, p3] = points.map(|(x, y)| (at.x + size * x, at.y + size * y));
        curve_edge([(at.x, at.y), p1, p2, p3])
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 1 } else { 1000 }))]

    #[test]
    #[cfg_attr(miri, ignore = "the oracle would need minutes to be exact enough")]
    fn splines_keep_the_bounds(graph in random_spline()) {
        assert_bounds(&graph, 300);
    }

    #[test]
    #[cfg_attr(miri, ignore = "the oracle would need minutes to be exact enough")]
    fn cusps_and_nearly_cusps_keep_the_bounds(graph in nearly_cusped()) {
        assert_bounds(&graph, 300);
    }

    #[test]
    #[cfg_attr(miri, ignore = "the oracle would need minutes to be exact enough")]
    fn four_points_anywhere_keep_the_bounds(graph in any_four_points()) {
        assert_bounds(&graph, 300);
    }

    #[test]
    fn pieces_join(graph in random_spline()) {
        let tracks = Tracks::compile(&graph);
        for (leg, edge) in [FORWARD, REVERSE].into_iter().zip([graph.edges()[0].curve; 2]) {
            let ulp = edge.control_points.map(|p| p.abs().max_element() as f32).map(|c| c.next_up() - c);
            let rounding = f64::from(ulp.into_iter().fold(0.0, f32::max));
            for (gap, turn) in joints(&tracks, leg) {
                prop_assert!(gap < 1e-6 + 2.0 * rounding, "{gap} m apart");
                let is_smooth = pieces_are_long(&tracks);
                prop_assert!(!is_smooth || turn.abs() < 1e-5, "{turn} rad apart");
            }
        }
    }
}

/// No tips, which are straight.
fn pieces_are_long(tracks: &Tracks) -> bool {
    tracks.infos().iter().all(|info| info.length.0 == 0 || info.length.0 > 16)
}
