//! Compares pieces with the exact curve along whole edges.

mod exact_curve;

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec2;
use proptest::prelude::*;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{EdgeIndex, Gear, Leg, NodeIndex};
use regatta_motion::{Distance, Track};

use super::*;
use exact_curve::{ExactPoint, sample};

/// The smallest radius of curvature, in metres, for which the bounds hold. There one unit of
/// distance changes the heading by 0.014°.
const SMALLEST_RADIUS: f64 = 30e-6;

fn graph_of(curve: CubicBezier, thetas: [f64; 2]) -> RouteGraph {
    let [p0, .., p3] = curve.control_points;
    let node = Node::new;
    let edge = Edge::new(1, NodeIndex(0), NodeIndex(1), curve, 1.0);
    let edge = Edge { reverse_speed: Some(0.5), ..edge };
    RouteGraph::from_valid_parts(vec![node(1, p0, thetas[0]), node(2, p3, thetas[1])], vec![edge])
}

/// Returns the graph of one `Spline` edge: two poses and the handles b (at the origin) and f (at
/// the destination).
fn spline(start: (f64, f64, f64), end: (f64, f64, f64), b: f64, f: f64) -> RouteGraph {
    let (p0, p3) = (DVec2::new(start.0, start.1), DVec2::new(end.0, end.1));
    let (p1, p2) = (p0 + DVec2::from_angle(start.2) * b, p3 - DVec2::from_angle(end.2) * f);
    graph_of(CubicBezier { control_points: [p0, p1, p2, p3] }, [start.2, end.2])
}

fn curve_edge(control_points: [(f64, f64); 4]) -> RouteGraph {
    graph_of(
        CubicBezier { control_points: control_points.map(|(x, y)| DVec2::new(x, y)) },
        [0.0; 2],
    )
}

/// Returns the cubic of a graph's only edge.
fn cubic(graph: &RouteGraph) -> &CubicBezier {
    graph.edges()[0].path.single().expect("one cubic")
}

const FORWARD: Leg = Leg { edge: EdgeIndex(0), gear: Gear::Forward };
const REVERSE: Leg = Leg { edge: EdgeIndex(0), gear: Gear::Reverse };

/// Returns the row and `w` of a robot that has driven `s` metres of a track, as the motion kernel
/// keeps them.
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

/// Returns the largest errors of the pieces of a graph's only edge, in both gears: metres, radians,
/// |p'| - 1.
fn largest_errors(graph: &RouteGraph, steps: u32) -> [f64; 3] {
    let tracks = compile(graph);
    let exact = sample(cubic(graph), steps);
    let length = exact.last().unwrap().s;
    let excluded = excluded_ranges(&exact);
    let mut worst = [0.0_f64; 3];
    for leg in [FORWARD, REVERSE] {
        let track = tracks.track(leg).unwrap();
        assert!(
            (track.length - length).abs() < 1e-6 + 1e-9 * length,
            "{} m long, not {length}",
            track.length
        );
        for point in &exact {
            let (s, sign) = if leg == FORWARD { (point.s, 1.0) } else { (length - point.s, -1.0) };
            let (row, w) = locate(&tracks, track, s);
            let piece = &tracks.pieces()[row];
            worst[0] = worst[0].max(piece.position(w).as_dvec2().distance(point.position));
            if excluded.iter().any(|range| range.contains(&point.s)) {
                continue;
            }
            let derivative = piece.derivative(w).as_dvec2();
            worst[1] = worst[1].max((derivative * sign).angle_to(point.tangent).abs());
            // The length is rounded to units while the ends are exact, so the middle compensates
            // for it.
            let rounding = 1.5 * 0.5 / f64::from(tracks.infos()[row].length.0);
            worst[2] = worst[2].max((derivative.length() - 1.0).abs() - rounding);
        }
    }
    worst
}

/// Returns the ranges of arc length where the curve turns too tightly, or stops and turns back,
/// with a margin of one micrometre.
fn excluded_ranges(exact: &[ExactPoint]) -> Vec<Range<f64>> {
    let tight =
        exact.iter().filter(|point| point.radius.is_nan() || point.radius < SMALLEST_RADIUS);
    tight.map(|point| point.s - 1e-6..point.s + 1e-6).collect()
}

fn assert_bounds(graph: &RouteGraph, steps: u32) {
    let [position, heading, speed] = largest_errors(graph, steps);
    let heading = heading.to_degrees();
    assert!(
        position <= 1e-3 && heading <= 0.1 && speed <= 1e-3,
        "errors of {position} m, {heading}° and {speed} in |p'|: {:?}",
        *cubic(graph)
    );
}

