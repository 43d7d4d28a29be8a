//! The density of robots from afar: when it replaces marks, and what is dense.

use glam::Vec2;
use regatta_plugin::World;

use crate::camera::Bounds;
use crate::curves::curve_point;

/// Robots above the second length in pixels are marks, those below the first are a field, and
/// between them more and more of them are marks.
pub const FADE: [f32; 2] = [1.6, 4.4];
/// The least number of robots per pixel of the picture at which marks are so many that they run
/// into each other: marks are larger than robots where there is room for that.
pub const CROWDED: f32 = 1.0 / 64.0;
/// Columns and rows of the cells in which a graph's ground is counted.
const CELLS: usize = 64;

/// Returns the ground that a graph's edges reach, in square metres, without the empty parts of a
/// site; `None` if there are no edges.
pub fn ground_of(world: &World<'_>) -> Option<f32> {
    let points = || {
        let parameters = [0.0, 0.25, 0.5, 0.75, 1.0];
        world
            .all_curves()
            .iter()
            .flat_map(move |curve| parameters.map(|parameter| curve_point(curve, parameter)))
    };
    let bounds = Bounds::from_points(points())?;
    // A single straight edge has no width of its own.
    let size = (bounds.high - bounds.low).max(Vec2::splat(1.0));
    let mut is_reached = vec![false; CELLS * CELLS];
    for point in points() {
        let cell = ((point - bounds.low) / size * CELLS as f32)
            .as_usizevec2()
            .min(glam::USizeVec2::splat(CELLS - 1));
        is_reached[cell.y * CELLS + cell.x] = true;
    }
    let reached = is_reached.iter().filter(|reached| **reached).count();
    Some(size.element_product() * reached as f32 / (CELLS * CELLS) as f32)
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

    use super::*;

    #[test]
    fn the_ground_of_a_graph_is_without_its_empty_parts() {
        assert_eq!(ground_of(&WorldData::default().view(1, 1)), None);
        let mut world = WorldData::default();
        // Two halls of 64 m by 64 m, 64 m apart.
        for row in 0..64 {
            for x in (0..64).chain(128..192) {
                let (x, y) = (x as f32, row as f32);
                world
                    .add_edge(EdgeRecord::default(), [CurveRecord::straight([x, y], [x + 1.0, y])]);
            }
        }
        let ground = ground_of(&world.view(1, 1)).expect("a ground");
        assert!((ground - 2.0 * 64.0 * 64.0).abs() < 500.0, "{ground}");
    }
}
