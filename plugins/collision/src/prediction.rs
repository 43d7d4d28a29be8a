//! Predicted trajectories: each robot continues along its edge at its present speed.
//!
//! A trajectory is a sequence of straight segments, each driven at a constant velocity and with a constant heading: one
//! for each chord of the edge that the robot reaches within the horizon. Whether two trajectories collide therefore has
//! an exact answer, without sampling instants.

use crate::body::Body;
use crate::edge_table::Chord;

/// The highest speed that is predicted, in metres per second: the highest that an edge may allow. Higher speeds count
/// as this one.
pub const MAX_SPEED: f32 = 50.0;

/// A straight segment of a trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    /// End of the segment, in seconds from now.
    pub until: f32,
    /// Position at which it starts, in metres.
    pub position: [f32; 2],
    /// Velocity, in metres per second.
    pub velocity: [f32; 2],
    /// Unit vector along the heading.
    pub heading: [f32; 2],
}

impl Segment {
    /// Returns the position at which it ends, given its start in seconds from now.
    pub(crate) fn end(&self, start: f32) -> [f32; 2] {
        let time = self.until - start;
        [self.position[0] + self.velocity[0] * time, self.position[1] + self.velocity[1] * time]
    }
}

/// A robot's motion along its edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeMotion<'edge_table> {
    /// Speed along the edge, in metres per second, at most [`MAX_SPEED`] either way; 0 if the robot stays put.
    pub speed: f32,
    /// Distance along the edge, in metres.
    pub s: f32,
    /// Chords of the edge; empty if the robot is on no edge and continues straight along its heading.
    pub chords: &'edge_table [Chord],
}

/// Appends a robot's trajectory from now to the horizon, in seconds: at least one segment.
///
/// The edge only determines the motion from the present pose: a pose beside the edge stays beside it, and a heading
/// that differs from the edge's keeps its angle to it.
pub(crate) fn predict(body: &Body, motion: EdgeMotion, horizon: f32, segments: &mut Vec<Segment>) {
    let EdgeMotion { speed, s, chords } = motion;
    let straight = |velocity| Segment { until: horizon, position: body.position, velocity, heading: body.heading };
    if speed == 0.0 {
        return segments.push(straight([0.0; 2]));
    }
    let straight_on = match chords {
        [] => Some(body.heading),
        [only] => Some(only.step),
        _ => s.is_nan().then_some(body.heading),
    };
    if let Some(step) = straight_on {
        return segments.push(straight(step.map(|part| part * speed)));
    }
    let mut at = chords.partition_point(|chord| chord.end <= s).min(chords.len() - 1);
    let offset = angle_between(body.heading, tangent(chords, at, s));
    let (mut s, mut now, mut position, mut heading) = (s, 0.0, body.position, body.heading);
    let seconds_per_metre = 1.0 / speed;
    loop {
        let chord = &chords[at];
        let end = if speed > 0.0 { chord.end } else { before(chords, at) };
        let until = (now + (end - s) * seconds_per_metre).max(now).min(horizon);
        let velocity = chord.step.map(|step| step * speed);
        segments.push(Segment { until, position, velocity, heading });
        let next = if speed > 0.0 { at + 1 } else { at.wrapping_sub(1) };
        if until >= horizon || next >= chords.len() {
            break;
        }
        let time = until - now;
        position = [position[0] + velocity[0] * time, position[1] + velocity[1] * time];
        (s, now, at) = (end, until, next);
        heading = rotate(offset, chords[at].heading);
    }
    if let Some(last) = segments.last_mut() {
        last.until = horizon;
    }
}

/// Returns the distance along the edge at which a chord starts, in metres.
fn before(chords: &[Chord], at: usize) -> f32 {
    at.checked_sub(1).map_or(f32::NEG_INFINITY, |at| chords[at].end)
}

/// Returns the edge's tangent at the distance `s` along it, which lies on the chord `at`.
fn tangent(chords: &[Chord], at: usize, s: f32) -> [f32; 2] {
    let (chord, start) = (&chords[at], before(chords, at));
    let Some(next) = chords.get(at + 1).filter(|_| start.is_finite()) else { return chord.tangent };
    let part = (s - start) / (chord.end - start);
    let mix = |axis: usize| chord.tangent[axis] + part * (next.tangent[axis] - chord.tangent[axis]);
    let mixed = [mix(0), mix(1)];
    let length = (mixed[0] * mixed[0] + mixed[1] * mixed[1]).sqrt();
    if length > 0.5 { mixed.map(|axis| axis / length) } else { chord.heading }
}

/// Returns the angle from `base` to `heading`, as a unit vector.
fn angle_between(heading: [f32; 2], base: [f32; 2]) -> [f32; 2] {
    [heading[0] * base[0] + heading[1] * base[1], heading[1] * base[0] - heading[0] * base[1]]
}

/// Rotates `base` by an angle given as a unit vector.
fn rotate(turn: [f32; 2], base: [f32; 2]) -> [f32; 2] {
    [base[0] * turn[0] - base[1] * turn[1], base[0] * turn[1] + base[1] * turn[0]]
}

#[cfg(test)]
mod tests;
