//! The space that robots sweep along an edge, as a chain of short stretches.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::{DVec2, Vec2, vec2};

use super::cubic::Cubic;
use super::{Rectangle, Span, angle_between};

/// The longest stretch in metres, unless another is given: the resolution at which claims are given
/// back.
const STEP: f64 = 0.1;
/// The largest change of heading within half a stretch, in radians; sharper bends get shorter
/// stretches.
const BEND: f64 = 0.1;
/// The shortest stretch, in metres: a cusp isn't divided for ever.
const SHORTEST: f64 = 0.01;
/// The margin by which footprints are enlarged on each side, in metres: poses are exact to 1 mm
/// only, and rounded.
pub const MARGIN: f32 = 0.003;

/// The outline of a robot: a rectangle or a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Half of a rectangle's size along (x) and across (y) the heading, in metres; 0 of a circle.
    half: Vec2,
    /// The radius of a circle, in metres; 0 of a rectangle.
    rounding: f32,
}

impl Footprint {
    /// A rectangle of a length along and a width across the heading, in metres.
    pub fn rectangle(length: f32, width: f32) -> Self {
        Self { half: vec2(0.5 * length, 0.5 * width), rounding: 0.0 }
    }

    /// A circle of a diameter in metres.
    pub fn circle(diameter: f32) -> Self {
        Self { half: Vec2::ZERO, rounding: 0.5 * diameter }
    }

    /// The distance from its middle to its front, in metres.
    pub fn reach(&self) -> f32 {
        self.half.x + self.rounding
    }

    /// The radius of the circle around it, in metres.
    pub fn radius(&self) -> f32 {
        self.half.length() + self.rounding
    }

    /// The outline of a robot that stands somewhere, in metres, and has a heading, a unit vector.
    pub fn at(&self, centre: Vec2, heading: Vec2) -> Rectangle {
        Rectangle { centre, heading, half: self.half, rounding: self.rounding }
    }

    /// The outline that is larger by some metres on all sides.
    #[must_use]
    pub fn grown(&self, metres: f32) -> Self {
        if self.is_round() {
            Self { rounding: self.rounding + metres, ..*self }
        } else {
            Self { half: self.half + metres, ..*self }
        }
    }

    /// Whether it is a circle.
    fn is_round(&self) -> bool {
        self.rounding > 0.0
    }
}

/// The heading of robots along an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyHeading {
    /// That of the tangent.
    Tangential,
    /// At this angle to the tangent, in radians.
    Offset(f64),
    /// The same heading everywhere, in radians.
    Fixed(f64),
}

/// A stretch of an edge, and by how much the robots on it may differ from a robot in its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptBox {
    /// Metres from the edge's origin to its ends.
    pub s: Span,
    /// The middle, in metres.
    centre: Vec2,
    /// Unit vector along the heading of a robot in the middle.
    heading: Vec2,
    /// The largest distance of a robot's position from the middle along and across that heading, in
    /// metres.
    offset: Vec2,
    /// Sine of the largest difference of headings; 1 for any heading.
    turn: f32,
}

impl SweptBox {
    /// Returns a rectangle that holds a footprint at every pose of the stretch; a rounded one for a
    /// circle.
    pub fn rectangle(&self, footprint: &Footprint) -> Rectangle {
        let Vec2 { x: length, y: width } = footprint.half;
        let half = if self.turn >= 1.0 {
            Vec2::splat(length.hypot(width))
        } else {
            vec2(length + width * self.turn, width + length * self.turn)
        };
        let half = half + self.offset + MARGIN;
        let rounding = footprint.rounding;
        Rectangle { centre: self.centre, heading: self.heading, half, rounding }
    }

    /// Returns a rectangle within a footprint, enlarged by the [`MARGIN`], at every pose of the
    /// stretch: robots on two stretches whose cores touch do so, too. `None` if the stretch is too
    /// long for it: half of the footprint's smaller side is short enough.
    pub fn core(&self, footprint: &Footprint) -> Option<Rectangle> {
        if footprint.is_round() {
            return self.round_core(footprint);
        }
        let Vec2 { x: length, y: width } = footprint.half + MARGIN;
        // The square in the circle that footprints of all headings have in common.
        let of_any_heading = Vec2::splat(length.min(width) * FRAC_1_SQRT_2);
        let turned = vec2(length - width * self.turn, width - length * self.turn);
        let half = if turned.y > of_any_heading.y { turned } else { of_any_heading } - self.offset;
        let is_positive = half.min_element() > 0.0;
        let (centre, heading) = (self.centre, self.heading);
        is_positive.then_some(Rectangle { centre, heading, half, rounding: 0.0 })
    }

