//! Acceleration limits: a trapezoidal profile of speed, tick by tick.
//!
//! A robot with limit a changes its speed by at most A = a Δt a tick, and drives the whole tick at the new speed v.
//! Braking from v to u by A a tick, it covers (v² - u² + A (v - u)) / 2a until its speed is u. So it can be at u
//! after a distance d if it drives no faster now than
//!
//! ```text
//!     v = √((u + A/2)² + 2 a d) - A/2
//! ```
//!
//! Of everything ahead on its released base (a slower edge, a change of gear, the base's end) the lowest such v
//! counts. As d is common to all that lies beyond the end of the robot's piece, one number per row holds them all:
//! `brake` = min over k of (u_k + A/2)² + 2 a D_k, with D_k measured from the end of the piece. It changes only
//! when the robot comes to another piece or gets an order.
//!
//! What comes out: speed rises and falls by at most A a tick, except where an order takes away road that the robot
//! would need to brake on (cancel, assign), which makes it brake harder, as it never leaves its released base. Into
//! the end of its base it comes with a speed of at most A, and stands.

use regatta_plugin::frame::RobotState;

use super::{Motion, Onward, REVERSE, Rows};

/// Stands for a type's acceleration if it has no limit: finite, so that the equations hold, and beyond any use.
pub(crate) const UNLIMITED: f32 = 1e18;

/// The slowest that a robot with road ahead brakes to, as a part of A: so that rounding can't keep it off its end.
pub(super) const LAST_STEP: f32 = 1.0 / 16.0;

/// The fastest from which a robot can brake for what lies beyond its piece; `ahead` is its `w` in metres, ≤ 0.
pub(super) fn brake_speed(brake: f32, acceleration: f32, change: f32, ahead: f32) -> f32 {
    (brake - (acceleration + acceleration) * ahead).sqrt() - 0.5 * change
}

impl Motion {
    /// Works out `brake` of a row from its route. Must follow every change of its piece or route.
    pub(crate) fn look_ahead(&self, rows: &mut Rows, row: usize) {
        if rows.limits.is_none() {
            return;
        }
        let acceleration = self.types[usize::from(rows.kind[row])].max_acceleration;
        let brake = if acceleration.is_finite() {
            self.lowest_ahead(rows, row, f64::from(acceleration))
        } else {
            f64::INFINITY
        };
        if let Some(limits) = &mut rows.limits {
            limits.brake[row] = brake as f32;
        }
    }

    /// The minimum of the module's comment. Goes only as far as something there can still count.
    fn lowest_ahead(&self, rows: &Rows, row: usize, acceleration: f64) -> f64 {
        let half_step = 0.5 * acceleration * f64::from(self.pace.seconds);
        let square = |speed: f32, distance: f64| {
            let speed = f64::from(speed) + half_step;
            speed * speed + 2.0 * acceleration * distance
        };
        let mut onward = self.onward(rows, row);
        let mut gear = rows.piece[row] & REVERSE;
        let mut distance = self.roads.rest(rows.piece[row]);
        let mut lowest = f64::INFINITY;
        while 2.0 * acceleration * distance < lowest {
            let Ok(leg) = self.next_leg(&mut onward) else { return lowest.min(square(0.0, distance)) };
            let lane = self.roads.lane(leg);
            let turns = lane.first_piece & REVERSE != gear;
            let speed = if turns { 0.0 } else { self.lane_speed(rows.kind[row], leg) };
            lowest = lowest.min(square(speed, distance));
            distance += f64::from(lane.length);
            gear = lane.first_piece & REVERSE;
        }
        lowest
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
        let (a, dt, u) = (0.8f32, 0.02f32, 0.3f32);
        let change = a * dt;
        let brake = (u + 0.5 * change) * (u + 0.5 * change);
        let (mut ahead, mut speed) = (-3.0f32, f32::INFINITY);
        while ahead < 0.0 {
            let next = brake_speed(brake, a, change, ahead);
            assert!(speed.is_infinite() || (speed - next - change).abs() < 1e-4, "{speed} to {next}");
            speed = next;
            ahead += speed * dt;
        }
        assert!(speed - u <= change * 1.001, "{speed}");
    }
}
