//! The stations on the plan: places where robots pick, drop, park or charge, with the nodes from
//! which robots serve them. A node with a role that no station has is a station of its own.

use std::collections::HashSet;

use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::{NodeRecord, Role};

use super::facilities::{Bar, BarColour};
use super::is_on_level;

/// The distance in metres from which on a station is joined with its node by a line.
const BESIDE: f32 = 0.05;

/// A station on the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Station<'a> {
    /// Its name; the role and the id of a node without a name.
    pub name: String,
    /// The work of robots there.
    pub role: Role,
    /// Metres east and north of the world's origin.
    pub place: Vec2,
    /// The nodes from which robots serve it, by their indices; none if it is a node itself.
    pub nodes: &'a [u32],
}

/// Returns the stations of a level (`None` for all levels).
pub fn stations<'a>(world: &World<'a>, level: Option<&str>) -> Vec<Station<'a>> {
    let mut stations = Vec::new();
    for record in world.stations().iter().filter(|record| is_on_level(world, record.level, level)) {
        stations.push(Station {
            name: world.text(record.name).to_owned(),
            role: record.role(),
            place: Vec2::new(record.x, record.y),
            nodes: world.station_nodes(record),
        });
    }
    let served = served(world);
    for (node, index) in world.nodes().iter().zip(0..) {
        if is_station(node, index, &served) && is_on_level(world, node.level, level) {
            let name = own_name(world, node);
            let place = Vec2::new(node.x, node.y);
            stations.push(Station { name, role: node.role(), place, nodes: &[] });
        }
    }
    stations.retain(|station| station.place.is_finite());
    stations
}

/// The name of a node that is a station of its own.
fn own_name(world: &World<'_>, node: &NodeRecord) -> String {
    match world.text(node.name) {
        "" => format!("{} {}", node.role().name(), node.id),
        name => name.to_owned(),
    }
}

/// Returns the name of the station that robots serve from a node, by its index, or that the node
/// is.
pub fn station_at(world: &World<'_>, index: u32) -> Option<String> {
    let mut stations = world.stations().iter();
    let station = stations.find(|record| world.station_nodes(record).contains(&index));
    if let Some(record) = station {
        return Some(world.text(record.name).to_owned());
    }
    let node = world.nodes().get(index as usize).filter(|node| node.role() != Role::None)?;
    Some(own_name(world, node))
}

/// The nodes from which robots serve stations, by their indices.
pub fn served(world: &World<'_>) -> HashSet<u32> {
    let nodes = world.stations().iter().flat_map(|station| world.station_nodes(station));
    nodes.copied().collect()
}

/// Whether a node is a station of its own.
pub fn is_station(node: &NodeRecord, index: u32, served: &HashSet<u32>) -> bool {
    node.role() != Role::None && !served.contains(&index)
}

/// Returns the lines from stations to those of their nodes that are elsewhere.
pub fn links(world: &World<'_>, stations: &[Station<'_>]) -> Vec<Bar> {
    let mut links = Vec::new();
    for Station { place, nodes, .. } in stations {
        let nodes = nodes.iter().filter_map(|node| world.nodes().get(*node as usize));
        for node in nodes.map(|node| Vec2::new(node.x, node.y)) {
            if node.distance(*place) > BESIDE {
                links.push(Bar { ends: [*place, node], colour: BarColour::Link as u32 });
            }
        }
    }
    links
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{StationRecord, WorldData};

    use super::*;

    /// Returns a world with the station `Storage 01` beside the first of three nodes, which has its
    /// role, and a charger at the second.
    pub fn world() -> WorldData {
        let mut world = WorldData::default();
        let [name, level] = ["Storage 01", "L1"].map(|text| world.texts.add(text));
        let roles = [Role::Pick, Role::Charge, Role::None];
        for (role, id) in roles.into_iter().zip(0..) {
            let (x, role) = (id as f32 * 4.0, role as u32);
            world.nodes.push(NodeRecord { id, x, role, level, ..NodeRecord::default() });
        }
        let role = Role::Pick as u32;
        let station = StationRecord { name, level, y: 1.5, role, ..StationRecord::default() };
        world.add_station(station, [0, 9]);
        world
    }

    #[test]
    fn stations_precede_the_nodes_with_a_role_that_none_of_them_has() {
        let data = world();
        let world = data.view(1, 1);
        let stations = stations(&world, Some("L1"));
        let names: Vec<_> = stations.iter().map(|station| &*station.name).collect();
        assert_eq!(names, ["Storage 01", "charge 1"]);
        assert_eq!((stations[0].role, stations[0].place), (Role::Pick, Vec2::new(0.0, 1.5)));
        assert!(super::stations(&world, Some("L2")).is_empty());
    }

    #[test]
    fn a_station_is_joined_with_its_nodes() {
        let data = world();
        let world = data.view(1, 1);
        let links = links(&world, &stations(&world, None));
        assert_eq!(links.len(), 1, "the world has no tenth node");
        assert_eq!(links[0].ends, [Vec2::new(0.0, 1.5), Vec2::ZERO]);
    }
}
