//! The robots of which lines were received.

use std::time::Duration;

use regatta_plugin::frame::{ColumnsMut, NO_EDGE, RobotState};

use crate::line::{LineFault, PoseLine};

/// The time over which mean speeds are computed; longer if the time between two lines is. The
/// jitter of datagrams is a millisecond or two, a large part of the time between two frames.
const SPEED_WINDOW: Duration = Duration::from_millis(100);
/// The time without lines after which a robot is considered standing.
const STANDS_AFTER: Duration = Duration::from_secs(2);
/// The speed up to which a robot is considered standing, in metres per second.
const STANDING: f32 = 0.01;

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    x: f32,
    y: f32,
    theta: f32,
    speed: f32,
    /// The position and the time at which the current mean of the speed starts.
    from_x: f32,
    from_y: f32,
    from_at: Duration,
    /// The time of the newest line; `None` if the robot is absent.
    updated_at: Option<Duration>,
}

/// The newest pose and the speed of every robot of which a line was received. Times are since any
/// fixed instant.
///
/// There is a row for each id up to the highest one, so that memory is bounded by the allowed
/// number of robots.
#[derive(Debug)]
pub struct Robots {
    rows: Vec<Robot>,
    max_robots: u32,
}

impl Robots {
    /// Creates an empty table for robots with ids below `max_robots`.
    pub fn new(max_robots: u32) -> Self {
        Self { rows: Vec::new(), max_robots }
    }

    /// Sets a robot's pose, with theta in radians in (-π, π].
    ///
    /// # Errors
    /// Returns [`LineFault::IdTooLarge`] if the id isn't allowed.
    pub fn update(&mut self, line: &PoseLine, now: Duration) -> Result<(), LineFault> {
        if line.id >= self.max_robots {
            return Err(LineFault::IdTooLarge);
        }
        let row = line.id as usize;
        self.rows.resize(self.rows.len().max(row + 1), Robot::default());
        let robot = &mut self.rows[row];
        let new = robot.updated_at.replace(now).is_none();
        (robot.x, robot.y, robot.theta) = (line.x, line.y, line.theta);
        let elapsed = now.saturating_sub(robot.from_at);
        if new || elapsed >= SPEED_WINDOW {
            robot.speed = if new { 0.0 } else { robot.mean_speed(elapsed) };
            (robot.from_x, robot.from_y, robot.from_at) = (line.x, line.y, now);
        }
        Ok(())
    }

    /// Makes robots absent of which no line was received for longer than `timeout`.
    pub fn forget(&mut self, timeout: Duration, now: Duration) {
        for robot in &mut self.rows {
            robot.updated_at =
                robot.updated_at.filter(|updated| now.saturating_sub(*updated) <= timeout);
        }
    }

    /// Returns the number of rows: the highest id received so far, plus one.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether no line was received yet.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns the numbers of standing and of driving robots.
    pub fn standing_and_driving(&self, now: Duration) -> (u32, u32) {
        let (mut standing, mut driving) = (0, 0);
        for robot in &self.rows {
            match robot.state(now) {
                RobotState::Driving => driving += 1,
                RobotState::Absent => {}
                _ => standing += 1,
            }
        }
        (standing, driving)
    }

    /// Writes all rows to a frame.
    pub fn write(&self, columns: &mut ColumnsMut<'_>, now: Duration) {
        for (row, robot) in self.rows.iter().enumerate() {
            let state = robot.state(now);
            columns.x[row] = robot.x;
            columns.y[row] = robot.y;
            columns.theta[row] = robot.theta;
            columns.speed[row] = if state == RobotState::Driving { robot.speed } else { 0.0 };
            columns.s[row] = 0.0;
            columns.edge[row] = NO_EDGE;
            columns.state[row] = state as u8;
        }
    }
}

impl Robot {
    /// Returns the distance since the mean started divided by the elapsed time; negative if the
    /// robot moved backwards.
    fn mean_speed(&self, elapsed: Duration) -> f32 {
        let [dx, dy] = [self.x - self.from_x, self.y - self.from_y].map(f64::from);
        let (sin, cos) = f64::from(self.theta).sin_cos();
        let speed = dx.hypot(dy).copysign(dx * cos + dy * sin) / elapsed.as_secs_f64();
        // The speed can overflow if a robot jumps across the range of an `f32`.
        if speed.is_finite() {
            speed.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
        } else {
            0.0
        }
    }