    /// The disc that circles at all poses have in common.
    fn round_core(&self, circle: &Footprint) -> Option<Rectangle> {
        let rounding = circle.rounding + MARGIN - self.offset.length();
        let (centre, heading) = (self.centre, self.heading);
        (rounding > 0.0).then_some(Rectangle { centre, heading, half: Vec2::ZERO, rounding })
    }

    /// The same stretch, with robots of any heading on it.
    #[must_use]
    pub fn of_any_heading(self) -> Self {
        Self { turn: 1.0, ..self }
    }

    /// Whether its half length is that of a straight line in a direction.
    fn is_along(&self, heading: f32) -> bool {
        let half = 0.5 * (self.s.high - self.s.low);
        let direction = vec2(heading.cos(), heading.sin());
        let along = direction.dot(self.heading).abs() * half;
        (self.offset.x - along).abs() < 1e-4
    }

    /// The stretch of a robot that stands with a heading in radians: a place of length zero.
    pub fn standing(position: Vec2, heading: f32) -> Self {
        Self { heading: Vec2::from_angle(heading), turn: 0.0, ..Self::disc(position) }
    }

    /// The stretch of robots that turn on the spot at a node: a place of length zero, any heading.
    pub fn disc(position: Vec2) -> Self {
        let s = Span::new(0.0, 0.0);
        Self { s, centre: position, heading: Vec2::X, offset: Vec2::ZERO, turn: 1.0 }
    }
}

/// The stretches of an edge, from its origin to its destination.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    boxes: Vec<SweptBox>,
    /// Tangents at the origin and at the destination, in radians.
    headings: [f32; 2],
}

impl Sweep {
    /// Samples an edge of cubic Bézier curves, end to end, given by their control points in metres.
    /// The stretches are at most 0.1 m long.
    pub fn new(heading: BodyHeading, curves: impl IntoIterator<Item = [DVec2; 4]>) -> Self {
        Self::with_step(heading, curves, STEP)
    }

    /// As [`new`](Self::new), of stretches of at most `step` metres, above 0. Straight
    /// lines that are driven along the tangent are as exact as with shorter ones.
    pub fn with_step(
        heading: BodyHeading,
        curves: impl IntoIterator<Item = [DVec2; 4]>,
        step: f64,
    ) -> Self {
        let mut builder = Builder { heading, s: 0.0, boxes: Vec::new() };
        let cubics: Vec<_> = curves.into_iter().map(Cubic::new).collect();
        for cubic in &cubics {
            let parts = (cubic.length(0.0, 0.5) + cubic.length(0.5, 1.0)) / step;
            let parts = parts.ceil().clamp(1.0, 1e6) as u32;
            for part in 0..parts {
                let [from, to] = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
                builder.add(cubic, from, to);
            }
        }
        let headings = [
            cubics.first().map_or(0.0, |first| angle_of(first.tangent(0.0)) as f32),
            cubics.last().map_or(0.0, |last| angle_of(last.tangent(1.0)) as f32),
        ];
        Self { boxes: builder.boxes, headings }
    }

    /// Arc length, in metres.
    pub fn length(&self) -> f32 {
        self.boxes.last().map_or(0.0, |last| last.s.high)
    }

    /// Tangents at the origin and at the destination, in radians in (-π, π].
    pub fn headings(&self) -> [f32; 2] {
        self.headings
    }

    /// Whether its tangent and the heading of robots are the same everywhere.
    pub fn is_straight(&self) -> bool {
        let Some(first) = self.boxes.first() else { return true };
        self.boxes.iter().all(|part| {
            part.turn == 0.0 && part.heading == first.heading && part.is_along(self.headings[0])
        }) && angle_between(self.headings[0], self.headings[1]) < 1e-4
    }

