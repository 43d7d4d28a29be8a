//! Places where a robot may stand without blocking others than those behind it.
//!
//! A place of an edge is *open* if a robot that stands there blocks only the edge itself, and edges
//! that lead straight into or out of it. A node is a *siding* if a robot that stands there is only
//! in the way of edges that meet there. No place in a zone for one robot is either: a robot enters
//! it if it can drive through.

use regatta_base::cores;
use regatta_base::rows::Rows;
use regatta_base::sweep::Span;

use super::{Leg, Reader, Relation, Roads, Writer};

/// The stopping places of robots with one footprint.
#[derive(Clone, Debug)]
pub struct Stops {
    /// By edge: the stretches that aren't open, in ascending order, in metres from its origin.
    closed: Rows<Span>,
    /// By leg: whether its end is a siding.
    sidings: Vec<bool>,
}

/// The distance that a robot has to keep from a closed stretch, in metres: its border counts as
/// closed for others.
const BORDER: f32 = 0.01;

impl Stops {
    pub(super) fn new(roads: &Roads, footprint: usize) -> Self {
        let edges = roads.edges().len();
        let mut arrivals = vec![0; roads.nodes() as usize];
        for edge in roads.edges() {
            arrivals[edge.destination as usize] += 1;
        }
        let closed = cores::map(edges, |edge| closed(roads, footprint, edge as u32, &arrivals));
        let closed = (0..)
            .zip(closed)
            .flat_map(|(edge, spans)| spans.into_iter().map(move |span| (edge, span)));
        let sidings =
            cores::map(2 * edges, |leg| is_siding(roads, footprint, Leg::from_index(leg as u32)));
        Self { closed: Rows::of_sorted(edges, closed), sidings }
    }

    /// Writes them.
    pub(super) fn write(&self, writer: &mut Writer) {
        writer.list(self.closed.starts().iter().copied());
        writer.floats(self.closed.values().iter().map(|span| span.low));
        writer.floats(self.closed.values().iter().map(|span| span.high));
        writer.list(self.sidings.iter().map(|is_siding| u32::from(*is_siding)));
    }

    /// Reads those of some edges.
    pub(super) fn read(edges: usize, reader: &mut Reader<'_>) -> Option<Self> {
        let starts = reader.starts(edges)?;
        let count = *starts.last()? as usize;
        let (low, high) = (reader.floats(count)?, reader.floats(count)?);
        let closed = low.into_iter().zip(high).map(|(low, high)| Span::new(low, high)).collect();
        let sidings =
            reader.list_of(2 * edges)?.into_iter().map(|is_siding| is_siding != 0).collect();
        Some(Self { closed: Rows::of_parts(starts, closed), sidings })
    }

    /// Returns the farthest open place of a leg in `from` to `to`, both in metres from where it is
    /// entered.
    pub fn last_open(&self, leg: Leg, length: f32, from: f32, to: f32) -> Option<f32> {
        let mut place = to;
        for span in self.driven(leg, length).rev() {
            if span.contains(place) {
                place = span.low - BORDER;
            }
        }
        (place >= from).then_some(place)
    }

    /// Returns the first open place of a leg at `from` or beyond, in metres from where it is
    /// entered.
    pub fn next_open(&self, leg: Leg, length: f32, from: f32) -> Option<f32> {
        let mut place = from;
        for span in self.driven(leg, length) {
            if span.contains(place) {
                place = span.high + BORDER;
            }
        }
        (place <= length).then_some(place)
    }

    /// The closed stretches of a leg in driving order, in metres from where it is entered.
    fn driven(&self, leg: Leg, length: f32) -> impl DoubleEndedIterator<Item = Span> {
        let closed = self.closed.row(leg.edge());
        let (forward, reverse) =
            if leg.is_reverse() { (&[][..], closed) } else { (closed, &[][..]) };
        let reverse = reverse.iter().rev().map(move |span| span.reversed(length));
        forward.iter().copied().chain(reverse)
    }

    /// Metres of an edge that aren't open.
    pub fn closed_length(&self, edge: u32) -> f32 {
        self.closed.row(edge).iter().map(|span| span.high - span.low).sum()
    }

    /// Whether the end of a leg is a siding.
    pub fn is_siding(&self, leg: Leg) -> bool {
        self.sidings[leg.index()]
    }
}

/// Returns the stretches of an edge where a robot blocks others, in ascending order, merged.
/// `arrivals` is the number of edges that lead to each node.
fn closed(roads: &Roads, footprint: usize, edge: u32, arrivals: &[u32]) -> Vec<Span> {
    let length = roads.edge(edge).length;
    let mut spans: Vec<Span> = (0..roads.footprints().len())
        .flat_map(|other| roads.conflicts().of(footprint, other, edge))
        .filter_map(|(track, relation)| match relation {
            Relation::Crossing { own, .. } => Some(own),
            // A robot just before a node where roads meet keeps those out that come from
            // elsewhere.
            Relation::Into(apart) if arrivals[roads.edge(track).origin as usize] > 1 => {
                Some(Span::new(length - apart, length))
            }
            Relation::Into(_) | Relation::From(_) => None,
        })
        .collect();
    let zones = roads.zones();
    let exclusive = zones.parts(edge).iter().filter(|part| zones.is_exclusive(part.zone));
    spans.extend(exclusive.map(|part| part.span));
    spans.sort_unstable_by(|a, b| a.low.total_cmp(&b.low));
    let mut merged: Vec<Span> = Vec::new();
    for span in spans {
        match merged.last_mut() {
            Some(last) if span.low <= last.high => last.high = last.high.max(span.high),
            _ => merged.push(span),
        }
    }
    merged
}

fn is_siding(roads: &Roads, footprint: usize, leg: Leg) -> bool {
    let node = roads.end(leg);
    let place = if leg.is_reverse() { 0.0 } else { roads.edge(leg.edge()).length };
    let zones = roads.zones();
    let mut parts = zones.parts(leg.edge()).iter();
    if parts.any(|part| zones.is_exclusive(part.zone) && part.span.contains(place)) {
        return false;
    }
    (0..roads.footprints().len()).all(|other| {
        roads.conflicts().of(footprint, other, leg.edge()).all(|(track, relation)| match relation {
            Relation::Crossing { own, .. } => !own.contains(place) || meets(roads, track, node),
            Relation::Into(_) | Relation::From(_) => true,
        })
    })
}

/// Whether a track meets a node.
fn meets(roads: &Roads, track: u32, node: u32) -> bool {
    match roads.edges().get(track as usize) {
        Some(edge) => edge.origin == node || edge.destination == node,
        None => track == roads.disc(node),
    }
}
