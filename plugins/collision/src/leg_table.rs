//! The legs of the route graph, with their speeds and their successors.

use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::EdgeRecord;

use crate::edge_table::{Chord, EdgeTable};

/// An edge that is driven in one gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leg(u32);

impl Leg {
    const REVERSE: u32 = 1 << 31;

    /// Creates a leg from the index of its edge in the world, of which the highest bit is ignored.
    pub(crate) fn new(edge: u32, reverse: bool) -> Self {
        Self(edge & !Self::REVERSE | if reverse { Self::REVERSE } else { 0 })
    }

    /// Returns the index of the edge in the world.
    pub(crate) fn edge(self) -> u32 {
        self.0 & !Self::REVERSE
    }

    /// Whether it is driven from destination to origin, in reverse gear.
    pub(crate) fn is_reverse(self) -> bool {
        self.0 & Self::REVERSE != 0
    }
}

/// A leg with everything that predictions need of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegInfo<'table> {
    /// Chords of the edge; at least one.
    pub chords: &'table [Chord],
    /// Length of the edge, in metres.
    pub length: f32,
    /// Highest speed, in metres per second; not above 0 if it is unknown.
    pub speed: f32,
}

/// The properties of an edge that an [`EdgeTable`] doesn't have.
#[derive(Clone, Copy, Debug)]
struct EdgeInfo {
    origin: u32,
    destination: u32,
    length: f32,
    /// Speed in forward gear, in metres per second.
    speed: f32,
    /// The speed in reverse gear.
    reverse_speed: f32,
}

/// The legs that leave each node, in one gear.
#[derive(Debug, Default)]
struct Exits {
    legs: Vec<Leg>,
    /// Index of each node's first leg, and the end of the last node's legs.
    starts: Vec<u32>,
}

/// All legs.
#[derive(Debug, Default)]
pub(crate) struct LegTable {
    chords: EdgeTable,
    edges: Vec<EdgeInfo>,
    forward: Exits,
    reverse: Exits,
}

impl LegTable {
    pub(crate) fn new(world: &World<'_>) -> Self {
        let (chords, edges) = (EdgeTable::new(world), world.edges());
        let (mut infos, mut forward, mut reverse) = (Vec::new(), Vec::new(), Vec::new());
        for (index, edge) in (0..).zip(edges) {
            let &EdgeRecord { origin, destination, .. } = edge;
            let length = chords.length(index).unwrap_or(edge.length);
            let (speed, reverse_speed) = (edge.speed, edge.reverse_speed);
            infos.push(EdgeInfo { origin, destination, length, speed, reverse_speed });
            forward.push((origin, Leg::new(index, false)));
            if edge.reverse_speed > 0.0 {
                reverse.push((destination, Leg::new(index, true)));
            }
        }
        Self { chords, edges: infos, forward: Exits::new(forward), reverse: Exits::new(reverse) }
    }

