//! Conversions are compared with de Boor's algorithm and with Bernstein polynomials.

use std::f64::consts::FRAC_1_SQRT_2;

use proptest::prelude::*;
use regatta_base::bezier::Side;

use super::*;

fn points(list: &[(f64, f64)]) -> Vec<DVec2> {
    list.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

fn b_spline(degree: usize, knots: &[f64], list: &[(f64, f64)]) -> Nurbs {
    Nurbs::new(degree, knots.to_vec(), &points(list), &[]).expect("valid")
}

/// The number of samples of a cubic. Between two, its distance from a point has one minimum, also
/// near a cusp.
const STEPS: u32 = 256;

/// Returns the distance from a point to the nearest point of cubics: ternary search between samples
/// where it may be.
fn distance(cubics: &[CubicBezier], point: DVec2) -> f64 {
    let mut best = f64::INFINITY;
    for (cubic, step) in cubics.iter().flat_map(|cubic| (0..STEPS).map(move |step| (cubic, step))) {
        let at = |lambda: f64| cubic.position(lambda).distance(point);
        let (mut low, mut high) =
            (f64::from(step) / f64::from(STEPS), f64::from(step + 1) / f64::from(STEPS));
        let fastest = cubic
            .control_points
            .windows(2)
            .map(|pair| 3.0 * pair[0].distance(pair[1]))
            .fold(0.0, f64::max);
        if at(low).min(at(high)) - fastest / f64::from(2 * STEPS) > best {
            continue;
        }
        for _ in 0..50 {
            let third = (high - low) / 3.0;
            if at(low + third) < at(high - third) { high -= third } else { low += third }
        }
        best = best.min(at(low));
    }
    best
}

/// Returns the greatest distance from points of a curve to its cubics.
fn greatest_distance(curve: &Nurbs, cubics: &Cubics) -> f64 {
    let [start, end] = curve.domain();
    let count = 61;
    let at =
        |index: u32| curve.position(start + (end - start) * f64::from(index) / f64::from(count));
    (0..=count).map(|index| distance(&cubics.cubics, at(index))).fold(0.0, f64::max)
}

#[test]
fn a_bezier_curve_as_nurbs_is_that_curve() {
    let list = [(0.0, 0.0), (1.0, 2.0), (4.0, 3.0), (5.0, 0.0)];
    let cubics = b_spline(3, &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0], &list).to_cubics();
    assert_eq!(
        cubics.cubics,
        [CubicBezier { control_points: list.map(|(x, y)| DVec2::new(x, y)) }]
    );
    assert_eq!(cubics.error, 0.0);
}

#[test]
fn the_joint_of_a_quadratic_is_known() {
    // Example 10.17 of LIF: one inner knot, so that the joint is the middle of the inner control
    // points.
    let list = [(0.0, 0.0), (0.0, 1.8), (3.6, 1.8), (3.6, 0.0)];
    let cubics = b_spline(2, &[0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0], &list).to_cubics().cubics;
    assert_eq!(cubics.len(), 2);
    assert!(cubics[0].control_points[3].distance(DVec2::new(1.8, 1.8)) < 1e-15);
    assert!(cubics[0].control_points[1].distance(DVec2::new(0.0, 1.2)) < 1e-15);
}

#[test]
fn corners_stay_corners() {
    let corner = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0)];
    let knots = [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0];
    let cubics = b_spline(2, &knots, &corner).to_cubics().cubics;
    assert_eq!(cubics.len(), 2);
    assert_eq!(cubics[0].tangent(1.0, Side::Before), DVec2::X);
    assert_eq!(cubics[1].tangent(0.0, Side::After), DVec2::Y);
    assert_eq!(cubics[1].control_points[0], DVec2::new(2.0, 0.0));
    let polyline =
        b_spline(1, &[0.0, 0.0, 0.5, 1.0, 1.0], &[(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)]).to_cubics();
    assert_eq!(polyline.cubics[1], CubicBezier::straight(DVec2::X * 3.0, DVec2::new(3.0, 4.0)));
}

#[test]
fn fitted_corners_stay_corners() {
    let knots = [vec![0.0; 5], vec![0.5; 4], vec![1.0; 5]].concat();
    let list = [
        (0.0, 0.0),
        (1.0, 0.5),
        (2.0, 0.5),
        (3.0, 0.0),
        (4.0, 0.0),
        (4.0, 1.0),
        (4.5, 2.0),
        (4.5, 3.0),
        (4.0, 4.0),
    ];
    let curve = b_spline(4, &knots, &list);
    let cubics = curve.to_cubics();
    let joint =
        cubics.cubics.iter().position(|cubic| cubic.control_points[3] == DVec2::new(4.0, 0.0));
    let joint = joint.expect("the corner is a joint");
    assert!(cubics.cubics[joint].tangent(1.0, Side::Before).distance(DVec2::X) < 1e-9);
    assert!(cubics.cubics[joint + 1].tangent(0.0, Side::After).distance(DVec2::Y) < 1e-9);
    assert!(greatest_distance(&curve, &cubics) < 0.001);
}

