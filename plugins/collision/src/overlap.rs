//! The centre of the overlap of two footprints.

use glam::{DVec2, Vec2};

use crate::body::{Body, Outline, between, corners, seen_along};

/// The inflation of the first of two rectangles, in metres, so that no two of their sides coincide.
const APART: f32 = 1e-5;
/// The smallest area of an overlap, as a part of the square of its perimeter, of which the centroid
/// is computed. The centroid of a thinner one is that of its sides.
const MIN_ROUNDNESS: f32 = 1e-3;

/// Returns the centre of the overlap of two footprints: for rectangles, the centroid of the
/// intersection polygon; with a circle, a point near it, which both footprints hold. If there is no
/// overlap, returns the middle of the gap.
pub(crate) fn overlap_centre(a: &Body, b: &Body) -> Vec2 {
    let offset = between(a.position, b.position);
    let (heading_a, heading_b) = (a.heading.as_dvec2(), b.heading.as_dvec2());
    let point = match (a.outline(), b.outline()) {
        (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
            let turn = seen_along(heading_a, heading_b);
            let from_a = seen_along(heading_a, offset);
            let centre = intersection_centroid(half_a, half_b, turn, from_a);
            let centre = centre.unwrap_or_else(|| middle_of_gap(half_a, half_b, turn, from_a));
            heading_a.rotate(centre)
        }
        (Outline::Rectangle(half), Outline::Circle(radius)) => {
            heading_a.rotate(with_circle(half, radius, seen_along(heading_a, offset)))
        }
        (Outline::Circle(radius), Outline::Rectangle(half)) => {
            heading_b.rotate(with_circle(half, radius, seen_along(heading_b, -offset))) + offset
        }
        (Outline::Circle(radius_a), Outline::Circle(radius_b)) => {
            between_circles(radius_a, radius_b, offset)
        }
    };
    (a.position.as_dvec2() + point).as_vec2()
}

/// The sides of a rectangle, counter-clockwise, by coordinates: where each starts, and the way to
/// its end.
#[derive(Clone, Copy)]
struct Sides {
    start: [[f32; 4]; 2],
    way: [[f32; 4]; 2],
}

impl Sides {
    fn new(half: Vec2) -> Self {
        let Vec2 { x: length, y: width } = half;
        let start = [[length, length, -length, -length], [-width, width, width, -width]];
        let way = [[0.0, -2.0 * length, 0.0, 2.0 * length], [2.0 * width, 0.0, -2.0 * width, 0.0]];
        Self { start, way }
    }

    /// Rotates by an angle given as a unit vector, and moves.
    fn placed(self, turn: Vec2, offset: Vec2) -> Self {
        Self { start: placed(self.start, turn, offset), way: placed(self.way, turn, Vec2::ZERO) }
    }

    /// Returns the part of each side, from a fraction to another, that is in a rectangle at the
    /// origin. A side outside of it has an empty part.
    fn clipped(&self, half: Vec2) -> [[f32; 4]; 2] {
        let [mut from, mut to] = [[0.0_f32; 4], [1.0; 4]];
        for (axis, half) in half.to_array().into_iter().enumerate() {
            for side in 0..4 {
                let way = self.way[axis][side];
                let inverse = 1.0 / if way.abs() < 1e-12 { 1e-12 } else { way };
                let start = self.start[axis][side];
                let [one, other] = [(-half - start) * inverse, (half - start) * inverse];
                from[side] = least(greatest(from[side], least(one, other)), 1.0);
                to[side] = least(to[side], greatest(one, other));
            }
        }
        for side in 0..4 {
            to[side] = greatest(to[side], from[side]);
        }
        [from, to]
    }
}

/// Rotates vectors, given by coordinates, and adds an offset.
fn placed([xs, ys]: [[f32; 4]; 2], turn: Vec2, offset: Vec2) -> [[f32; 4]; 2] {
    let Vec2 { x: cos, y: sin } = turn;
    let [mut x, mut y] = [[0.0; 4]; 2];
    for side in 0..4 {
        x[side] = offset.x + xs[side] * cos - ys[side] * sin;
        y[side] = offset.y + xs[side] * sin + ys[side] * cos;
    }
    [x, y]
}

/// Returns the lower number. Unlike `f32::min`, it is a single instruction.
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