fn pieces(graph: &RouteGraph) -> u32 {
    compile(graph).track(FORWARD).unwrap().pieces
}

#[test]
fn a_quarter_turn_has_three_pieces_and_keeps_the_bounds() {
    for radius in [0.001, 0.1, 1.0] {
        let handle = radius * 0.5523;
        let graph = spline((0.0, 0.0, 0.0), (radius, radius, PI / 2.0), handle, handle);
        assert_eq!(pieces(&graph), 3, "radius {radius}");
        assert_bounds(&graph, 300);
    }
}

#[test]
fn a_straight_edge_has_one_piece_every_eight_metres() {
    for (length, expected) in [(0.001, 1), (7.5, 1), (8.0, 1), (8.1, 2), (500.0, 63)] {
        let straight = CubicBezier::straight(DVec2::new(-3.0, 7.0), DVec2::new(-3.0 + length, 7.0));
        let graph = graph_of(straight, [0.0; 2]);
        assert_eq!(pieces(&graph), expected, "{length} m");
        assert_bounds(&graph, 100);
    }
}

#[test]
fn a_long_collinear_spline_has_as_few_pieces_as_a_straight_edge() {
    assert_eq!(pieces(&spline((0.0, 0.0, 0.0), (80.0, 0.0, 0.0), 3.0, 60.0)), 10);
}

#[test]
fn a_track_ends_at_the_exact_pose_of_its_node_in_both_gears() {
    let (start, end) = ((7_405.1, -8_000.0, 2.9), (7_413.77, -7_999.9, -0.3));
    let graph = spline(start, end, 4.0, 3.0);
    let tracks = compile(&graph);
    let last = |leg| tracks.pieces()[tracks.track(leg).unwrap().last_piece() as usize];
    let (forward, reverse) = (last(FORWARD), last(REVERSE));
    assert_eq!(forward.x[..2], [end.0 as f32, end.2.cos() as f32]);
    assert_eq!(forward.y[..2], [end.1 as f32, end.2.sin() as f32]);
    assert_eq!(reverse.x[..2], [start.0 as f32, -start.2.cos() as f32]);
    assert_eq!(reverse.y[..2], [start.1 as f32, -start.2.sin() as f32]);
    let at_node = tracks.pieces()[tracks.node_piece(NodeIndex(1)) as usize];
    assert_eq!(
        (at_node.x[..2].to_vec(), at_node.y[..2].to_vec()),
        (forward.x[..2].to_vec(), forward.y[..2].to_vec())
    );
}

#[test]
fn distances_along_the_edge_count_from_its_origin_in_both_gears() {
    let graph = spline((0.0, 0.0, 0.0), (30.0, 12.0, 1.0), 12.0, 12.0);
    let tracks = compile(&graph);
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
    let tracks = compile(&graph);
    let headings: Vec<_> =
        discontinuities(&tracks, FORWARD).into_iter().map(|(_, turn)| turn.abs()).collect();
    assert_eq!(
        headings.iter().filter(|&&turn| (turn - PI).abs() < 1e-5).count(),
        1,
        "{headings:?}"
    );
    assert_eq!(headings.iter().filter(|&&turn| turn > 1e-5).count(), 1, "{headings:?}");
    assert_bounds(&graph, 1000);
}

/// Returns the gaps between consecutive pieces of a leg, in metres and in radians.
fn discontinuities(tracks: &Tracks, leg: Leg) -> Vec<(f64, f64)> {
    let track = tracks.track(leg).unwrap();
    let rows = track.first_piece as usize..track.last_piece() as usize;
    let discontinuity = |row: usize| {
        let (piece, next) = (tracks.pieces()[row], tracks.pieces()[row + 1]);
        let w = -tracks.infos()[row + 1].length.to_metres() as f32;
        let gap = piece.position(0.0).as_dvec2().distance(next.position(w).as_dvec2());
        (gap, piece.derivative(0.0).as_dvec2().angle_to(next.derivative(w).as_dvec2()))
    };
    rows.map(discontinuity).collect()
}

