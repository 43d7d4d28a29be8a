//! Cubic Bézier curves: points, derivatives, tangents and arc length, in `f64`.

use glam::DVec2;

/// The fraction of the curve's extent below which the length of a derivative is a rounding error
/// and counts as zero.
const NEGLIGIBLE: f64 = 1e-12;

/// The three-point Gauss-Legendre rule on [-1, 1]: the distance √(3/5) of the outer points from the
/// middle, and the weights of an outer point and of the middle.
const OUTER: f64 = 0.774_596_669_241_483_4;
const OUTER_WEIGHT: f64 = 5.0 / 9.0;
const MIDDLE_WEIGHT: f64 = 8.0 / 9.0;

/// The number of halvings after which [`CubicBezier::length_between`] accepts the result: 2⁻⁴⁰ of
/// the curve.
const MAX_DEPTH: u32 = 40;

/// A cubic Bézier curve in metres.
///
/// ```
/// use glam::DVec2;
/// use regatta_base::bezier::CubicBezier;
///
/// let curve = CubicBezier::straight(DVec2::ZERO, DVec2::new(3.0, 4.0));
/// assert_eq!(curve.position(0.5), DVec2::new(1.5, 2.0));
/// assert!((curve.length() - 5.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicBezier {
    /// P0 to P3.
    pub control_points: [DVec2; 4],
}

/// The side from which a parameter is approached, which distinguishes the two tangents of a cusp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From smaller parameters: the tangent on arrival.
    Before,
    /// From larger parameters: the tangent on departure.
    After,
}

impl CubicBezier {
    /// Returns the straight segment with constant |p'|: its control points are evenly spaced.
    pub fn straight(p0: DVec2, p3: DVec2) -> Self {
        Self { control_points: [p0, p0.lerp(p3, 1.0 / 3.0), p0.lerp(p3, 2.0 / 3.0), p3] }
    }

    /// Returns the same curve in the opposite direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let [p0, p1, p2, p3] = self.control_points;
        Self { control_points: [p3, p2, p1, p0] }
    }

    /// Returns the length in metres of the line through `intervals + 1` points of the curve, which
    /// is at most the curve's own.
    pub fn polyline_length(&self, intervals: u32) -> f64 {
        let points = (0..=intervals).map(|i| self.position(f64::from(i) / f64::from(intervals)));
        points.clone().zip(points.skip(1)).map(|(from, to)| from.distance(to)).sum()
    }

    /// Returns the point at `lambda` in [0, 1] (equation 3.7), in metres. The ends are exactly P0
    /// and P3.
    pub fn position(&self, lambda: f64) -> DVec2 {
        let [p0, p1, p2, p3] = self.control_points;
        let mu = 1.0 - lambda;
        p0 * (mu * mu * mu)
            + (p1 * mu + p2 * lambda) * (3.0 * mu * lambda)
            + p3 * (lambda * lambda * lambda)
    }

    /// Returns p'(λ) in metres.
    pub fn derivative(&self, lambda: f64) -> DVec2 {
        let [a, b, c] = self.hodograph();
        let mu = 1.0 - lambda;
        a * (mu * mu) + b * (2.0 * mu * lambda) + c * (lambda * lambda)
    }

    /// Returns p''(λ) in metres.
    pub fn second_derivative(&self, lambda: f64) -> DVec2 {
        let [a, b, c] = self.hodograph();
        ((b - a) * (1.0 - lambda) + (c - b) * lambda) * 2.0
    }

    /// Returns p''', which is constant, in metres.
    pub fn third_derivative(&self) -> DVec2 {
        let [a, b, c] = self.hodograph();
        (a - b * 2.0 + c) * 2.0
    }

    /// Returns the parameter, in [0, 1], that one step of Newton's method makes of `lambda` on the
    /// way to the point of the curve that is nearest to another; the same where the distance has no
    /// minimum nearby.
    pub fn nearer(&self, lambda: f64, to: DVec2) -> f64 {
        let (offset, velocity) = (self.position(lambda) - to, self.derivative(lambda));
        let slope = velocity.length_squared() + offset.dot(self.second_derivative(lambda));
        if slope > 0.0 { (lambda - offset.dot(velocity) / slope).clamp(0.0, 1.0) } else { lambda }
    }

    /// Returns the unit tangent at `lambda` in [0, 1]. Where p' = 0 (a handle of length zero, a
    /// cusp) it is the limit from `side`, or from inside the curve at its ends; (1, 0) if all
    /// control points coincide.
    pub fn tangent(&self, lambda: f64, side: Side) -> DVec2 {
        let after = lambda <= 0.0 || (side == Side::After && lambda < 1.0);
        let towards = if after { 1.0 } else { -1.0 };
        let negligible = NEGLIGIBLE * self.extent();
        [self.derivative(lambda), self.second_derivative(lambda) * towards, self.third_derivative()]
            .into_iter()
            .find(|candidate| candidate.length() > negligible)
            .map_or(DVec2::X, DVec2::normalize)
    }

    /// Returns the arc length in metres, accurate to about a nanometre.
    pub fn length(&self) -> f64 {
        self.slow_points()
            .chain([1.0])
            .fold((0.0, 0.0), |(sum, from), to| (sum + self.length_between(from, to), to))
            .0
    }

    /// Returns the arc length between two parameters in metres, by adaptive Gauss-Legendre
    /// quadrature of |p'|.
    pub fn length_between(&self, from: f64, to: f64) -> f64 {
        let velocity = self.velocity();
        velocity.refine(from, to, velocity.quadrature(from, to), MAX_DEPTH)
    }

    /// Returns p' prepared for evaluation at many points.
    pub fn velocity(&self) -> Velocity {
        let [a, b, c] = self.hodograph();
        Velocity([a, (b - a) * 2.0, a - b * 2.0 + c])
    }

    /// Returns the slow points: the parameters strictly inside (0, 1), ascending, where |p'| has a
    /// local minimum that is small compared with the rest of the curve (cusps and near cusps).
    pub fn slow_points(&self) -> impl Iterator<Item = f64> + use<> {
        let hodograph = self.hodograph();
        let points = if is_clearly_regular(hodograph) { [None; 3] } else { slow_points(hodograph) };
        points.into_iter().flatten()
    }

    /// Returns the control points of p', which is a quadratic Bézier curve.
    fn hodograph(&self) -> [DVec2; 3] {
        let [p0, p1, p2, p3] = self.control_points;
        [(p1 - p0) * 3.0, (p2 - p1) * 3.0, (p3 - p2) * 3.0]
    }

    /// Returns an upper bound on the distance of the curve's points from P0.
    fn extent(&self) -> f64 {
        let [p0, others @ ..] = self.control_points;
        others.into_iter().map(|point| point.distance(p0)).fold(0.0, f64::max)
    }
}

