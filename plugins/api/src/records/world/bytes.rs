//! The world as bytes: a gateway to another host sends them.

use bytemuck::{Pod, cast_slice};

use super::{Texts, World, WorldData, WorldHeader};

/// The number of a world's sections.
pub(super) const SECTIONS: usize = 16;

impl<'sample> World<'sample> {
    /// The header: run, revision, and the length of each section.
    pub fn header(&self) -> &WorldHeader {
        &self.header
    }

    /// The bytes of the sections, in the order in which the header counts them.
    pub fn sections(&self) -> [&'sample [u8]; SECTIONS] {
        [
            cast_slice(self.nodes),
            cast_slice(self.edges),
            cast_slice(self.curves),
            cast_slice(self.robot_types),
            self.texts,
            cast_slice(self.zones),
            cast_slice(self.zone_members),
            cast_slice(self.other_names),
            cast_slice(self.doors),
            cast_slice(self.lifts),
            cast_slice(self.lift_levels),
            cast_slice(self.facility_members),
            cast_slice(self.stations),
            cast_slice(self.station_nodes),
            cast_slice(self.background_lines),
            cast_slice(self.background_points),
        ]
    }
}

impl WorldData {
    /// Returns a copy of a world from its header and its [sections](World::sections), end to end
    /// without padding. Returns `None` if their length isn't the one that the header implies.
    /// Nothing else is checked: readers check the references of records.
    pub fn from_bytes(header: &WorldHeader, bytes: &[u8]) -> Option<Self> {
        let mut rest = bytes;
        let world = Self {
            origin: header.origin,
            nodes: take(&mut rest, header.nodes)?,
            edges: take(&mut rest, header.edges)?,
            curves: take(&mut rest, header.curves)?,
            robot_types: take(&mut rest, header.robot_types)?,
            texts: Texts::from_bytes(take(&mut rest, header.text_bytes)?),
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
        };
        rest.is_empty().then_some(world)
    }
}

/// Takes a section of `count` records, which may be anywhere in memory. Allocates only for bytes
/// that are there.
fn take<T: Pod>(rest: &mut &[u8], count: u32) -> Option<Vec<T>> {
    let length = (count as usize).checked_mul(size_of::<T>())?;
    let (section, after) = rest.split_at_checked(length)?;
    *rest = after;
    Some(section.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::world::{CurveRecord, EdgeRecord, NodeRecord};

    #[test]
    fn a_world_survives_its_bytes() {
        let mut world = WorldData { origin: [1.0, 2.0], ..WorldData::default() };
        let name = world.texts.add("dock 1");
        world.nodes = vec![NodeRecord { id: 1, name, ..NodeRecord::default() }; 2];
        let edge = EdgeRecord { destination: 1, length: 3.0, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [3.0, 0.0])]);
        let view = world.view(1, 1);
        let bytes = view.sections().concat();
        let copy = WorldData::from_bytes(view.header(), &bytes).expect("the same length");
        assert_eq!(copy.view(1, 1).sections(), view.sections());
        assert_eq!((copy.origin, copy.texts.get(name)), (world.origin, "dock 1"));
        assert!(WorldData::from_bytes(view.header(), &bytes[1..]).is_none());
        let header = WorldHeader { station_nodes: u32::MAX, ..*view.header() };
        assert!(WorldData::from_bytes(&header, &bytes).is_none());
    }
}
