//! The centre of the overlap of two footprints.

use crate::body::{Body, Outline, Vector, between, corners, seen_along, turned_by, wide};

/// The inflation of the first of two rectangles, in metres, so that no two of their sides coincide.
const APART: f32 = 1e-5;
/// The smallest area of an overlap, as a part of the square of its perimeter, of which the centroid
/// is computed. The centroid of a thinner one is that of its sides.
const MIN_ROUNDNESS: f32 = 1e-3;

/// Returns the centre of the overlap of two footprints: for rectangles, the centroid of the
/// intersection polygon; with a circle, a point near it, which both footprints hold. If there is no
/// overlap, returns the middle of the gap.
pub(crate) fn overlap_centre(a: &Body, b: &Body) -> [f32; 2] {
    let offset = between(a.position, b.position);
    let point = match (a.outline(), b.outline()) {
        (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
            let turn = seen_along(wide(a.heading), wide(b.heading));
            let from_a = seen_along(wide(a.heading), offset);
            let centre = intersection_centroid(half_a, half_b, turn, from_a);
            let centre = centre.unwrap_or_else(|| middle_of_gap(half_a, half_b, turn, from_a));
            turned_by(wide(a.heading), centre)
        }
        (Outline::Rectangle(half), Outline::Circle(radius)) => turned_by(
            wide(a.heading),
            with_circle(half, radius, seen_along(wide(a.heading), offset)),
        ),
        (Outline::Circle(radius), Outline::Rectangle(half)) => {
            let back = offset.map(|axis| -axis);
            let [x, y] = turned_by(
                wide(b.heading),
                with_circle(half, radius, seen_along(wide(b.heading), back)),
            );
            [x + offset[0], y + offset[1]]
        }
        (Outline::Circle(radius_a), Outline::Circle(radius_b)) => {
            between_circles(radius_a, radius_b, offset)
        }
    };
    [0, 1].map(|axis| (f64::from(a.position[axis]) + point[axis]) as f32)
}

/// The sides of a rectangle, counter-clockwise, by coordinates: where each starts, and the way to
/// its end.
#[derive(Clone, Copy)]
struct Sides {
    start: [[f32; 4]; 2],
    way: [[f32; 4]; 2],
}

impl Sides {
    fn new([length, width]: [f32; 2]) -> Self {
        let start = [[length, length, -length, -length], [-width, width, width, -width]];
        let way = [[0.0, -2.0 * length, 0.0, 2.0 * length], [2.0 * width, 0.0, -2.0 * width, 0.0]];
        Self { start, way }
    }

    /// Rotates by an angle given as a unit vector, and moves.
    fn placed(self, [cos, sin]: [f32; 2], offset: [f32; 2]) -> Self {
        let turned = |vectors: [[f32; 4]; 2], offset: [f32; 2]| {
            let [mut x, mut y] = [[0.0; 4]; 2];
            for side in 0..4 {
                x[side] = offset[0] + vectors[0][side] * cos - vectors[1][side] * sin;
                y[side] = offset[1] + vectors[0][side] * sin + vectors[1][side] * cos;
            }
            [x, y]
        };
        Self { start: turned(self.start, offset), way: turned(self.way, [0.0; 2]) }
    }