fn greatest(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The sides of an intersection polygon: parts of the sides of both rectangles.
#[derive(Default)]
struct Polygon {
    from: [[f32; 8]; 2],
    to: [[f32; 8]; 2],
    /// Metres.
    lengths: [f32; 8],
}

impl Polygon {
    /// Sets half of the sides to parts of a rectangle's sides.
    fn set(&mut self, first: usize, sides: &Sides, [from, to]: [[f32; 4]; 2], half: Vec2) {
        for axis in 0..2 {
            for side in 0..4 {
                let (start, way) = (sides.start[axis][side], sides.way[axis][side]);
                self.from[axis][first + side] = start + from[side] * way;
                self.to[axis][first + side] = start + to[side] * way;
            }
        }
        let lengths = [2.0 * half.y, 2.0 * half.x, 2.0 * half.y, 2.0 * half.x];
        for side in 0..4 {
            self.lengths[first + side] = (to[side] - from[side]) * lengths[side];
        }
    }

    /// Returns the centroid of the area, or, if it is thin, that of the sides; `None` without
    /// sides.
    fn centroid(&self) -> Option<Vec2> {
        let Self { from, to, lengths } = self;
        let perimeter = sum(*lengths);
        if perimeter <= 0.0 {
            return None;
        }
        // Around it, the rounding errors of the area are smallest.
        let middle = 0.5 * self.moments(lengths, Vec2::ZERO) / perimeter;
        let Vec2 { x, y } = middle;
        let mut crosses = [0.0; 8];
        for side in 0..8 {
            let (p, q) =
                ([from[0][side] - x, from[1][side] - y], [to[0][side] - x, to[1][side] - y]);
            crosses[side] = p[0] * q[1] - p[1] * q[0];
        }
        let area = sum(crosses);
        if area <= MIN_ROUNDNESS * perimeter * perimeter {
            return Some(middle);
        }
        Some(middle + self.moments(&crosses, middle) / (3.0 * area))
    }

    /// Returns the sum of both ends of all sides, relative to `origin` and with these weights.
    fn moments(&self, weights: &[f32; 8], origin: Vec2) -> Vec2 {
        let mut moments = [[0.0; 8]; 2];
        for (axis, origin) in origin.to_array().into_iter().enumerate() {
            for side in 0..8 {
                let (from, to) = (self.from[axis][side] - origin, self.to[axis][side] - origin);
                moments[axis][side] = (from + to) * weights[side];
            }
        }
        moments.map(sum).into()
    }
}

/// Returns the sum, four at once.
fn sum(values: [f32; 8]) -> f32 {
    let [a, b, c, d] = [0, 1, 2, 3].map(|lane| values[lane] + values[lane + 4]);
    (a + b) + (c + d)
}

/// Returns the centroid of the intersection of a rectangle at the origin with another one; `None`
/// if there is none. By Green's theorem, from the parts of the sides of each that are inside the
/// other: without branches, as the CPU could not predict them.
fn intersection_centroid(
    half_a: DVec2,
    half_b: DVec2,
    turn: DVec2,
    offset: DVec2,
) -> Option<DVec2> {
    let (half_b, turn, offset) = (half_b.as_vec2(), turn.as_vec2(), offset.as_vec2());
    let half_a = half_a.as_vec2() + APART;
    // Relative to the middle of the overlapping bounding boxes, at which rounding errors are
    // smallest.
    let Vec2 { x: cos, y: sin } = turn.abs();
    let extent = Vec2::new(half_b.x * cos + half_b.y * sin, half_b.x * sin + half_b.y * cos);
    let middle = 0.5 * ((offset - extent).max(-half_a) + (offset + extent).min(half_a));
    let (sides_a, sides_b) = (Sides::new(half_a), Sides::new(half_b));
    let back_turn = Vec2::new(turn.x, -turn.y);
    let a_from_b = sides_a.placed(back_turn, -back_turn.rotate(offset)).clipped(half_b);
    let b_from_a = sides_b.placed(turn, offset).clipped(half_a);
    let mut polygon = Polygon::default();
    polygon.set(0, &sides_a.placed(Vec2::X, -middle), a_from_b, half_a);
    polygon.set(4, &sides_b.placed(turn, offset - middle), b_from_a, half_b);
    Some((middle + polygon.centroid()?).as_dvec2())
}

/// Returns the middle between the nearest points of a rectangle at the origin and another one that
/// doesn't overlap it.
fn middle_of_gap(half_a: DVec2, half_b: DVec2, turn: DVec2, offset: DVec2) -> DVec2 {
    let back = DVec2::new(turn.x, -turn.y);
    let from_b = back.rotate(offset);
    let near_a = corners(half_b).map(|corner| nearest(half_a, turn.rotate(corner) + offset));
    let near_b = corners(half_a)
        .map(|corner| nearest(half_b, back.rotate(corner) - from_b))
        .map(|(square, point)| (square, turn.rotate(point) + offset));
    let all = near_a.into_iter().chain(near_b);
    all.min_by(|(one, _), (other, _)| one.total_cmp(other)).map_or(offset, |(_, point)| point)
}

/// Returns the squared distance of a corner from a rectangle at the origin, and the point halfway
/// to it.
fn nearest(half: DVec2, corner: DVec2) -> (f64, DVec2) {
    let point = corner.clamp(-half, half);
    ((corner - point).length_squared(), 0.5 * (corner + point))
}

/// Returns a point in the middle of the overlap of a rectangle at the origin with a circle: the
/// middle of the overlap of the rectangle with the circle's bounding box, or, if the circle doesn't
/// reach that far, of the part that it reaches.
fn with_circle(half: DVec2, radius: f64, centre: DVec2) -> DVec2 {
    let nearest = centre.clamp(-half, half);
    let middle =
        0.5 * ((centre - radius).clamp(-half, half) + (centre + radius).clamp(-half, half));
    let (from_centre, to_middle) = (nearest - centre, middle - nearest);
    let (distance, way) = (from_centre.length(), to_middle.length());
    if distance > radius {
        // They don't overlap: halfway between the nearest points.
        return nearest - 0.5 * (1.0 - radius / distance) * from_centre;
    }
    // From the nearest point, `reach` metres towards the middle leave the circle.
    let along = if way > 0.0 { from_centre.dot(to_middle) / way } else { 0.0 };
    let reach = (along * along + radius * radius - distance * distance).max(0.0).sqrt() - along;
    let part = if way > reach { 0.5 * reach / way } else { 1.0 };
    nearest + part * to_middle
}

/// Returns the middle of the overlap of two circles on the line between their centres.
fn between_circles(radius_a: f64, radius_b: f64, offset: DVec2) -> DVec2 {
    let distance = offset.length();
    let (low, high) = ((distance - radius_b).max(-radius_a), radius_a.min(distance + radius_b));
    let part = if distance > 0.0 { 0.5 * (low + high) / distance } else { 0.0 };
    part * offset
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::body::gap;
    use crate::geometry_reference::{bodies, distance, intersection_centroid, outline, position};

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_centre_of_an_overlap_lies_in_both_footprints(a in bodies(), mut b in bodies(), nearer in 0.0_f32..1.0) {
            b.position = a.position + nearer * (b.position - a.position);
            let centre = overlap_centre(&a, &b).as_dvec2().to_array();
            let far = |body: &Body| distance(&(vec![centre], 0.0), &outline(body, position(body), body.heading));
            let gap = gap(&a, &b, f64::INFINITY);
            prop_assert!(far(&a).max(far(&b)) < 0.5 * gap + 5e-5, "{} {} {gap}", far(&a), far(&b));
            let [outline_a, outline_b] = [&a, &b].map(|body| outline(body, position(body), body.heading));
            if a.is_circle() || b.is_circle() {
                return Ok(());
            }
            if let Some((exact, roundness)) = intersection_centroid(&outline_a.0, &outline_b.0) {
                let off = (exact[0] - centre[0]).hypot(exact[1] - centre[1]);
                prop_assert!(off < 0.02 || roundness < 1.01 * f64::from(MIN_ROUNDNESS), "{off} m off");
            }
        }
    }

    #[test]
    fn equal_and_aligned_footprints_have_their_overlap_in_the_middle() {
        let body = |x: f32, y: f32| Body {
            position: Vec2::new(x, y),
            heading: Vec2::X,
            half_length: 0.5,
            half_width: 0.25,
        };
        for (a, b, expected) in [
            (body(3.0, 1.0), body(3.0, 1.0), [3.0, 1.0]),
            (body(3.0, 1.0), body(3.8, 1.0), [3.4, 1.0]),
            (body(3.0, 1.0), body(4.0, 1.5), [3.5, 1.25]),
            (body(3.0, 1.0), body(4.0, 1.0), [3.5, 1.0]),
        ] {
            let Vec2 { x, y } = overlap_centre(&a, &b);
            assert!(
                (x - expected[0]).abs() < 1e-4 && (y - expected[1]).abs() < 1e-4,
                "{x} {y} {expected:?}"
            );
        }
    }
}