/// The derivative p' in the power basis of λ.
#[derive(Clone, Copy, Debug)]
pub struct Velocity([DVec2; 3]);

impl Velocity {
    /// Returns p'(λ). Where it is small, its rounding error is larger than that of
    /// [`CubicBezier::derivative`].
    pub fn at(&self, lambda: f64) -> DVec2 {
        self.0[0] + (self.0[1] + self.0[2] * lambda) * lambda
    }

    /// Applies one Gauss-Legendre rule to |p'| over the whole interval.
    pub fn quadrature(&self, from: f64, to: f64) -> f64 {
        let (half, middle) = ((to - from) / 2.0, (to + from) / 2.0);
        let speed = |node: f64| self.at(middle + half * node).length();
        half * (OUTER_WEIGHT * (speed(-OUTER) + speed(OUTER)) + MIDDLE_WEIGHT * speed(0.0))
    }

    fn refine(&self, from: f64, to: f64, whole: f64, depth: u32) -> f64 {
        let middle = (from + to) / 2.0;
        let (left, right) = (self.quadrature(from, middle), self.quadrature(middle, to));
        let halves = left + right;
        // The halves are about 2⁶ times more accurate than the whole where the integrand is smooth.
        if depth == 0 || (halves - whole).abs() <= 1e-9 + 1e-13 * halves {
            return halves;
        }
        self.refine(from, middle, left, depth - 1) + self.refine(middle, to, right, depth - 1)
    }
}

/// Whether p' stays well away from zero, judged by its convex hull only: true for nearly every real
/// edge.
fn is_clearly_regular(hodograph: [DVec2; 3]) -> bool {
    let axis = hodograph[0] + hodograph[1] + hodograph[2];
    let fastest = hodograph.map(DVec2::length).into_iter().fold(0.0, f64::max);
    hodograph.into_iter().all(|point| point.dot(axis) > 0.1 * fastest * axis.length())
}

/// Returns the minima of |p'|² in (0, 1) where |p'| is below a tenth of the longest hodograph
/// control point. At least one is `None`: a quartic has at most two minima.
fn slow_points([p, q, r]: [DVec2; 3]) -> [Option<f64>; 3] {
    let (a, b, c) = (p - q * 2.0 + r, (q - p) * 2.0, p);
    // p' = aλ² + bλ + c, so p'·p'', half the derivative of |p'|², is a cubic.
    let slope =
        [b.dot(c), b.length_squared() + 2.0 * a.dot(c), 3.0 * a.dot(b), 2.0 * a.length_squared()];
    let fastest = [p, q, r].map(DVec2::length).into_iter().fold(0.0, f64::max);
    rising_roots(slope)
        .map(|root| root.filter(|&at| ((a * at + b) * at + c).length() < 0.1 * fastest))
}

/// Returns the roots in (0, 1) at which c₀ + c₁λ + c₂λ² + c₃λ³ changes from negative to positive,
/// at most one for each monotone interval.
fn rising_roots(c: [f64; 4]) -> [Option<f64>; 3] {
    let [first, second] =
        quadratic_roots(c[1], 2.0 * c[2], 3.0 * c[3]).map(|root| root.clamp(0.0, 1.0));
    [(0.0, first), (first, second), (second, 1.0)].map(|(low, high)| {
        let rises = cubic(c, low) < 0.0 && cubic(c, high) > 0.0;
        rises.then(|| bisect(c, low, high)).filter(|root| (1e-9..=1.0 - 1e-9).contains(root))
    })
}

