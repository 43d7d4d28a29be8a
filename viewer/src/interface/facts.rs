//! What the interface shows, and what it asks for in return. It knows nothing of windows and graphics cards.

use glam::Vec2;
use regatta_plugin::control::{ControlRequest, ControlResponse};
use regatta_plugin::frame::{ClockState, Frame};
use regatta_plugin::world::{EdgeRecord, NodeRecord, RobotTypeRecord};
use regatta_plugin::{ColumnName, Contacts};

use super::labels::Labels;
use super::performance::Timing;
use super::rig::Pose;
use super::rows::{RowQuery, Rows};
use crate::camera::Bounds;
use crate::feed::Counts;
use crate::gpu::pick::Picked;
use crate::palette::Legend;
use crate::route::Remaining;

/// How the fleet's producer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// There has been none since the viewer was started.
    Awaited,
    /// It sends frames.
    Running,
    /// It was paused.
    Paused,
    /// It sends none, and doesn't say why.
    Silent,
    /// It has ended its run, or was killed.
    Gone,
}

/// All that is known at the moment of one picture.
#[derive(Clone, Debug)]
pub struct Facts<'a> {
    /// Name of the fleet.
    pub fleet: &'a str,
    /// Its producer.
    pub engine: Engine,
    /// What the producer said of itself last.
    pub status: Option<&'a ControlResponse>,
    /// The newest frame.
    pub frame: Option<Frame<'a>>,
    /// Nodes of the graph.
    pub nodes: &'a [NodeRecord],
    /// Edges of the graph.
    pub edges: &'a [EdgeRecord],
    /// The ids of both.
    pub labels: &'a Labels,
    /// Kinds of robots.
    pub types: &'a [RobotTypeRecord],
    /// Each robot's index into `types`.
    pub kinds: Option<&'a [f32]>,
    /// What a collision checker says.
    pub contacts: Option<Contacts<'a>>,
    /// What the colours mean.
    pub legend: &'a Legend,
    /// The columns that plugins publish.
    pub columns: &'a [ColumnName],
    /// The values of those columns for the selected robot.
    pub values: &'a [(ColumnName, f32)],
    /// What the selected robot has still to drive, if its route is known.
    pub route: Option<Remaining>,
    /// Robots in the order that was asked for.
    pub rows: Option<&'a Rows>,
    /// Where there is something to see.
    pub bounds: Bounds,
    /// The followed robot, as drawn now.
    pub followed: Option<Pose>,
    /// What takes the time.
    pub timing: &'a Timing,
    /// Frames read and skipped.
    pub counts: Counts,
    /// Age of the newest frame when it was read, in seconds.
    pub lag: Option<f64>,
    /// Points of the trails that the adapter has room for, of those that were asked for.
    pub trail_points: u32,
    /// Whether the UDP source and the UDP sender run.
    pub udp: [bool; 2],
}

/// A thing that can be picked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thing {
    /// By its id.
    Robot(u32),
    /// By its index in the world.
    Edge(u32),
    /// By its index in the world.
    Node(u32),
}

/// What a person asks for, to be done outside of the interface.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// To be sent to the engine.
    Control(ControlRequest),
    /// Select what is at a point of the picture.
    Pick {
        /// Points from its top left.
        at: Vec2,
        /// Beside what is selected already.
        beside: bool,
    },
    /// Rows of the fleet list in this order.
    Rows(RowQuery),
    /// Start a program that receives robots by UDP, and answers.
    StartUdpSource {
        /// Host and port to receive at.
        listen: String,
        /// Host and port to answer to.
        echo_to: Option<String>,
        /// Metres to add to the positions that it answers.
        offset: Vec2,
    },
    /// Start a program that sends the fleet by UDP.
    StartUdpSender {
        /// Host and port to send to.
        to: String,
    },
    /// Stop the UDP source.
    StopUdpSource,
    /// Stop the UDP sender.
    StopUdpSender,
    /// Fill the screen, or no longer.
    FullScreen,
    /// Close the window.
    Quit,
}

impl Facts<'_> {
    /// Whether the engine's clock stands.
    pub fn is_paused(&self) -> bool {
        let clock = self.frame.map(|frame| frame.header().clock).or(self.status.map(|status| status.clock));
        clock == Some(ClockState::Paused as u32)
    }

    /// The pose of a robot in the newest frame, where it is drawn.
    pub fn pose(&self, robot: u32, offset: Vec2) -> Option<Pose> {
        let (frame, row) = (self.frame?, robot as usize);
        let place = Vec2::new(*frame.x().get(row)?, *frame.y().get(row)?) + offset;
        Some(Pose { place, theta: *frame.theta().get(row)? })
    }
}

impl From<Picked> for Thing {
    fn from(picked: Picked) -> Self {
        match picked {
            Picked::Robot(id) => Self::Robot(id),
            Picked::Edge(index) => Self::Edge(index),
            Picked::Node(index) => Self::Node(index),
        }
    }
}