    /// Returns the part of each side, from a fraction to another, that is in a rectangle at the
    /// origin. A side outside of it has an empty part.
    fn clipped(&self, half: [f32; 2]) -> [[f32; 4]; 2] {
        let [mut from, mut to] = [[0.0_f32; 4], [1.0; 4]];
        for (axis, half) in half.into_iter().enumerate() {
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
    fn set(
        &mut self,
        first: usize,
        sides: &Sides,
        [from, to]: [[f32; 4]; 2],
        [length, width]: [f32; 2],
    ) {
        for axis in 0..2 {
            for side in 0..4 {
                let (start, way) = (sides.start[axis][side], sides.way[axis][side]);
                self.from[axis][first + side] = start + from[side] * way;
                self.to[axis][first + side] = start + to[side] * way;
            }
        }
        let lengths = [2.0 * width, 2.0 * length, 2.0 * width, 2.0 * length];
        for side in 0..4 {
            self.lengths[first + side] = (to[side] - from[side]) * lengths[side];
        }
    }

    /// Returns the centroid of the area, or, if it is thin, that of the sides; `None` without
    /// sides.
    fn centroid(&self) -> Option<[f32; 2]> {
        let Self { from, to, lengths } = self;
        let (perimeter, [x, y]) =
            (sum(*lengths), [0, 1].map(|axis| self.moment(axis, lengths, 0.0)));
        if perimeter <= 0.0 {
            return None;
        }
        // Around it, the rounding errors of the area are smallest.
        let [x, y] = [x, y].map(|moment| 0.5 * moment / perimeter);
        let mut crosses = [0.0; 8];
        for side in 0..8 {
            let (p, q) =
                ([from[0][side] - x, from[1][side] - y], [to[0][side] - x, to[1][side] - y]);
            crosses[side] = p[0] * q[1] - p[1] * q[0];
        }
        let area = sum(crosses);
        if area <= MIN_ROUNDNESS * perimeter * perimeter {
            return Some([x, y]);
        }
        let part = |axis: usize, at: f32| at + self.moment(axis, &crosses, at) / (3.0 * area);
        Some([part(0, x), part(1, y)])
    }

    /// Returns the sum of both ends of all sides, relative to `origin` and with these weights.
    fn moment(&self, axis: usize, weights: &[f32; 8], origin: f32) -> f32 {
        let mut moments = [0.0; 8];
        for side in 0..8 {
            moments[side] =
                (self.from[axis][side] - origin + (self.to[axis][side] - origin)) * weights[side];
        }
        sum(moments)
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
    half_a: Vector,
    half_b: Vector,
    turn: Vector,
    offset: Vector,
) -> Option<Vector> {
    let narrow = |vector: Vector| vector.map(|axis| axis as f32);
    let (half_a, half_b, [cos, sin], offset) =
        (narrow(half_a), narrow(half_b), narrow(turn), narrow(offset));
    let half_a = half_a.map(|half| half + APART);
    // Relative to the middle of the overlapping bounding boxes, where rounding errors are smallest.
    let extent = [
        half_b[0] * cos.abs() + half_b[1] * sin.abs(),
        half_b[0] * sin.abs() + half_b[1] * cos.abs(),
    ];
    let middle = [0, 1].map(|axis| {
        let (low, high) = (
            (offset[axis] - extent[axis]).max(-half_a[axis]),
            (offset[axis] + extent[axis]).min(half_a[axis]),
        );
        0.5 * (low + high)
    });
    let (sides_a, sides_b) = (Sides::new(half_a), Sides::new(half_b));
    let back = [-offset[0] * cos - offset[1] * sin, offset[0] * sin - offset[1] * cos];
    let a_from_b = sides_a.placed([cos, -sin], back).clipped(half_b);
    let b_from_a = sides_b.placed([cos, sin], offset).clipped(half_a);
    let mut polygon = Polygon::default();
    polygon.set(0, &sides_a.placed([1.0, 0.0], middle.map(|axis| -axis)), a_from_b, half_a);
    let offset = [offset[0] - middle[0], offset[1] - middle[1]];
    polygon.set(4, &sides_b.placed([cos, sin], offset), b_from_a, half_b);
    let centroid = polygon.centroid()?;
    Some([0, 1].map(|axis| f64::from(middle[axis] + centroid[axis])))
}

/// Returns the middle between the nearest points of a rectangle at the origin and another one that
/// doesn't overlap it.
fn middle_of_gap(half_a: Vector, half_b: Vector, turn: Vector, offset: Vector) -> Vector {
    let back = [turn[0], -turn[1]];
    let from_b = turned_by(back, offset);
    let nearest = |half: Vector, corner: Vector| {
        let point = [corner[0].clamp(-half[0], half[0]), corner[1].clamp(-half[1], half[1])];
        let [x, y] = [corner[0] - point[0], corner[1] - point[1]];
        (x * x + y * y, [0.5 * (corner[0] + point[0]), 0.5 * (corner[1] + point[1])])
    };
    let of_b = corners(half_b)
        .map(|corner| turned_by(turn, corner))
        .map(|[x, y]| [x + offset[0], y + offset[1]]);
    let of_a = corners(half_a)
        .map(|corner| turned_by(back, corner))
        .map(|[x, y]| [x - from_b[0], y - from_b[1]]);
    let near_a = of_b.map(|corner| nearest(half_a, corner));
    let near_b = of_a.map(|corner| nearest(half_b, corner)).map(|(square, point)| {
        let [x, y] = turned_by(turn, point);
        (square, [x + offset[0], y + offset[1]])
    });
    let all = near_a.into_iter().chain(near_b);
    all.min_by(|(one, _), (other, _)| one.total_cmp(other)).map_or(offset, |(_, point)| point)
}

/// Returns a point in the middle of the overlap of a rectangle at the origin with a circle: the
/// middle of the overlap of the rectangle with the circle's bounding box, or, where the circle
/// doesn't reach that far, of the part that it reaches.
fn with_circle(half: Vector, radius: f64, centre: Vector) -> Vector {
    let nearest = [0, 1].map(|axis| centre[axis].clamp(-half[axis], half[axis]));
    let middle = [0, 1].map(|axis| {
        let [low, high] = [centre[axis] - radius, centre[axis] + radius]
            .map(|side| side.clamp(-half[axis], half[axis]));
        0.5 * (low + high)
    });
    let [x, y] = [nearest[0] - centre[0], nearest[1] - centre[1]];
    let [u, v] = [middle[0] - nearest[0], middle[1] - nearest[1]];
    let (distance, way) = ((x * x + y * y).sqrt(), (u * u + v * v).sqrt());
    if distance > radius {
        // They don't overlap: halfway between the nearest points.
        let part = 0.5 * (1.0 - radius / distance);
        return [nearest[0] - part * x, nearest[1] - part * y];
    }
    // From the nearest point, `reach` metres towards the middle leave the circle.
    let along = if way > 0.0 { (x * u + y * v) / way } else { 0.0 };
    let reach = (along * along + radius * radius - distance * distance).max(0.0).sqrt() - along;
    let part = if way > reach { 0.5 * reach / way } else { 1.0 };
    [nearest[0] + part * u, nearest[1] + part * v]
}

/// Returns the middle of the overlap of two circles on the line between their centres.
fn between_circles(radius_a: f64, radius_b: f64, offset: Vector) -> Vector {
    let distance = (offset[0] * offset[0] + offset[1] * offset[1]).sqrt();
    let (low, high) = ((distance - radius_b).max(-radius_a), radius_a.min(distance + radius_b));
    let part = if distance > 0.0 { 0.5 * (low + high) / distance } else { 0.0 };
    offset.map(|axis| part * axis)
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
            b.position = [0, 1].map(|axis| a.position[axis] + nearer * (b.position[axis] - a.position[axis]));
            let centre = overlap_centre(&a, &b).map(f64::from);
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
            position: [x, y],
            heading: [1.0, 0.0],
            half_length: 0.5,
            half_width: 0.25,
        };
        for (a, b, expected) in [
            (body(3.0, 1.0), body(3.0, 1.0), [3.0, 1.0]),
            (body(3.0, 1.0), body(3.8, 1.0), [3.4, 1.0]),
            (body(3.0, 1.0), body(4.0, 1.5), [3.5, 1.25]),
            (body(3.0, 1.0), body(4.0, 1.0), [3.5, 1.0]),
        ] {
            let [x, y] = overlap_centre(&a, &b);
            assert!(
                (x - expected[0]).abs() < 1e-4 && (y - expected[1]).abs() < 1e-4,
                "{x} {y} {expected:?}"
            );
        }
    }
}
