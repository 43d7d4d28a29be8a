//! Zones: groups of nodes and edges with a rule for the robots in them.

use std::num::NonZeroU32;

use regatta_base::graph::{EdgeIndex, NodeIndex};

/// A group of nodes and edges with a rule. A robot is in it while it stands at or drives along one
/// of them; a group without a rule is only a tag, [`Tags::zone`](super::tags::Tags::zone).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Zone {
    /// The name, unique among zones.
    pub name: Box<str>,
    /// The rule.
    pub rule: ZoneRule,
    /// Its nodes, in ascending order.
    pub nodes: Vec<NodeIndex>,
    /// Its edges, in ascending order.
    pub edges: Vec<EdgeIndex>,
}

/// The rule for the robots in a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneRule {
    /// At most so many robots at the same time.
    Capacity(NonZeroU32),
    /// Several robots only if all have entered at the same node. Nodes where two or more of its
    /// edges meet are in it, too.
    SameDirection,
}

impl ZoneRule {
    /// The rule of a zone for one robot at a time: a block of openTCS, a mutex group of Open-RMF.
    pub const EXCLUSIVE: Self = Self::Capacity(NonZeroU32::MIN);
}