    /// Returns how far apart two robots have to be on a [straight](Self::is_straight) edge, in
    /// metres.
    pub fn straight_separation(&self, a: &Footprint, b: &Footprint) -> Option<f32> {
        let first = self.boxes.first()?;
        let roundings = a.rounding + b.rounding;
        if a.is_round() && b.is_round() {
            return Some(roundings + 2.0 * MARGIN);
        }
        let tangent = vec2(self.headings[0].cos(), self.headings[0].sin());
        let along = tangent.dot(first.heading).abs();
        let across = tangent.perp_dot(first.heading).abs();
        // Beside a rectangle, a circle counts as the square around it.
        let size = a.half + b.half + roundings + 2.0 * MARGIN;
        Some((size.x / along.max(1e-6)).min(size.y / across.max(1e-6)))
    }

    /// The stretches.
    pub fn boxes(&self) -> &[SweptBox] {
        &self.boxes
    }
}

struct Builder {
    heading: BodyHeading,
    /// Metres from the edge's origin to the end of the last stretch.
    s: f64,
    boxes: Vec<SweptBox>,
}

impl Builder {
    /// Adds a part of a curve as a stretch, or as several where it bends.
    fn add(&mut self, cubic: &Cubic, from: f64, to: f64) {
        let length = cubic.length(from, to);
        let middle = 0.5 * (from + to);
        let tangent = cubic.tangent(middle);
        let bend = [0.0, 0.25, 0.75, 1.0]
            .map(|part| angle_from(tangent, cubic.tangent(from + part * (to - from))))
            .into_iter()
            .fold(0.0, f64::max);
        if bend > BEND && length > SHORTEST {
            self.add(cubic, from, middle);
            self.add(cubic, middle, to);
            return;
        }
        // Between the samples the heading may differ a little more than at them.
        let turn = if bend == 0.0 { 0.0 } else { (1.25 * bend).sin().min(1.0) };
        let turn = if bend > BEND { 1.0 } else { turn };
        self.boxes.push(self.swept_box(cubic.point(middle), tangent, 0.5 * length, turn));
        self.s += length;
    }

    fn swept_box(&self, centre: DVec2, tangent: DVec2, half: f64, turn: f64) -> SweptBox {
        let angle = angle_of(tangent);
        let (heading, turns) = match self.heading {
            BodyHeading::Tangential => (angle, true),
            BodyHeading::Offset(offset) => (angle + offset, true),
            BodyHeading::Fixed(heading) => (heading, false),
        };
        // The path stays within this of the line through the middle, along and across it.
        let (along, across) = (half, half * turn);
        let (sin, cos) = (heading - angle).sin_cos();
        let offset = DVec2::new(
            along * cos.abs() + across * sin.abs(),
            along * sin.abs() + across * cos.abs(),
        );
        SweptBox {
            s: Span::new(self.s as f32, (self.s + 2.0 * half) as f32),
            centre: centre.as_vec2(),
            heading: DVec2::new(heading.cos(), heading.sin()).as_vec2(),
            offset: offset.as_vec2(),
            turn: if turns { turn as f32 } else { 0.0 },
        }
    }
}

/// Returns the angle of a direction, in radians in [-π, π].
fn angle_of(direction: DVec2) -> f64 {
    direction.y.atan2(direction.x)
}

