//! Finds the edge at a place, by a grid over the route graph that is made once for each world.

use std::collections::BTreeMap;

use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord};
use regatta_scene::curves::{curve_length, curve_point};

/// The least and the largest width of a cell, in metres.
const CELL: (f32, f32) = (1.0, 50.0);
/// The maximum number of examined points of a curve.
const MAX_POINTS: u32 = 4096;
/// The largest reach, in cells: with the distance between two points of a curve, it is less than a
/// cell.
const REACH: f32 = 0.7;
/// The number of chords that stand for a curve.
const CHORDS: u32 = 16;

/// The edges of a world, by place.
#[derive(Clone, Debug, Default)]
pub struct EdgeFinder {
    cell: f32,
    cells: BTreeMap<[i32; 2], Vec<u32>>,
}

impl EdgeFinder {
    /// Sorts the edges of a world, or of one of its levels, into cells.
    pub fn new(world: &World<'_>, level: Option<&str>) -> Self {
        let edges = world.edges();
        let mean = edges.iter().map(|edge| edge.length).sum::<f32>() / edges.len().max(1) as f32;
        let mut finder = Self { cell: mean.clamp(CELL.0, CELL.1), cells: BTreeMap::new() };
        let shown = edges
            .iter()
            .zip(0..)
            .filter(|(edge, _)| level.is_none_or(|level| world.text(edge.level) == level));
        for (edge, index) in shown {
            for curve in world.curves(edge) {
                finder.add(index, curve);
            }
        }
        finder
    }

    fn add(&mut self, edge: u32, curve: &CurveRecord) {
        // Half a cell apart: a curve that only touches the corner of a cell may miss it, but then
        // it is in the one beside it.
        let points =
            (2.0 * curve_length(curve) / self.cell).ceil().clamp(1.0, MAX_POINTS as f32) as u32;
        for point in 0..=points {
            let key = self.key(curve_point(curve, point as f32 / points as f32));
            let edges = self.cells.entry(key).or_default();
            if edges.last() != Some(&edge) {
                edges.push(edge);
            }
        }
    }

    fn key(&self, at: Vec2) -> [i32; 2] {
        (at / self.cell).floor().as_ivec2().to_array()
    }

    /// Returns the edge nearest to a place, by its index in the world, if it is within a reach in
    /// metres (at most a part of a cell). Of edges as near as each other, the first one.
    pub fn nearest(&self, world: &World<'_>, at: Vec2, reach: f32) -> Option<u32> {
        if self.cells.is_empty() || !at.is_finite() {
            return None;
        }
        let [x, y] = self.key(at);
        let keys = (-1..=1)
            .flat_map(|dx| (-1..=1).map(move |dy| [x.saturating_add(dx), y.saturating_add(dy)]));
        let near = keys.filter_map(|key| self.cells.get(&key)).flatten();
        let mut found: Option<(f32, u32)> = None;
        for index in near {
            let distance = world
                .edges()
                .get(*index as usize)
                .map_or(f32::INFINITY, |edge| distance(world, edge, at));
            if distance <= reach.min(REACH * self.cell)
                && found.is_none_or(|best| (distance, *index) < best)
            {
                found = Some((distance, *index));
            }
        }
        found.map(|(_, index)| index)
    }
}

/// The distance of a place from an edge, in metres.
fn distance(world: &World<'_>, edge: &EdgeRecord, at: Vec2) -> f32 {
    let mut nearest = f32::INFINITY;
    for curve in world.curves(edge) {
        let mut from = curve_point(curve, 0.0);
        for chord in 1..=CHORDS {
            let to = curve_point(curve, chord as f32 / CHORDS as f32);
            nearest = nearest.min(from_chord(from, to, at));
            from = to;
        }
    }
    nearest
}

fn from_chord(from: Vec2, to: Vec2, at: Vec2) -> f32 {
    let along = to - from;
    let part = ((at - from).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
    at.distance(from + along * part)
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;

    fn world(lines: &[[[f32; 2]; 2]]) -> WorldData {
        let mut world = WorldData::default();
        for [from, to] in lines {
            let length = Vec2::from(*from).distance(Vec2::from(*to));
            let level = world.texts.add("ground");
            world.add_edge(
                EdgeRecord { length, level, ..EdgeRecord::default() },
                [CurveRecord::straight(*from, *to)],
            );
        }
        world
    }

    #[test]
    fn only_edges_of_the_level_within_reach_are_found() {
        let world = world(&[[[0.0, 0.0], [10.0, 0.0]], [[0.0, 3.0], [10.0, 3.0]]]);
        let world = world.view(1, 1);
        let finder = EdgeFinder::new(&world, None);
        assert_eq!(finder.nearest(&world, Vec2::new(5.0, 1.0), 2.0), Some(0));
        assert_eq!(finder.nearest(&world, Vec2::new(5.0, 1.0), 0.5), None);
        assert_eq!(finder.nearest(&world, Vec2::new(5.0, 2.0), 2.0), Some(1));
        assert_eq!(finder.nearest(&world, Vec2::NAN, 2.0), None);
        assert_eq!(
            EdgeFinder::new(&world, Some("cellar")).nearest(&world, Vec2::new(5.0, 1.0), 2.0),
            None
        );
        assert!(
            EdgeFinder::new(&world, Some("ground"))
                .nearest(&world, Vec2::new(5.0, 1.0), 2.0)
                .is_some()
        );
    }

    #[test]
    fn the_grid_finds_what_a_search_through_all_edges_finds() {
        let mut state = 1_u32;
        let mut random = |range: f32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((state >> 8) as f32 / (1 << 24) as f32 - 0.5) * 2.0 * range
        };
        let mut found = 0;
        for edges in 1..60 {
            let lines: Vec<_> = (0..edges)
                .map(|_| [[random(60.0), random(60.0)], [random(60.0), random(60.0)]])
                .collect();
            let world = world(&lines);
            let world = world.view(1, 1);
            let finder = EdgeFinder::new(&world, None);
            for _ in 0..50 {
                let (at, reach) = (Vec2::new(random(65.0), random(65.0)), random(4.0).abs());
                let all = world
                    .edges()
                    .iter()
                    .zip(0..)
                    .map(|(edge, index)| (distance(&world, edge, at), index));
                let within = all.filter(|(distance, _)| *distance <= reach);
                let nearest: Option<(f32, u32)> =
                    within.min_by(|a, b| a.partial_cmp(b).expect("finite"));
                assert_eq!(
                    finder.nearest(&world, at, reach),
                    nearest.map(|(_, index)| index),
                    "{at} {reach} {lines:?}"
                );
                found += usize::from(nearest.is_some());
            }
        }
        assert!(found > 500, "{found}");
    }
}
