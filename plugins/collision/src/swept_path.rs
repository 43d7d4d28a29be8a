//! Swept paths: summaries of trajectories that quickly show that two robots stay apart.

use glam::Vec2;

use crate::body::Body;
use crate::bounds::{Bounds, slack};
use crate::continuous::{ALWAYS, TimeWindow};
use crate::criteria::HYSTERESIS;
use crate::prediction::Segment;

/// The summary of a robot's trajectory through the horizon. Half a cache line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweptPath {
    /// Bounding box of all points that the robot may cover at a time that counts, with padding.
    pub bounds: Bounds,
    /// Mean velocity, in metres per second.
    pub mean_velocity: Vec2,
    /// Largest distance of the trajectory from a motion at the mean velocity, in metres.
    pub deviation: f32,
    /// Index of the trajectory's first segment in the list that it belongs to. Trajectories of a
    /// single segment are not stored there.
    pub first_segment: u32,
}

impl SweptPath {
    /// Returns the swept path of the trajectory that starts at `first_segment`. `now` is the
    /// bounding box of the present footprint with its padding.
    pub(crate) fn new(
        body: &Body,
        all_segments: &[Segment],
        first_segment: usize,
        now: Bounds,
    ) -> Self {
        let (segments, first_segment) = (&all_segments[first_segment..], first_segment as u32);
        if let Some(only) = only_straight_on(body, segments) {
            let swept =
                padded(around(only.position, only.end(0.0)), body.half_extent(body.heading));
            return Self {
                bounds: now.join(swept),
                mean_velocity: only.velocity,
                deviation: 0.0,
                first_segment,
            };
        }
        // Any other robot may turn any of its sides outwards.
        let mut all = around(body.position, body.position);
        let (mut end, mut until) = (body.position, 0.0);
        for segment in segments {
            end = segment.end(until);
            until = segment.until;
            all = all.join(around(end, end));
        }
        let mean_velocity = (end - body.position) / until;
        let mut square = 0.0_f32;
        for pair in segments.windows(2) {
            let off = pair[1].position - body.position - mean_velocity * pair[0].until;
            square = square.max(off.length_squared());
        }
        let bounds = now.join(padded(all, Vec2::splat(body.radius())));
        Self { bounds, mean_velocity, deviation: square.sqrt(), first_segment }
    }
}

/// Returns the segment of a robot that only drives straight on and keeps its heading. At the end of
/// its leg, a robot may take another heading at once: that of the next leg.
pub(crate) fn only_straight_on<'all>(
    body: &Body,
    segments: &'all [Segment],
) -> Option<&'all Segment> {
    match segments {
        [only] if only.turn_rate == 0.0 && only.heading == body.heading => Some(only),
        _ => None,
    }
}

fn around(a: Vec2, b: Vec2) -> Bounds {
    Bounds::new(a.min(b), a.max(b))
}

/// Returns the bounding box of a trajectory padded by the footprint, the hysteresis and the
/// rounding errors.
fn padded(path: Bounds, half: Vec2) -> Bounds {
    let (west, south, east, north) = (path.west(), path.south(), path.east(), path.north());
    let padding = HYSTERESIS as f32 + slack(west) + slack(east) + slack(south) + slack(north);
    let half = half + padding;
    Bounds::new(Vec2::new(west, south) - half, Vec2::new(east, north) + half)
}

/// Returns the only segment of a robot that drives straight on.
pub(crate) fn straight_on(body: &Body, swept_path: &SweptPath, horizon: f32) -> Segment {
    let (position, velocity, heading) = (body.position, swept_path.mean_velocity, body.heading);
    Segment { until: horizon, position, velocity, heading, turn_rate: 0.0 }
}

/// The relative motion of two bounding circles, each of which moves at its robot's mean velocity
/// and is large enough to hold the robot all the time. In single precision, with allowance for its
/// rounding errors; without branches, which would often be mispredicted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach {
    /// Position of the second robot relative to the first, in metres.
    offset: Vec2,
    /// Velocity of the second robot relative to the first, in metres per second.
    velocity: Vec2,
    /// Sum of the radii of both footprints, in metres, plus the largest rounding error.
    radii: f32,
    /// Sum of the deviations of both trajectories, in metres.
    deviations: f32,
}

impl Approach {
    pub(crate) fn of((a, swept_a): (&Body, &SweptPath), (b, swept_b): (&Body, &SweptPath)) -> Self {
        let [far_a, far_b] = [a, b].map(|body| body.position.x.abs() + body.position.y.abs());
        Self {
            offset: b.position - a.position,
            velocity: swept_b.mean_velocity - swept_a.mean_velocity,
            radii: a.radius() + b.radius() + 0.01 + 1e-6 * (far_a + far_b),
            deviations: swept_a.deviation + swept_b.deviation,
        }
    }

    /// Whether the footprints may be within some metres of each other now.
    pub(crate) fn is_near(&self, metres: f32) -> bool {
        let reach = self.radii + metres;
        self.offset.length_squared() <= reach * reach
    }

    /// Whether the footprints may come within some metres of each other in that many seconds.
    pub(crate) fn comes_near(&self, metres: f32, seconds: f32) -> bool {
        let reach = self.radii + self.deviations + metres;
        let time = self.time_of_closest_approach();
        let time = if time > 0.0 { time } else { 0.0 };
        let time = if time < seconds { time } else { seconds };
        (self.offset + self.velocity * time).length_squared() <= reach * reach
    }

    /// Returns the time in which the footprints may be within some metres of each other.
    pub(crate) fn when_near(&self, metres: f32) -> TimeWindow {
        let reach = self.radii + self.deviations + metres;
        let (square, cross) = (self.velocity.length_squared(), self.offset.perp_dot(self.velocity));
        // Half of the time in which the circles are within reach, before and after the closest
        // approach.
        let half = ((reach * reach * square - cross * cross).max(0.0)).sqrt() / square;
        let middle = self.time_of_closest_approach();
        if square < MIN_SQUARED_SPEED {
            ALWAYS
        } else {
            TimeWindow { from: middle - half, to: middle + half }
        }
    }

    /// Returns the time of closest approach, in seconds from now; an arbitrary number without
    /// relative motion.
    fn time_of_closest_approach(&self) -> f32 {
        let square = self.velocity.length_squared();
        let square = if square < MIN_SQUARED_SPEED { MIN_SQUARED_SPEED } else { square };
        -self.offset.dot(self.velocity) / square
    }
}

/// The square of the lowest relative speed that counts as motion, in m²/s².
const MIN_SQUARED_SPEED: f32 = 1e-12;

/// Returns the segments of a trajectory by its index among the swept paths; empty if the robot
/// drives straight on.
pub(crate) fn segments_of<'all>(
    number: usize,
    swept_paths: &[SweptPath],
    segments: &'all [Segment],
) -> &'all [Segment] {
    let Some(swept_path) = swept_paths.get(number) else { return &[] };
    let end =
        swept_paths.get(number + 1).map_or(segments.len(), |next| next.first_segment as usize);
    &segments[swept_path.first_segment as usize..end]
}
