//! The world as a producer makes it.

use super::bytes::SECTIONS;
use super::{
    BackgroundLineRecord, CurveRecord, DoorRecord, EdgeRecord, LiftLevelRecord, LiftRecord,
    MAX_BACKGROUND_POINTS, NodeRecord, OtherNameRecord, RobotTypeRecord, StationRecord, Texts,
    World, WorldHeader, ZoneRecord,
};
use crate::records::frame::{BYTES_PER_LINE, Line};

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
    /// The stations, which refer to their nodes.
    pub stations: Vec<StationRecord>,
    /// The indices of the nodes of all stations.
    pub station_nodes: Vec<u32>,
    /// The lines of the background, which refer to their points.
    pub background_lines: Vec<BackgroundLineRecord>,
    /// The points of all lines of the background: metres east and north of the world's origin.
    pub background_points: Vec<[f32; 2]>,
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

    /// Appends a station with its nodes, by their indices. Fills in `first_node` and `nodes`.
    pub fn add_station(&mut self, station: StationRecord, nodes: impl IntoIterator<Item = u32>) {
        let first_node = self.station_nodes.len() as u32;
        self.station_nodes.extend(nodes);
        let nodes = self.station_nodes.len() as u32 - first_node;
        self.stations.push(StationRecord { first_node, nodes, ..station });
    }

    /// Appends a line of the background: the offset of its level's name, and its points in metres.
    /// Returns false if the background has no room for it: more than [`MAX_BACKGROUND_POINTS`] are
    /// left out.
    pub fn add_background_line(
        &mut self,
        level: u32,
        points: impl IntoIterator<Item = [f32; 2]>,
    ) -> bool {
        let first_point = self.background_points.len();
        let room = MAX_BACKGROUND_POINTS.saturating_sub(first_point);
        self.background_points.extend(points.into_iter().take(room + 1));
        let points = self.background_points.len() - first_point;
        let has_room = points <= room;
        if has_room && points > 1 {
            let [first_point, points] = [first_point, points].map(|number| number as u32);
            self.background_lines.push(BackgroundLineRecord { level, first_point, points });
        } else {
            self.background_points.truncate(first_point);
        }
        has_room
    }

    /// Returns the world as its readers see it.
    pub fn view(&self, run_id: u64, revision: u64) -> World<'_> {
        World {
            header: self.header(run_id, revision),
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
            stations: &self.stations,
            station_nodes: &self.station_nodes,
            background_lines: &self.background_lines,
            background_points: &self.background_points,
        }
    }

    pub(crate) fn header(&self, run_id: u64, revision: u64) -> WorldHeader {
        WorldHeader {
            run_id,
            revision,
            origin: self.origin,
            nodes: self.nodes.len() as u32,
            edges: self.edges.len() as u32,
            curves: self.curves.len() as u32,
            robot_types: self.robot_types.len() as u32,
            text_bytes: self.texts.as_bytes().len() as u32,
            zones: self.zones.len() as u32,
            zone_members: self.zone_members.len() as u32,
            other_names: self.other_names.len() as u32,
            doors: self.doors.len() as u32,
            lifts: self.lifts.len() as u32,
            lift_levels: self.lift_levels.len() as u32,
            facility_members: self.facility_members.len() as u32,
            stations: self.stations.len() as u32,
            station_nodes: self.station_nodes.len() as u32,
            background_lines: self.background_lines.len() as u32,
            background_points: self.background_points.len() as u32,
        }
    }

    /// The bytes of its sections, in the order of [`World::split`].
    fn sections(&self) -> [&[u8]; SECTIONS] {
        self.view(0, 0).sections()
    }

    /// The number of lines that [`write`](Self::write) needs.
    pub(crate) fn lines(&self) -> usize {
        self.sections().iter().map(|bytes| lines_of(bytes)).sum()
    }

    /// Writes the sections to a block of [`lines`](Self::lines).
    pub(crate) fn write(&self, lines: &mut [Line]) {
        let mut rest = lines;
        for bytes in self.sections() {
            let (section, after) = rest.split_at_mut(lines_of(bytes));
            bytemuck::cast_slice_mut::<Line, u8>(section)[..bytes.len()].copy_from_slice(bytes);
            rest = after;
        }
    }
}

fn lines_of(bytes: &[u8]) -> usize {
    bytes.len().div_ceil(BYTES_PER_LINE)
}
