//! The places at which two tracks touch: stretch by stretch, with circles around groups of them.

use glam::Vec2;

use super::{Footprint, Rectangle, Span, SweptBox};

/// The outlines of a footprint along a track.
#[derive(Clone, Debug)]
pub struct Outlines<'a> {
    boxes: &'a [SweptBox],
    rectangles: Vec<Rectangle>,
    /// Of each [`GROUP`] rectangles: a circle around them, so that most pairs are never looked at.
    circles: Vec<Circle>,
}

/// Rectangles that share a circle.
const GROUP: usize = 8;

#[derive(Clone, Copy, Debug)]
struct Circle {
    centre: Vec2,
    radius: f32,
}

impl Circle {
    /// Returns a circle around rectangles.
    fn around(rectangles: &[Rectangle]) -> Self {
        let middle = rectangles[rectangles.len() / 2].centre;
        let reaches = rectangles
            .iter()
            .map(|rectangle| middle.distance(rectangle.centre) + rectangle.radius());
        Self { centre: middle, radius: reaches.fold(0.0, f32::max) }
    }

    fn touches(&self, other: &Self) -> bool {
        self.centre.distance(other.centre) <= self.radius + other.radius
    }
}

/// The places at which robots on two tracks touch, in metres from the origins of the tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touching {
    /// The smallest span of the first track that holds them.
    pub own: Span,
    /// The same of the second track.
    pub other: Span,
    /// The largest distance between robots that touch, in metres along both tracks, if the first
    /// leads into the second; and if the second leads into the first.
    pub apart: [f32; 2],
    /// The largest difference of their places, if both tracks are the same.
    pub farthest: f32,
}

impl<'a> Outlines<'a> {
    /// Makes the outlines along the stretches of a track.
    pub fn new(boxes: &'a [SweptBox], footprint: &Footprint) -> Self {
        let rectangles: Vec<_> = boxes.iter().map(|part| part.rectangle(footprint)).collect();
        let circles = rectangles.chunks(GROUP).map(Circle::around).collect();
        Self { boxes, rectangles, circles }
    }

    /// One rectangle for each stretch, in their order.
    pub fn rectangles(&self) -> &[Rectangle] {
        &self.rectangles
    }

    fn length(&self) -> f32 {
        self.boxes.last().map_or(0.0, |last| last.s.high)
    }
}

/// Finds where robots on two tracks touch; `None` if they never do.
pub fn touching(a: &Outlines<'_>, b: &Outlines<'_>) -> Option<Touching> {
    let mut all = Touching::NONE;
    for (i, circle) in a.circles.iter().enumerate() {
        for (j, other) in b.circles.iter().enumerate() {
            if circle.touches(other) {
                touching_groups([a, b], [i, j], &mut all);
            }
        }
    }
    (all.own.low <= all.own.high).then_some(all)
}

/// Adds where robots within a group of stretches each touch.
fn touching_groups([a, b]: [&Outlines<'_>; 2], groups: [usize; 2], all: &mut Touching) {
    let lengths = [a.length(), b.length()];
    let [of_a, of_b] = groups.map(|group| GROUP * group);
    for (part, rectangle) in a.boxes.iter().zip(&a.rectangles).skip(of_a).take(GROUP) {
        let radius = rectangle.radius();
        for (other_part, other) in b.boxes.iter().zip(&b.rectangles).skip(of_b).take(GROUP) {
            let reach = radius + other.radius();
            if rectangle.centre.distance_squared(other.centre) <= reach * reach
                && rectangle.touches(other)
            {
                all.add(part.s, other_part.s, lengths);
            }
        }
    }
}

impl Touching {
    const NONE: Self =
        Self { own: Span::EMPTY, other: Span::EMPTY, apart: [0.0; 2], farthest: 0.0 };

    fn add(&mut self, own: Span, other: Span, lengths: [f32; 2]) {
        self.own = self.own.union(own);
        self.other = self.other.union(other);
        self.apart[0] = self.apart[0].max(lengths[0] - own.low + other.high);
        self.apart[1] = self.apart[1].max(lengths[1] - other.low + own.high);
        self.farthest = self.farthest.max(own.high - other.low).max(other.high - own.low);
    }
}
