//! The order log: the orders that a producer applied, tick by tick, on `regatta/F/order_log`.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;

/// The iceoryx2 user header of `regatta/F/order_log`. The payload is a slice of
/// [`OrderRecord`](super::order::OrderRecord)s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_OrderLogHeader"))]
pub struct OrderLogHeader {
    /// The run that the tick belongs to.
    pub run_id: u64,
    /// The tick that the orders took effect in.
    pub tick: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

super::sequence::sequenced!(OrderLogHeader: sequence);