#[test]
fn a_rational_quarter_circle_is_a_circle_within_the_stated_error() {
    for radius in [0.5, 5.0, 100.0] {
        let list = points(&[(radius, 0.0), (radius, radius), (0.0, radius)]);
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let curve = Nurbs::new(2, knots, &list, &[1.0, FRAC_1_SQRT_2, 1.0]).expect("valid");
        assert!((curve.position(0.37).length() - radius).abs() < 1e-12 * radius);
        let cubics = curve.to_cubics();
        let error = (0..=1000u32)
            .flat_map(|i| cubics.cubics.iter().map(move |cubic| (cubic, f64::from(i) / 1000.0)));
        let error = error
            .map(|(cubic, at)| (cubic.position(at).length() - radius).abs())
            .fold(0.0, f64::max);
        assert!(
            error <= 1.1 * cubics.error && cubics.error <= TOLERANCE,
            "{error} {}",
            cubics.error
        );
        assert!(cubics.cubics.len() <= 2, "{}", cubics.cubics.len());
        // Tangents of a circle are at right angles to its radii.
        let samples = cubics
            .cubics
            .iter()
            .flat_map(|cubic| (0..=1000u32).map(move |i| (cubic, f64::from(i) / 1000.0)));
        let angles = samples.map(|(cubic, at)| {
            let radius = cubic.position(at).normalize();
            cubic.tangent(at, Side::After).dot(radius).asin().abs()
        });
        let worst = angles.fold(0.0, f64::max);
        assert!(worst <= 1.01 * HEADING_TOLERANCE, "{worst}");
    }
}

#[test]
fn an_elevated_cubic_is_recognised() {
    let cubic = points(&[(0.0, 0.0), (1.0, 2.0), (4.0, 3.0), (5.0, 0.0)]);
    let mut elevated = cubic.clone();
    for _ in 0..2 {
        let degree = elevated.len() as f64;
        let middle =
            (1..elevated.len()).map(|i| elevated[i].lerp(elevated[i - 1], i as f64 / degree));
        elevated = [cubic[0]].into_iter().chain(middle).chain([cubic[3]]).collect();
    }
    let cubics = bezier_to_cubics(&elevated).expect("degree 5");
    assert_eq!((elevated.len(), cubics.cubics.len()), (6, 1));
    assert!(cubics.error < 1e-12, "{}", cubics.error);
}

#[test]
fn pieces_without_extent_are_left_out() {
    let curve = b_spline(
        1,
        &[0.0, 0.0, 0.3, 0.6, 1.0, 1.0],
        &[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (2.0, 0.0)],
    );
    assert_eq!(curve.to_cubics().cubics.len(), 2);
    assert_eq!(bezier_to_cubics(&[DVec2::ONE; 6]).expect("a point").cubics.len(), 1);
}

#[test]
fn curves_that_do_not_exist_are_errors() {
    let new = |degree, knots: &[f64], count: usize, weights: &[f64]| {
        let points: Vec<DVec2> = (0..count).map(|i| DVec2::X * i as f64).collect();
        Nurbs::new(degree, knots.to_vec(), &points, weights).expect_err("not valid")
    };
    assert_eq!(new(0, &[], 0, &[]), NurbsError::Degree(0));
    assert_eq!(new(6, &[], 9, &[]), NurbsError::Degree(6));
    assert_eq!(new(3, &[], 3, &[]), NurbsError::TooFewPoints { points: 3, degree: 3 });
    assert_eq!(new(1, &[0.0, 1.0], 2, &[]), NurbsError::KnotCount { found: 2, expected: 4 });
    assert_eq!(
        new(1, &[0.0, 0.0, 1.0, 1.0], 2, &[1.0]),
        NurbsError::WeightCount { found: 1, points: 2 }
    );
    assert_eq!(new(1, &[0.0, 0.0, 1.0, 1.0], 2, &[1.0, 0.0]), NurbsError::Weight(1));
    assert_eq!(new(1, &[0.0, 0.0, 1.0, 1.0], 2, &[1.0, f64::NAN]), NurbsError::Weight(1));
    assert_eq!(new(1, &[0.0, 1.0, 0.0, 1.0], 2, &[]), NurbsError::KnotOrder(2));
    assert_eq!(new(1, &[0.0, 0.0, 1.0, f64::INFINITY], 2, &[]), NurbsError::KnotOrder(3));
    assert_eq!(new(1, &[0.0, 0.0, 0.0, 1.0], 2, &[]), NurbsError::NoDomain);
    let interrupted = new(1, &[0.0, 0.0, 0.5, 0.5, 1.0, 1.0], 4, &[]);
    assert_eq!(interrupted, NurbsError::Interrupted { index: 3, degree: 1 });
    let far = Nurbs::new(1, vec![0.0, 0.0, 1.0, 1.0], &[DVec2::ZERO, DVec2::INFINITY], &[]);
    assert_eq!(far, Err(NurbsError::Point(1)));
    assert_eq!(bezier_to_cubics(&[]), Err(NurbsError::Degree(0)));
}

