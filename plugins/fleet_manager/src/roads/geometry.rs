//! Rectangles, spans and curves.

use glam::DVec2;
use glam::Vec2;
use regatta_plugin::world::CurveRecord;

/// A rectangle in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Metres east and north.
    pub centre: Vec2,
    /// Unit vector along its first side.
    pub heading: Vec2,
    /// Half of its sides along and across the heading, in metres.
    pub half: Vec2,
}

impl Rectangle {
    /// Radius of the circle around it, in metres.
    pub fn radius(&self) -> f32 {
        // Sizes are far from what overflows, and `hypot` takes several times as long.
        self.half.length()
    }

    /// Whether two rectangles have a point in common: the separating axis theorem.
    pub fn touches(&self, other: &Self) -> bool {
        let offset = other.centre - self.centre;
        let cos = self.heading.dot(other.heading).abs();
        let sin = self.heading.perp_dot(other.heading).abs();
        !(self.is_apart(offset, cos, sin, other.half)
            || other.is_apart(offset, cos, sin, self.half))
    }

    /// Whether one of its own axes separates it from a rectangle whose centre is at an offset,
    /// given the absolute cosine and sine of the angle between both.
    fn is_apart(&self, offset: Vec2, cos: f32, sin: f32, other_half: Vec2) -> bool {
        self.heading.dot(offset).abs() > self.half.x + other_half.x * cos + other_half.y * sin
            || self.heading.perp_dot(offset).abs()
                > self.half.y + other_half.x * sin + other_half.y * cos
    }
}

/// A stretch of an edge, in metres from one of the edge's ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its nearer end.
    pub low: f32,
    /// Its farther end.
    pub high: f32,
}

impl Span {
    /// The span of nothing.
    pub const EMPTY: Self = Self::new(f32::INFINITY, f32::NEG_INFINITY);

    /// Makes a span of its ends.
    pub const fn new(low: f32, high: f32) -> Self {
        Self { low, high }
    }

    /// Whether a place is within, ends included.
    pub fn contains(self, place: f32) -> bool {
        place >= self.low && place <= self.high
    }

    /// The span as seen from the other end of an edge of some length in metres.
    #[must_use]
    pub fn reversed(self, length: f32) -> Self {
        Self::new(length - self.high, length - self.low)
    }

    /// The smallest span that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }
}

/// A cubic Bézier curve in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Cubic([DVec2; 4]);

/// Abscissas and weights of the five-point Gauss–Legendre rule on [-1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

impl Cubic {
    /// Takes a curve of the world.
    pub fn new(record: &CurveRecord) -> Self {
        Self(record.control_points.map(|[x, y]| DVec2::new(x.into(), y.into())))
    }

    /// The point at a parameter in 0 to 1.
    pub fn point(&self, t: f64) -> DVec2 {
        let (u, [p0, p1, p2, p3]) = (1.0 - t, self.0);
        p0 * (u * u * u) + p1 * (3.0 * u * u * t) + p2 * (3.0 * u * t * t) + p3 * (t * t * t)
    }

    /// The derivative at a parameter. Where it vanishes (a handle of length zero), the direction of
    /// the chord from there.
    pub fn tangent(&self, t: f64) -> DVec2 {
        let derivative = self.derivative(t);
        if derivative.x.hypot(derivative.y) > 1e-9 {
            return derivative;
        }
        let (near, far) = if t < 0.5 { (t, t + 1e-4) } else { (t - 1e-4, t) };
        self.point(far) - self.point(near)
    }

    /// The arc length between two parameters, in metres.
    pub fn length(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let speeds = GAUSS
            .map(|(abscissa, weight)| weight * self.derivative(middle + half * abscissa).length());
        half * speeds.iter().sum::<f64>()
    }

    fn derivative(&self, t: f64) -> DVec2 {
        let (u, [p0, p1, p2, p3]) = (1.0 - t, self.0);
        ((p1 - p0) * (u * u) + (p2 - p1) * (2.0 * u * t) + (p3 - p2) * (t * t)) * 3.0
    }
}
