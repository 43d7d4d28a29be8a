//! Stations: places that robots serve from nodes of the route graph.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::Role;

/// A station: a place with a name that robots serve from one or more nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_StationRecord"))]
pub struct StationRecord {
    /// Offset of the name in the [`Texts`](super::Texts).
    pub name: u32,
    /// Offset of the name of its level (floor) in the [`Texts`](super::Texts); 0 for none.
    pub level: u32,
    /// Metres east of the world's origin.
    pub x: f32,
    /// Metres north of the world's origin.
    pub y: f32,
    /// A [`Role`].
    pub role: u32,
    /// Index of the first of its nodes among the nodes of all stations.
    pub first_node: u32,
    /// Number of its nodes.
    pub nodes: u32,
}

impl StationRecord {
    /// The purpose of the station. An unknown number counts as nothing in particular.
    pub fn role(&self) -> Role {
        Role::from_number(self.role).unwrap_or_default()
    }
}
