//! Zones: groups of nodes and edges with a rule for the robots in them.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

/// A group of nodes and edges with a rule: a block, a mutex group, the cabin of a lift. A robot is
/// in it while it stands at or drives along one of them. Fleet managers keep the rule; the engine
/// doesn't know it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_ZoneRecord"))]
pub struct ZoneRecord {
    /// Offset of the name in the [`Texts`](super::Texts).
    pub name: u32,
    /// A [`ZoneRule`].
    pub rule: u32,
    /// The largest number of robots at the same time; 0 if the rule is another one.
    pub capacity: u32,
    /// Index of the first of its members: its nodes in ascending order, then its edges.
    pub first_member: u32,
    /// Number of its nodes.
    pub nodes: u32,
    /// Number of its edges.
    pub edges: u32,
}

impl ZoneRecord {
    /// The rule; `None` if a later version of the contract has added it.
    pub fn rule(&self) -> Option<ZoneRule> {
        ZoneRule::from_number(self.rule)
    }
}

numbered! {
    /// The rule for the robots in a zone.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum ZoneRule: u32 {
        /// At most [`capacity`](ZoneRecord::capacity) robots at the same time.
        #[default]
        Capacity = 0,
        /// Several robots only if all have entered at the same node.
        SameDirection = 1,
    }
}
