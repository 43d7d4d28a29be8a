//! Traces a robot along the chords of its legs, and writes down the segments.

use glam::Vec2;

use super::Segment;
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
    position: Vec2,
    heading: Vec2,
    /// Angle from the heading that robots have on the edge to this robot's, as a unit vector.
    offset: Vec2,
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
        Self {
            now: 0.0,
            horizon,
            position: body.position,
            heading: body.heading,
            offset: Vec2::X,
            chords: &[],
            at: 0,
            s: 0.0,
            sign,
            first: segments.len(),
            segments,
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
        let is_forward = self.sign > 0.0;
        let behind = chords.partition_point(|chord| chord.end < s || is_forward && chord.end == s);
        self.at = behind.min(chords.len().saturating_sub(1));
        if let Some(edge_heading) = self.edge_heading() {
            let Vec2 { x: cos, y: sin } = edge_heading;
            self.offset = Vec2::new(cos, -sin).rotate(self.heading);
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
                self.push(step * speed, turn * speed, seconds * (part / metres));
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
            self.push(Vec2::ZERO, 0.0, rest);
        }
        if let Some(last) = self.segments.last_mut() {
            last.until = self.horizon;
        }
    }

    /// Returns the chord that the robot is on: its step, its turn, and the metres to its end.
    fn chord(&self) -> (Vec2, f32, f32) {
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
    fn push(&mut self, velocity: Vec2, turn_rate: f32, seconds: f32) {
        let until = self.now + seconds;
        let (position, heading) = (self.position, self.heading);
        match self.segments[self.first..].last_mut() {
            Some(last)
                if (last.turn_rate, turn_rate) == (0.0, 0.0)
                    && is_same(last.velocity, velocity)
                    && is_same(last.heading, heading) =>
            {
                last.until = until;
            }
            _ => self.segments.push(Segment { until, position, velocity, heading, turn_rate }),
        }
        self.position = position + velocity * seconds;
        self.now = until;
    }

    fn turn_to_edge(&mut self) {
        if let Some(edge_heading) = self.edge_heading() {
            self.heading = self.offset.rotate(edge_heading);
        }
    }

    /// Returns the heading that robots have at this one's place on the edge.
    fn edge_heading(&self) -> Option<Vec2> {
        let chord = self.chords.get(self.at)?;
        let start = before(self.chords, self.at);
        if chord.turn == 0.0 {
            return Some(chord.heading);
        }
        Some(heading(chord.turn * (self.s - start)).rotate(chord.start_heading))
    }
}

/// Returns the distance along the edge at which a chord starts, in metres.
fn before(chords: &[Chord], at: usize) -> f32 {
    at.checked_sub(1).map_or(f32::NEG_INFINITY, |at| chords[at].end)
}

/// Whether two vectors count as equal.
fn is_same(a: Vec2, b: Vec2) -> bool {
    (a - b).abs().max_element() <= SAME
}
