//! The names of stations, doors, lifts and zones on the plan, each with the scale from which there
//! is room for it. A name that is shown at a scale is shown at all larger ones, so that names neither
//! flicker nor jump while a camera moves.

use std::collections::HashMap;

use glam::{IVec2, Vec2};
use regatta_plugin::World;
use regatta_plugin::world::{EdgeRecord, NodeRecord};

use super::facilities::named;
use super::stations::stations;
use super::zones::zones;

/// The mean width of a letter, in heights of the font.
const LETTER: f32 = 0.55;
/// The room that each name keeps free to each side, and above and below, in heights of the font.
const FREE: Vec2 = Vec2::new(1.5, 1.0);
/// The side of a cell of the grid in which names are searched for, in heights of the font.
const CELL: f32 = 8.0;
/// The largest scale that is searched, in heights of the font per metre: from there on, names are
/// centimetres apart.
const LARGEST_SCALE: f32 = 16.0;
/// The size of all names together at the smallest scale that is searched, in heights of the font.
const SMALLEST_PICTURE: f32 = 16.0;

/// A name on the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// The name.
    pub text: Box<str>,
    /// The place of what has the name, in metres.
    pub place: Vec2,
    /// The scale from which there is room for the name, in heights of the font per metre.
    pub scale: f32,
}

/// Returns the name of an edge, or else its id, as everything that tells of it does.
pub fn edge_name(world: &World<'_>, edge: &EdgeRecord) -> String {
    name_or_id(world.text(edge.name), edge.id)
}

/// Returns the name of a node, or else its id, as everything that tells of it does.
pub fn node_name(world: &World<'_>, node: &NodeRecord) -> String {
    name_or_id(world.text(node.name), node.id)
}

/// Returns the name of an edge, or else the word and its id: `edge 12`. It stands alone, beside no
/// word that tells of an edge.
pub fn titled_edge(world: &World<'_>, edge: &EdgeRecord) -> String {
    match world.text(edge.name) {
        "" => format!("edge {}", edge.id),
        name => name.to_owned(),
    }
}

fn name_or_id(name: &str, id: u32) -> String {
    if name.is_empty() { id.to_string() } else { name.to_owned() }
}

/// Returns the names of the doors, lifts, stations and zones of a level (`None` for all levels), in
/// ascending order of their scales.
pub fn names(world: &World<'_>, level: Option<&str>) -> Vec<Name> {
    let facilities = named(world, level).into_iter();
    let facilities = facilities.map(|facility| (facility.name.into(), facility.place));
    let stations = stations(world, level).into_iter();
    let stations = stations.map(|station| (station.name.into(), station.place));
    let zones = zones(world, level).into_iter().map(|(name, place)| (name.into(), place));
    let all = facilities.chain(stations).chain(zones);
    with_scales(all.filter(|(_, place)| place.is_finite()).collect())
}

/// Gives each name the smallest power of two, in heights of the font per metre, at which it has
/// room beside the names before it.
fn with_scales(names: Vec<(Box<str>, Vec2)>) -> Vec<Name> {
    let mut shown: Vec<Name> = Vec::with_capacity(names.len());
    let mut waiting = names;
    let mut scale = smallest_scale(&waiting);
    while scale < LARGEST_SCALE && !waiting.is_empty() {
        let mut taken = Taken::default();
        for name in &shown {
            taken.add(area(&name.text, name.place * scale));
        }
        waiting.retain_mut(|(text, place)| {
            let area = area(text, *place * scale);
            let is_free = taken.has_room(area);
            if is_free {
                taken.add(area);
                shown.push(Name { text: std::mem::take(text), place: *place, scale });
            }
            !is_free
        });
        scale *= 2.0;
    }
    let rest = waiting.into_iter().map(|(text, place)| Name { text, place, scale });
    shown.extend(rest);
    shown
}

