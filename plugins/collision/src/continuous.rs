//! Continuous collision detection: whether the footprints of two predicted robots come to overlap.

use crate::body::{Body, Outline, between, wide};
use crate::prediction::Segment;
use crate::relative_motion::{Proximity, RelativeMotion};

/// The time window of [`closest_proximity`] that covers the whole trajectories, in seconds from
/// now.
pub(crate) const ALWAYS: [f32; 2] = [0.0, f32::INFINITY];

/// The largest distance between a point of a turning robot and where it is assumed to be, in
/// metres.
const MAX_TURN_ERROR: f64 = 0.01;

/// Returns the closest proximity of two robots on their trajectories, as they are and with both
/// inflated by some metres on all sides. No instants are sampled: the result is exact for robots
/// that drive straight on, and to [`MAX_TURN_ERROR`] for turning ones. Only segments within the
/// time window `[from, to]`, in seconds from now, are examined.
pub(crate) fn closest_proximity(
    (a, segments_a): (&Body, &[Segment]),
    (b, segments_b): (&Body, &[Segment]),
    [from, to]: [f32; 2],
    inflation: f64,
) -> Proximity {
    let reach = a.radius() + b.radius() + 2.0 * inflation as f32;
    let mut cursor_a = TrajectoryCursor { segments: segments_a, start: 0.0 };
    let mut cursor_b = TrajectoryCursor { segments: segments_b, start: 0.0 };
    let (mut now, mut proximity) = (0.0, Proximity::Apart);
    while let ([segment_a, ..], [segment_b, ..]) = (cursor_a.segments, cursor_b.segments)
        && now <= to
    {
        let until = segment_a.until.min(segment_b.until);
        if until >= from {
            let pass = Pass {
                a: (segment_a, now - cursor_a.start),
                b: (segment_b, now - cursor_b.start),
                seconds: until - now,
            };
            if !(pass.is_far(0, reach) | pass.is_far(1, reach)) {
                proximity = proximity.max(pass.proximity((a, b), inflation, reach));
            }
            if proximity == Proximity::Overlap {
                return proximity;
            }
        }
        cursor_a.advance(until);
        cursor_b.advance(until);
        now = until;
    }
    proximity
}

/// The rest of a trajectory, and the time at which its first segment started, in seconds from now.
struct TrajectoryCursor<'segments> {
    segments: &'segments [Segment],
    start: f32,
}

impl TrajectoryCursor<'_> {
    fn advance(&mut self, now: f32) {
        if let [segment, rest @ ..] = self.segments
            && segment.until <= now
        {
            (self.segments, self.start) = (rest, now);
        }
    }
}

/// The part of two trajectories in which both robots drive straight, and turn evenly.
#[derive(Clone, Copy)]
struct Pass<'segments> {
    /// Segment of the first robot, and the seconds since it started.
    a: (&'segments Segment, f32),
    /// Segment of the second robot, likewise.
    b: (&'segments Segment, f32),
    /// Duration, in seconds.
    seconds: f32,
}

impl Pass<'_> {
    fn proximity(&self, bodies: (&Body, &Body), inflation: f64, reach: f32) -> Proximity {
        let error = self.turn_error(bodies);
        if error <= MAX_TURN_ERROR {
            return self.proximity_without_turn(bodies, [0.0, inflation]);
        }
        // Larger by the error, robots at their mean heading hold themselves at all headings of the
        // pass; smaller, they are held by themselves.
        match self.proximity_without_turn(bodies, [-error, inflation + 0.5 * error]) {
            Proximity::Near => self.proximity_of_halves(bodies, inflation, reach),
            certain => certain,
        }
    }

    fn proximity_of_halves(&self, bodies: (&Body, &Body), inflation: f64, reach: f32) -> Proximity {
        let mut proximity = Proximity::Apart;
        for half in self.halves() {
            if proximity < Proximity::Overlap && !(half.is_far(0, reach) | half.is_far(1, reach)) {
                proximity = proximity.max(half.proximity(bodies, inflation, reach));
            }
        }
        proximity
    }

    /// Returns the largest sum of the distances by which a turn in the pass moves a point of both
    /// robots from where it is at the mean heading, in metres.
    fn turn_error(&self, (a, b): (&Body, &Body)) -> f64 {
        let error = |segment: &Segment, body: &Body| {
            let radius =
                if segment.turn_rate == 0.0 || body.is_circle() { 0.0 } else { body.radius() };
            0.5 * (segment.turn_rate * self.seconds).abs() * radius
        };
        f64::from(error(self.a.0, a) + error(self.b.0, b))
    }

    fn halves(self) -> [Self; 2] {
        let seconds = 0.5 * self.seconds;
        let later = |(segment, elapsed)| (segment, elapsed + seconds);
        [Self { seconds, ..self }, Self { a: later(self.a), b: later(self.b), seconds }]
    }

    /// Returns the proximity if both keep their mean headings, with the inflations of
    /// [`Proximity::of`].
    fn proximity_without_turn(&self, (a, b): (&Body, &Body), inflations: [f64; 2]) -> Proximity {
        let motion = self.motion();
        let heading = |(segment, elapsed): (&Segment, f32)| {
            segment.heading_after(elapsed + 0.5 * self.seconds)
        };
        let (heading_a, heading_b) = (wide(heading(self.a)), wide(heading(self.b)));
        match (a.outline(), b.outline()) {
            (Outline::Rectangle(half_a), Outline::Rectangle(half_b)) => {
                motion.rectangles((half_a, heading_a), (half_b, heading_b), inflations)
            }
            (Outline::Rectangle(half), Outline::Circle(radius)) => {
                Proximity::of(inflations, |inflation| {
                    motion.seen_along(heading_a).hits_rectangle(half, radius, inflation)
                })
            }
            (Outline::Circle(radius), Outline::Rectangle(half)) => {
                Proximity::of(inflations, |inflation| {
                    motion.seen_along(heading_b).hits_rectangle(half, radius, inflation)
                })
            }
            (Outline::Circle(a), Outline::Circle(b)) => {
                let distance = motion.distance([0.0; 2]);
                Proximity::of(inflations, |inflation| distance <= a + b + 2.0 * inflation)
            }
        }
    }

    /// Whether they stay farther apart than `reach` along an axis, which cheaply excludes most
    /// pairs. In single precision, with allowance for its rounding errors.
    fn is_far(&self, axis: usize, reach: f32) -> bool {
        let ((a, elapsed_a), (b, elapsed_b)) = (self.a, self.b);
        let offset = b.position[axis] - a.position[axis] + b.velocity[axis] * elapsed_b
            - a.velocity[axis] * elapsed_a;
        let motion = (b.velocity[axis] - a.velocity[axis]) * self.seconds;
        let rounding = 0.01 + 1e-6 * (a.position[axis].abs() + b.position[axis].abs());
        (offset + 0.5 * motion).abs() > reach + 0.5 * motion.abs() + rounding
    }

    fn motion(&self) -> RelativeMotion {
        let ((a, elapsed_a), (b, elapsed_b)) = (self.a, self.b);
        let (offset, velocity) = (between(a.position, b.position), between(a.velocity, b.velocity));
        let displacement = |segment: &Segment, axis: usize, elapsed: f32| {
            f64::from(segment.velocity[axis]) * f64::from(elapsed)
        };
        let here = |axis: usize| {
            offset[axis] + displacement(b, axis, elapsed_b) - displacement(a, axis, elapsed_a)
        };
        RelativeMotion {
            offset: [here(0), here(1)],
            displacement: velocity.map(|speed| speed * f64::from(self.seconds)),
        }
    }
}

#[cfg(test)]
mod tests;