    /// Returns a leg; `None` if there is no such edge, or it isn't a curve.
    pub(crate) fn get(&self, leg: Leg) -> Option<LegInfo<'_>> {
        let (chords, edge) = (self.chords.chords(leg.edge()), self.edges.get(leg.edge() as usize)?);
        let speed = if leg.is_reverse() { edge.reverse_speed } else { edge.speed };
        (!chords.is_empty()).then_some(LegInfo { chords, length: edge.length, speed })
    }

    /// Whether robots have the heading of the tangent on all edges, so that it is their direction
    /// of travel, too.
    pub(crate) fn are_tangential(&self) -> bool {
        self.chords.are_tangential()
    }

    /// Returns the direction of travel in forward gear, as a unit vector, of a robot on an edge
    /// with this heading.
    pub(crate) fn direction(&self, edge: u32, s: f32, heading: Vec2) -> Vec2 {
        self.chords.direction(edge, s, heading)
    }

    /// Returns the legs that a robot may drive after this one without changing gear: all that leave
    /// its end, except for the one straight back, which is possible only if there is no other.
    pub(crate) fn successors(&self, leg: Leg) -> impl Iterator<Item = Leg> + Clone {
        let [start, end] = self.nodes(leg).unwrap_or([u32::MAX; 2]);
        let exits = if leg.is_reverse() { &self.reverse } else { &self.forward };
        let exits = exits.of(end);
        let back =
            exits.iter().position(|exit| self.nodes(*exit).is_some_and(|[_, end]| end == start));
        let back = back.filter(|_| exits.len() > 1);
        exits
            .iter()
            .enumerate()
            .filter(move |(place, _)| Some(*place) != back)
            .map(|(_, exit)| *exit)
    }

    /// Returns the nodes at which a leg starts and ends.
    fn nodes(&self, leg: Leg) -> Option<[u32; 2]> {
        let &EdgeInfo { origin, destination, .. } = self.edges.get(leg.edge() as usize)?;
        Some(if leg.is_reverse() { [destination, origin] } else { [origin, destination] })
    }
}

impl Exits {
    /// Sorts legs by the node that they leave.
    fn new(mut legs: Vec<(u32, Leg)>) -> Self {
        legs.sort_by_key(|(node, _)| *node);
        // A world of garbage may name any node; the list of starts must not grow with it.
        let nodes = legs
            .iter()
            .rposition(|(node, _)| (*node as usize) < 2 * legs.len() + 2)
            .map_or(0, |last| last + 1);
        legs.truncate(nodes);
        let count = legs.last().map_or(0, |(node, _)| *node as usize + 1);
        let starts = (0..=count)
            .map(|node| legs.partition_point(|(start, _)| (*start as usize) < node) as u32);
        Self { starts: starts.collect(), legs: legs.into_iter().map(|(_, leg)| leg).collect() }
    }

    fn of(&self, node: u32) -> &[Leg] {
        let node = node as usize;
        match (self.starts.get(node), self.starts.get(node.wrapping_add(1))) {
            (Some(&start), Some(&end)) => &self.legs[start as usize..end as usize],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;

    fn edge(origin: u32, destination: u32, reverse_speed: f32) -> EdgeRecord {
        EdgeRecord { origin, destination, reverse_speed, length: 1.0, ..EdgeRecord::default() }
    }

    fn table(edges: &[EdgeRecord]) -> LegTable {
        LegTable::new(&WorldData { edges: edges.to_vec(), ..WorldData::default() }.view(1, 1))
    }

    fn successors(table: &LegTable, edge: u32, reverse: bool) -> Vec<(u32, bool)> {
        table
            .successors(Leg::new(edge, reverse))
            .map(|leg| (leg.edge(), leg.is_reverse()))
            .collect()
    }

    #[test]
    fn a_robot_turns_straight_back_only_at_a_dead_end_and_keeps_its_gear() {
        // 0 ⇄ 1 → 2 ⇄ 3
        let edges =
            [edge(0, 1, 0.5), edge(1, 0, 0.0), edge(1, 2, 0.5), edge(2, 3, 0.0), edge(3, 2, 0.0)];
        let table = table(&edges);
        assert_eq!(successors(&table, 0, false), [(2, false)]);
        assert_eq!(successors(&table, 3, false), [(4, false)], "node 3 is a dead end");
        assert_eq!(successors(&table, 4, false), [(3, false)], "so is node 2");
        assert_eq!(successors(&table, 2, true), [(0, true)]);
        assert_eq!(successors(&table, 0, true), []);
        assert_eq!(successors(&table, 77, false), [], "no such edge");
    }

    #[test]
    fn nodes_that_do_not_exist_have_no_successors() {
        let table = table(&[edge(0, 1, 0.0), edge(u32::MAX, u32::MAX, 0.0)]);
        assert_eq!(successors(&table, 0, false), []);
        assert_eq!(successors(&table, 1, false), []);
    }
}
