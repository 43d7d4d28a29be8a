//! A producer outside Regatta's repository: a gateway that publishes robots which it doesn't drive
//! itself.
//!
//! These robots drive in a circle. Replace [`Gateway::read`] by the source of your own robots'
//! poses: a bus, a driver, another simulator. Every reader of Regatta works with it: the viewer,
//! the collision checker, recorders, plugins of your own.
//!
//!     cargo run --release -- --fleet gateway --rate 20
//!     regatta viewer --fleet gateway

use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::producer::{Producer, Session};
use regatta_plugin::world::{NodeRecord, Role, RobotTypeRecord, WorldData};
use regatta_plugin::{Error, Result};

struct Gateway {
    /// Per robot: x and y in metres, theta in radians.
    poses: Vec<[f32; 3]>,
}

impl Gateway {
    /// Reads where the robots are at a simulated time in seconds.
    fn read(&mut self, time: f32) {
        let robots = self.poses.len() as f32;
        for (robot, pose) in self.poses.iter_mut().enumerate() {
            let angle = 0.2 * time + std::f32::consts::TAU * robot as f32 / robots;
            *pose = [
                10.0 * angle.cos(),
                10.0 * angle.sin(),
                (angle + 1.5).sin().atan2((angle + 1.5).cos()),
            ];
        }
    }
}

impl Producer for Gateway {
    type Error = Error;

    fn start(&mut self, session: &mut Session) -> Result {
        let charger = NodeRecord { id: 1, role: Role::Charge as u32, ..NodeRecord::default() };
        let tugger = RobotTypeRecord { max_speed: 2.0, ..RobotTypeRecord::new("tugger", 1.2, 0.8) };
        let world =
            WorldData { nodes: vec![charger], robot_types: vec![tugger], ..WorldData::default() };
        session.ports().publish_world(&world)?;
        self.tick(session)
    }

    fn tick(&mut self, session: &mut Session) -> Result {
        self.read(session.sim_time().as_secs_f32());
        self.show(session)
    }

    fn show(&mut self, session: &mut Session) -> Result {
        Ok(session.publish(self.poses.len(), |columns| {
            for (robot, pose) in self.poses.iter().enumerate() {
                [columns.x[robot], columns.y[robot], columns.theta[robot]] = *pose;
                (columns.speed[robot], columns.s[robot]) = (2.0, 0.0);
                (columns.edge[robot], columns.state[robot]) = (NO_EDGE, RobotState::Driving as u8);
            }
        })?)
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        [0, self.poses.len() as u32, 0, 0, 0, 0, 0, 0]
    }
}

fn main() -> Result {
    regatta_plugin::produce(Gateway { poses: vec![[0.0; 3]; 12] })
}
