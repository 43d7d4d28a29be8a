//! A reader's view of the world.

use bytemuck::Pod;

use super::texts::text_at;
use super::{
    BackgroundLineRecord, CurveRecord, DoorRecord, EdgeRecord, LiftLevelRecord, LiftRecord,
    NodeRecord, OtherNameRecord, RobotTypeRecord, StationRecord, WorldHeader, ZoneRecord,
};
use crate::records::frame::{BYTES_PER_LINE, Line};

/// A reader's view of the world: slices of shared memory, not copies.
#[derive(Clone, Copy, Debug, Default)]
pub struct World<'sample> {
    pub(super) header: WorldHeader,
    pub(super) nodes: &'sample [NodeRecord],
    pub(super) edges: &'sample [EdgeRecord],
    pub(super) curves: &'sample [CurveRecord],
    pub(super) robot_types: &'sample [RobotTypeRecord],
    pub(super) texts: &'sample [u8],
    pub(super) zones: &'sample [ZoneRecord],
    pub(super) zone_members: &'sample [u32],
    pub(super) other_names: &'sample [OtherNameRecord],
    pub(super) doors: &'sample [DoorRecord],
    pub(super) lifts: &'sample [LiftRecord],
    pub(super) lift_levels: &'sample [LiftLevelRecord],
    pub(super) facility_members: &'sample [u32],
    pub(super) stations: &'sample [StationRecord],
    pub(super) station_nodes: &'sample [u32],
    pub(super) background_lines: &'sample [BackgroundLineRecord],
    pub(super) background_points: &'sample [[f32; 2]],
}

impl<'sample> World<'sample> {
    /// Splits a block of lines into its sections. Returns `None` if it has fewer lines than the
    /// header implies.
    pub(crate) fn split(header: &WorldHeader, lines: &'sample [Line]) -> Option<Self> {
        let mut rest = lines;
        Some(Self {
            header: *header,
            nodes: take(&mut rest, header.nodes)?,
            edges: take(&mut rest, header.edges)?,
            curves: take(&mut rest, header.curves)?,
            robot_types: take(&mut rest, header.robot_types)?,
            texts: take(&mut rest, header.text_bytes)?,
            zones: take(&mut rest, header.zones)?,
            zone_members: take(&mut rest, header.zone_members)?,
            other_names: take(&mut rest, header.other_names)?,
            doors: take(&mut rest, header.doors)?,
            lifts: take(&mut rest, header.lifts)?,
            lift_levels: take(&mut rest, header.lift_levels)?,
            facility_members: take(&mut rest, header.facility_members)?,
            stations: take(&mut rest, header.stations)?,
            station_nodes: take(&mut rest, header.station_nodes)?,
            background_lines: take(&mut rest, header.background_lines)?,
            background_points: take(&mut rest, header.background_points)?,
        })
    }

    /// The run that the world belongs to.
    pub fn run_id(&self) -> u64 {
        self.header.run_id
    }

    /// Counts the worlds of a run, from 1.
    pub fn revision(&self) -> u64 {
        self.header.revision
    }

    /// Metres east and north of (0, 0) of the fleet's positions, on the map of the route graph's
    /// file: a position on that map is `origin` + position.
    pub fn origin(&self) -> [f64; 2] {
        self.header.origin
    }