    fn state(&self, now: Duration) -> RobotState {
        match self.updated_at {
            None => RobotState::Absent,
            Some(updated)
                if now.saturating_sub(updated) <= STANDS_AFTER && self.speed.abs() > STANDING =>
            {
                RobotState::Driving
            }
            Some(_) => RobotState::Idle,
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{Columns, Line, frame_lines};

    use super::*;

    const MILLI: Duration = Duration::from_millis(1);

    fn line(id: u32, x: f32, theta: f32) -> PoseLine {
        PoseLine { id, x, y: 2.0, theta }
    }

    /// Returns the state and the speed of each row in a frame.
    fn rows(robots: &Robots, now: Duration) -> Vec<(RobotState, f32)> {
        let mut lines = vec![Line([7.0; 16]); frame_lines(robots.len())];
        robots.write(&mut ColumnsMut::split(&mut lines, robots.len()), now);
        let columns = Columns::split(&lines, robots.len()).expect("enough lines");
        assert!(
            columns.edge.iter().all(|&edge| edge == NO_EDGE) && columns.s.iter().all(|&s| s == 0.0)
        );
        columns
            .state
            .iter()
            .map(|&state| RobotState::from_number(state))
            .zip(columns.speed.iter().copied())
            .collect()
    }

    #[test]
    fn robots_without_a_line_are_absent() {
        let mut robots = Robots::new(10);
        robots.update(&line(2, 1.0, 0.0), MILLI).expect("an allowed id");
        assert_eq!(robots.update(&line(10, 1.0, 0.0), MILLI), Err(LineFault::IdTooLarge));
        let states: Vec<_> = rows(&robots, MILLI).into_iter().map(|(state, _)| state).collect();
        assert_eq!(states, [RobotState::Absent, RobotState::Absent, RobotState::Idle]);
        assert_eq!(robots.standing_and_driving(MILLI), (1, 0));
    }

    #[test]
    fn speed_is_distance_over_time_and_negative_backwards() {
        for (theta, speed) in [(0.0, 2.0), (core::f32::consts::PI, -2.0)] {
            let mut robots = Robots::new(1);
            // Every 20 ms, with a jitter of up to 2 ms.
            let times = (0..30).map(|i| MILLI * (i * 20 + i % 3));
            times.clone().for_each(|at| {
                robots.update(&line(0, at.as_secs_f32() * 2.0, theta), at).expect("an allowed id");
            });
            let [(state, measured)] = rows(&robots, MILLI * 600)[..] else { panic!("one robot") };
            assert!(state == RobotState::Driving && (measured - speed).abs() < 1e-4, "{measured}");
        }
    }

    #[test]
    fn a_robot_without_new_lines_stands_and_later_is_absent() {
        let mut robots = Robots::new(1);
        (0..30).for_each(|i| {
            robots.update(&line(0, i as f32, 0.0), MILLI * 20 * i).expect("an allowed id")
        });
        assert_eq!(rows(&robots, MILLI * 600)[0].0, RobotState::Driving);
        assert_eq!(rows(&robots, MILLI * 3_000), [(RobotState::Idle, 0.0)]);
        robots.forget(MILLI * 5_000, MILLI * 5_000);
        assert_eq!(rows(&robots, MILLI * 5_000)[0].0, RobotState::Idle);
        robots.forget(MILLI * 5_000, MILLI * 6_000);
        assert_eq!(rows(&robots, MILLI * 6_000)[0].0, RobotState::Absent);
        robots.update(&line(0, 900.0, 0.0), MILLI * 7_000).expect("an allowed id");
        assert_eq!(
            rows(&robots, MILLI * 7_000),
            [(RobotState::Idle, 0.0)],
            "its old position doesn't count"
        );
    }

    #[test]
    fn speeds_stay_finite_when_positions_jump() {
        let mut robots = Robots::new(1);
        for (i, x) in (0..).zip([f32::MIN, f32::MAX, f32::MIN_POSITIVE, f32::MIN, 0.0]) {
            robots
                .update(&PoseLine { id: 0, x, y: x, theta: x }, MILLI * i * 100)
                .expect("an allowed id");
            assert!(rows(&robots, MILLI * i * 100)[0].1.is_finite());
        }
    }
}
