//! The world: the route graph and the robot types, published once per change on `regatta/F/world`.
//! A sample is a block of lines: nodes, edges and robot types, each section starting on a whole line.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// The iceoryx2 user header of `regatta/F/world`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_WorldHeader")]
pub struct WorldHeader {
    /// The run that this world belongs to.
    pub run_id: u64,
    /// Counts the worlds of a run, from 1.
    pub revision: u64,
    /// Number of [`NodeRecord`]s.
    pub nodes: u32,
    /// Number of [`EdgeRecord`]s.
    pub edges: u32,
    /// Number of [`RobotTypeRecord`]s.
    pub robot_types: u32,
    /// Zero.
    pub reserved: u32,
}

/// A node of the route graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_NodeRecord")]
pub struct NodeRecord {
    /// Id in the route graph's file.
    pub id: u32,
    /// Metres east.
    pub x: f32,
    /// Metres north.
    pub y: f32,
    /// Radians in (-π, π].
    pub theta: f32,
}

/// An edge of the route graph: a cubic Bézier curve. Straight edges are written as one too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_EdgeRecord")]
pub struct EdgeRecord {
    /// Id in the route graph's file.
    pub id: u32,
    /// Index of the origin in the world's nodes.
    pub origin: u32,
    /// Index of the destination in the world's nodes.
    pub destination: u32,
    /// Arc length in metres.
    pub length: f32,
    /// Control points P0 to P3, each x and y in metres.
    pub control_points: [[f32; 2]; 4],
    /// Metres per second from origin to destination.
    pub velocity_forward: f32,
    /// Metres per second from destination to origin in reverse gear; 0 if that is not allowed.
    pub velocity_backwards: f32,
    /// Zero.
    pub reserved: [u32; 2],
}

/// A kind of robot.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_RobotTypeRecord")]
pub struct RobotTypeRecord {
    /// Name in UTF-8, padded with zeros.
    pub name: [u8; 48],
    /// Metres along the heading.
    pub length: f32,
    /// Metres across it.
    pub width: f32,
    /// Metres per second; `f32::INFINITY` for no limit.
    pub max_speed: f32,
    /// Metres per second squared; `f32::INFINITY` for no limit.
    pub max_acceleration: f32,
}
