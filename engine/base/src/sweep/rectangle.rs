//! Rectangles, and spans of curves.

use glam::{Vec2, vec2};

/// A rectangle in the plane, or all points within a distance of one: a disc if its sides are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Metres east and north.
    pub centre: Vec2,
    /// Unit vector along its first side.
    pub heading: Vec2,
    /// Half of its sides along and across the heading, in metres.
    pub half: Vec2,
    /// The distance in metres within which points belong to it; 0 for a plain rectangle.
    pub rounding: f32,
}

impl Rectangle {
    /// Radius of the circle around it, in metres.
    pub fn radius(&self) -> f32 {
        // Sizes are far from what overflows, and `hypot` takes several times as long.
        self.half.length() + self.rounding
    }

    /// Whether two of them have a point in common.
    pub fn touches(&self, other: &Self) -> bool {
        let reach = self.rounding + other.rounding;
        if reach == 0.0 {
            return self.overlaps(other);
        }
        // Most pairs are apart along an axis, too: the distance takes longer.
        self.with_corners().overlaps(&other.with_corners())
            && (self.overlaps(other) || self.distance_squared(other) <= reach * reach)
    }

    /// The plain rectangle around it.
    fn with_corners(&self) -> Self {
        Self { half: self.half + self.rounding, rounding: 0.0, ..*self }
    }

    /// Whether both have a point in common without their roundings: the separating axis theorem.
    fn overlaps(&self, other: &Self) -> bool {
        let offset = other.centre - self.centre;
        let cos = self.heading.dot(other.heading).abs();
        let sin = self.heading.perp_dot(other.heading).abs();
        !(self.is_apart(offset, cos, sin, other.half)
            || other.is_apart(offset, cos, sin, self.half))
    }

    /// The square of the distance in metres between two that don't overlap, without their
    /// roundings: one of the points nearest to each other is a corner.
    fn distance_squared(&self, other: &Self) -> f32 {
        self.nearest_corner(other).min(other.nearest_corner(self))
    }

    /// The square of the distance in metres to the nearest corner of another one.
    fn nearest_corner(&self, other: &Self) -> f32 {
        let offset = other.centre - self.centre;
        let (along, across) = (other.heading * other.half.x, other.heading.perp() * other.half.y);
        [along + across, along - across, across - along, -along - across]
            .map(|corner| self.beyond(offset + corner).length_squared())
            .into_iter()
            .fold(f32::INFINITY, f32::min)
    }

    /// The metres along and across the heading by which a point is outside of the sides, given its
    /// offset from the centre.
    fn beyond(&self, point: Vec2) -> Vec2 {
        let place = vec2(self.heading.dot(point), self.heading.perp_dot(point)).abs();
        (place - self.half).max(Vec2::ZERO)
    }

    /// Whether one of its own axes separates it from a rectangle whose centre is at an offset,
    /// given the absolute cosine and sine of the angle between both.
    fn is_apart(&self, offset: Vec2, cos: f32, sin: f32, other_half: Vec2) -> bool {
        self.heading.dot(offset).abs() > self.half.x + other_half.x * cos + other_half.y * sin
            || self.heading.perp_dot(offset).abs()
                > self.half.y + other_half.x * sin + other_half.y * cos
    }
}

/// A stretch of a curve, in metres from one of its ends.
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

    /// The span as seen from the other end of a curve of some length in metres.
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

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::random::Random;

    /// Samples along each side.
    const SAMPLES: u32 = 120;

    /// A rectangle of the numbers from `first` on: a third has no rounding, and some no sides.
    fn drawn(random: &Random, first: u64) -> Rectangle {
        let within = |number: u64, low: f32, high: f32| {
            low + (high - low) * random.unit(first + number) as f32
        };
        Rectangle {
            centre: vec2(within(0, -1.5, 1.5), within(1, -1.5, 1.5)),
            heading: Vec2::from_angle(within(2, -3.0, 3.0)),
            half: vec2(within(3, -0.5, 1.5), within(4, -0.5, 1.0)).max(Vec2::ZERO),
            rounding: within(5, -0.3, 0.6).max(0.0),
        }
    }

    /// The distance in metres of points all over the one from the other, without roundings.
    fn sampled_distance(one: &Rectangle, other: &Rectangle) -> f64 {
        let [axis, centre] = [one.heading, one.centre].map(Vec2::as_dvec2);
        let [to, middle] = [other.heading, other.centre].map(Vec2::as_dvec2);
        let mut least = f64::INFINITY;
        for (x, y) in (0..=SAMPLES).flat_map(|x| (0..=SAMPLES).map(move |y| (x, y))) {
            let part = 2.0 * DVec2::new(x.into(), y.into()) / f64::from(SAMPLES) - 1.0;
            let place = part * one.half.as_dvec2();
            let offset = centre + axis * place.x + axis.perp() * place.y - middle;
            let along = DVec2::new(to.dot(offset), to.perp_dot(offset)).abs();
            least = least.min((along - other.half.as_dvec2()).max(DVec2::ZERO).length());
        }
        least
    }

    #[test]
    fn rounded_rectangles_touch_where_their_points_are_near_enough() {
        let random = Random::new(7);
        // Half of the diagonal between the samples of the largest one.
        let between = 0.5 * f64::from(vec2(3.0, 2.0).length()) / f64::from(SAMPLES);
        let mut found = [0, 0];
        for pair in 0..2_000 {
            let [one, other] = [12 * pair, 12 * pair + 6].map(|first| drawn(&random, first));
            let (distance, reach) =
                (sampled_distance(&one, &other), f64::from(one.rounding + other.rounding));
            let is_touching = one.touches(&other);
            assert_eq!(is_touching, other.touches(&one), "{one:?} {other:?}");
            match is_touching {
                true => assert!(distance <= reach + between + 1e-5, "{one:?} {other:?}"),
                false => assert!(distance > reach - 1e-5, "{one:?} {other:?}"),
            }
            found[usize::from(is_touching)] += 1;
        }
        assert!(found.iter().all(|count| *count > 200), "{found:?}");
    }

    #[test]
    fn discs_touch_as_circles_do() {
        let disc = |x: f32, y: f32| Rectangle {
            centre: vec2(x, y),
            heading: Vec2::from_angle(x),
            half: Vec2::ZERO,
            rounding: 0.5,
        };
        assert!(disc(0.0, 0.0).touches(&disc(0.7, 0.7)), "0.990 m apart");
        assert!(!disc(0.0, 0.0).touches(&disc(0.71, 0.71)), "1.004 m apart");
        assert_eq!(disc(3.0, 4.0).radius(), 0.5);
    }
}