    /// The nodes of the route graph.
    pub fn nodes(&self) -> &'sample [NodeRecord] {
        self.nodes
    }

    /// The edges of the route graph; a frame's `edge` column holds indices into them.
    pub fn edges(&self) -> &'sample [EdgeRecord] {
        self.edges
    }

    /// The curves of an edge of this world, from origin to destination; empty if the record refers
    /// to curves that the world doesn't have.
    pub fn curves(&self, edge: &EdgeRecord) -> &'sample [CurveRecord] {
        let first = edge.first_curve as usize;
        let end = first.checked_add(edge.curves as usize);
        end.and_then(|end| self.curves.get(first..end)).unwrap_or_default()
    }

    /// The curves of all edges.
    pub fn all_curves(&self) -> &'sample [CurveRecord] {
        self.curves
    }

    /// The robot types; the column [`TYPE`](crate::column::TYPE) has indices into them.
    pub fn robot_types(&self) -> &'sample [RobotTypeRecord] {
        self.robot_types
    }

    /// The zones with a rule.
    pub fn zones(&self) -> &'sample [ZoneRecord] {
        self.zones
    }

    /// The names of nodes besides their own: those of stations there, and of nodes at the same
    /// place that the layout was read without.
    pub fn other_names(&self) -> &'sample [OtherNameRecord] {
        self.other_names
    }

    /// The nodes of a zone of this world, by their indices; empty if the record refers to members
    /// that the world doesn't have.
    pub fn zone_nodes(&self, zone: &ZoneRecord) -> &'sample [u32] {
        slice(self.zone_members, zone.first_member, zone.nodes)
    }

    /// The edges of a zone of this world, by their indices; empty if the record refers to members
    /// that the world doesn't have.
    pub fn zone_edges(&self, zone: &ZoneRecord) -> &'sample [u32] {
        let first = zone.first_member.checked_add(zone.nodes);
        first.map(|first| slice(self.zone_members, first, zone.edges)).unwrap_or_default()
    }

    /// The doors.
    pub fn doors(&self) -> &'sample [DoorRecord] {
        self.doors
    }

    /// The lifts.
    pub fn lifts(&self) -> &'sample [LiftRecord] {
        self.lifts
    }

    /// The edges of a door of this world, by their indices; empty if the record refers to members
    /// that the world doesn't have. So it is with the levels, nodes and rides of lifts.
    pub fn door_edges(&self, door: &DoorRecord) -> &'sample [u32] {
        slice(self.facility_members, door.first_edge, door.edges)
    }

    /// The levels of a lift, from the lowest to the highest.
    pub fn lift_levels(&self, lift: &LiftRecord) -> &'sample [LiftLevelRecord] {
        slice(self.lift_levels, lift.first_level, lift.levels)
    }

    /// The nodes in the cabin of a lift at a level, by their indices.
    pub fn level_nodes(&self, level: &LiftLevelRecord) -> &'sample [u32] {
        slice(self.facility_members, level.first_node, level.nodes)
    }

    /// The edges of a lift from level to level, by their indices.
    pub fn lift_rides(&self, lift: &LiftRecord) -> &'sample [u32] {
        slice(self.facility_members, lift.first_ride, lift.rides)
    }

    /// The stations.
    pub fn stations(&self) -> &'sample [StationRecord] {
        self.stations
    }

    /// The nodes of a station of this world, by their indices; empty if the record refers to nodes
    /// that the world doesn't have.
    pub fn station_nodes(&self, station: &StationRecord) -> &'sample [u32] {
        slice(self.station_nodes, station.first_node, station.nodes)
    }

    /// The lines of the background.
    pub fn background_lines(&self) -> &'sample [BackgroundLineRecord] {
        self.background_lines
    }

    /// The points of a line of the background: metres east and north of the world's origin. Empty
    /// if the record refers to points that the world doesn't have.
    pub fn background_points(&self, line: &BackgroundLineRecord) -> &'sample [[f32; 2]] {
        slice(self.background_points, line.first_point, line.points)
    }

    /// The text that a record refers to by its offset: the name, level or zone of a node or an
    /// edge. Empty for the offset 0 and for an offset at which there is no text.
    pub fn text(&self, offset: u32) -> &'sample str {
        text_at(self.texts, offset)
    }
}

/// Returns some records of a list; none if it doesn't have all of them.
fn slice<T>(list: &[T], first: u32, count: u32) -> &[T] {
    let end = (first as usize).checked_add(count as usize);
    end.and_then(|end| list.get(first as usize..end)).unwrap_or_default()
}

