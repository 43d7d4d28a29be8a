//! Distances of points from trajectories and straight lines.

use crate::message::{ControlPoint, Trajectory};

/// The largest degree of a trajectory that is evaluated.
const MOST_DEGREE: usize = 8;
/// The most control points of a trajectory that is evaluated.
const MOST_POINTS: usize = 1000;
/// Points of a trajectory that are evaluated for each of its control points.
const SAMPLES: usize = 12;

/// The distance of a point from a line between two points.
pub(super) fn distance_to_line(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let (east, north) = (to[0] - from[0], to[1] - from[1]);
    let square = east * east + north * north;
    let along = (point[0] - from[0]) * east + (point[1] - from[1]) * north;
    let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    let nearest = [from[0] + share * east, from[1] + share * north];
    (point[0] - nearest[0]).hypot(point[1] - nearest[1])
}

/// The distance of a point from a trajectory; `None` if the trajectory isn't a sound curve.
pub(super) fn distance_to_path(point: [f64; 2], path: &Trajectory) -> Option<f64> {
    let places = samples(path)?;
    let distances = places.windows(2).map(|pair| distance_to_line(point, pair[0], pair[1]));
    distances.filter(|distance| distance.is_finite()).min_by(f64::total_cmp)
}

/// Points along a trajectory.
fn samples(path: &Trajectory) -> Option<Vec<[f64; 2]>> {
    let degree = path.degree.unwrap_or(1) as usize;
    let points = &path.control_points;
    let is_sound =
        (1..=MOST_DEGREE).contains(&degree) && (degree + 1..=MOST_POINTS).contains(&points.len());
    if !is_sound {
        return None;
    }
    let knots = path.knot_vector.clone().unwrap_or_else(|| even_knots(degree, points.len()));
    let is_clamped =
        knots.len() == degree + 1 + points.len() && knots.windows(2).all(|pair| pair[0] <= pair[1]);
    if !is_clamped {
        return None;
    }
    let count = points.len() * SAMPLES;
    let (first, last) = (knots[degree], knots[points.len()]);
    let steps = (0..=count).map(|step| first + (last - first) * step as f64 / count as f64);
    Some(steps.map(|at| place(points, &knots, degree, at)).collect())
}

/// Knots with the same distance, and `degree + 1` at each end.
fn even_knots(degree: usize, points: usize) -> Vec<f64> {
    let spans = points - degree;
    let inner = (1..spans).map(|knot| knot as f64 / spans as f64);
    let start = std::iter::repeat_n(0.0, degree + 1);
    start.chain(inner).chain(std::iter::repeat_n(1.0, degree + 1)).collect()
}

/// The place on a NURBS curve, by de Boor's algorithm on points with weights.
fn place(points: &[ControlPoint], knots: &[f64], degree: usize, at: f64) -> [f64; 2] {
    let inner = &knots[degree + 1..points.len()];
    let span = degree + inner.partition_point(|knot| *knot <= at);
    let mut row: Vec<[f64; 3]> = points[span - degree..=span]
        .iter()
        .map(|point| {
            let weight = point.weight.unwrap_or(1.0);
            [point.x * weight, point.y * weight, weight]
        })
        .collect();
    for level in 1..=degree {
        for place in (level..=degree).rev() {
            let low = knots[span - degree + place];
            let high = knots[span + 1 + place - level];
            let share = if high > low { (at - low) / (high - low) } else { 0.0 };
            row[place] = between(row[place - 1], row[place], share);
        }
    }
    let [x, y, weight] = row[degree];
    [x / weight, y / weight]
}

/// The place between two points with weights.
fn between(from: [f64; 3], to: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| (1.0 - share) * from[axis] + share * to[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, weight: f64) -> ControlPoint {
        ControlPoint { x, y, weight: Some(weight) }
    }

    /// A quarter of a circle around (0, 0) is a curve of degree 2 with weights.
    #[test]
    fn a_quarter_of_a_circle_keeps_its_radius() {
        let control_points =
            vec![point(1.0, 0.0, 1.0), point(1.0, 1.0, 0.5_f64.sqrt()), point(0.0, 1.0, 1.0)];
        let path = Trajectory { degree: Some(2), knot_vector: None, control_points };
        for place in samples(&path).expect("a curve") {
            assert!((place[0].hypot(place[1]) - 1.0).abs() < 1e-12, "{place:?}");
        }
        let distance = distance_to_path([0.0, 0.0], &path).expect("a curve");
        assert!((distance - 1.0).abs() < 0.01, "{distance}");
    }

    #[test]
    fn a_polyline_passes_its_points_and_other_curves_are_refused() {
        let points = vec![point(0.0, 0.0, 1.0), point(2.0, 0.0, 1.0), point(2.0, 2.0, 1.0)];
        let path = Trajectory { degree: None, knot_vector: None, control_points: points };
        assert!(distance_to_path([2.0, 0.0], &path).expect("a curve") < 1e-9);
        assert!((distance_to_path([1.0, 1.0], &path).expect("a curve") - 1.0).abs() < 0.1);
        for knots in [vec![0.0; 3], vec![1.0, 0.0, 0.5, 0.0, 0.0]] {
            let path = Trajectory { knot_vector: Some(knots), ..path.clone() };
            assert_eq!(distance_to_path([0.0, 0.0], &path), None);
        }
        for degree in [0, 3, u32::MAX] {
            let path = Trajectory { degree: Some(degree), ..path.clone() };
            assert_eq!(distance_to_path([0.0, 0.0], &path), None);
        }
    }
}