/// Evaluates c₀ + c₁λ + c₂λ² + c₃λ³.
fn cubic(c: [f64; 4], lambda: f64) -> f64 {
    c[0] + lambda * (c[1] + lambda * (c[2] + lambda * c[3]))
}

/// Returns the point where a cubic polynomial, negative at `low` and positive at `high`, changes
/// its sign.
fn bisect(c: [f64; 4], mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        *(if cubic(c, middle) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    (low + high) / 2.0
}

/// Returns the real roots of c₀ + c₁λ + c₂λ², ascending; arbitrary finite numbers in place of roots
/// that don't exist.
fn quadratic_roots(c0: f64, c1: f64, c2: f64) -> [f64; 2] {
    let discriminant = c1 * c1 - 4.0 * c2 * c0;
    if discriminant < 0.0 {
        return [0.0; 2];
    }
    // The form without cancellation; a division by zero means that the root is outside [0, 1].
    let q = -0.5 * (c1 + discriminant.sqrt().copysign(c1));
    let [one, other] = [q / c2, c0 / q].map(|root| if root.is_finite() { root } else { 0.0 });
    [one.min(other), one.max(other)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: [(f64, f64); 4]) -> CubicBezier {
        CubicBezier { control_points: points.map(|(x, y)| DVec2::new(x, y)) }
    }

    #[test]
    fn a_straight_edge_has_a_constant_derivative() {
        let straight = CubicBezier::straight(DVec2::new(-1.0, 2.0), DVec2::new(2.0, 6.0));
        assert!((straight.length() - 5.0).abs() < 1e-12);
        assert!(straight.position(0.3).distance(DVec2::new(-0.1, 3.2)) < 1e-12);
        assert!((straight.derivative(0.9).length() - 5.0).abs() < 1e-12);
        assert!(
            straight.second_derivative(0.5).length() < 1e-12
                && straight.third_derivative().length() < 1e-12
        );
    }

    #[test]
    fn derivatives_match_finite_differences() {
        let curve = curve([(0.0, 0.0), (1.0, 3.0), (-2.0, 4.0), (5.0, 1.0)]);
        let difference = |at: f64, f: &dyn Fn(f64) -> DVec2| (f(at + 1e-6) - f(at - 1e-6)) / 2e-6;
        for at in [0.1, 0.5, 0.8] {
            assert!(difference(at, &|at| curve.position(at)).distance(curve.derivative(at)) < 1e-6);
            assert!(
                difference(at, &|at| curve.derivative(at)).distance(curve.second_derivative(at))
                    < 1e-6
            );
            assert!(
                difference(at, &|at| curve.second_derivative(at))
                    .distance(curve.third_derivative())
                    < 1e-6
            );
        }
    }

    #[test]
    fn the_length_includes_both_directions_at_a_cusp() {
        // x(λ) = 6λ - 15λ² + 10λ³ turns back where λ² - λ + 1/5 = 0, at x = 1/2 ± √5/10.
        let there_and_back = curve([(0.0, 0.0), (2.0, 0.0), (-1.0, 0.0), (1.0, 0.0)]);
        let turn = 0.5 + 5.0_f64.sqrt() / 10.0;
        assert!((there_and_back.length() - (4.0 * turn - 1.0)).abs() < 1e-9);
        assert_eq!(there_and_back.slow_points().count(), 2);
    }

    #[test]
    fn the_length_of_a_curve_with_a_near_cusp_is_the_sum_of_its_parts() {
        let tight = curve([(0.0, 0.0), (1.0, 1.0), (1e-4, 1.0), (1.0, 0.0)]);
        let count = if cfg!(miri) { 20 } else { 10_000 };
        let at = |i: i32| f64::from(i) / f64::from(count);
        let parts: f64 = (0..count).map(|i| tight.length_between(at(i), at(i + 1))).sum();
        assert!((tight.length() - parts).abs() < 1e-8, "{} {parts}", tight.length());
        assert!((tight.reversed().length() - parts).abs() < 1e-8);
    }

    #[test]
    fn the_tangent_is_a_limit_where_the_derivative_is_zero() {
        let close = |a: DVec2, b: DVec2| a.distance(b) < 1e-9;
        let no_handle = curve([(0.0, 0.0), (0.0, 0.0), (3.0, 4.0), (5.0, 5.0)]);
        assert!(close(no_handle.tangent(0.0, Side::Before), DVec2::new(0.6, 0.8)));
        let no_handles = curve([(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (3.0, 4.0)]);
        assert!(close(no_handles.tangent(0.0, Side::After), DVec2::new(0.6, 0.8)));
        let cusp = curve([(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0)]);
        assert!(
            close(cusp.tangent(0.5, Side::Before), DVec2::Y)
                && close(cusp.tangent(0.5, Side::After), -DVec2::Y)
        );
        assert_eq!(curve([(2.0, 2.0); 4]).tangent(0.5, Side::After), DVec2::X);
    }
}
