//! The robots that were heard of.

use std::time::Duration;

use regatta_plugin::frame::{ColumnsMut, NO_EDGE, RobotState};

use crate::line::{LineFault, PoseLine};

/// Speeds are means over this time, or over the time between two lines if that is longer: datagrams come a
/// millisecond or two early or late, which is much of the time between two frames.
const SPEED_WINDOW: Duration = Duration::from_millis(100);
/// A robot not heard of for so long is taken to stand.
const STANDS_AFTER: Duration = Duration::from_secs(2);
/// A robot slower than this, in m/s, stands.
const STANDING: f32 = 0.01;

#[derive(Clone, Copy, Debug, Default)]
struct Robot {
    x: f32,
    y: f32,
    theta: f32,
    speed: f32,
    /// Where the mean of its speed starts.
    from: [f32; 2],
    from_at: Duration,
    heard_at: Option<Duration>,
}

/// The newest pose of every robot that was heard of, and its speed. Times are since any one moment.
///
/// There is a row for each id up to the highest, so memory is bounded by the number of robots allowed.
#[derive(Debug)]
pub struct Robots {
    rows: Vec<Robot>,
    most: u32,
}

impl Robots {
    /// Nobody yet, and `most` robots in the end.
    pub fn new(most: u32) -> Self {
        Self { rows: Vec::new(), most }
    }

    /// Takes a robot's pose, with theta in radians in (-π, π].
    ///
    /// # Errors
    /// [`LineFault::IdTooLarge`] if there is no room for that id.
    pub fn hear(&mut self, line: &PoseLine, now: Duration) -> Result<(), LineFault> {
        if line.id >= self.most {
            return Err(LineFault::IdTooLarge);
        }
        let row = line.id as usize;
        self.rows.resize(self.rows.len().max(row + 1), Robot::default());
        let robot = &mut self.rows[row];
        let new = robot.heard_at.replace(now).is_none();
        (robot.x, robot.y, robot.theta) = (line.x, line.y, line.theta);
        if new {
            (robot.from, robot.from_at, robot.speed) = ([line.x, line.y], now, 0.0);
        }
        let elapsed = now.saturating_sub(robot.from_at);
        if elapsed >= SPEED_WINDOW {
            robot.speed = robot.mean_speed(elapsed);
            (robot.from, robot.from_at) = ([line.x, line.y], now);
        }
        Ok(())
    }

    /// Forgets robots that were not heard of for so long.
    pub fn forget(&mut self, silence: Duration, now: Duration) {
        let gone = |robot: &Robot| robot.heard_at.is_some_and(|heard| now.saturating_sub(heard) > silence);
        self.rows.iter_mut().filter(|robot| gone(robot)).for_each(|robot| robot.heard_at = None);
    }

    /// Rows: one more than the highest id heard of.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether no robot was ever heard of.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Robots that stand and robots that drive.
    pub fn standing_and_driving(&self, now: Duration) -> [u32; 2] {
        let mut counts = [0; 2];
        for state in self.rows.iter().map(|robot| robot.state(now)) {
            match state {
                RobotState::Driving => counts[1] += 1,
                RobotState::Absent => {}
                _ => counts[0] += 1,
            }
        }
        counts
    }

    /// Writes all rows into a frame.
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
    /// The way since the mean started over the time; negative if it went backwards.
    fn mean_speed(&self, elapsed: Duration) -> f32 {
        let [dx, dy] = [self.x - self.from[0], self.y - self.from[1]].map(f64::from);
        let (sin, cos) = f64::from(self.theta).sin_cos();
        let speed = dx.hypot(dy).copysign(dx * cos + dy * sin) / elapsed.as_secs_f64();
        // A robot can jump from one end of the numbers to the other.
        if speed.is_finite() { speed.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32 } else { 0.0 }
    }

    fn state(&self, now: Duration) -> RobotState {
        match self.heard_at {
            None => RobotState::Absent,
            Some(heard) if now.saturating_sub(heard) <= STANDS_AFTER && self.speed.abs() > STANDING => {
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

    /// State and speed of each row, as a frame tells them.
    fn told(robots: &Robots, now: Duration) -> Vec<(RobotState, f32)> {
        let mut lines = vec![Line([7.0; 16]); frame_lines(robots.len())];
        robots.write(&mut ColumnsMut::split(&mut lines, robots.len()), now);
        let columns = Columns::split(&lines, robots.len()).expect("lines enough");
        assert!(columns.edge.iter().all(|&edge| edge == NO_EDGE) && columns.s.iter().all(|&s| s == 0.0));
        columns.state.iter().map(|&state| RobotState::from_number(state)).zip(columns.speed.iter().copied()).collect()
    }

    #[test]
    fn rows_nobody_spoke_of_are_absent() {
        let mut robots = Robots::new(10);
        robots.hear(&line(2, 1.0, 0.0), MILLI).expect("room");
        assert_eq!(robots.hear(&line(10, 1.0, 0.0), MILLI), Err(LineFault::IdTooLarge));
        let states: Vec<_> = told(&robots, MILLI).into_iter().map(|(state, _)| state).collect();
        assert_eq!(states, [RobotState::Absent, RobotState::Absent, RobotState::Idle]);
        assert_eq!(robots.standing_and_driving(MILLI), [1, 0]);
    }

    #[test]
    fn speed_is_the_way_over_the_time_and_has_the_sign_of_the_gear() {
        for (theta, speed) in [(0.0, 2.0), (core::f32::consts::PI, -2.0)] {
            let mut robots = Robots::new(1);
            // Every 20 ms, give or take 2.
            let times = (0..30).map(|i| MILLI * (i * 20 + i % 3));
            times.clone().for_each(|at| robots.hear(&line(0, at.as_secs_f32() * 2.0, theta), at).expect("room"));
            let [(state, told)] = told(&robots, MILLI * 600)[..] else { panic!("one robot") };
            assert!(state == RobotState::Driving && (told - speed).abs() < 1e-4, "{told}");
        }
    }

    #[test]
    fn silence_means_standing_and_at_last_absence() {
        let mut robots = Robots::new(1);
        (0..30).for_each(|i| robots.hear(&line(0, i as f32, 0.0), MILLI * 20 * i).expect("room"));
        assert_eq!(told(&robots, MILLI * 600)[0].0, RobotState::Driving);
        assert_eq!(told(&robots, MILLI * 3_000), [(RobotState::Idle, 0.0)]);
        robots.forget(MILLI * 5_000, MILLI * 5_000);
        assert_eq!(told(&robots, MILLI * 5_000)[0].0, RobotState::Idle);
        robots.forget(MILLI * 5_000, MILLI * 6_000);
        assert_eq!(told(&robots, MILLI * 6_000)[0].0, RobotState::Absent);
        robots.hear(&line(0, 900.0, 0.0), MILLI * 7_000).expect("room");
        assert_eq!(told(&robots, MILLI * 7_000), [(RobotState::Idle, 0.0)], "where it was before doesn't count");
    }

    #[test]
    fn jumps_across_all_numbers_stay_finite() {
        let mut robots = Robots::new(1);
        for (i, x) in (0..).zip([f32::MIN, f32::MAX, f32::MIN_POSITIVE, f32::MIN, 0.0]) {
            robots.hear(&PoseLine { id: 0, x, y: x, theta: x }, MILLI * i * 100).expect("room");
            assert!(told(&robots, MILLI * i * 100)[0].1.is_finite());
        }
    }
}
