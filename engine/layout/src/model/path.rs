//! The shape of an edge: one or more cubic Bézier curves, end to end.

use glam::DVec2;
use regatta_base::bezier::{CubicBezier, Side};

/// A curve of one or more cubics. Each starts where the one before it ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    first: CubicBezier,
    /// The cubics after the first. Most edges have none, which takes no memory.
    others: Box<[CubicBezier]>,
}

impl From<CubicBezier> for Path {
    fn from(first: CubicBezier) -> Self {
        Self { first, others: Box::default() }
    }
}

impl Path {
    /// Joins cubics, each of which must start where the one before it ends. Returns `None` if there
    /// are none.
    pub fn from_cubics(cubics: &[CubicBezier]) -> Option<Self> {
        let (&first, others) = cubics.split_first()?;
        Some(Self { first, others: others.into() })
    }

    /// Returns the cubics from start to end.
    pub fn cubics(&self) -> impl DoubleEndedIterator<Item = &CubicBezier> + Clone {
        std::iter::once(&self.first).chain(&self.others)
    }

    /// Returns the number of cubics, at least 1.
    pub fn cubic_count(&self) -> usize {
        1 + self.others.len()
    }

    /// Returns the cubic if there is only one.
    pub fn single(&self) -> Option<&CubicBezier> {
        self.others.is_empty().then_some(&self.first)
    }

    /// Returns the start in metres.
    pub fn start(&self) -> DVec2 {
        self.first.control_points[0]
    }

    /// Returns the end in metres.
    pub fn end(&self) -> DVec2 {
        self.last().control_points[3]
    }

    /// Returns the unit tangent at the start.
    pub fn start_tangent(&self) -> DVec2 {
        self.first.tangent(0.0, Side::After)
    }

    /// Returns the unit tangent at the end.
    pub fn end_tangent(&self) -> DVec2 {
        self.last().tangent(1.0, Side::Before)
    }

    /// Returns the point and the unit tangent at a fraction of the path, in [0, 1]. Each cubic
    /// covers an equal share of the fractions, whatever its length.
    pub fn at(&self, fraction: f64) -> (DVec2, DVec2) {
        let scaled = fraction.clamp(0.0, 1.0) * self.cubic_count() as f64;
        let index = (scaled as usize).min(self.others.len());
        let cubic = self.cubics().nth(index).unwrap_or(&self.first);
        let lambda = scaled - index as f64;
        (cubic.position(lambda), cubic.tangent(lambda, Side::After))
    }

    /// Returns the largest angle in radians, in [0, π], between the tangents of two cubics where
    /// they meet; 0 if there is only one.
    pub fn largest_corner(&self) -> f64 {
        let mut largest: f64 = 0.0;
        for (before, after) in self.cubics().zip(&self.others) {
            let (before, after) =
                (before.tangent(1.0, Side::Before), after.tangent(0.0, Side::After));
            largest = largest.max(before.angle_to(after).abs());
        }
        largest
    }

    /// Returns the arc length in metres.
    pub fn length(&self) -> f64 {
        self.cubics().map(CubicBezier::length).sum()
    }

    /// Returns the length in metres of a line through points of the path, which is at most the
    /// path's own; `intervals` for each cubic.
    pub fn polyline_length(&self, intervals: u32) -> f64 {
        self.cubics().map(|cubic| cubic.polyline_length(intervals)).sum()
    }

    /// Returns the path in the opposite direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut cubics = self.cubics().rev().map(CubicBezier::reversed);
        let first = cubics.next().unwrap_or(self.first);
        Self { first, others: cubics.collect() }
    }

    /// Returns the path with every control point changed by a function.
    #[must_use]
    pub fn map(&self, change: impl Fn(DVec2) -> DVec2) -> Self {
        let mut path = self.clone();
        for cubic in std::iter::once(&mut path.first).chain(&mut path.others) {
            cubic.control_points = cubic.control_points.map(&change);
        }
        path
    }

    /// Returns all control points, in order.
    pub fn control_points(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.cubics().flat_map(|cubic| cubic.control_points)
    }

    fn last(&self) -> &CubicBezier {
        self.others.last().unwrap_or(&self.first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Path {
        let points = [DVec2::ZERO, DVec2::X * 2.0, DVec2::new(2.0, 3.0)];
        let cubics = [
            CubicBezier::straight(points[0], points[1]),
            CubicBezier::straight(points[1], points[2]),
        ];
        Path::from_cubics(&cubics).expect("two cubics")
    }

    #[test]
    fn a_path_joins_its_cubics() {
        let path = corner();
        assert_eq!(
            (path.start(), path.end(), path.cubic_count()),
            (DVec2::ZERO, DVec2::new(2.0, 3.0), 2)
        );
        assert!((path.length() - 5.0).abs() < 1e-12);
        assert_eq!((path.start_tangent(), path.end_tangent()), (DVec2::X, DVec2::Y));
        assert_eq!(path.at(0.5), (DVec2::X * 2.0, DVec2::Y));
        assert_eq!(path.at(1.0).0, path.end());
        assert!((path.largest_corner() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!(
            path.single().is_none()
                && Path::from(CubicBezier::straight(DVec2::ZERO, DVec2::X)).single().is_some()
        );
    }

    #[test]
    fn a_reversed_path_has_the_ends_exchanged() {
        let (path, back) = (corner(), corner().reversed());
        assert_eq!((back.start(), back.end()), (path.end(), path.start()));
        assert_eq!(back.reversed(), path);
        assert_eq!(back.start_tangent(), -path.end_tangent());
    }
}
