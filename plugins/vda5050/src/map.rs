//! The layout of a fleet's world, by the ids that orders use.

use regatta_base::graph::{EdgeIndex, Gear, Leg};
use regatta_plugin::World;
use regatta_plugin::command::RouteLeg;
use regatta_plugin::world::{Orientation, Role};
use rustc_hash::FxHashMap;

/// Two positions at most this far apart are the same place, in metres.
const SAME_PLACE: f64 = 0.05;

/// The nodes and edges of a world, with the ids of the layout's own file.
///
/// The id of a node or an edge is its name, or its number if it has none. Nodes are also known by
/// the names of nodes that were joined with them, and of stations that are there alone.
#[derive(Clone, Debug, Default)]
pub struct Map {
    nodes: Vec<Place>,
    edges: Vec<Road>,
    node_ids: FxHashMap<String, Option<u32>>,
    edge_ids: FxHashMap<String, Option<u32>>,
    node_numbers: FxHashMap<u32, u32>,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its id in orders.
    pub id: String,
    /// Its number in the contract.
    pub number: u32,
    /// Metres on the map of the layout's file.
    pub x: f64,
    /// Metres on the map of the layout's file.
    pub y: f64,
    /// The map: the level of the layout, or the name for layouts without levels.
    pub map_id: String,
    /// Whether robots are charged there.
    pub is_charger: bool,
}

/// An edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Road {
    /// Its id in orders.
    pub id: String,
    /// Its number in the contract.
    pub number: u32,
    /// Index of the node where it begins.
    pub origin: u32,
    /// Index of the node where it ends.
    pub destination: u32,
    /// Metres.
    pub length: f64,
    /// Metres per second forward.
    pub speed: f64,
    /// Metres per second in reverse gear; 0 if that isn't allowed.
    pub reverse_speed: f64,
    /// The heading of robots along it.
    pub orientation: Orientation,
}

impl Map {
    /// Creates the map of a world. Nodes without a level are on the map `map_id`.
    pub fn of(world: &World<'_>, map_id: &str) -> Self {
        let mut map = Self::default();
        let [east, north] = world.origin();
        for node in world.nodes() {
            map.nodes.push(Place {
                id: id_of(world.text(node.name), node.id),
                number: node.id,
                x: east + f64::from(node.x),
                y: north + f64::from(node.y),
                map_id: Some(world.text(node.level))
                    .filter(|level| !level.is_empty())
                    .unwrap_or(map_id)
                    .to_owned(),
                is_charger: node.role() == Role::Charge,
            });
        }
        for edge in world.edges() {
            map.edges.push(Road {
                id: id_of(world.text(edge.name), edge.id),
                number: edge.id,
                origin: edge.origin,
                destination: edge.destination,
                length: f64::from(edge.length),
                speed: f64::from(edge.speed),
                reverse_speed: f64::from(edge.reverse_speed),
                orientation: edge.orientation(),
            });
        }
        map.index(world);
        map
    }

    fn index(&mut self, world: &World<'_>) {
        for (place, index) in self.nodes.iter().zip(0..) {
            add(&mut self.node_ids, &place.id, index);
            self.node_numbers.insert(place.number, index);
        }
        for (road, index) in self.edges.iter().zip(0..) {
            add(&mut self.edge_ids, &road.id, index);
        }
        let mut others = FxHashMap::default();
        for other in world.other_names() {
            add(&mut others, world.text(other.name), other.node);
        }
        for (name, node) in others {
            self.node_ids.entry(name).or_insert(node);
        }
    }

    /// The nodes.
    pub fn nodes(&self) -> &[Place] {
        &self.nodes
    }

    /// A node by its index.
    pub fn node(&self, index: u32) -> Option<&Place> {
        self.nodes.get(index as usize)
    }

    /// An edge by its index.
    pub fn edge(&self, index: u32) -> Option<&Road> {
        self.edges.get(index as usize)
    }

    /// The index of a node by its id; `None` for an id that no node has, or several.
    pub fn find_node(&self, id: &str) -> Option<u32> {
        self.node_ids.get(id).copied().flatten()
    }

    /// The index of an edge by its id.
    pub fn find_edge(&self, id: &str) -> Option<u32> {
        self.edge_ids.get(id).copied().flatten()
    }

    /// The index of a node by its number in the contract.
    pub fn node_with_number(&self, number: u32) -> Option<u32> {
        self.node_numbers.get(&number).copied()
    }

    /// Whether some node is on this map.
    pub fn has_map(&self, map_id: &str) -> bool {
        self.nodes.iter().any(|place| place.map_id == map_id)
    }

    /// The gear in which an edge is driven from one node to another.
    pub fn gear(&self, edge: u32, from: u32, to: u32) -> Option<Gear> {
        let road = self.edge(edge)?;
        if (road.origin, road.destination) == (from, to) {
            return Some(Gear::Forward);
        }
        let is_back = (road.destination, road.origin) == (from, to);
        (is_back && road.reverse_speed > 0.0).then_some(Gear::Reverse)
    }

    /// The speed at which the layout lets a leg be driven, in metres per second.
    pub fn speed(&self, leg: Leg) -> f64 {
        self.edge(leg.edge.0).map_or(0.0, |road| match leg.gear {
            Gear::Forward => road.speed,
            Gear::Reverse => road.reverse_speed,
        })
    }

    /// A leg as commands have it.
    pub fn route_leg(&self, leg: Leg) -> Option<RouteLeg> {
        let edge = self.edge(leg.edge.0)?.number;
        Some(match leg.gear {
            Gear::Forward => RouteLeg::forward(edge),
            Gear::Reverse => RouteLeg::reverse(edge),
        })
    }

    /// The node at a place, if there is one; the first of several.
    pub fn node_at(&self, x: f64, y: f64) -> Option<u32> {
        let mut nodes = self.nodes.iter().zip(0..);
        nodes.find(|(node, _)| (node.x - x).hypot(node.y - y) <= SAME_PLACE).map(|found| found.1)
    }

    /// The first leg that leaves a node.
    pub fn exit(&self, node: u32) -> Option<Leg> {
        let mut roads = self.edges.iter().zip(0..);
        let found = roads.find(|(road, _)| road.origin == node)?;
        Some(Leg { edge: EdgeIndex(found.1), gear: Gear::Forward })
    }
}

fn id_of(name: &str, number: u32) -> String {
    if name.is_empty() { number.to_string() } else { name.to_owned() }
}

/// Adds an index under an id. An id that several have stands for none.
fn add(ids: &mut FxHashMap<String, Option<u32>>, id: &str, index: u32) {
    ids.entry(id.to_owned()).and_modify(|known| *known = None).or_insert(Some(index));
}
