//! Acceleration limits: a trapezoidal profile of speed, tick by tick.
//!
//! A robot with limit a changes its speed evenly over a tick, from u to v, by at most A = a Δt; so it drives
//! (u + v) Δt / 2, just as in continuous time. With the distance d to a place where it may have speed e at most, it
//! must come out of the tick with v² ≤ e² + 2 a (d - (u + v) Δt / 2), to be able to brake for it:
//!
//! ```text
//!     v ≤ √(A (A/4 - u) + e² + 2 a d) - A/2
//! ```
//!
//! unless it passes that place within the tick anyway: then v ≤ e is enough. Of everything ahead on its released base
//! (a slower edge, a change of gear, the base's end) the lowest such v counts.
//!
//! For most rows the kernel does that with one number each: `brake` = min over k of e_k² + 2 a D_k, with D_k measured
//! from the end of the robot's leg, as the rest of d is common to all. It changes only when the robot comes to another
//! leg or gets an order. Rows that may come to the end of their leg in the tick are left as they are and listed, and
//! [`Motion::drive_on`] looks at each place ahead in turn.
//!
//! What comes out: speed changes by at most A a tick (and √(2 a 2⁻²⁶ m), which is what the grain of distances makes; at
//! 1 m/s² it is 0.2 mm/s), except where an order takes away road that the robot would need
//! to brake on (cancel, assign), which makes it brake harder, as it never leaves its released base. The robot stands
//! at the very end of its base, within the tick in which it comes there.

use regatta_plugin::frame::RobotState;

use super::{Motion, Onward, REVERSE, Rows};
use crate::graph::arc_length::Distance;

/// Stands for a type's acceleration if it has no limit: finite, so that the equations hold, and beyond any use.
pub(crate) const UNLIMITED: f32 = 1e18;

/// The slowest that a robot with road ahead brakes to, as a part of A: it has to get there.
pub(super) const LAST_STEP: f32 = 1.0 / 16.0;

/// The fastest that a robot may be after a tick that it begins at speed `before` with `ahead` metres to
/// the end of its leg, negative; `change` is A.
pub(super) fn brake_speed(brake: f32, acceleration: f32, change: f32, before: f32, ahead: f32) -> f32 {
    let square = change * (0.25 * change - before) + (brake - (acceleration + acceleration) * ahead);
    (square.max(0.0).sqrt() - 0.5 * change).max(LAST_STEP * change)
}

impl Motion {
    /// Works out `brake` of a row from its route. Must follow every change of its leg or route.
    pub(crate) fn look_ahead(&self, rows: &mut Rows, row: usize) {
        if rows.limits.is_none() {
            return;
        }
        let acceleration = self.types[usize::from(rows.kind[row])].max_acceleration;
        let mut lowest = f64::INFINITY;
        if acceleration.is_finite() {
            let twice = 2.0 * f64::from(acceleration);
            self.places_ahead(rows, row, |speed, distance| {
                lowest = lowest.min(speed * speed + twice * distance);
                twice * distance < lowest
            });
        }
        if let Some(limits) = &mut rows.limits {
            limits.brake[row] = lowest as f32;
        }
    }

    /// Drives a robot with a limit that may come to the end of its leg in this tick, as far as the tick goes: its
    /// `w` may be ≥ 0 then.
    pub(super) fn drive_on(&self, rows: &mut Rows, row: usize) {
        let before = rows.speed[row];
        let Some(limits) = &rows.limits else { return };
        let change = limits.acceleration[row] * self.pace.seconds;
        let wanted = (before + change).min(limits.cruise[row]).max(before - change);
        let limited = self.is_limited(rows.kind[row]);
        let now = if limited { wanted.min(self.allowed(rows, row, change)) } else { wanted };
        rows.speed[row] = now;
        rows.w[row] += (f64::from((before + now) * (0.5 * self.pace.units)) + 0.5) as i32;
    }

    /// The fastest that a robot may be after this tick, with each place ahead in view; `change` is A.
    fn allowed(&self, rows: &Rows, row: usize, change: f32) -> f32 {
        let twice = 2.0 * f64::from(self.types[usize::from(rows.kind[row])].max_acceleration);
        let change = f64::from(change);
        let spent = change * (0.25 * change - f64::from(rows.speed[row]));
        let ahead = Distance(rows.w[row]).to_metres() - f64::from(self.roads.rest(rows.piece[row]));
        let after = |square: f64| (spent + square).max(0.0).sqrt() - 0.5 * change;
        let mut lowest = f64::INFINITY;
        self.places_ahead(rows, row, |speed, distance| {
            let square = twice * (distance - ahead);
            lowest = lowest.min(after(speed * speed + square).max(speed));
            after(square) < lowest
        });
        lowest as f32
    }

    /// Shows every place ahead where a robot's speed is bounded, nearest first: the bound in m/s, and the distance from
    /// the end of its leg in metres. Ends with the base, or when `look` has seen enough and returns false.
    fn places_ahead(&self, rows: &Rows, row: usize, mut look: impl FnMut(f64, f64) -> bool) {
        let mut onward = self.onward(rows, row);
        let mut gear = rows.piece[row] & REVERSE;
        let mut distance = 0.0;
        loop {
            let Ok(leg) = self.next_leg(&mut onward) else {
                look(0.0, distance);
                return;
            };
            let lane = self.roads.lane(leg);
            let turns = lane.first_piece & REVERSE != gear;
            let speed = if turns { 0.0 } else { self.lane_speed(rows.kind[row], leg) };
            if !look(f64::from(speed), distance) {
                return;
            }
            distance += f64::from(lane.length);
            gear = lane.first_piece & REVERSE;
        }
    }

    /// Where a row's route goes on.
    pub(crate) fn onward(&self, rows: &Rows, row: usize) -> Onward {
        Onward {
            robot: rows.robot(row),
            route: rows.route[row],
            node: self.roads.node_ahead(rows.leg(row), rows.piece[row]),
            leg: rows.leg(row),
        }
    }

    /// Sets what a row's speed is to come to: its lane's, or nothing while it is held. Without a limit it has that
    /// speed at once.
    pub(super) fn command_speed(&self, rows: &mut Rows, row: usize, cruise: f32) {
        let wanted = if rows.is(row, RobotState::Held) { 0.0 } else { cruise };
        if let Some(limits) = &mut rows.limits {
            limits.cruise[row] = wanted;
        }
        if !self.is_limited(rows.kind[row]) {
            rows.speed[row] = wanted;
        }
    }

    /// Stands now, whatever the limit.
    pub(super) fn stop(&self, rows: &mut Rows, row: usize) {
        rows.speed[row] = 0.0;
        if let Some(limits) = &mut rows.limits {
            limits.cruise[row] = 0.0;
        }
    }

    /// Whether robots of a type have to take their time to change speed.
    pub(crate) fn is_limited(&self, kind: u16) -> bool {
        self.types[usize::from(kind)].max_acceleration.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equation of the module's comment, against braking tick by tick.
    #[test]
    fn braking_from_the_allowed_speed_arrives_at_the_wanted_one() {
        let (a, dt, end) = (0.8f32, 0.02f32, 0.3f32);
        let change = a * dt;
        let (mut ahead, mut speed) = (-3.0f32, (end * end + 2.0 * a * 3.0).sqrt());
        while ahead < 0.0 {
            let next = brake_speed(end * end, a, change, speed, ahead);
            assert!((speed - next - change).abs() < 1e-4, "{speed} to {next}");
            ahead += 0.5 * (speed + next) * dt;
            speed = next;
        }
        assert!(speed <= end * 1.0001 && speed > end - change, "{speed}");
    }
}