/// Returns the scale at which all names are in a small picture: a power of two.
fn smallest_scale(names: &[(Box<str>, Vec2)]) -> f32 {
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for (_, place) in names {
        (low, high) = (low.min(*place), high.max(*place));
    }
    let metres = (high - low).max_element().clamp(1.0, 1e6);
    (SMALLEST_PICTURE / metres).log2().floor().exp2()
}

/// Left lower and right upper corner of a name with its free room, in heights of the font. Names
/// are to the right of their places.
type Area = [Vec2; 2];

fn area(text: &str, place: Vec2) -> Area {
    let size = Vec2::new(text.chars().count() as f32 * LETTER, 1.0);
    [place - FREE / 2.0, place + size + FREE / 2.0]
}

/// The areas that are taken, by the cells of a grid.
#[derive(Debug, Default)]
struct Taken(HashMap<IVec2, Vec<Area>>);

impl Taken {
    fn has_room(&self, area: Area) -> bool {
        let mut near = cells(area).filter_map(|cell| self.0.get(&cell)).flatten();
        !near.any(|other| area[0].cmplt(other[1]).all() && other[0].cmplt(area[1]).all())
    }

    fn add(&mut self, area: Area) {
        for cell in cells(area) {
            self.0.entry(cell).or_default().push(area);
        }
    }
}

fn cells(area: Area) -> impl Iterator<Item = IVec2> {
    let [low, high] = area.map(|corner| (corner / CELL).floor().as_ivec2());
    (low.x..=high.x).flat_map(move |x| (low.y..=high.y).map(move |y| IVec2::new(x, y)))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{DoorRecord, EdgeRecord, NodeRecord, Role, WorldData};

    use super::*;

    /// A world with a station every two metres, named by its number, and one without a role.
    fn world(stations: u32) -> WorldData {
        let mut world = WorldData::default();
        for id in 0..stations {
            let name = world.texts.add(&format!("rack {id:04}"));
            let (x, role) = (id as f32 * 2.0, Role::Pick as u32);
            world.nodes.push(NodeRecord { id, name, x, role, ..NodeRecord::default() });
        }
        world.nodes.push(NodeRecord { y: 1.0, ..NodeRecord::default() });
        world
    }

    #[test]
    fn names_that_are_shown_together_do_not_overlap_and_all_are_shown_at_last() {
        let data = world(400);
        let names = names(&data.view(1, 1), None);
        assert_eq!(names.len(), 400, "nodes without a role have no name");
        assert!(names.is_sorted_by_key(|name| name.scale));
        for scale in [0.03, 0.1, 0.5, 2.0] {
            let shown: Vec<_> = names.iter().filter(|name| name.scale <= scale).collect();
            assert!(!shown.is_empty(), "{scale}");
            let areas: Vec<_> = shown.iter().map(|n| area(&n.text, n.place * scale)).collect();
            let mut sorted = areas.clone();
            sorted.sort_by(|a, b| a[0].x.total_cmp(&b[0].x));
            assert!(sorted.windows(2).all(|pair| pair[0][1].x <= pair[1][0].x), "{scale}");
        }
        let few = names.iter().filter(|name| name.scale <= 0.1).count();
        assert!((5..30).contains(&few), "80 heights of the font have room for few: {few}");
        assert!(names.iter().all(|name| name.scale <= 4.0));
    }

    #[test]
    fn doors_precede_stations_and_names_at_one_place_take_turns() {
        let mut data = world(1);
        let name = data.texts.add("gate");
        data.add_edge(EdgeRecord::default(), []);
        data.add_door(DoorRecord { name, ..DoorRecord::default() }, [0]);
        let names = names(&data.view(1, 1), None);
        let [gate, rack] = &names[..] else { panic!("{names:?}") };
        assert_eq!((&*gate.text, &*rack.text), ("gate", "rack 0000"));
        assert!(gate.scale <= LARGEST_SCALE && rack.scale >= LARGEST_SCALE);
    }

    #[test]
    fn a_world_without_names_has_none() {
        assert!(names(&WorldData::default().view(1, 1), None).is_empty());
    }
}
