//! The command log: the commands that a producer applied, tick by tick, on `regatta/F/command_log`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/command_log`. The payload is a slice of
/// [`CommandRecord`](super::command::CommandRecord)s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_CommandLogHeader"))]
pub struct CommandLogHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick that the commands took effect in.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

super::sequence::sequenced!(CommandLogHeader: sequence);
