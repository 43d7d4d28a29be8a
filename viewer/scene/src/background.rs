//! The background on the plan: walls, and the outlines of floors and racks.

use glam::Vec2;
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

/// Returns the bars of the lines of a level.
pub fn walls(world: &World<'_>, level: Option<&str>) -> Vec<Bar> {
    let mut walls = Vec::new();
    for points in lines(world, level) {
        let ends = points.clone().zip(points.skip(1));
        walls.extend(
            ends.map(|(from, to)| Bar { ends: [from, to], colour: BarColour::Wall as u32 }),
        );
    }
    walls
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

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
}
