//! Requests to a fleet manager: to send a robot somewhere, and to call it back. Request-response on
//! `regatta/F/manager`, which has no server if the fleet has no manager that takes requests.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

numbered! {
    /// Kinds of [`ManagerRequest`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ManagerRequestKind: u32 {
        /// Send a robot to a node: at once, or if it carries a load, as soon as its order is
        /// finished. It takes the place of an earlier request for the same robot.
        Send = 1,
        /// Call a robot back, and manage it as before.
        Recall = 2,
    }
}

numbered! {
    /// Answers of a fleet manager.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ManagerAnswer: u32 {
        /// It does so now.
        Now = 1,
        /// It does so as soon as the robot's order is finished.
        Later = 2,
        /// There is no such robot.
        UnknownRobot = 3,
        /// There is no such node.
        UnknownNode = 4,
        /// No way leads there, for example because edges are closed.
        NoWay = 5,
        /// The robot was not sent anywhere.
        NotSent = 6,
        /// The manager has seen no frame yet.
        NotReady = 7,
        /// The manager doesn't know this kind of request.
        UnknownKind = 8,
    }
}

impl ManagerAnswer {
    /// Whether the request is carried out, now or later.
    pub fn is_granted(self) -> bool {
        matches!(self, Self::Now | Self::Later)
    }
}

/// A request to the fleet manager.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ManagerRequest"))]
pub struct ManagerRequest {
    /// A [`ManagerRequestKind`].
    pub kind: u32,
    /// The robot, by id.
    pub robot: u32,
    /// The node to send it to, by its id in the route graph; 0 for other kinds.
    pub node: u32,
    /// Zero.
    pub reserved: u32,
}

/// The fleet manager's answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ManagerResponse"))]
pub struct ManagerResponse {
    /// The number of the transport order by which the robot is sent, as in the order log; 0 if
    /// there is none.
    pub order: u64,
    /// A [`ManagerAnswer`].
    pub answer: u32,
    /// The robot of the request.
    pub robot: u32,
}

impl ManagerRequest {
    /// Creates a request to send a robot to a node, by its id.
    pub const fn send(robot: u32, node: u32) -> Self {
        Self { kind: ManagerRequestKind::Send as u32, robot, node, reserved: 0 }
    }

    /// Creates a request to call a robot back.
    pub const fn recall(robot: u32) -> Self {
        Self { kind: ManagerRequestKind::Recall as u32, robot, node: 0, reserved: 0 }
    }

    /// Returns the kind of the request; `None` for one that this version doesn't know.
    pub fn kind(&self) -> Option<ManagerRequestKind> {
        ManagerRequestKind::from_number(self.kind)
    }
}

impl ManagerResponse {
    /// Creates an answer to a request.
    pub const fn new(request: &ManagerRequest, answer: ManagerAnswer, order: u64) -> Self {
        Self { order, answer: answer as u32, robot: request.robot }
    }

    /// Returns the answer; `None` for one that this version doesn't know.
    pub fn answer(&self) -> Option<ManagerAnswer> {
        ManagerAnswer::from_number(self.answer)
    }
}
