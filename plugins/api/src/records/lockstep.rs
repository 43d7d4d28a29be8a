//! Lockstep reports: `regatta/F/done`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// A reader's report that it has finished a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_Done")]
pub struct Done {
    /// The run.
    pub run_id: u64,
    /// The tick.
    pub tick: u64,
    /// The reader's name in UTF-8, padded with zeros.
    pub name: [u8; 64],
}
