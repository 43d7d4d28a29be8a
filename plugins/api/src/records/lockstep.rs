//! Lockstep reports: `regatta/F/done`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

/// A reader's report that it has finished a tick, or that it has left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_Done"))]
pub struct Done {
    /// The run.
    pub run_id: u64,
    /// The tick, or [`LEFT`](Self::LEFT).
    pub tick: u64,
    /// The reader's name in UTF-8, padded with zeros.
    pub name: [u8; 64],
}

impl Done {
    /// All ticks from now on: the reader has ended on request, and the producer doesn't wait for
    /// it.
    pub const LEFT: u64 = u64::MAX;
}
