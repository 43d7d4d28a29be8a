//! A frame as ROS 2 has it: present robots, in the coordinates of the layout's file.

use std::time::Duration;

use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::world::Orientation;
use regatta_plugin::{Frame, World};

use crate::message::geometry::{Pose, Time, Twist, Vector3};

/// The robots that are there, in the order of their ids.
#[derive(Clone, Debug, Default)]
pub(crate) struct Snapshot {
    pub run_id: u64,
    pub sim_time: Duration,
    pub robots: Vec<Robot>,
}

/// A robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Robot {
    pub id: u32,
    /// Metres east and north on the map of the layout's file.
    pub x: f64,
    pub y: f64,
    /// Radians.
    pub theta: f64,
    /// Metres per second along the edge.
    pub speed: f64,
    /// Index of its edge, or [`NO_EDGE`].
    pub edge: u32,
    pub state: RobotState,
}

impl Snapshot {
    /// Copies a frame. `origin` is that of the world.
    pub fn of(frame: &Frame<'_>, origin: [f64; 2]) -> Self {
        let columns = frame.columns();
        let mut robots = Vec::with_capacity(frame.len());
        for row in 0..frame.len() {
            let state = frame.state_of(row);
            if state == RobotState::Absent {
                continue;
            }
            robots.push(Robot {
                id: row as u32,
                x: origin[0] + f64::from(columns.x[row]),
                y: origin[1] + f64::from(columns.y[row]),
                theta: f64::from(columns.theta[row]),
                speed: f64::from(columns.speed[row]),
                edge: columns.edge[row],
                state,
            });
        }
        Self { run_id: frame.run_id(), sim_time: frame.sim_time(), robots }
    }

    /// The simulated time.
    pub fn stamp(&self) -> Time {
        Time::after(self.sim_time)
    }

    /// A robot by its id.
    pub fn robot(&self, id: u32) -> Option<&Robot> {
        let place = self.robots.binary_search_by_key(&id, |robot| robot.id).ok()?;
        self.robots.get(place)
    }
}

impl Robot {
    /// Its pose.
    pub fn pose(&self) -> Pose {
        Pose::on_ground(self.x, self.y, self.theta)
    }

    /// Its velocity on the map, as far as its heading tells; it counts as not turning.
    pub fn twist_on_map(&self) -> Twist {
        let (sine, cosine) = self.theta.sin_cos();
        let linear = Vector3 { x: self.speed * cosine, y: self.speed * sine, z: 0.0 };
        Twist { linear, ..Twist::default() }
    }

    /// Its velocity in its own frame. `before` is the same robot some seconds earlier, for the
    /// rate at which it turns.
    pub fn twist(&self, before: Option<(&Self, f64)>, headings: &Headings) -> Twist {
        let (side, ahead) = headings.travel(self, before.map(|(robot, _)| robot)).sin_cos();
        let turn = before.filter(|(_, seconds)| *seconds > 0.0).map_or(0.0, |(robot, seconds)| {
            let turned = (self.theta - robot.theta + std::f64::consts::PI)
                .rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            turned / seconds
        });
        Twist {
            linear: Vector3 { x: self.speed * ahead, y: self.speed * side, z: 0.0 },
            angular: Vector3 { z: turn, ..Vector3::default() },
        }
    }
}

/// The headings of robots along each edge.
#[derive(Clone, Debug, Default)]
pub(crate) struct Headings(Vec<Orientation>);

impl Headings {
    /// Reads them of a world.
    pub fn of(world: &World<'_>) -> Self {
        Self(world.edges().iter().map(|edge| edge.orientation()).collect())
    }

    /// The direction in which a robot drives, in its own frame: radians from straight ahead.
    fn travel(&self, robot: &Robot, before: Option<&Robot>) -> f64 {
        let edge = (robot.edge != NO_EDGE).then(|| self.0.get(robot.edge as usize)).flatten();
        match (edge, before) {
            (Some(Orientation::Offset(angle)), _) => -f64::from(*angle),
            (Some(Orientation::Fixed(_)), Some(before)) if before.edge == robot.edge => {
                let back = if robot.speed < 0.0 { std::f64::consts::PI } else { 0.0 };
                (robot.y - before.y).atan2(robot.x - before.x) - robot.theta + back
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const AT_START: Robot = Robot {
        id: 3,
        x: 0.0,
        y: 0.0,
        theta: 3.1,
        speed: 2.0,
        edge: 0,
        state: RobotState::Driving,
    };

    #[test]
    fn robots_drive_where_their_edges_head() {
        let later = Robot { theta: -3.1, x: -0.2, y: 0.1, ..AT_START };
        let twist = |headings: Headings| later.twist(Some((&AT_START, 0.1)), &headings);
        let ahead = twist(Headings(vec![Orientation::Tangential]));
        assert_eq!((ahead.linear.x, ahead.linear.y), (2.0, 0.0));
        let turned = 10.0 * (std::f64::consts::TAU - 6.2);
        assert!((ahead.angular.z - turned).abs() < 1e-9, "the short way: {}", ahead.angular.z);
        let sideways = twist(Headings(vec![Orientation::Offset(FRAC_PI_2 as f32)]));
        assert!(sideways.linear.x.abs() < 1e-6 && (sideways.linear.y + 2.0).abs() < 1e-6);
        let fixed = Robot { theta: 0.0, ..later };
        let fixed = fixed.twist(Some((&AT_START, 0.1)), &Headings(vec![Orientation::Fixed(0.0)]));
        assert!((fixed.linear.x + 4.0 / 5_f64.sqrt()).abs() < 1e-6, "{fixed:?}");
        let alone = later.twist(None, &Headings::default());
        assert_eq!((alone.linear.x, alone.angular.z), (2.0, 0.0));
    }

    #[test]
    fn robots_are_found_by_their_ids() {
        let robots = [1, 4, 9].map(|id| Robot { id, ..AT_START }).to_vec();
        let snapshot = Snapshot { robots, ..Snapshot::default() };
        assert_eq!(snapshot.robot(4).map(|robot| robot.id), Some(4));
        assert_eq!(snapshot.robot(5), None);
    }
}
