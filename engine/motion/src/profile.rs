//! Speeds: the variation of speeds, and acceleration limits.
//!
//! Limited robots follow a trapezoidal velocity profile, tick by tick.
//!
//! A robot with limit a changes its speed evenly over a tick, from u to v, by at most A = a Δt; so
//! it drives (u + v) Δt / 2, just as in continuous time. To be able to brake for a place at
//! distance d where its speed may be at most e, its speed after the tick must satisfy v² ≤ e² + 2 a
//! (d - (u + v) Δt / 2):
//!
//! ```text
//!     v ≤ √(A (A/4 - u) + e² + 2 a d) - A/2
//! ```
//!
//! unless it passes that place within the tick anyway: then v ≤ e is enough. The lowest such v of
//! everything ahead on its released base (a slower edge, a change of gear, a turn on the spot, the
//! base's end) counts.
//!
//! The base may end within a leg, at its limit: then distances on that leg are measured from the
//! limit, not from the leg's end (`base_end.rs`).
//!
//! For most rows the kernel needs a single number for this: `brake` = min over k of e_k² + 2 a D_k,
//! with D_k measured from the end of the robot's leg, because the rest of d is common to all. It
//! changes only when the robot enters another leg or gets a command. Rows that may reach the end of
//! their leg in the tick are listed instead of moved, and [`Motion::drive_near_leg_end`] examines
//! each place ahead in turn.
//!
//! As a result, speed changes by at most A a tick, plus √(2 a 2⁻²⁶ m) due to the resolution of
//! distances, which is 0.2 mm/s at 1 m/s². The exception is a command that takes away road that the
//! robot would need to brake on (cancel, assign): then it brakes harder, because it never leaves
//! its released base. The robot stops at the very end of its base, within the tick in which it gets
//! there.

use regatta_base::graph::EdgeIndex;
use regatta_base::random::mix;

use super::Motion;
use super::routes::RouteCursor;
use super::rows::Rows;

/// The limits of a robot type.
#[derive(Clone, Copy, Debug)]
pub struct KinematicLimits {
    /// Metres per second; infinity for no limit.
    pub max_speed: f32,
    /// Metres per second squared; infinity for no limit.
    pub max_acceleration: f32,
    /// Radians per second; 0 if the type can't turn on the spot.
    pub max_rotation_speed: f32,
    /// Radians per second squared; infinity for no limit.
    pub max_rotation_acceleration: f32,
}

impl KinematicLimits {
    /// Whether robots of the type turn on the spot.
    pub fn can_turn(&self) -> bool {
        self.max_rotation_speed > 0.0
    }
}

/// The variation of speeds: each robot drives each leg a little more slowly than it might.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedVariation {
    /// The largest part of its speed by which a robot is slower; 0 for no variation.
    pub most: f32,
    /// The seed of the random parts by robot and edge.
    pub seed: u64,
}

impl SpeedVariation {
    /// Returns the speed of a robot on an edge that it could drive at `speed`.
    pub fn apply(self, speed: f32, robot: u32, edge: EdgeIndex) -> f32 {
        if self.most == 0.0 {
            return speed;
        }
        let random = mix(self.seed ^ mix(u64::from(robot) << 32 | u64::from(edge.0)));
        speed * (1.0 - self.most * ((random >> 40) as f32 / (1u32 << 24) as f32))
    }
}

/// The acceleration in the columns of a type without a limit: finite, so that the equations hold,
/// and larger than any real one.
pub const UNLIMITED: f32 = 1e18;

/// The slowest speed that a robot with road ahead brakes to, as a fraction of A: it has to get
/// there.
pub(super) const LAST_STEP: f32 = 1.0 / 16.0;

/// The largest number of legs that a robot looks ahead for places to brake at. One that needs more
/// of them to stop drives as if its base ended there: random walks and loops never end, so that a
/// tiny acceleration would look ahead for ever.
const MAX_LEGS_AHEAD: usize = 256;

/// Returns the fastest speed that a robot may have after a tick that it begins at speed `before`
/// with `ahead` metres to the end of its leg, negative; `change` is A.
pub(super) fn brake_speed(
    brake: f32,
    acceleration: f32,
    change: f32,
    before: f32,
    ahead: f32,
) -> f32 {
    let square =
        change * (0.25 * change - before) + (brake - (acceleration + acceleration) * ahead);
    (square.max(0.0).sqrt() - 0.5 * change).max(LAST_STEP * change)
}

/// Returns the fastest speed after a tick that begins at speed `before`, from which a robot can
/// brake to a place: `square` is e² + 2 a d, and `change` is A.
fn speed_after(before: f64, change: f64, square: f64) -> f64 {
    (change * (0.25 * change - before) + square).max(0.0).sqrt() - 0.5 * change
}

