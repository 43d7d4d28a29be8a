//! The world as a producer makes it.

use super::view::{World, WorldLayout};
use super::{
    CurveRecord, EdgeRecord, NodeRecord, OtherNameRecord, RobotTypeRecord, Texts, ZoneRecord,
};

/// The content of a world, for
/// [`ProducerPorts::publish_world`](crate::ProducerPorts::publish_world).
///
/// ```
/// use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
///
/// let mut world = WorldData::default();
/// let name = world.texts.add("dock 1");
/// world.nodes = vec![NodeRecord { id: 1, name, ..NodeRecord::default() }, NodeRecord { id: 2, x: 3.0, ..NodeRecord::default() }];
/// let edge = EdgeRecord { id: 7, origin: 0, destination: 1, length: 3.0, speed: 1.0, ..EdgeRecord::default() };
/// world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [3.0, 0.0])]);
///
/// let world = world.view(1, 1);
/// assert_eq!(world.text(world.nodes()[0].name), "dock 1");
/// assert_eq!(world.curves(&world.edges()[0]).len(), 1);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldData {
    /// Metres east and north of (0, 0) of the fleet's positions, on the map of the route graph's
    /// file.
    pub origin: [f64; 2],
    /// The nodes.
    pub nodes: Vec<NodeRecord>,
    /// The edges, which refer to nodes and curves.
    pub edges: Vec<EdgeRecord>,
    /// The curves of all edges.
    pub curves: Vec<CurveRecord>,
    /// The robot types.
    pub robot_types: Vec<RobotTypeRecord>,
    /// The texts that nodes, edges and zones refer to.
    pub texts: Texts,
    /// The zones with a rule, which refer to members.
    pub zones: Vec<ZoneRecord>,
    /// The indices of the nodes and edges of all zones.
    pub zone_members: Vec<u32>,
    /// Names of nodes besides their own.
    pub other_names: Vec<OtherNameRecord>,
}

impl WorldData {
    /// Appends an edge with its curves, of which there must be at least one. Fills in `first_curve`
    /// and `curves`.
    pub fn add_edge(&mut self, edge: EdgeRecord, curves: impl IntoIterator<Item = CurveRecord>) {
        let first_curve = self.curves.len() as u32;
        self.curves.extend(curves);
        self.edges.push(EdgeRecord {
            first_curve,
            curves: self.curves.len() as u32 - first_curve,
            ..edge
        });
    }

    /// Appends a zone with its nodes and edges, by their indices. Fills in `first_member`, `nodes`
    /// and `edges`.
    pub fn add_zone(
        &mut self,
        zone: ZoneRecord,
        nodes: impl IntoIterator<Item = u32>,
        edges: impl IntoIterator<Item = u32>,
    ) {
        let first_member = self.zone_members.len();
        self.zone_members.extend(nodes);
        let first_edge = self.zone_members.len();
        self.zone_members.extend(edges);
        self.zones.push(ZoneRecord {
            first_member: first_member as u32,
            nodes: (first_edge - first_member) as u32,
            edges: (self.zone_members.len() - first_edge) as u32,
            ..zone
        });
    }

    /// Returns the world as its readers see it.
    pub fn view(&self, run_id: u64, revision: u64) -> World<'_> {
        World {
            header: self.layout().header(self.origin, run_id, revision),
            nodes: &self.nodes,
            edges: &self.edges,
            curves: &self.curves,
            robot_types: &self.robot_types,
            texts: self.texts.as_bytes(),
            zones: &self.zones,
            zone_members: &self.zone_members,
            other_names: &self.other_names,
        }
    }

    pub(crate) fn layout(&self) -> WorldLayout {
        WorldLayout {
            nodes: self.nodes.len(),
            edges: self.edges.len(),
            curves: self.curves.len(),
            robot_types: self.robot_types.len(),
            text_bytes: self.texts.as_bytes().len(),
            zones: self.zones.len(),
            zone_members: self.zone_members.len(),
            other_names: self.other_names.len(),
        }
    }
}
