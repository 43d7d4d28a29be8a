//! Closed edges: those that no robot may enter now. The producer publishes all of them on
//! `regatta/F/closures` with every change, so that a process that joins later knows them, too.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/closures`. The payload is a [`ClosedEdge`] for each of
/// them, sorted by id.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ClosureHeader"))]
pub struct ClosureHeader {
    /// The run that the tick belongs to. Edges that were closed in another run are open.
    pub run_id: u64,
    /// The tick in which they changed.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// An edge that no robot may enter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ClosedEdge"))]
pub struct ClosedEdge {
    /// Id of the edge in the route graph. It is closed in both gears.
    pub edge: u32,
}

super::sequence::sequenced!(ClosureHeader: sequence);
