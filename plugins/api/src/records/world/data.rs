//! The world as a producer makes it.

use super::view::{World, WorldLayout};
use super::{
    CurveRecord, DoorRecord, EdgeRecord, LiftLevelRecord, LiftRecord, NodeRecord, OtherNameRecord,
    RobotTypeRecord, Texts, ZoneRecord,
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
    /// The doors, which refer to members of facilities.
    pub doors: Vec<DoorRecord>,
    /// The lifts, which refer to their levels and to members of facilities.
    pub lifts: Vec<LiftRecord>,
    /// The levels of all lifts.
    pub lift_levels: Vec<LiftLevelRecord>,
    /// The indices of the edges of doors, and of the rides and nodes of lifts.
    pub facility_members: Vec<u32>,
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

    /// Appends a door with its edges, by their indices. Fills in `first_edge` and `edges`.
    pub fn add_door(&mut self, door: DoorRecord, edges: impl IntoIterator<Item = u32>) {
        let [first_edge, edges] = self.add_members(edges);
        self.doors.push(DoorRecord { first_edge, edges, ..door });
    }

    /// Appends a lift with its levels from the lowest to the highest (the offset of the name, and
    /// the indices of the nodes) and its rides, by the indices of the edges. Fills in the fields
    /// that refer to them.
    pub fn add_lift<Nodes: IntoIterator<Item = u32>>(
        &mut self,
        lift: LiftRecord,
        levels: impl IntoIterator<Item = (u32, Nodes)>,
        rides: impl IntoIterator<Item = u32>,
    ) {
        let first_level = self.lift_levels.len() as u32;
        for (name, nodes) in levels {
            let [first_node, nodes] = self.add_members(nodes);
            self.lift_levels.push(LiftLevelRecord { name, first_node, nodes });
        }
        let [first_ride, rides] = self.add_members(rides);
        let levels = self.lift_levels.len() as u32 - first_level;
        self.lifts.push(LiftRecord { first_level, levels, first_ride, rides, ..lift });
    }

    /// Appends members of facilities; returns the index of the first and their number.
    fn add_members(&mut self, members: impl IntoIterator<Item = u32>) -> [u32; 2] {
        let first = self.facility_members.len() as u32;
        self.facility_members.extend(members);
        [first, self.facility_members.len() as u32 - first]
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
            doors: &self.doors,
            lifts: &self.lifts,
            lift_levels: &self.lift_levels,
            facility_members: &self.facility_members,
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
            doors: self.doors.len(),
            lifts: self.lifts.len(),
            lift_levels: self.lift_levels.len(),
            facility_members: self.facility_members.len(),
        }
    }
}
