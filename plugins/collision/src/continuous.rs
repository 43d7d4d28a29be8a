//! Continuous collision detection: whether the footprints of two predicted robots come to overlap.

use glam::DVec2;

use crate::body::{Body, Outline, between};
use crate::prediction::Segment;
use crate::relative_motion::{Inflations, Proximity, RelativeMotion};

/// A window of time, in seconds from now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeWindow {
    pub from: f32,
    pub to: f32,
}

/// The time window of [`closest_proximity`] that covers the whole trajectories, in seconds from
/// now.
pub(crate) const ALWAYS: TimeWindow = TimeWindow { from: 0.0, to: f32::INFINITY };

/// The largest distance in metres between a point of a turning robot and its assumed position.
const MAX_TURN_ERROR: f64 = 0.01;

/// Returns the closest proximity of two robots on their trajectories, as they are and with both
/// inflated by some metres on all sides. No instants are sampled: the result is exact for robots
/// that drive straight on, and to [`MAX_TURN_ERROR`] for turning ones. Only segments within the
/// time window are examined.
pub(crate) fn closest_proximity(
    (a, segments_a): (&Body, &[Segment]),
    (b, segments_b): (&Body, &[Segment]),
    window: TimeWindow,
    inflation: f64,
) -> Proximity {
    let reach = a.radius() + b.radius() + 2.0 * inflation as f32;
    let mut cursor_a = TrajectoryCursor { segments: segments_a, start: 0.0 };
    let mut cursor_b = TrajectoryCursor { segments: segments_b, start: 0.0 };
    let (mut now, mut proximity) = (0.0, Proximity::Apart);
    while let ([segment_a, ..], [segment_b, ..]) = (cursor_a.segments, cursor_b.segments)
        && now <= window.to
    {
        let until = segment_a.until.min(segment_b.until);
        if until >= window.from {
            let pass = Pass {
                a: (segment_a, now - cursor_a.start),
                b: (segment_b, now - cursor_b.start),
                seconds: until - now,
            };
            if !pass.is_far(reach) {
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
    /// The segment of the second robot.
    b: (&'segments Segment, f32),
    /// Duration, in seconds.
    seconds: f32,
}

impl Pass<'_> {
    fn proximity(&self, bodies: (&Body, &Body), inflation: f64, reach: f32) -> Proximity {
        let error = self.turn_error(bodies);
        if error <= MAX_TURN_ERROR {
            return self
                .proximity_without_turn(bodies, Inflations { overlapping: 0.0, near: inflation });
        }
        // Larger by the error, robots at their mean heading hold themselves at all headings of the
        // pass; smaller, they are held by themselves.
        let inflations = Inflations { overlapping: -error, near: inflation + 0.5 * error };
        match self.proximity_without_turn(bodies, inflations) {
            Proximity::Near => self.proximity_of_halves(bodies, inflation, reach),
            certain => certain,
        }
    }

    fn proximity_of_halves(&self, bodies: (&Body, &Body), inflation: f64, reach: f32) -> Proximity {
        let mut proximity = Proximity::Apart;
        for half in self.halves() {
            if proximity < Proximity::Overlap && !half.is_far(reach) {
                proximity = proximity.max(half.proximity(bodies, inflation, reach));
            }
        }
        proximity
    }

    /// Returns the largest sum of the distances by which a turn in the pass moves a point of both
    /// robots from where it is at the mean heading, in metres.
    fn turn_error(&self, (a, b): (&Body, &Body)) -> f64 {
        let [error_a, error_b] = [(self.a.0, a), (self.b.0, b)].map(|(segment, body)| {
            let turns = segment.turn_rate != 0.0 && !body.is_circle();
            let radius = if turns { body.radius() } else { 0.0 };
            0.5 * (segment.turn_rate * self.seconds).abs() * radius
        });
        f64::from(error_a + error_b)
    }

    fn halves(self) -> [Self; 2] {
        let seconds = 0.5 * self.seconds;
        let [a, b] = [self.a, self.b].map(|(segment, elapsed)| (segment, elapsed + seconds));
        [Self { seconds, ..self }, Self { a, b, seconds }]
    }

    /// Returns the proximity if both keep their mean headings, with the inflations of
    /// [`Proximity::of`].
    fn proximity_without_turn(&self, (a, b): (&Body, &Body), inflations: Inflations) -> Proximity {
        let motion = self.motion();
        let [heading_a, heading_b] = [self.a, self.b].map(|(segment, elapsed)| {
            segment.heading_after(elapsed + 0.5 * self.seconds).as_dvec2()
        });
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
                let distance = motion.distance(DVec2::ZERO);
                Proximity::of(inflations, |inflation| distance <= a + b + 2.0 * inflation)
            }
        }
    }

    /// Whether they stay farther apart than `reach` along an axis, which cheaply excludes most
    /// pairs. In single precision, with allowance for its rounding errors.
    fn is_far(&self, reach: f32) -> bool {
        let ((a, elapsed_a), (b, elapsed_b)) = (self.a, self.b);
        let offset = b.position - a.position + b.velocity * elapsed_b - a.velocity * elapsed_a;
        let motion = (b.velocity - a.velocity) * self.seconds;
        let rounding = 0.01 + 1e-6 * (a.position.abs() + b.position.abs());
        let limit = reach + 0.5 * motion.abs() + rounding;
        (offset + 0.5 * motion).abs().cmpgt(limit).any()
    }

    fn motion(&self) -> RelativeMotion {
        let ((a, _), (b, _)) = (self.a, self.b);
        let [driven_a, driven_b] = [self.a, self.b]
            .map(|(segment, elapsed)| segment.velocity.as_dvec2() * f64::from(elapsed));
        RelativeMotion {
            offset: between(a.position, b.position) + driven_b - driven_a,
            displacement: between(a.velocity, b.velocity) * f64::from(self.seconds),
        }
    }
}

#[cfg(test)]
mod tests;
