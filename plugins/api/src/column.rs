//! Columns: one value per robot, published by a plugin on `regatta/F/columns/NAME`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// The iceoryx2 user header of a column. Its payload is `robots` values of `f32`, padded to whole lines.
///
/// The producer itself publishes the column `type`: each robot's index into the world's robot types.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_ColumnHeader")]
pub struct ColumnHeader {
    /// The run of the frame that these values belong to.
    pub run_id: u64,
    /// The tick of the frame that these values belong to.
    pub tick: u64,
    /// Number of values.
    pub robots: u32,
    /// Zero.
    pub reserved: u32,
}
