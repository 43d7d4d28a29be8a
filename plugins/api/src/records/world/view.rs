//! A reader's view of the world, and the places of its sections in a block of lines.

use bytemuck::{NoUninit, Pod};

use super::texts::text_at;
use super::{
    CurveRecord, DoorRecord, EdgeRecord, LiftLevelRecord, LiftRecord, NodeRecord, OtherNameRecord,
    RobotTypeRecord, WorldData, WorldHeader, ZoneRecord,
};
use crate::records::frame::{BYTES_PER_LINE, Line};

/// The number of a world's sections.
const SECTIONS: usize = 12;

/// The sections of a world in its block of lines: each starts on a whole line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WorldLayout {
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
    pub(crate) curves: usize,
    pub(crate) robot_types: usize,
    pub(crate) text_bytes: usize,
    pub(crate) zones: usize,
    pub(crate) zone_members: usize,
    pub(crate) other_names: usize,
    pub(crate) doors: usize,
    pub(crate) lifts: usize,
    pub(crate) lift_levels: usize,
    pub(crate) facility_members: usize,
}

impl WorldLayout {
    fn of(header: &WorldHeader) -> Self {
        Self {
            nodes: header.nodes as usize,
            edges: header.edges as usize,
            curves: header.curves as usize,
            robot_types: header.robot_types as usize,
            text_bytes: header.text_bytes as usize,
            zones: header.zones as usize,
            zone_members: header.zone_members as usize,
            other_names: header.other_names as usize,
            doors: header.doors as usize,
            lifts: header.lifts as usize,
            lift_levels: header.lift_levels as usize,
            facility_members: header.facility_members as usize,
        }
    }

    pub(crate) fn header(self, origin: [f64; 2], run_id: u64, revision: u64) -> WorldHeader {
        WorldHeader {
            run_id,
            revision,
            origin,
            nodes: self.nodes as u32,
            edges: self.edges as u32,
            curves: self.curves as u32,
            robot_types: self.robot_types as u32,
            text_bytes: self.text_bytes as u32,
            zones: self.zones as u32,
            zone_members: self.zone_members as u32,
            other_names: self.other_names as u32,
            doors: self.doors as u32,
            lifts: self.lifts as u32,
            lift_levels: self.lift_levels as u32,
            facility_members: self.facility_members as u32,
        }
    }

    /// Returns the number of lines of each section.
    fn section_lines(self) -> [usize; SECTIONS] {
        let bytes = [
            self.nodes * size_of::<NodeRecord>(),
            self.edges * size_of::<EdgeRecord>(),
            self.curves * size_of::<CurveRecord>(),
            self.robot_types * size_of::<RobotTypeRecord>(),
            self.text_bytes,
            self.zones * size_of::<ZoneRecord>(),
            self.zone_members * size_of::<u32>(),
            self.other_names * size_of::<OtherNameRecord>(),
            self.doors * size_of::<DoorRecord>(),
            self.lifts * size_of::<LiftRecord>(),
            self.lift_levels * size_of::<LiftLevelRecord>(),
            self.facility_members * size_of::<u32>(),
        ];
        bytes.map(|bytes| bytes.div_ceil(BYTES_PER_LINE))
    }

    pub(crate) fn lines(self) -> usize {
        self.section_lines().iter().sum()
    }

    /// Writes a world of this layout to a block of [`lines`](Self::lines).
    pub(crate) fn write(self, lines: &mut [Line], world: &WorldData) {
        let mut rest = lines;
        let sections = self.section_lines().map(|count| {
            let (section, after) = std::mem::take(&mut rest).split_at_mut(count);
            rest = after;
            section
        });
        let [nodes, edges, curves, robot_types, texts, zones, zone_members, other_names, rest @ ..] =
            sections;
        let [doors, lifts, lift_levels, facility_members] = rest;
        copy(nodes, &world.nodes);
        copy(edges, &world.edges);
        copy(curves, &world.curves);
        copy(robot_types, &world.robot_types);
        copy(texts, world.texts.as_bytes());
        copy(zones, &world.zones);
        copy(zone_members, &world.zone_members);
        copy(other_names, &world.other_names);
        copy(doors, &world.doors);
        copy(lifts, &world.lifts);
        copy(lift_levels, &world.lift_levels);
        copy(facility_members, &world.facility_members);
    }
}

fn copy<T: NoUninit>(section: &mut [Line], records: &[T]) {
    let bytes: &[u8] = bytemuck::cast_slice(records);
    bytemuck::cast_slice_mut::<Line, u8>(section)[..bytes.len()].copy_from_slice(bytes);
}

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
}

impl<'sample> World<'sample> {
    /// Splits a block of lines into its sections. Returns `None` if it has fewer lines than the
    /// header implies.
    pub(crate) fn split(header: &WorldHeader, lines: &'sample [Line]) -> Option<Self> {
        let layout = WorldLayout::of(header);
        let mut rest = lines;
        let mut sections = [&[][..]; SECTIONS];
        for (section, count) in sections.iter_mut().zip(layout.section_lines()) {
            (*section, rest) = rest.split_at_checked(count)?;
        }
        let [nodes, edges, curves, robot_types, texts, zones, zone_members, other_names, rest @ ..] =
            sections;
        let [doors, lifts, lift_levels, facility_members] = rest;
        Some(Self {
            header: *header,
            nodes: records(nodes, layout.nodes),
            edges: records(edges, layout.edges),
            curves: records(curves, layout.curves),
            robot_types: records(robot_types, layout.robot_types),
            texts: records(texts, layout.text_bytes),
            zones: records(zones, layout.zones),
            zone_members: records(zone_members, layout.zone_members),
            other_names: records(other_names, layout.other_names),
            doors: records(doors, layout.doors),
            lifts: records(lifts, layout.lifts),
            lift_levels: records(lift_levels, layout.lift_levels),
            facility_members: records(facility_members, layout.facility_members),
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

/// Returns the first `count` records of a section, which has the lines for them.
fn records<T: Pod>(section: &[Line], count: usize) -> &[T] {
    // The records need not fill the last line.
    bytemuck::cast_slice(&bytemuck::cast_slice::<_, u8>(section)[..count * size_of::<T>()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::world::{Texts, ZoneRule};

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

    #[test]
    fn a_world_is_cut_where_it_was_joined() {
        let data = world();
        let layout = data.layout();
        let mut lines = vec![Line::default(); layout.lines()];
        layout.write(&mut lines, &data);
        let header = layout.header(data.origin, 7, 1);
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
        let layout = data.layout();
        let mut lines = vec![Line::default(); layout.lines()];
        layout.write(&mut lines, &data);
        let world = World::split(&layout.header([0.0; 2], 7, 1), &lines).expect("enough lines");
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
        let layout = data.layout();
        let mut lines = vec![Line::default(); layout.lines()];
        layout.write(&mut lines, &data);
        let world = World::split(&layout.header([0.0; 2], 7, 1), &lines).expect("enough lines");
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
        let layout = data.layout();
        let mut lines = vec![Line::default(); layout.lines()];
        layout.write(&mut lines, &data);
        let world = World::split(&layout.header([0.0; 2], 7, 1), &lines).expect("enough lines");
        let [other] = world.other_names() else { panic!("{:?}", world.other_names()) };
        assert_eq!((world.text(other.name), other.node), ("Storage 01", 3));
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
