//! The background: lines that are drawn under the route graph and mean nothing to robots.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

/// The largest number of points of the background of a world: 2 MB.
pub const MAX_BACKGROUND_POINTS: usize = 250_000;

/// A line of the background through two points or more: a wall, the outline of a floor or a rack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_BackgroundLineRecord"))]
pub struct BackgroundLineRecord {
    /// Offset of the name of its level (floor) in the [`Texts`](super::Texts); 0 for none.
    pub level: u32,
    /// Index of the first of its points among those of all lines.
    pub first_point: u32,
    /// Number of its points.
    pub points: u32,
}
