//! Conflicts between stretches of tracks.
//!
//! A track is an edge, or the place of a node at which robots turn on the spot. Two robots on
//! different tracks may touch only where the table has a pair. All values are rounded outwards, so
//! each pair of touching poses is in the table.

mod build;

use regatta_base::rows::Rows;
use regatta_base::sweep::{Span, Sweep};

use super::{Reader, Roads, Writer};

/// A conflict between robots on two tracks. Places are metres from the origins of the edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relation {
    /// A robot within `own` may touch one within `other`.
    Crossing {
        /// The stretch of this track.
        own: Span,
        /// The stretch of the other.
        other: Span,
    },
    /// This track leads into the other: a robot here may touch one there if they are less than this
    /// far apart, in metres from here to the end of this track and from the start of the other to
    /// there.
    Into(f32),
    /// The other track leads into this one.
    From(f32),
}

/// A pair of tracks, as seen from one of them. Eight bytes, because there are several for each
/// edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pair {
    /// The other track, and in the two highest bits the kind of relation.
    other_and_kind: u32,
    /// `Crossing`: the stretches, in 1/255 of each length. Else the distance in the first two, in
    /// 1/32 m.
    spans: [u8; 4],
}

const KIND_SHIFT: u32 = 30;
/// Resolution of distances between robots that follow each other, in 1/m.
const PER_METRE: f32 = 32.0;

impl Pair {
    pub(super) fn new(other: u32, relation: Relation, own_length: f32, other_length: f32) -> Self {
        let (kind, spans) = match relation {
            Relation::Crossing { own, other } => {
                let ([a, b], [c, d]) = (outward(own, own_length), outward(other, other_length));
                (0, [a, b, c, d])
            }
            Relation::Into(metres) => (1, distance(metres)),
            Relation::From(metres) => (2, distance(metres)),
        };
        Self { other_and_kind: other | kind << KIND_SHIFT, spans }
    }

    pub(super) fn other(self) -> u32 {
        self.other_and_kind & ((1 << KIND_SHIFT) - 1)
    }

    fn relation(self, own_length: f32, other_length: f32) -> Relation {
        let [low, high, ..] = self.spans;
        let metres = f32::from(u16::from_le_bytes([low, high])) / PER_METRE;
        let [a, b, c, d] = self.spans.map(|part| f32::from(part) / 255.0);
        match self.other_and_kind >> KIND_SHIFT {
            1 => Relation::Into(metres),
            2 => Relation::From(metres),
            _ => Relation::Crossing {
                own: Span::new(a * own_length, b * own_length),
                other: Span::new(c * other_length, d * other_length),
            },
        }
    }
}

/// Resolution of the distances at which robots follow each other, in metres.
pub const RESOLUTION: f32 = 1.0 / PER_METRE;

/// Returns a distance in 1/32 m, rounded up: two kilometres at most, twice the longest robot.
fn distance(metres: f32) -> [u8; 4] {
    let [low, high] = ((metres * PER_METRE).ceil() as u16).to_le_bytes();
    [low, high, 0, 0]
}

/// Returns a stretch in 1/255 of a length, rounded outwards.
fn outward(span: Span, length: f32) -> [u8; 2] {
    if length <= 0.0 {
        return [0, 255];
    }
    // Rounded a little further: the division may round inwards.
    let (low, high) = (span.low / length * 255.0 - 1e-3, span.high / length * 255.0 + 1e-3);
    [low.floor().max(0.0) as u8, high.ceil().min(255.0) as u8]
}

/// The conflicts of robots with one footprint (on the track asked about) and robots with another.
#[derive(Clone, Debug)]
pub struct ConflictTable {
    /// By track.
    pairs: Rows<Pair>,
    /// By track: how far apart two robots on it have to be, in metres.
    separations: Vec<f32>,
}

/// The conflicts of all footprints.
#[derive(Debug, Default)]
pub struct Conflicts {
    /// By own and other footprint.
    tables: Vec<ConflictTable>,
    footprints: usize,
    /// By track, in metres; 0 for the place of a node.
    lengths: Vec<f32>,
}

impl Conflicts {
    pub(super) fn new(roads: &Roads, sweeps: &[Sweep], discs: &[u32]) -> Self {
        let lengths = lengths(roads);
        let tables = build::tables(roads, sweeps, discs, &lengths);
        Self { tables, footprints: roads.footprints().len(), lengths }
    }