/// Takes the next section, of `count` records, from a block of lines. Returns `None` if it has
/// fewer lines.
fn take<'sample, T: Pod>(rest: &mut &'sample [Line], count: u32) -> Option<&'sample [T]> {
    let bytes = (count as usize).checked_mul(size_of::<T>())?;
    let (section, after) = rest.split_at_checked(bytes.div_ceil(BYTES_PER_LINE))?;
    *rest = after;
    // The records need not fill the last line.
    Some(bytemuck::cast_slice(&bytemuck::cast_slice::<_, u8>(section)[..bytes]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::world::{MAX_BACKGROUND_POINTS, Role, Texts, WorldData, ZoneRule};

    /// A world of five nodes, three edges with one, two and three curves, and a robot type.
    fn world() -> WorldData {
        let mut texts = Texts::default();
        let (level, zone) = (texts.add("1st floor"), texts.add("north"));
        let mut world = WorldData {
            origin: [3.5e6, -5.25e6],
            nodes: (0..5)
                .map(|id| NodeRecord { id, x: id as f32, level, zone, ..NodeRecord::default() })
                .collect(),
            robot_types: vec![RobotTypeRecord::new("tug", 1.2, 0.8)],
            texts,
            ..WorldData::default()
        };
        for id in 0..3 {
            let edge = EdgeRecord { id, length: 2.0, level, ..EdgeRecord::default() };
            let curve =
                |x: u32| CurveRecord::straight([x as f32, 0.0], [x as f32 + 1.0, id as f32]);
            world.add_edge(edge, (0..=id).map(curve));
        }
        world
    }

    /// Returns a world as a sample has it.
    fn written(data: &WorldData) -> (WorldHeader, Vec<Line>) {
        let mut lines = vec![Line::default(); data.lines()];
        data.write(&mut lines);
        (data.header(7, 1), lines)
    }

    #[test]
    fn a_world_is_cut_where_it_was_joined() {
        let data = world();
        let (header, lines) = written(&data);
        let world = World::split(&header, &lines).expect("enough lines");
        assert_eq!((world.nodes(), world.edges()), (&data.nodes[..], &data.edges[..]));
        assert_eq!((world.all_curves(), world.origin()), (&data.curves[..], [3.5e6, -5.25e6]));
        assert_eq!(
            (world.robot_types()[0].name(), world.run_id(), world.revision()),
            ("tug", 7, 1)
        );
        assert_eq!(
            (world.text(world.nodes()[4].level), world.text(world.nodes()[4].zone)),
            ("1st floor", "north")
        );
        assert!(World::split(&header, &lines[1..]).is_none(), "a line is missing");
    }

    #[test]
    fn each_zone_has_its_nodes_and_edges() {
        let mut data = world();
        let name = data.texts.add("block");
        data.add_zone(ZoneRecord { name, capacity: 1, ..ZoneRecord::default() }, [1, 4], [2]);
        data.add_zone(ZoneRecord { rule: 1, ..ZoneRecord::default() }, [], [0, 1]);
        let (header, lines) = written(&data);
        let world = World::split(&header, &lines).expect("enough lines");
        let [block, lane] = world.zones() else { panic!("{:?}", world.zones()) };
        assert_eq!((world.text(block.name), block.rule()), ("block", Some(ZoneRule::Capacity)));
        assert_eq!((world.zone_nodes(block), world.zone_edges(block)), (&[1, 4][..], &[2][..]));
        assert_eq!((world.zone_nodes(lane), world.zone_edges(lane)), (&[][..], &[0, 1][..]));
        let wrong = ZoneRecord { first_member: 4, nodes: 2, ..ZoneRecord::default() };
        assert!(world.zone_nodes(&wrong).is_empty() && world.zone_edges(&wrong).is_empty());
    }

    #[test]
    fn doors_and_lifts_have_their_members() {
        let mut data = world();
        let [door, lift] = ["gate", "north"].map(|name| data.texts.add(name));
        let levels = ["L1", "L2"].map(|name| data.texts.add(name));
        data.add_door(DoorRecord { name: door, ..DoorRecord::default() }, [1, 2]);
        let record = LiftRecord { name: lift, capacity: 2, ..LiftRecord::default() };
        data.add_lift(record, [(levels[0], vec![0, 1]), (levels[1], vec![4])], [0]);
        let (header, lines) = written(&data);
        let world = World::split(&header, &lines).expect("enough lines");
        let ([door], [lift]) = (world.doors(), world.lifts()) else { panic!("one of each") };
        assert_eq!((world.text(door.name), world.door_edges(door)), ("gate", &[1, 2][..]));
        assert_eq!((world.text(lift.name), world.lift_rides(lift)), ("north", &[0][..]));
        let levels: Vec<_> = world.lift_levels(lift).iter().collect();
        let nodes = levels.iter().map(|level| world.level_nodes(level));
        assert_eq!(nodes.collect::<Vec<_>>(), [&[0, 1][..], &[4][..]]);
        assert_eq!(world.text(levels[1].name), "L2");
        let wrong = DoorRecord { first_edge: 9, edges: 9, ..DoorRecord::default() };
        assert!(world.door_edges(&wrong).is_empty());
    }

    #[test]
    fn nodes_have_other_names() {
        let mut data = world();
        let name = data.texts.add("Storage 01");
        data.other_names.push(OtherNameRecord { name, node: 3 });
        let (header, lines) = written(&data);
        let world = World::split(&header, &lines).expect("enough lines");
        let [other] = world.other_names() else { panic!("{:?}", world.other_names()) };
        assert_eq!((world.text(other.name), other.node), ("Storage 01", 3));
    }

    #[test]
    fn stations_have_nodes_and_lines_of_the_background_points() {
        let mut data = world();
        let [name, level] = ["Storage 01", "1st floor"].map(|text| data.texts.add(text));
        let role = Role::Transfer as u32;
        let station = StationRecord { name, level, x: 2.0, role, ..StationRecord::default() };
        data.add_station(StationRecord::default(), [0]);
        data.add_station(station, [3, 4]);
        assert!(data.add_background_line(level, [[0.0, 0.0], [9.0, 0.0], [9.0, 3.0]]));
        assert!(data.add_background_line(0, [[5.0, 5.0]]), "a point alone is no line");
        assert!(data.add_background_line(0, [[0.0, 1.0], [0.0, 2.0]]));
        let (header, lines) = written(&data);
        let world = World::split(&header, &lines).expect("enough lines");
        let [_, storage] = world.stations() else { panic!("{:?}", world.stations()) };
        assert_eq!((world.text(storage.name), storage.role()), ("Storage 01", Role::Transfer));
        assert_eq!(world.station_nodes(storage), [3, 4]);
        let lines = world.background_lines().iter().map(|line| world.background_points(line));
        let expected: [&[[f32; 2]]; 2] =
            [&[[0.0, 0.0], [9.0, 0.0], [9.0, 3.0]], &[[0.0, 1.0], [0.0, 2.0]]];
        assert_eq!(lines.collect::<Vec<_>>(), expected);
        let wrong = StationRecord { first_node: 2, nodes: 2, ..StationRecord::default() };
        assert!(world.station_nodes(&wrong).is_empty());
        let wrong = BackgroundLineRecord { first_point: u32::MAX, points: 9, level: 0 };
        assert!(world.background_points(&wrong).is_empty());
    }

    #[test]
    fn the_background_is_bounded() {
        let mut data = WorldData::default();
        let line = |points: usize| (0..points).map(|index| [index as f32, 0.0]);
        assert!(data.add_background_line(0, line(MAX_BACKGROUND_POINTS - 2)));
        assert!(!data.add_background_line(0, line(3)), "no room");
        assert!(data.add_background_line(0, line(2)), "as many as there is room for");
        assert_eq!(data.background_points.len(), MAX_BACKGROUND_POINTS);
        assert_eq!(data.background_lines.len(), 2);
    }

    #[test]
    fn each_edge_has_its_curves() {
        let data = world();
        let world = data.view(1, 1);
        let counts: Vec<_> = world.edges().iter().map(|edge| world.curves(edge).len()).collect();
        assert_eq!(counts, [1, 2, 3]);
        let last = world.curves(&world.edges()[2]);
        assert_eq!(
            (last[0].control_points[0], last[2].control_points[3]),
            ([0.0, 0.0], [3.0, 2.0])
        );
        for (first_curve, curves) in [(5, 2), (6, 1), (u32::MAX, u32::MAX)] {
            let wrong = EdgeRecord { first_curve, curves, ..EdgeRecord::default() };
            assert!(world.curves(&wrong).is_empty(), "{first_curve} {curves}");
        }
    }

    #[test]
    fn a_wrong_offset_is_the_empty_text() {
        let data = world();
        let world = data.view(1, 1);
        assert_eq!([0, 1_000, u32::MAX].map(|offset| world.text(offset)), [""; 3]);
    }
}
