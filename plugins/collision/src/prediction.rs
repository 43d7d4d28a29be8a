//! Where robots will be: on along their edge at their speed.
//!
//! A prediction is a row of straight pieces, each driven at a constant velocity and with a constant heading, one for
//! each chord of the edge that the robot comes to within the horizon. So whether two of them meet can be told exactly,
//! not only at some instants.

use crate::body::Body;
use crate::path::Chord;

/// Fastest that a robot is expected to go, in metres per second: the fastest that an edge may allow. One that claims
/// more counts as that fast.
pub const MAX_SPEED: f32 = 50.0;

/// A straight piece of a prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Seconds from now when it ends.
    pub until: f32,
    /// Where it starts.
    pub place: [f32; 2],
    /// Metres per second.
    pub velocity: [f32; 2],
    /// Unit vector along the heading.
    pub heading: [f32; 2],
}

impl Piece {
    /// Where it ends, if it starts that many seconds from now.
    pub(crate) fn end(&self, start: f32) -> [f32; 2] {
        let time = self.until - start;
        [self.place[0] + self.velocity[0] * time, self.place[1] + self.velocity[1] * time]
    }
}

/// How a robot drives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive<'paths> {
    /// Metres per second along the edge, at most [`MAX_SPEED`] either way; 0 if it stays put.
    pub speed: f32,
    /// Metres along the edge.
    pub s: f32,
    /// The edge; nothing if it is on none, and goes straight on along its heading.
    pub chords: &'paths [Chord],
}

/// Adds a robot's pieces from now to the horizon, in seconds; at least one.
///
/// The edge only says how the robot moves from where it is: a pose beside its edge stays beside it, and a heading
/// that isn't the edge's keeps its angle to it.
pub(crate) fn predict(body: &Body, drive: Drive, horizon: f32, pieces: &mut Vec<Piece>) {
    let Drive { speed, s, chords } = drive;
    let straight = |velocity| Piece { until: horizon, place: body.place, velocity, heading: body.heading };
    if speed == 0.0 {
        return pieces.push(straight([0.0; 2]));
    }
    let straight_on = match chords {
        [] => Some(body.heading),
        [only] => Some(only.step),
        _ => s.is_nan().then_some(body.heading),
    };
    if let Some(step) = straight_on {
        return pieces.push(straight(step.map(|part| part * speed)));
    }
    let mut at = chords.partition_point(|chord| chord.end <= s).min(chords.len() - 1);
    let turned = untwist(body.heading, tangent(chords, at, s));
    let (mut s, mut now, mut place, mut heading) = (s, 0.0, body.place, body.heading);
    let seconds_per_metre = 1.0 / speed;
    loop {
        let chord = &chords[at];
        let end = if speed > 0.0 { chord.end } else { before(chords, at) };
        let until = (now + (end - s) * seconds_per_metre).max(now).min(horizon);
        let velocity = chord.step.map(|step| step * speed);
        pieces.push(Piece { until, place, velocity, heading });
        let next = if speed > 0.0 { at + 1 } else { at.wrapping_sub(1) };
        if until >= horizon || next >= chords.len() {
            break;
        }
        let time = until - now;
        place = [place[0] + velocity[0] * time, place[1] + velocity[1] * time];
        (s, now, at) = (end, until, next);
        heading = twist(turned, chords[at].heading);
    }
    if let Some(last) = pieces.last_mut() {
        last.until = horizon;
    }
}

/// Metres along the edge where a chord starts.
fn before(chords: &[Chord], at: usize) -> f32 {
    at.checked_sub(1).map_or(f32::NEG_INFINITY, |at| chords[at].end)
}

/// The edge's tangent at `s`, on that chord.
fn tangent(chords: &[Chord], at: usize, s: f32) -> [f32; 2] {
    let (chord, start) = (&chords[at], before(chords, at));
    let Some(next) = chords.get(at + 1).filter(|_| start.is_finite()) else { return chord.tangent };
    let part = (s - start) / (chord.end - start);
    let mix = |axis: usize| chord.tangent[axis] + part * (next.tangent[axis] - chord.tangent[axis]);
    let mixed = [mix(0), mix(1)];
    let length = (mixed[0] * mixed[0] + mixed[1] * mixed[1]).sqrt();
    if length > 0.5 { mixed.map(|axis| axis / length) } else { chord.heading }
}

/// The angle from `base` to `heading`, as a unit vector.
fn untwist(heading: [f32; 2], base: [f32; 2]) -> [f32; 2] {
    [heading[0] * base[0] + heading[1] * base[1], heading[1] * base[0] - heading[0] * base[1]]
}

/// `base`, turned by such an angle.
fn twist(turn: [f32; 2], base: [f32; 2]) -> [f32; 2] {
    [base[0] * turn[0] - base[1] * turn[1], base[0] * turn[1] + base[1] * turn[0]]
}
