//! Places where a robot may stand without blocking others than those behind it.
//!
//! A place of an edge is *open* if a robot that stands there is in nobody's way but on the edge
//! itself and on those that lead straight into or out of it. A node is a *siding* if a robot that
//! stands there is only in the way of edges that meet there.

use super::{Leg, Reader, Relation, Roads, Writer, cores};

/// The stopping places of robots with one footprint.
#[derive(Clone, Debug, Default)]
pub struct Stops {
    /// Stretches of each edge that aren't open, in ascending order: `closed[starts[e]..starts[e +
    /// 1]]`.
    starts: Vec<u32>,
    closed: Vec<[f32; 2]>,
    /// By leg: whether its end is a siding.
    sidings: Vec<bool>,
}

/// The distance that a robot has to keep from a closed stretch, in metres: its border counts as
/// closed for others.
const BORDER: f32 = 0.01;

impl Stops {
    pub(super) fn new(roads: &Roads, footprint: usize) -> Self {
        let mut stops = Self { starts: vec![0], ..Self::default() };
        let mut arrivals = vec![0; roads.nodes() as usize];
        roads.edges().iter().for_each(|edge| arrivals[edge.destination as usize] += 1);
        let places = cores::map(roads.edges().len(), |edge| {
            let sidings = [false, true]
                .map(|reverse| is_siding(roads, footprint, Leg::new(edge as u32, reverse)));
            (closed(roads, footprint, edge as u32, &arrivals), sidings)
        });
        for (closed, sidings) in places {
            stops.closed.extend(closed);
            stops.starts.push(stops.closed.len() as u32);
            stops.sidings.extend(sidings);
        }
        stops
    }

    /// Writes them.
    pub(super) fn write(&self, writer: &mut Writer) {
        writer.list(self.starts.iter().copied());
        [0, 1]
            .into_iter()
            .for_each(|end| writer.floats(self.closed.iter().map(|closed| closed[end])));
        writer.list(self.sidings.iter().map(|is_siding| u32::from(*is_siding)));
    }

    /// Reads those of some edges.
    pub(super) fn read(edges: usize, reader: &mut Reader<'_>) -> Option<Self> {
        let starts = reader.starts(edges)?;
        let count = *starts.last()? as usize;
        let (low, high) = (reader.floats(count)?, reader.floats(count)?);
        let closed = low.into_iter().zip(high).map(|(low, high)| [low, high]).collect();
        let sidings =
            reader.list_of(2 * edges)?.into_iter().map(|is_siding| is_siding != 0).collect();
        Some(Self { starts, closed, sidings })
    }

    /// Returns the farthest open place of a leg in `from` to `to`, both in metres from where it is
    /// entered.
    pub fn last_open(&self, leg: Leg, length: f32, from: f32, to: f32) -> Option<f32> {
        let closed = self.closed(leg.edge());
        let mut place = to;
        let mut leave = |[low, high]: [f32; 2]| {
            if place >= low && place <= high {
                place = low - BORDER;
            }
        };
        if leg.is_reverse() {
            closed.iter().for_each(|&[low, high]| leave([length - high, length - low]));
        } else {
            closed.iter().rev().for_each(|&stretch| leave(stretch));
        }
        (place >= from).then_some(place)
    }

    /// Returns the first open place of a leg at `from` or beyond, in metres from where it is
    /// entered.
    pub fn next_open(&self, leg: Leg, length: f32, from: f32) -> Option<f32> {
        let mut place = from;
        let mut leave = |[low, high]: [f32; 2]| {
            if place >= low && place <= high {
                place = high + BORDER;
            }
        };
        let closed = self.closed(leg.edge());
        if leg.is_reverse() {
            closed.iter().rev().for_each(|&[low, high]| leave([length - high, length - low]));
        } else {
            closed.iter().for_each(|&stretch| leave(stretch));
        }
        (place <= length).then_some(place)
    }

    /// Metres of an edge that aren't open.
    pub fn closed_length(&self, edge: u32) -> f32 {
        self.closed(edge).iter().map(|[low, high]| high - low).sum()
    }

    fn closed(&self, edge: u32) -> &[[f32; 2]] {
        &self.closed[self.starts[edge as usize] as usize..self.starts[edge as usize + 1] as usize]
    }

    /// Whether the end of a leg is a siding.
    pub fn is_siding(&self, leg: Leg) -> bool {
        self.sidings[leg.index()]
    }
}

/// Returns the stretches of an edge where a robot blocks others, in ascending order, merged.
/// `arrivals` is the number of edges that lead to each node.
fn closed(roads: &Roads, footprint: usize, edge: u32, arrivals: &[u32]) -> Vec<[f32; 2]> {
    let length = roads.edge(edge).length;
    let mut spans: Vec<[f32; 2]> = (0..roads.footprints().len())
        .flat_map(|other| roads.conflicts().of(footprint, other, edge))
        .filter_map(|(track, relation)| match relation {
            Relation::Crossing { own, .. } => Some(own),
            // A robot just before a node where roads meet keeps those out that come from
            // elsewhere.
            Relation::Into(apart) if arrivals[roads.edge(track).origin as usize] > 1 => {
                Some([length - apart, length])
            }
            Relation::Into(_) | Relation::From(_) => None,
        })
        .collect();
    spans.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut merged: Vec<[f32; 2]> = Vec::new();
    for [low, high] in spans {
        match merged.last_mut() {
            Some(last) if low <= last[1] => last[1] = last[1].max(high),
            _ => merged.push([low, high]),
        }
    }
    merged
}

fn is_siding(roads: &Roads, footprint: usize, leg: Leg) -> bool {
    let node = roads.end(leg);
    let place = if leg.is_reverse() { 0.0 } else { roads.edge(leg.edge()).length };
    let meets = |track: u32| match roads.edges().get(track as usize) {
        Some(edge) => edge.origin == node || edge.destination == node,
        None => track == roads.disc(node),
    };
    (0..roads.footprints().len()).all(|other| {
        roads.conflicts().of(footprint, other, leg.edge()).all(|(track, relation)| match relation {
            Relation::Crossing { own, .. } => place < own[0] || place > own[1] || meets(track),
            Relation::Into(_) | Relation::From(_) => true,
        })
    })
}
