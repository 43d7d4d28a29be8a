//! Columns: one value per robot, published by a plugin on `regatta/F/columns/NAME`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of a column. Its payload is `robots` values of `f32`, padded to whole
/// lines.
///
/// The producer itself publishes the column `type`: each robot's index into the world's robot
/// types.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ColumnHeader"))]
pub struct ColumnHeader {
    /// The run of the frame that the values were computed from.
    pub run_id: u64,
    /// The tick of the frame that the values were computed from.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
    /// Number of values.
    pub robots: u32,
    /// Microseconds that the publisher spent on the frame before it published this; 0 if it doesn't
    /// say.
    pub cost_micros: u32,
}

impl Sequenced for ColumnHeader {
    fn run_id(&self) -> u64 {
        self.run_id
    }

    fn sequence(&self) -> u64 {
        self.sequence
    }
}