/// Returns the absolute angle between two directions, in radians.
fn angle_from(a: DVec2, b: DVec2) -> f64 {
    let angle = a.perp_dot(b).atan2(a.dot(b)).abs();
    // Straight lines have no bend but rounding.
    if angle < 1e-6 { 0.0 } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a robot that drives along the x axis, 10 m long, touches one that stands near it.
    fn touches(step: f64, standing: SweptBox) -> bool {
        let robot = Footprint::rectangle(0.9, 0.6);
        let line = [0.0, 10.0 / 3.0, 20.0 / 3.0, 10.0].map(|x| DVec2::new(x, 0.0));
        let sweep = Sweep::with_step(BodyHeading::Tangential, [line], step);
        let standing = standing.rectangle(&robot);
        sweep.boxes().iter().any(|part| part.rectangle(&robot).touches(&standing))
    }

    #[test]
    fn long_stretches_of_a_straight_line_are_as_exact_as_short_ones() {
        let side_by_side = 0.6 + 2.0 * MARGIN;
        let behind = 10.0 + 0.9 + 2.0 * MARGIN;
        for step in [0.1, 1.0, 5.0] {
            for (x, y) in [(4.3, side_by_side), (behind, 0.0)] {
                let [nearer, farther] =
                    [-1e-3, 1e-3].map(|gap| SweptBox::standing(vec2(x, y) + gap, 0.0));
                assert!(touches(step, nearer) && !touches(step, farther), "{step} m: {x}, {y}");
            }
            let turned = SweptBox::disc(vec2(5.0, 0.3 + 0.45_f32.hypot(0.3)));
            assert!(touches(step, turned), "any heading, with a step of {step} m");
        }
    }

    /// A point at a distance from a place, in a direction of 16.
    fn beside(place: DVec2, metres: f32, direction: u32) -> Rectangle {
        let direction = Vec2::from_angle(std::f32::consts::TAU * direction as f32 / 16.0);
        Footprint::rectangle(0.0, 0.0).at(place.as_vec2() + metres * direction, Vec2::X)
    }

    #[test]
    fn a_stretch_holds_the_circle_at_each_pose_and_its_core_is_in_each() {
        let points = [(0.0, 0.0), (1.2, 0.2), (2.0, 1.2), (2.2, 2.4)];
        let curve = points.map(|(x, y)| DVec2::new(x, y));
        let (circle, cubic) = (Footprint::circle(0.9), Cubic::new(curve));
        let mut poses = 0;
        for heading in [BodyHeading::Tangential, BodyHeading::Offset(0.8), BodyHeading::Fixed(2.0)]
        {
            let sweep = Sweep::new(heading, [curve]);
            for pose in 0..=500 {
                let t = f64::from(pose) / 500.0;
                let (place, s) = (cubic.point(t), cubic_length(&cubic, t) as f32);
                for part in sweep.boxes().iter().filter(|part| part.s.contains(s)) {
                    let swept = part.rectangle(&circle);
                    assert!((0..16).all(|at| swept.touches(&beside(place, 0.45, at))));
                    let core = part.core(&circle).expect("a short stretch");
                    let apart = place.as_vec2().distance(core.centre) + core.rounding;
                    // Poses are exact to 1 mm.
                    assert!(core.half == Vec2::ZERO && apart <= 0.45 + MARGIN + 1e-3, "{apart}");
                    poses += 1;
                }
            }
        }
        assert!(poses > 1400, "{poses}");
    }

    /// The arc length up to a parameter, in metres, summed up of short parts.
    fn cubic_length(cubic: &Cubic, t: f64) -> f64 {
        (0..64)
            .map(|part| f64::from(part) / 64.0)
            .map(|at| cubic.length(at * t, (at + 1.0 / 64.0) * t))
            .sum()
    }

    #[test]
    fn a_heading_and_a_turn_cost_a_circle_no_room() {
        let circle = Footprint::circle(0.9);
        for place in [0.0, 0.4, 0.8].map(|angle| SweptBox::standing(Vec2::ZERO, angle)) {
            assert_eq!(place.rectangle(&circle).radius(), 0.45 + (2.0_f32).sqrt() * MARGIN);
        }
        let turning = SweptBox::disc(Vec2::ZERO).rectangle(&circle);
        assert!((0..16).all(|at| !turning.touches(&beside(DVec2::ZERO, 0.455, at))));
        assert!((0..16).all(|at| turning.touches(&beside(DVec2::ZERO, 0.4529, at))));
    }

    #[test]
    fn circles_follow_each_other_a_diameter_apart_whatever_their_heading() {
        let line = [0.0, 1.0, 2.0, 3.0].map(|x| DVec2::new(x, 0.0));
        let (circle, robot) = (Footprint::circle(0.9), Footprint::rectangle(1.2, 0.6));
        for heading in [BodyHeading::Tangential, BodyHeading::Fixed(0.6)] {
            let sweep = Sweep::new(heading, [line]);
            let circles = sweep.straight_separation(&circle, &circle).expect("a stretch");
            assert!((circles - 0.9 - 2.0 * MARGIN).abs() < 1e-6, "{circles}");
            let mixed = sweep.straight_separation(&circle, &robot).expect("a stretch");
            assert!(mixed >= 1.05 + 2.0 * MARGIN - 1e-6, "{mixed}");
        }
    }
}
