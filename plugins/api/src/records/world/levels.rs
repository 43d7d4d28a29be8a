//! The levels (floors) of a world: robots on different levels can't touch, whatever their
//! positions.

use std::collections::BTreeMap;

use super::World;

/// A level of a world, or none in particular.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Level(u16);

impl Level {
    /// No level in particular: that of a lift, of a ramp, or of a world without levels.
    pub const ANY: Self = Self(0);

    /// Whether robots on these two levels may be near each other.
    pub fn may_meet(self, other: Self) -> bool {
        self == other || self == Self::ANY || other == Self::ANY
    }
}

/// The distance from the end of an edge, in metres, up to which a robot stands at the node there.
const AT_NODE: f32 = 2e-3;

/// The levels of a world's nodes and edges.
#[derive(Clone, Debug, Default)]
pub struct Levels {
    nodes: Vec<Level>,
    edges: Vec<EdgeLevels>,
    count: usize,
}

/// The levels along an edge.
#[derive(Clone, Copy, Debug)]
struct EdgeLevels {
    /// At its origin, between, and at its destination.
    parts: [Level; 3],
    /// Metres.
    length: f32,
}

impl Levels {
    /// Reads the levels of a world. An edge is on the level that it names, or else on that of both
    /// its ends; an edge whose ends are on different levels is on none in particular.
    pub fn new(world: &World<'_>) -> Self {
        let mut numbers = BTreeMap::new();
        let mut nodes: Vec<Level> = Vec::new();
        for node in world.nodes() {
            nodes.push(level(&mut numbers, world.text(node.level)));
        }
        let edges = world.edges().iter().map(|edge| {
            let own = level(&mut numbers, world.text(edge.level));
            let [from, to] = [edge.origin, edge.destination]
                .map(|node| nodes.get(node as usize).copied().unwrap_or_default());
            let between = match own {
                _ if !from.may_meet(to) => Level::ANY,
                Level::ANY if from == to => from,
                own => own,
            };
            EdgeLevels { parts: [from, between, to], length: edge.length }
        });
        let edges = edges.collect();
        Self { nodes, edges, count: numbers.len() }
    }

    /// Whether there are several levels. If not, each robot may meet any other one.
    pub fn are_several(&self) -> bool {
        self.count > 1
    }

    /// The level of a node, by its index; [`Level::ANY`] if there is no such node.
    pub fn of_node(&self, node: u32) -> Level {
        self.nodes.get(node as usize).copied().unwrap_or_default()
    }

    /// The level of an edge, by its index; [`Level::ANY`] if there is no such edge.
    pub fn of_edge(&self, edge: u32) -> Level {
        self.edges.get(edge as usize).map_or(Level::ANY, |edge| edge.parts[1])
    }

    /// The level of a robot on an edge, by its index, `s` metres from the edge's origin: a robot at
    /// the end of a lift has left it.
    pub fn of_robot(&self, edge: u32, s: f32) -> Level {
        let Some(EdgeLevels { parts, length }) = self.edges.get(edge as usize) else {
            return Level::ANY;
        };
        let [from, between, to] = *parts;
        match between {
            Level::ANY if s <= AT_NODE => from,
            Level::ANY if s >= length - AT_NODE => to,
            between => between,
        }
    }
}

/// Returns the level with a name; the empty name is none in particular.
fn level<'world>(numbers: &mut BTreeMap<&'world str, usize>, name: &'world str) -> Level {
    if name.is_empty() {
        return Level::ANY;
    }
    let next = numbers.len() + 1;
    Level(u16::try_from(*numbers.entry(name).or_insert(next)).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

    #[test]
    fn a_lift_meets_both_of_its_levels_and_these_never_each_other() {
        let mut world = WorldData::default();
        let offsets = ["L1", "L2"].map(|name| world.texts.add(name));
        for (id, level) in [offsets[0], offsets[0], offsets[1], offsets[1], 0].into_iter().zip(0..)
        {
            world.nodes.push(NodeRecord { id: level, level: id, ..NodeRecord::default() });
        }
        for (origin, destination, level) in
            [(0, 1, 0), (2, 3, offsets[1]), (1, 2, offsets[0]), (4, 0, 0), (4, 0, offsets[0])]
        {
            let edge =
                EdgeRecord { origin, destination, level, length: 1.0, ..EdgeRecord::default() };
            world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [1.0, 0.0])]);
        }
        let levels = Levels::new(&world.view(1, 1));
        let [first, second, lift, stub, named] = [0, 1, 2, 3, 4].map(|edge| levels.of_edge(edge));
        assert!(!first.may_meet(second) && !levels.of_node(0).may_meet(levels.of_node(2)));
        assert!(lift.may_meet(first) && lift.may_meet(second), "a lift joins both");
        assert_eq!((lift, stub, named), (Level::ANY, Level::ANY, first));
        assert!(levels.are_several());
        let along = [0.0, 0.5, 1.0].map(|s| levels.of_robot(2, s));
        assert_eq!(along, [first, Level::ANY, second], "along the lift");
        assert_eq!(levels.of_edge(99), Level::ANY, "a robot on no edge");
        assert!(!Levels::new(&World::default()).are_several());
    }
}
