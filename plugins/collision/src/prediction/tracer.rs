//! Traces a robot along the chords of its legs, and writes down the segments.

use super::{Segment, rotate};
use crate::body::Body;
use crate::edge_table::Chord;
use crate::heading::heading;

/// Two segments that differ by no more than this, in metres per second and in radians, are one.
const SAME: f32 = 1e-4;

/// A robot on its way.
pub(super) struct Tracer<'out, 'table> {
    /// Seconds from now.
    now: f32,
    horizon: f32,
    position: [f32; 2],
    heading: [f32; 2],
    /// Angle from the heading that robots have on the edge to this robot's, as a unit vector.
    offset: [f32; 2],
    /// Chords of the edge; empty if the robot is on none, and drives straight on.
    chords: &'table [Chord],
    /// Index of the chord that the robot is on.
    at: usize,
    /// Distance along the edge, in metres.
    s: f32,
    /// 1, or -1 in reverse gear.
    sign: f32,
    segments: &'out mut Vec<Segment>,
    /// Index of the trajectory's first segment.
    first: usize,
}

impl<'out, 'table> Tracer<'out, 'table> {
    /// Places a robot at the start of a trajectory that is appended to `segments`.
    pub(super) fn new(
        body: &Body,
        sign: f32,
        horizon: f32,
        segments: &'out mut Vec<Segment>,
    ) -> Self {
        let first = segments.len();
        let (position, heading) = (body.position, body.heading);
        let (now, offset) = (0.0, [1.0, 0.0]);
        Self {
            now,
            horizon,
            position,
            heading,
            offset,
            chords: &[],
            at: 0,
            s: 0.0,
            sign,
            segments,
            first,
        }
    }

    /// Returns the time until the horizon, in seconds.
    pub(super) fn rest(&self) -> f32 {
        self.horizon - self.now
    }

    /// Puts the robot on the edge with those chords, where it is now.
    pub(super) fn enter_at(&mut self, chords: &'table [Chord], s: f32) {
        (self.chords, self.s) = (chords, s);
        // In reverse gear, the chord behind a knot is the next one.
        let is_behind =
            |chord: &Chord| if self.sign > 0.0 { chord.end <= s } else { chord.end < s };
        self.at = chords.partition_point(is_behind).min(chords.len().saturating_sub(1));
        if let Some(edge_heading) = self.edge_heading() {
            self.offset = angle_between(self.heading, edge_heading);
        }
    }

    /// Puts the robot at the start of the next leg, on an edge of that length, with an unchanged
    /// angle to the heading that robots have on it.
    pub(super) fn enter_next(&mut self, chords: &'table [Chord], length: f32, sign: f32) {
        let offset = self.offset;
        self.sign = sign;
        self.enter_at(chords, if sign > 0.0 { 0.0 } else { length });
        self.offset = offset;
        self.turn_to_edge();
    }

    /// Drives so many metres in so many seconds, at a constant speed.
    pub(super) fn advance(&mut self, metres: f32, seconds: f32) {
        let (speed, mut left) = (self.sign * metres / seconds, metres);
        while left > 0.0 {
            let (step, turn, room) = self.chord();
            let part = left.min(room);
            if part > 0.0 {
                self.push(step.map(|axis| axis * speed), turn * speed, seconds * (part / metres));
            }
            (self.s, left) = (self.s + self.sign * part, left - part);
            if left > 0.0 {
                self.at = if self.sign > 0.0 { self.at + 1 } else { self.at - 1 };
                self.turn_to_edge();
            }
        }
    }

    /// Stands until the horizon, and ends the trajectory.
    pub(super) fn stand(&mut self) {
        let rest = self.rest();
        // The time that is left may be a rounding error of the phases.
        if self.segments.len() == self.first || rest > 1e-5 * self.horizon {
            self.push([0.0; 2], 0.0, rest);
        }
        if let Some(last) = self.segments.last_mut() {
            last.until = self.horizon;
        }
    }

    /// Returns the chord that the robot is on: its step, its turn, and the metres to its end.
    fn chord(&self) -> ([f32; 2], f32, f32) {
        match self.chords {
            [] => (self.heading, 0.0, f32::INFINITY),
            [only] => (only.step, 0.0, f32::INFINITY),
            chords => {
                let chord = &chords[self.at];
                let end = if self.sign > 0.0 { chord.end } else { before(chords, self.at) };
                (chord.step, chord.turn, ((end - self.s) * self.sign).max(0.0))
            }
        }
    }

    /// Appends a segment, or lengthens the last one.
    fn push(&mut self, velocity: [f32; 2], turn_rate: f32, seconds: f32) {
        let until = self.now + seconds;
        let (position, heading) = (self.position, self.heading);
        let differs =
            |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) > SAME;
        match self.segments[self.first..].last_mut() {
            Some(last)
                if (last.turn_rate, turn_rate) == (0.0, 0.0)
                    && !differs(last.velocity, velocity)
                    && !differs(last.heading, heading) =>
            {
                last.until = until;
            }
            _ => self.segments.push(Segment { until, position, velocity, heading, turn_rate }),
        }
        self.position = [position[0] + velocity[0] * seconds, position[1] + velocity[1] * seconds];
        self.now = until;
    }

    fn turn_to_edge(&mut self) {
        if let Some(edge_heading) = self.edge_heading() {
            self.heading = rotate(self.offset, edge_heading);
        }
    }

    /// Returns the heading that robots have on the edge where this one is.
    fn edge_heading(&self) -> Option<[f32; 2]> {
        let chord = self.chords.get(self.at)?;
        let start = before(self.chords, self.at);
        if chord.turn == 0.0 {
            return Some(chord.heading);
        }
        Some(rotate(heading(chord.turn * (self.s - start)), chord.start_heading))
    }
}

/// Returns the distance along the edge at which a chord starts, in metres.
fn before(chords: &[Chord], at: usize) -> f32 {
    at.checked_sub(1).map_or(f32::NEG_INFINITY, |at| chords[at].end)
}

/// Returns the angle from `base` to `heading`, as a unit vector.
fn angle_between(heading: [f32; 2], base: [f32; 2]) -> [f32; 2] {
    [heading[0] * base[0] + heading[1] * base[1], heading[1] * base[0] - heading[0] * base[1]]
}
