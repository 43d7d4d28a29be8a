//! The background on the plan: walls, and the outlines of floors and racks.

use glam::Vec2;
use regatta_base::outline::{LineKind, kinds};
use regatta_plugin::World;

use super::facilities::{Bar, BarColour};
use super::is_on_level;

/// Returns the lines of a level (`None` for all levels), each a list of points in metres. A line
/// without a level is on all of them.
pub fn lines<'a>(
    world: &World<'a>,
    level: Option<&str>,
) -> impl Iterator<Item = impl Iterator<Item = Vec2> + Clone + use<'a>> {
    let lines = world.background_lines().iter();
    let shown = lines.filter(move |line| line.level == 0 || is_on_level(world, line.level, level));
    shown.map(|line| {
        let points = world.background_points(line).iter().map(|point| Vec2::from_array(*point));
        points.filter(|point| point.is_finite())
    })
}

/// A line of the background.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its points in metres.
    pub points: Vec<Vec2>,
    /// Its meaning.
    pub kind: LineKind,
}

/// Returns the lines of a level with their kinds.
pub fn lines_by_kind(world: &World<'_>, level: Option<&str>) -> Vec<Line> {
    let lines: Vec<Vec<Vec2>> = lines(world, level).map(Iterator::collect).collect();
    let exact: Vec<Vec<_>> =
        lines.iter().map(|line| line.iter().map(|point| point.as_dvec2()).collect()).collect();
    let nodes = world.nodes().iter().filter(|node| is_on_level(world, node.level, level));
    let nodes = nodes.map(|node| Vec2::new(node.x, node.y).as_dvec2());
    let kinds = kinds(&exact, nodes.filter(|place| place.is_finite()));
    lines.into_iter().zip(kinds).map(|(points, kind)| Line { points, kind }).collect()
}

/// Returns the bars of the lines of a level: walls over racks.
pub fn walls(world: &World<'_>, level: Option<&str>) -> Vec<Bar> {
    let mut lines = lines_by_kind(world, level);
    lines.sort_by_key(|line| line.kind == LineKind::Wall);
    let mut walls = Vec::new();
    for Line { points, kind } in lines {
        let colour = match kind {
            LineKind::Wall => BarColour::Wall,
            LineKind::Rack => BarColour::Rack,
        };
        walls.extend(
            points.windows(2).map(|ends| Bar { ends: [ends[0], ends[1]], colour: colour as u32 }),
        );
    }
    walls
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{NodeRecord, WorldData};

    use super::*;

    #[test]
    fn walls_are_on_their_levels_and_those_without_one_on_all() {
        let mut data = WorldData::default();
        let level = data.texts.add("L1");
        data.add_background_line(level, [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]);
        data.add_background_line(0, [[1.0, 1.0], [1.0, 2.0]]);
        let world = data.view(1, 1);
        let counts = [None, Some("L1"), Some("L2")].map(|level| walls(&world, level).len());
        assert_eq!(counts, [3, 3, 1]);
        assert_eq!(walls(&world, None)[1].ends, [Vec2::new(4.0, 0.0), Vec2::new(4.0, 3.0)]);
    }

    #[test]
    fn a_point_that_is_no_number_is_left_out() {
        let mut data = WorldData::default();
        data.add_background_line(0, [[0.0, 0.0], [f32::NAN, 0.0], [4.0, 3.0]]);
        assert_eq!(walls(&data.view(1, 1), None)[0].ends, [Vec2::ZERO, Vec2::new(4.0, 3.0)]);
    }

    #[test]
    fn racks_have_a_colour_of_their_own() {
        let mut data = WorldData::default();
        data.nodes.push(NodeRecord { x: -1.0, ..NodeRecord::default() });
        let rack = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0]];
        data.add_background_line(0, rack);
        data.add_background_line(0, [[9.0, 0.0], [9.0, 3.0]]);
        let walls = walls(&data.view(1, 1), None);
        let colours: Vec<_> = walls.iter().map(|wall| wall.colour).collect();
        let [rack, wall] = [BarColour::Rack, BarColour::Wall].map(|colour| colour as u32);
        assert_eq!(colours, [rack, rack, rack, rack, wall]);
    }
}
