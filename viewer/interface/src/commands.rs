//! Commands that a user gives from the picture.

use core::fmt;

/// A command of the user. Robots, nodes and edges are given by their ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UserCommand {
    /// Make a robot brake and stand.
    Hold(u32),
    /// End a hold.
    Resume(u32),
    /// Make a robot break down.
    Break(u32),
    /// Repair a robot.
    Repair(u32),
    /// Drop a robot's route beyond its edge.
    Cancel(u32),
    /// Send a robot to a node by the fastest way.
    Send {
        /// The robot.
        robot: u32,
        /// The node.
        node: u32,
    },
    /// Ask the fleet manager to send a robot to a node.
    SendByManager {
        /// The robot.
        robot: u32,
        /// The node.
        node: u32,
    },
    /// Ask the fleet manager to cancel the last sending of a robot.
    Recall(u32),
    /// Close an edge.
    Close(u32),
    /// Open an edge.
    Open(u32),
}

impl UserCommand {
    /// The robot that it is about.
    pub fn robot(self) -> Option<u32> {
        match self {
            Self::Hold(robot) | Self::Resume(robot) | Self::Break(robot) | Self::Repair(robot) => {
                Some(robot)
            }
            Self::Cancel(robot) | Self::Recall(robot) => Some(robot),
            Self::Send { robot, .. } | Self::SendByManager { robot, .. } => Some(robot),
            Self::Close(_) | Self::Open(_) => None,
        }
    }
}

impl fmt::Display for UserCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hold(robot) => write!(f, "hold robot {robot}"),
            Self::Resume(robot) => write!(f, "resume robot {robot}"),
            Self::Break(robot) => write!(f, "break robot {robot} down"),
            Self::Repair(robot) => write!(f, "repair robot {robot}"),
            Self::Cancel(robot) => write!(f, "cancel the route of robot {robot}"),
            Self::Send { robot, node } | Self::SendByManager { robot, node } => {
                write!(f, "send robot {robot} to node {node}")
            }
            Self::Recall(robot) => write!(f, "recall robot {robot}"),
            Self::Close(edge) => write!(f, "close edge {edge}"),
            Self::Open(edge) => write!(f, "open edge {edge}"),
        }
    }
}
