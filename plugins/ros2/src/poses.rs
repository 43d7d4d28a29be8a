//! The messages of each frame: poses of the whole fleet, frames in `/tf`, odometry of chosen
//! robots.

use std::time::Duration;

use regatta_plugin::{World, tell};

use crate::link::{Keep, Link, LinkError, Output};
use crate::message::display::Odometry;
use crate::message::geometry::{
    Header, PoseArray, PoseWithCovariance, TFMessage, Transform, TransformStamped,
    TwistWithCovariance, Vector3,
};
use crate::options::{Namespace, RobotRange, robot_name};
use crate::snapshot::{Headings, Robot, Snapshot};

/// The frame of the map.
pub(crate) const MAP: &str = "map";

/// Poses of one message: 112 kB. Messages beyond 150 kB or so are lost where the buffers of sockets
/// have their default size.
const POSES: usize = 2_000;
/// Bytes of a pose.
const POSE_BYTES: usize = 56;
/// The most topics of poses.
const MOST_TOPICS: usize = 10;
/// Transforms of one message.
const TRANSFORMS: usize = 500;
/// Bytes of a transform, about.
const TRANSFORM_BYTES: usize = 120;
/// The pause after a large message, in which readers empty their sockets.
const PAUSE: Duration = Duration::from_millis(4);

/// The topics.
pub(crate) struct Poses {
    namespace: Namespace,
    frames: RobotRange,
    fleet: Vec<Output<PoseArray>>,
    transforms: Output<TFMessage>,
    odometry: Vec<(u32, Output<Odometry>)>,
    headings: Headings,
    before: Snapshot,
    /// The number of robots of which one is published, as last told.
    step: usize,
    /// Whether the user was told that robots have no frame.
    has_told_frames: bool,
}

impl Poses {
    pub fn open(
        link: &mut Link,
        namespace: &Namespace,
        frames: &RobotRange,
    ) -> Result<Self, LinkError> {
        Ok(Self {
            namespace: namespace.clone(),
            frames: frames.clone(),
            fleet: Vec::new(),
            transforms: link.output("/tf", Keep::Nothing, TRANSFORMS * TRANSFORM_BYTES)?,
            odometry: Vec::new(),
            headings: Headings::default(),
            before: Snapshot::default(),
            step: 1,
            has_told_frames: false,
        })
    }

    /// Gives a robot topics of its own.
    pub fn choose(&mut self, robot: u32, link: &mut Link) -> Result<(), LinkError> {
        let name = format!("{}/odom", robot_name(robot));
        self.odometry.push((robot, link.output(&name, Keep::Nothing, 800)?));
        Ok(())
    }

    pub fn take_world(&mut self, world: &World<'_>) {
        self.headings = Headings::of(world);
    }

    /// Publishes a frame.
    pub fn publish(&mut self, snapshot: &Snapshot, link: &mut Link) -> Result<(), LinkError> {
        self.publish_transforms(snapshot);
        self.publish_odometry(snapshot);
        self.publish_fleet(snapshot, link)?;
        self.before = snapshot.clone();
        Ok(())
    }

    /// Publishes the poses of the fleet, in as many topics as they need.
    fn publish_fleet(&mut self, snapshot: &Snapshot, link: &mut Link) -> Result<(), LinkError> {
        let robots = &snapshot.robots;
        let step = robots.len().div_ceil(MOST_TOPICS * POSES).max(1);
        let topics = robots.len().div_ceil(step).div_ceil(POSES).max(1);
        if (step, topics.max(self.fleet.len())) != (self.step, self.fleet.len()) {
            self.open_topics(topics, link)?;
            self.tell(step, robots.len());
            self.step = step;
        }
        let header = Header::new(&snapshot.stamp(), MAP);
        let mut poses = robots.iter().step_by(step).map(Robot::pose);
        // Topics beyond those of a fleet that has shrunk get empty messages.
        for output in &mut self.fleet {
            let poses: Vec<_> = poses.by_ref().take(POSES).collect();
            let is_large = poses.len() > POSES / 2;
            output.publish(PoseArray { header: header.clone(), poses });
            if is_large {
                std::thread::sleep(PAUSE);
            }
        }
        Ok(())
    }

    fn open_topics(&mut self, topics: usize, link: &mut Link) -> Result<(), LinkError> {
        while self.fleet.len() < topics {
            let name = match self.fleet.len() {
                0 => "poses".to_owned(),
                number => format!("poses_{number}"),
            };
            self.fleet.push(link.output(&name, Keep::Nothing, POSES * POSE_BYTES)?);
        }
        Ok(())
    }

    fn tell(&self, step: usize, robots: usize) {
        if self.fleet.len() > 1 {
            let last = self.fleet.len() - 1;
            tell!(
                "ros2: DDS loses larger messages: {POSES} poses each, the topics are poses to \
                 poses_{last}"
            );
        }
        if step > 1 {
            tell!("ros2: of {robots} robots, every {step}th is among the poses");
        }
    }

    fn publish_transforms(&mut self, snapshot: &Snapshot) {
        let robots = snapshot.robots.iter().filter(|robot| self.frames.0.contains(&robot.id));
        let robots: Vec<_> = robots.collect();
        let left_out = snapshot.robots.len() - robots.len();
        if left_out > 0 && !std::mem::replace(&mut self.has_told_frames, true) {
            tell!(
                "ros2: {left_out} robots have no frame in /tf; --frames chooses the robots that \
                 have one"
            );
        }
        let header = Header::new(&snapshot.stamp(), MAP);
        for robots in robots.chunks(TRANSFORMS) {
            let transforms = robots.iter().map(|robot| self.transform(robot, &header)).collect();
            self.transforms.publish(TFMessage { transforms });
            if robots.len() > TRANSFORMS / 2 {
                std::thread::sleep(PAUSE);
            }
        }
    }

    fn transform(&self, robot: &Robot, header: &Header) -> TransformStamped {
        TransformStamped {
            header: header.clone(),
            child_frame_id: self.namespace.frame_of(robot.id),
            transform: Transform {
                translation: Vector3 { x: robot.x, y: robot.y, z: 0.0 },
                rotation: robot.pose().orientation,
            },
        }
    }

    fn publish_odometry(&mut self, snapshot: &Snapshot) {
        let is_same_run = self.before.run_id == snapshot.run_id;
        let seconds = snapshot.sim_time.saturating_sub(self.before.sim_time).as_secs_f64();
        for (id, output) in &mut self.odometry {
            let Some(robot) = snapshot.robot(*id) else { continue };
            let before = self.before.robot(*id).filter(|_| is_same_run);
            let twist = robot.twist(before.map(|robot| (robot, seconds)), &self.headings);
            output.publish(Odometry {
                header: Header::new(&snapshot.stamp(), MAP),
                child_frame_id: self.namespace.frame_of(*id),
                pose: PoseWithCovariance { pose: robot.pose(), ..Default::default() },
                twist: TwistWithCovariance { twist, ..Default::default() },
            });
        }
    }
}
