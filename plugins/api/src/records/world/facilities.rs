//! The doors and lifts of a world. Their states are
//! [`FacilityState`](crate::records::facility::FacilityState)s.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

/// A door across edges. No robot enters one of them unless the door is open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_DoorRecord"))]
pub struct DoorRecord {
    /// Offset of the name in the [`Texts`](super::Texts).
    pub name: u32,
    /// Index of the first of its edges among the members of facilities.
    pub first_edge: u32,
    /// Number of its edges.
    pub edges: u32,
    /// Seconds from closed to open.
    pub opening_secs: f32,
    /// Seconds from open to closed.
    pub closing_secs: f32,
    /// Its ends, each metres east and north of the world's origin.
    pub line: [[f32; 2]; 2],
}

/// A lift: a cabin that carries robots from level to level. No robot enters or leaves it unless the
/// cabin is there and its doors are open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_LiftRecord"))]
pub struct LiftRecord {
    /// Offset of the name in the [`Texts`](super::Texts).
    pub name: u32,
    /// Index of the lowest of its levels among those of all lifts.
    pub first_level: u32,
    /// Number of its levels.
    pub levels: u32,
    /// Index of the first of its rides among the members of facilities: of the edges from level to
    /// level.
    pub first_ride: u32,
    /// Number of its rides.
    pub rides: u32,
    /// The largest number of robots in the cabin.
    pub capacity: u32,
    /// Seconds of the cabin from a level to the next.
    pub level_secs: f32,
    /// Seconds from closed to open of its doors.
    pub opening_secs: f32,
    /// Seconds from open to closed.
    pub closing_secs: f32,
    /// The centre of the cabin, in metres east and north of the world's origin.
    pub centre: [f32; 2],
    /// The extents of the cabin along its own axes, in metres; 0 if they are unknown.
    pub size: [f32; 2],
    /// The angle of its first axis, in radians.
    pub yaw: f32,
}

/// A level that a lift serves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_LiftLevelRecord"))]
pub struct LiftLevelRecord {
    /// Offset of the level's name in the [`Texts`](super::Texts).
    pub name: u32,
    /// Index of the first of its nodes among the members of facilities.
    pub first_node: u32,
    /// Number of the nodes in the cabin while it is there.
    pub nodes: u32,
}