#[test]
#[cfg_attr(miri, ignore = "the exact curve takes minutes to sample finely enough")]
fn extreme_edges_keep_the_bounds() {
    let far = (-7_990.0, 7_990.0);
    for graph in [
        // Zero handles at one end, at both ends, and both inner points on one node.
        curve_edge([(0.0, 0.0), (0.0, 0.0), (4.0, 1.0), (4.0, 4.0)]),
        curve_edge([(0.0, 0.0), (0.0, 0.0), (4.0, 4.0), (4.0, 4.0)]),
        curve_edge([(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (4.0, 4.0)]),
        curve_edge([(0.0, 0.0), (1.0, 2.0), (1.0, 2.0), (4.0, 4.0)]),
        // Starting and ending at the same point.
        curve_edge([(0.0, 0.0), (5.0, 1.0), (-5.0, 2.0), (0.0, 0.0)]),
        // Back and forth on a line, with two cusps.
        curve_edge([(0.0, 0.0), (2.0, 1.0), (-1.0, -0.5), (1.0, 0.5)]),
        // A loop, and very tight turns.
        curve_edge([(0.0, 0.0), (3.0, 1.0), (-2.0, 1.0), (1.0, 0.0)]),
        curve_edge([(0.0, 0.0), (1.0, 1.0), (1e-3, 1.0), (1.0, 0.0)]),
        spline((0.0, 0.0, 0.0), (0.0, 0.05, PI), 1.0, 1.0),
        // Tiny and huge, at the largest coordinates.
        spline((far.0, far.1, 0.0), (far.0 + 0.001, far.1 + 0.001, 1.0), 0.001, 0.001),
        spline((far.0, far.1, 1.0), (far.0 + 400.0, far.1 - 300.0, -1.0), 1.0, 900.0),
    ] {
        assert_bounds(&graph, 2000);
    }
}

#[test]
fn heading_follows_a_tight_turn_in_small_steps() {
    // In the dissertation's simulator a large turn between two close poses made the heading jump.
    let graph = spline((0.0, 0.0, 0.0), (0.0, 0.02, PI), 0.0133, 0.0133);
    let tracks = compile(&graph);
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
    /// Between 1 mm and 90 m, uniform in the logarithm.
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
    /// P1 and P2 crossed so that the curve has a cusp, then moved by little or nothing.
    fn near_cusp()(
        at in place(), size in size(), width in 0.1..2.0, height in 0.1..2.0, nudge in prop_oneof![Just(0.0), -9.0..-1.0],
    ) -> RouteGraph {
        let nudge = if nudge == 0.0 { 0.0 } else { 10.0_f64.powf(nudge) };
        let points = [(0.0, 0.0), (width, height), (nudge, height), (width, 0.0)];
        curve_edge(points.map(|(x, y)| (at.x + x * size, at.y + y * size)))
    }
}

prop_compose! {
    fn arbitrary_control_points()(
        at in place(), size in size(), points in [(-1.0..1.0, -1.0..1.0), (-1.0..1.0, -1.0..1.0), (-1.0..1.0, -1.0..1.0)],
    ) -> RouteGraph {
        let [p1, p2, p3] = points.map(|(x, y)| (at.x + size * x, at.y + size * y));
        curve_edge([(at.x, at.y), p1, p2, p3])
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 1 } else { 1000 }))]

    #[test]
    #[cfg_attr(miri, ignore = "the exact curve takes minutes to sample finely enough")]
    fn splines_keep_the_bounds(graph in random_spline()) {
        assert_bounds(&graph, 300);
    }

    #[test]
    #[cfg_attr(miri, ignore = "the exact curve takes minutes to sample finely enough")]
    fn cusps_and_near_cusps_keep_the_bounds(graph in near_cusp()) {
        assert_bounds(&graph, 300);
    }

    #[test]
    #[cfg_attr(miri, ignore = "the exact curve takes minutes to sample finely enough")]
    fn arbitrary_control_points_keep_the_bounds(graph in arbitrary_control_points()) {
        assert_bounds(&graph, 300);
    }

    #[test]
    fn consecutive_pieces_are_continuous(graph in random_spline()) {
        let tracks = compile(&graph);
        for (leg, edge) in [FORWARD, REVERSE].into_iter().zip([*cubic(&graph); 2]) {
            let ulp = edge.control_points.map(|p| p.abs().max_element() as f32).map(|c| c.next_up() - c);
            let rounding = f64::from(ulp.into_iter().fold(0.0, f32::max));
            for (gap, turn) in discontinuities(&tracks, leg) {
                prop_assert!(gap < 1e-6 + 2.0 * rounding, "a gap of {gap} m");
                let is_smooth = no_piece_is_straightened(&tracks);
                prop_assert!(!is_smooth || turn.abs() < 1e-5, "a turn of {turn} rad");
            }
        }
    }
}

/// Whether no piece is so short that it was replaced by a straight line.
fn no_piece_is_straightened(tracks: &Tracks) -> bool {
    tracks.infos().iter().all(|info| info.length.0 == 0 || info.length.0 > 16)
}
