//! The knee of a throughput curve: from how many robots on more bring next to nothing.

/// The knee of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knee {
    /// The index of the point.
    pub index: usize,
    /// Whether it is the last point: the knee may be beyond it.
    pub is_last: bool,
}

/// Returns the first point of a curve from which on each more robot brings less than a part of what
/// one brings alone; `None` if there are no points, or none has any throughput.
///
/// Points are (robots, throughput), by ascending robots, which are above 0. The curve is replaced
/// by its upper concave hull, with the origin as its first point: noise makes a measured curve rise
/// and fall, and whoever looks for the best number of robots passes over its dents. What one robot
/// brings alone is the steepest slope of the hull, its first one.
pub fn knee(points: &[(f64, f64)], part: f64) -> Option<Knee> {
    let hull = hull(points);
    let slope = |from: (f64, f64), to: (f64, f64)| (to.1 - from.1) / (to.0 - from.0);
    let corners: Vec<(f64, f64)> =
        std::iter::once((0.0, 0.0)).chain(hull.iter().map(|index| points[*index])).collect();
    let alone = slope(*corners.first()?, *corners.get(1)?);
    if alone <= 0.0 {
        return None;
    }
    let is_flat = |pair: &[(f64, f64)]| slope(pair[0], pair[1]) < part * alone;
    // The knee is where the first flat piece begins; the piece from the origin is never flat.
    let corner = corners.windows(2).position(is_flat).unwrap_or(hull.len());
    let index = hull[corner - 1];
    Some(Knee { index, is_last: index + 1 == points.len() })
}

/// Returns the indices of the points on the upper concave hull, which begins at the origin
/// (Andrew's monotone chain).
fn hull(points: &[(f64, f64)]) -> Vec<usize> {
    let mut hull: Vec<usize> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        while let Some(&last) = hull.last() {
            let before =
                hull.len().checked_sub(2).map_or((0.0, 0.0), |second| points[hull[second]]);
            let (first, second) = (points[last], *point);
            let cross = (first.0 - before.0) * (second.1 - before.1)
                - (first.1 - before.1) * (second.0 - before.0);
            if cross < 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(index);
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robots_at_knee(points: &[(f64, f64)], part: f64) -> Option<f64> {
        knee(points, part).map(|knee| points[knee.index].0)
    }

    #[test]
    fn a_curve_that_saturates_has_its_knee_there() {
        let points: Vec<(f64, f64)> =
            (1..=30).map(|robots| (f64::from(robots), 2.0 * f64::from(robots).min(12.0))).collect();
        assert_eq!(robots_at_knee(&points, 0.01), Some(12.0));
        assert_eq!(
            knee(&points[..8], 0.01),
            Some(Knee { index: 7, is_last: true }),
            "still rising"
        );
    }

    #[test]
    fn a_curve_that_falls_has_its_knee_at_its_top_and_dents_do_not_matter() {
        let points = [(1.0, 1.0), (2.0, 1.9), (4.0, 3.0), (8.0, 6.0), (16.0, 9.0), (32.0, 8.0)];
        assert_eq!(robots_at_knee(&points, 0.01), Some(16.0));
        // From 8 to 16, a robot brings 0.375 of what one brings alone.
        assert_eq!(robots_at_knee(&points, 0.5), Some(8.0));
    }

    #[test]
    fn nothing_has_no_knee() {
        assert_eq!((knee(&[], 0.01), knee(&[(1.0, 0.0), (2.0, 0.0)], 0.01)), (None, None));
        assert_eq!(knee(&[(5.0, 1.0)], 0.01), Some(Knee { index: 0, is_last: true }));
    }
}
