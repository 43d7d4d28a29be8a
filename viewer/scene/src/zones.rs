//! The zones on the plan, each with the place where its name is written: the middle of its members.

use std::collections::{BTreeMap, HashSet};

use glam::Vec2;
use regatta_plugin::World;

use super::curves::midpoint;
use super::is_on_level;

/// The places of the members of zones, by the offsets of the zones' names.
type Members = BTreeMap<u32, Vec<Vec2>>;

/// Returns the names and places of the zones of a level (`None` for all levels). The zone of a
/// lift's robots is left out: the lift has its own name.
pub fn zones(world: &World<'_>, level: Option<&str>) -> Vec<(String, Vec2)> {
    let lifts: Vec<_> =
        world.lifts().iter().map(|lift| format!("lift {}", world.text(lift.name))).collect();
    let members = members(world, level).into_iter();
    let named = members.map(|(name, places)| (world.text(name), places));
    let named = named.filter(|(name, _)| !lifts.iter().any(|lift| lift == name));
    named
        .map(|(name, places)| {
            let middle = places.iter().sum::<Vec2>() / places.len() as f32;
            (name.to_owned(), middle)
        })
        .collect()
}

/// Returns the members of zones: those of zones with rules, and nodes and edges that name a zone.
fn members(world: &World<'_>, level: Option<&str>) -> Members {
    let mut members = Members::new();
    for zone in world.zones() {
        let nodes = world.zone_nodes(zone).iter().map(|node| node_place(world, *node, level));
        let edges = world.zone_edges(zone).iter().map(|edge| edge_place(world, *edge, level));
        add(&mut members, zone.name, nodes.chain(edges));
    }
    let ruled: HashSet<&str> = world.zones().iter().map(|zone| world.text(zone.name)).collect();
    let is_tag = |zone: u32| !ruled.contains(world.text(zone)) && !world.text(zone).is_empty();
    for (index, node) in (0..).zip(world.nodes()).filter(|(_, node)| is_tag(node.zone)) {
        add(&mut members, node.zone, [node_place(world, index, level)]);
    }
    for (index, edge) in (0..).zip(world.edges()).filter(|(_, edge)| is_tag(edge.zone)) {
        add(&mut members, edge.zone, [edge_place(world, index, level)]);
    }
    members
}

/// Adds the places of members that are on the level.
fn add(members: &mut Members, zone: u32, places: impl IntoIterator<Item = Option<Vec2>>) {
    let mut places = places.into_iter().flatten().filter(|place| place.is_finite()).peekable();
    if places.peek().is_some() {
        members.entry(zone).or_default().extend(places);
    }
}

fn node_place(world: &World<'_>, index: u32, level: Option<&str>) -> Option<Vec2> {
    let node = world.nodes().get(index as usize)?;
    is_on_level(world, node.level, level).then(|| Vec2::new(node.x, node.y))
}

fn edge_place(world: &World<'_>, index: u32, level: Option<&str>) -> Option<Vec2> {
    let edge = world.edges().get(index as usize)?;
    midpoint(world, edge).filter(|_| is_on_level(world, edge.level, level))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{NodeRecord, WorldData, ZoneRecord};

    use super::*;

    #[test]
    fn a_zone_is_named_in_the_middle_of_its_members_on_the_level() {
        let mut data = WorldData::default();
        let [door, hall, level] = ["door", "hall", "L1"].map(|text| data.texts.add(text));
        let node = |x, zone, level| NodeRecord { x, zone, level, ..NodeRecord::default() };
        data.nodes = vec![node(0.0, hall, level), node(4.0, hall, level), node(9.0, door, 0)];
        data.add_zone(ZoneRecord { name: door, ..ZoneRecord::default() }, [1, 2], []);
        let world = data.view(1, 1);
        let all = [("door".to_owned(), Vec2::new(6.5, 0.0)), ("hall".to_owned(), Vec2::X * 2.0)];
        assert_eq!(zones(&world, None), all);
        assert_eq!(zones(&world, Some("L1"))[0].1, Vec2::X * 4.0);
    }
}