    /// Writes all tables.
    pub(super) fn write(&self, writer: &mut Writer) {
        for table in &self.tables {
            table.write(writer);
        }
    }

    /// Reads the tables of roads.
    pub(super) fn read(roads: &Roads, reader: &mut Reader<'_>) -> Option<Self> {
        let (lengths, footprints) = (lengths(roads), roads.footprints().len());
        let tables =
            (0..footprints * footprints).map(|_| ConflictTable::read(lengths.len(), reader));
        Some(Self { tables: tables.collect::<Option<_>>()?, footprints, lengths })
    }

    /// The conflicts of robots with a footprint with robots of another one, by index.
    pub fn table(&self, own: usize, other: usize) -> &ConflictTable {
        &self.tables[own * self.footprints + other]
    }

    /// The tracks that conflict with a track, with the relations.
    pub fn of(
        &self,
        own: usize,
        other: usize,
        track: u32,
    ) -> impl Iterator<Item = (u32, Relation)> + '_ {
        let length = self.length(track);
        let pairs = self.table(own, other).pairs.row(track);
        pairs
            .iter()
            .map(move |pair| (pair.other(), pair.relation(length, self.length(pair.other()))))
    }

    /// The conflicts of a track for robots of any footprint: the other tracks and the relations.
    pub fn of_any(&self, track: u32) -> impl Iterator<Item = (u32, Relation)> + '_ {
        let pairs = (0..self.footprints)
            .flat_map(|own| (0..self.footprints).map(move |other| (own, other)));
        pairs.flat_map(move |(own, other)| self.of(own, other, track))
    }

    /// Some tracks and those that conflict with them, in ascending order, without repetitions.
    pub fn near(&self, tracks: &[u32]) -> Vec<u32> {
        let mut near = tracks.to_vec();
        for &track in tracks {
            near.extend(self.of_any(track).map(|(other, _)| other));
        }
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Length of a track, in metres.
    pub fn length(&self, track: u32) -> f32 {
        self.lengths[track as usize]
    }

    /// Number of pairs, each counted from both sides.
    pub fn len(&self) -> usize {
        self.tables.iter().map(|table| table.pairs.values().len()).sum()
    }

    /// Whether there are no conflicts.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of tracks.
    pub fn tracks(&self) -> usize {
        self.lengths.len()
    }
}

/// Returns the lengths of all tracks, in metres.
fn lengths(roads: &Roads) -> Vec<f32> {
    let lengths = roads.edges().iter().map(|edge| edge.length);
    lengths.chain((0..roads.nodes()).map(|_| 0.0)).collect()
}

impl ConflictTable {
    fn write(&self, writer: &mut Writer) {
        let pairs = self.pairs.values();
        writer.list(self.pairs.starts().iter().copied());
        writer.list(pairs.iter().map(|pair| pair.other_and_kind));
        writer.list(pairs.iter().map(|pair| u32::from_le_bytes(pair.spans)));
        writer.floats(self.separations.iter().copied());
    }

    fn read(tracks: usize, reader: &mut Reader<'_>) -> Option<Self> {
        let starts = reader.starts(tracks)?;
        let count = *starts.last()? as usize;
        let (others, spans) = (reader.list_of(count)?, reader.list_of(count)?);
        let pairs = others.into_iter().zip(spans);
        let pairs = pairs
            .map(|(other_and_kind, spans)| Pair { other_and_kind, spans: spans.to_le_bytes() });
        let pairs: Vec<Pair> = pairs.collect();
        let separations = reader.floats(tracks)?;
        let is_possible = pairs.iter().all(|pair| (pair.other() as usize) < tracks);
        is_possible.then(|| Self { pairs: Rows::of_parts(starts, pairs), separations })
    }

    /// Sorts the pairs by track; each comes with the track that it is seen from.
    pub(super) fn new(mut found: Vec<(u32, Pair)>, separations: Vec<f32>) -> Self {
        found.sort_unstable_by_key(|(track, pair)| (*track, pair.other()));
        Self { pairs: Rows::of_sorted(separations.len(), found), separations }
    }

    /// The least distance between two robots on a track, in metres.
    pub fn separation(&self, track: u32) -> f32 {
        self.separations[track as usize]
    }
}
