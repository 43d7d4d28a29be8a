//! Zones: groups of nodes and edges with a rule for the robots in them.

use regatta_base::rows::Rows;
use regatta_base::sweep::Span;
use regatta_plugin::World;
use regatta_plugin::world::{ZoneRecord, ZoneRule};

use super::{Leg, Road, Roads};

/// The distance from a node, in metres, up to which a robot is kept off it.
const NEAR_NODE: f32 = 0.1;
/// The distance from the end of an edge, in metres, up to which a robot stands at the node there,
/// and not on the edge.
const AT_NODE: f32 = 2e-3;

/// A part of a track that belongs to a zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZonePart {
    /// Index of the zone.
    pub zone: u32,
    /// Metres from the edge's origin.
    pub span: Span,
}

/// The zones of some roads.
#[derive(Clone, Debug)]
pub struct Zones {
    rules: Vec<Rule>,
    /// By zone: the tracks of which a part belongs to it, in ascending order.
    tracks: Vec<Vec<u32>>,
    /// By track.
    parts: Rows<ZonePart>,
}

/// The rule for the robots in a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// At most so many robots.
    Capacity(u32),
    /// Several robots only if all have entered at the same node.
    SameDirection,
}

impl Zones {
    /// Reads the zones of a world with these edges.
    pub(super) fn new(world: &World<'_>, edges: &[Road]) -> Self {
        let (mut rules, mut parts) = (Vec::new(), Vec::new());
        for record in world.zones() {
            let Some(rule) = rule(record) else { continue };
            let zone = rules.len() as u32;
            rules.push(rule);
            let whole = world.zone_edges(record).iter().filter_map(|&edge| {
                let length = edges.get(edge as usize)?.length;
                let inner = AT_NODE.min(0.5 * length);
                Some((edge, ZonePart { zone, span: Span::new(inner, length - inner) }))
            });
            parts.extend(whole);
            parts.extend(parts_of_nodes(world.zone_nodes(record), edges, zone));
        }
        let mut tracks = vec![Vec::new(); rules.len()];
        for (track, part) in &parts {
            tracks[part.zone as usize].push(*track);
        }
        for tracks in &mut tracks {
            tracks.sort_unstable();
            tracks.dedup();
        }
        Self { rules, tracks, parts: Rows::by_row(edges.len() + world.nodes().len(), parts) }
    }

    /// Number of zones.
    pub fn len(&self) -> usize {
        self.rules.len()
    }

    /// Whether there are no zones.
    pub fn is_empty(&self) -> bool {
        self.rules.is_empty()
    }

    /// The rule of a zone.
    pub fn rule(&self, zone: u32) -> Rule {
        self.rules[zone as usize]
    }

    /// Whether a zone has room for one robot only.
    pub fn is_exclusive(&self, zone: u32) -> bool {
        self.rule(zone) == Rule::Capacity(1)
    }

    /// The parts of a track that belong to zones.
    pub fn parts(&self, track: u32) -> &[ZonePart] {
        if self.is_empty() { &[] } else { self.parts.row(track) }
    }

    /// The tracks of which a part belongs to a zone, in ascending order.
    pub fn tracks(&self, zone: u32) -> &[u32] {
        &self.tracks[zone as usize]
    }
}

impl ZonePart {
    /// The part as a leg drives it, in metres from where the leg is entered.
    pub fn driven(&self, roads: &Roads, leg: Option<Leg>) -> Span {
        match leg.filter(|leg| leg.is_reverse()) {
            Some(leg) => self.span.reversed(roads.edge(leg.edge()).length),
            None => self.span,
        }
    }
}

/// Returns the rule of a zone; `None` if it can't be kept, because it is unknown.
fn rule(record: &ZoneRecord) -> Option<Rule> {
    match record.rule()? {
        ZoneRule::Capacity => Some(Rule::Capacity(record.capacity.max(1))),
        ZoneRule::SameDirection => Some(Rule::SameDirection),
    }
}

/// Returns the parts at nodes, in ascending order, of all edges that meet there and of the places
/// where robots turn.
fn parts_of_nodes(
    nodes: &[u32],
    edges: &[Road],
    zone: u32,
) -> impl Iterator<Item = (u32, ZonePart)> {
    let ends = (0..).zip(edges).flat_map(move |(track, edge)| {
        let near = NEAR_NODE.min(0.5 * edge.length);
        let spans = [
            (edge.origin, Span::new(0.0, near)),
            (edge.destination, Span::new(edge.length - near, edge.length)),
        ];
        spans.into_iter().filter_map(move |(node, span)| {
            let is_member = nodes.binary_search(&node).is_ok();
            is_member.then_some((track, ZonePart { zone, span }))
        })
    });
    let discs = nodes.iter().map(move |&node| {
        (edges.len() as u32 + node, ZonePart { zone, span: Span::new(0.0, 0.0) })
    });
    ends.chain(discs)
}