/// Curves of every degree, with repeated inner knots and free ends.
fn curves(weights: std::ops::Range<f64>) -> impl Strategy<Value = (Nurbs, bool)> {
    let sizes = (1..=MAX_DEGREE, 0..6usize, any::<bool>(), any::<bool>());
    sizes.prop_flat_map(move |(degree, more, clamped, rational)| {
        let count = degree + 1 + more;
        let lists = prop::collection::vec((-20.0..20.0, -20.0..20.0), count);
        let gaps =
            prop::collection::vec(prop_oneof![2 => Just(0.0), 5 => 0.1..1.0], count + degree + 1);
        let weights = prop::collection::vec(weights.clone(), count);
        (lists, gaps, weights).prop_filter_map("not a curve", move |(list, gaps, weights)| {
            let mut knots: Vec<f64> = gaps
                .iter()
                .scan(0.0, |sum, gap| {
                    *sum += gap;
                    Some(*sum)
                })
                .collect();
            if clamped {
                let (start, end) = (knots[degree], knots[count]);
                knots[..degree].fill(start);
                knots[count + 1..].fill(end);
            }
            let curve =
                Nurbs::new(degree, knots, &points(&list), if rational { &weights } else { &[] })
                    .ok()?;
            Some((curve, degree <= 3 && !rational))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn conversions_follow_the_curve((curve, is_exact) in curves(0.2..5.0)) {
        let cubics = curve.to_cubics();
        let greatest = greatest_distance(&curve, &cubics);
        prop_assert!(!is_exact || (cubics.error == 0.0 && greatest < 1e-8), "{} {greatest}", cubics.error);
        prop_assert!(cubics.error <= TOLERANCE, "{}", cubics.error);
        prop_assert!(greatest <= 1.2 * cubics.error + 1e-8, "{greatest} > {}", cubics.error);
        let [start, end] = curve.domain();
        prop_assert!(cubics.cubics[0].control_points[0].distance(curve.position(start)) < 1e-9);
        let last = cubics.cubics.last().expect("at least one").control_points[3];
        prop_assert!(last.distance(curve.position(end)) < 1e-9);
    }

    #[test]
    fn exact_conversions_have_the_points_of_each_span((curve, is_exact) in curves(0.2..5.0)) {
        let cubics = curve.to_cubics().cubics;
        let mut knots: Vec<f64> = curve.knots[curve.degree..=curve.points.len()].to_vec();
        knots.dedup();
        if !is_exact || knots.len() != cubics.len() + 1 {
            return Ok(());
        }
        for (pair, cubic) in knots.windows(2).zip(&cubics) {
            for step in 0..=10u32 {
                let at = f64::from(step) / 10.0;
                let point = curve.position(pair[0] + (pair[1] - pair[0]) * at);
                prop_assert!(cubic.position(at).distance(point) < 1e-9);
            }
        }
    }

    #[test]
    fn bezier_curves_agree_with_bernstein(list in prop::collection::vec((-50.0..50.0, -50.0..50.0), 2..=6)) {
        let control = points(&list);
        let cubics = bezier_to_cubics(&control).expect("degree 1 to 5");
        prop_assert!(cubics.error <= TOLERANCE);
        let degree = control.len() as i32 - 1;
        for step in 0..=100u32 {
            let at = f64::from(step) / 100.0;
            let choose = |k: i32| (1..=k).map(|i| f64::from(degree + 1 - i) / f64::from(i)).product::<f64>();
            let weight = |k: i32| choose(k) * at.powi(k) * (1.0 - at).powi(degree - k);
            let point: DVec2 = (0..).zip(&control).map(|(k, point)| *point * weight(k)).sum();
            // Ternary search can miss the nearest point in a hairpin: exact conversions have the
            // same parameter.
            let same = cubics.cubics[0].position(at).distance(point);
            prop_assert!(same < 0.001 || distance(&cubics.cubics, point) < 0.001);
        }
    }

    #[test]
    fn hostile_curves_end(
        degree in 0..8usize,
        knots in prop::collection::vec(prop_oneof![any::<f64>(), 0.0..1.0], 0..20),
        list in prop::collection::vec((any::<f64>(), -1e8..1e8f64), 0..10),
        weights in prop::collection::vec(prop_oneof![any::<f64>(), 1e-3..1e3], 0..10),
    ) {
        let mut sorted = knots.clone();
        sorted.sort_by(f64::total_cmp);
        for knots in [knots, sorted] {
            if let Ok(curve) = Nurbs::new(degree, knots, &points(&list), &weights) {
                let cubics = curve.to_cubics();
                prop_assert!(cubics.cubics.iter().all(|cubic| cubic.control_points.iter().all(|point| point.is_finite())));
            }
        }
    }
}