impl Motion {
    /// Returns `brake` of a row with an acceleration limit.
    pub(super) fn brake(&self, rows: &Rows, row: usize, acceleration: f32) -> f32 {
        let twice = 2.0 * f64::from(acceleration);
        let mut lowest = f64::INFINITY;
        self.visit_speed_bounds(rows, row, |speed, distance| {
            lowest = lowest.min(speed * speed + twice * distance);
            twice * distance < lowest
        });
        lowest as f32
    }

    /// Drives a robot for a tick that may reach the end of its leg in it. Its `w` may be ≥ 0
    /// afterwards.
    pub(super) fn drive_near_leg_end(&self, rows: &mut Rows, row: usize) {
        let before = rows.speed[row];
        let Some(limits) = &rows.limits else { return };
        let change = limits.acceleration[row] * self.time_step.seconds;
        let wanted = (before + change).min(limits.cruise[row]).max(before - change);
        let limited = self.is_limited(rows.robot_type[row]);
        let now = if limited { wanted.min(self.allowed_speed(rows, row, change)) } else { wanted };
        rows.speed[row] = now;
        rows.w[row] += (f64::from((before + now) * (0.5 * self.time_step.units)) + 0.5) as i32;
    }

    /// Returns the fastest speed that a robot may have after this tick, given every place ahead;
    /// `change` is A.
    fn allowed_speed(&self, rows: &Rows, row: usize, change: f32) -> f32 {
        let twice =
            2.0 * f64::from(self.limits[usize::from(rows.robot_type[row])].max_acceleration);
        let before = f64::from(rows.speed[row]);
        let change = f64::from(change);
        let ahead = -self.distance_to_end(rows, row);
        let mut lowest = f64::INFINITY;
        self.visit_speed_bounds(rows, row, |speed, distance| {
            let square = twice * (distance - ahead);
            let bound = speed_after(before, change, speed * speed + square);
            lowest = lowest.min(bound.max(speed));
            speed_after(before, change, square) < lowest
        });
        lowest as f32
    }

    /// Calls `visit` for every place ahead that bounds a robot's speed, nearest first, with the
    /// bound in m/s and the distance in metres from the end of its leg, or of its base if that is
    /// on the leg. Ends with the base, after [`MAX_LEGS_AHEAD`], or when `visit` returns false.
    fn visit_speed_bounds(&self, rows: &Rows, row: usize, mut visit: impl FnMut(f64, f64) -> bool) {
        let mut cursor = self.route_cursor(rows, row);
        let mut gear = rows.piece.get(row).gear();
        let mut distance = 0.0;
        if self.plans.limit_on_leg(cursor.route).is_finite() {
            visit(0.0, distance);
            return;
        }
        for _ in 0..MAX_LEGS_AHEAD {
            let before = cursor.leg;
            let Ok(leg) = self.next_leg(&mut cursor) else { break };
            let compiled = self.legs.leg(leg);
            let robot_type = rows.robot_type[row];
            let stops =
                compiled.first_piece.gear() != gear || self.turns_between(robot_type, before, leg);
            let speed = if stops { 0.0 } else { self.leg_speed(rows, row, leg) };
            if !visit(f64::from(speed), distance) {
                return;
            }
            let limit = self.plans.limit_on_leg(cursor.route);
            distance += limit.min(f64::from(compiled.length));
            if limit.is_finite() {
                break;
            }
            gear = compiled.first_piece.gear();
        }
        visit(0.0, distance);
    }

    /// Returns the position on a row's route from which its next legs can be read.
    pub(super) fn route_cursor(&self, rows: &Rows, row: usize) -> RouteCursor {
        RouteCursor {
            robot: rows.robot(row),
            route: rows.route[row],
            node: self.legs.node_ahead(rows.leg(row), rows.piece.get(row)),
            leg: rows.leg(row),
        }
    }

    /// Sets the speed that a row accelerates or brakes to: 0 while it may not drive. Without a
    /// limit the row has that speed at once.
    pub(super) fn command_speed(&self, rows: &mut Rows, row: usize, cruise: f32) {
        let wanted = if rows.is_stopped(row) { 0.0 } else { cruise };
        if let Some(limits) = &mut rows.limits {
            limits.cruise[row] = wanted;
        }
        if !self.is_limited(rows.robot_type[row]) {
            rows.speed[row] = wanted;
        }
    }

    /// Stops a row now, whatever its limit.
    pub(super) fn stop(&self, rows: &mut Rows, row: usize) {
        rows.speed[row] = 0.0;
        if let Some(limits) = &mut rows.limits {
            limits.cruise[row] = 0.0;
        }
    }

    /// Whether a robot type limits its acceleration.
    pub(super) fn is_limited(&self, robot_type: u16) -> bool {
        self.limits[usize::from(robot_type)].max_acceleration.is_finite()
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
