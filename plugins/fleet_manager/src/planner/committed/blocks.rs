//! The legs that a standing robot blocks.

use crate::claims::Stretch;
use crate::roads::{Leg, Relation, Roads};

/// The number of something that a robot can be in the way of: a leg, or the place of a node where
/// robots turn on the spot.
pub type Key = u32;

/// Returns the key of the place of a node where robots turn on the spot.
pub fn disc_key(roads: &Roads, node: u32) -> Key {
    2 * roads.edges().len() as u32 + node
}

/// Returns the number of keys.
pub fn key_count(roads: &Roads) -> usize {
    2 * roads.edges().len() + roads.nodes() as usize
}

/// The end of a leg, where a robot of a footprint stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EndId(usize);

/// The keys that robots block which stand at the ends of legs, computed on demand.
#[derive(Debug, Default)]
pub struct Blocks {
    /// By footprint and leg; `None` if they aren't computed yet.
    at_ends: Vec<Option<Box<[Key]>>>,
}

impl Blocks {
    /// Returns all that a robot blocks that stands at a place: the legs that no other robot can
    /// drive from end to end, and the nodes where none can turn. In ascending order.
    pub fn of(&mut self, roads: &Roads, footprint: usize, place: &Stretch) -> Vec<Key> {
        match place.leg.filter(|leg| place.to >= roads.edge(leg.edge()).length) {
            Some(leg) => self.at_end(roads, footprint, leg).to_vec(),
            None => blocked(roads, footprint, place),
        }
    }

    /// The same for a robot at the end of a leg.
    pub fn at_end(&mut self, roads: &Roads, footprint: usize, leg: Leg) -> &[Key] {
        let end = self.end(roads, footprint, leg);
        self.at(end)
    }

    /// The end of a leg, for [`at`](Self::at).
    pub fn end(&mut self, roads: &Roads, footprint: usize, leg: Leg) -> EndId {
        let legs = 2 * roads.edges().len();
        let index = footprint * legs + leg.index();
        if index >= self.at_ends.len() {
            self.at_ends.resize((footprint + 1) * legs, None);
        }
        self.at_ends[index].get_or_insert_with(|| {
            let end = Stretch::at(leg, roads.edge(leg.edge()).length);
            blocked(roads, footprint, &end).into_boxed_slice()
        });
        EndId(index)
    }

    /// All that a robot blocks at an end, in ascending order.
    pub fn at(&self, end: EndId) -> &[Key] {
        self.at_ends[end.0].as_deref().unwrap_or_default()
    }
}

fn blocked(roads: &Roads, footprint: usize, place: &Stretch) -> Vec<Key> {
    let mut keys = Vec::new();
    add_track(roads, place.track, &mut keys);
    let s = metres_from_origin(roads, place);
    add_zones(roads, place.track, s, &mut keys);
    let length = roads.conflicts().length(place.track);
    for other in 0..roads.footprints().len() {
        for (track, relation) in roads.conflicts().of(footprint, other, place.track) {
            let touches = match relation {
                Relation::Crossing { own, .. } => own.contains(s),
                Relation::Into(apart) => length - s < apart,
                Relation::From(apart) => s < apart,
            };
            if touches {
                add_track(roads, track, &mut keys);
            }
        }
    }
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// Adds all tracks of the zones for one robot that a place is in.
fn add_zones(roads: &Roads, track: u32, s: f32, keys: &mut Vec<Key>) {
    for part in roads.zones().parts(track).iter().filter(|part| part.span.contains(s)) {
        if roads.zones().is_exclusive(part.zone) {
            for &track in roads.zones().tracks(part.zone) {
                add_track(roads, track, keys);
            }
        }
    }
}

/// Adds both legs of an edge, or the place of a node.
fn add_track(roads: &Roads, track: u32, keys: &mut Vec<Key>) {
    match track.checked_sub(roads.edges().len() as u32) {
        Some(node) => keys.push(disc_key(roads, node)),
        None => keys.extend([2 * track, 2 * track + 1]),
    }
}

/// The end of a stretch, in metres from the origin of its edge.
fn metres_from_origin(roads: &Roads, stretch: &Stretch) -> f32 {
    match stretch.leg {
        Some(leg) if leg.is_reverse() => roads.edge(leg.edge()).length - stretch.to,
        _ => stretch.to,
    }
}

/// Whether a robot that stands at `place` is in the way of one that drives on along a leg to its
/// end, `from` metres from where the leg is entered. Both are given with their footprints.
pub fn blocks_rest(
    roads: &Roads,
    (footprint, leg, from): (usize, Leg, f32),
    (other, place): (usize, &Stretch),
) -> bool {
    let length = roads.edge(leg.edge()).length;
    let along = |s: f32| if leg.is_reverse() { length - s } else { s };
    let s = metres_from_origin(roads, place);
    if place.track == leg.edge() {
        return along(s) >= from;
    }
    if is_in_zone_ahead(roads, (leg, from), (place.track, s)) {
        return true;
    }
    let other_length = roads.conflicts().length(place.track);
    roads.conflicts().of(footprint, other, leg.edge()).any(|(track, relation)| {
        track == place.track
            && match relation {
                Relation::Crossing { own, other } => {
                    other.contains(s) && along(own.low).max(along(own.high)) >= from
                }
                // Ahead, where this leg leads into the other one's edge.
                Relation::Into(apart) => !leg.is_reverse() && s < apart,
                Relation::From(apart) => leg.is_reverse() && other_length - s < apart,
            }
    })
}

/// Whether a place is in a zone for one robot that a robot would enter which drives on along a leg.
fn is_in_zone_ahead(roads: &Roads, (leg, from): (Leg, f32), (track, s): (u32, f32)) -> bool {
    let zones = roads.zones();
    let mut here = zones.parts(track).iter();
    here.any(|part| {
        let is_held = part.span.contains(s) && zones.is_exclusive(part.zone);
        let mut ahead = zones.parts(leg.edge()).iter();
        is_held
            && ahead
                .any(|other| other.zone == part.zone && other.driven(roads, Some(leg)).low > from)
    })
}
