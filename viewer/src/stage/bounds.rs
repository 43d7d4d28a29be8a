//! The bounds of what is drawn on the floor.

use glam::Vec2;
use regatta_plugin::World;
use regatta_scene::background::lines;
use regatta_scene::camera::Bounds;
use regatta_scene::curves::curve_point;
use regatta_scene::is_on_level;
use regatta_scene::stations::stations;

/// The bounds of a graph with its stations and its background, or of one of its levels; `None` if
/// that has neither edges nor nodes.
pub(super) fn bounds_of_graph(world: &World<'_>, level: Option<&str>) -> Option<Bounds> {
    let edges = world.edges().iter().filter(|edge| is_on_level(world, edge.level, level));
    let nodes = world.nodes().iter().filter(|node| is_on_level(world, node.level, level));
    let curves = edges.flat_map(|edge| world.curves(edge));
    let points =
        curves.flat_map(|curve| [0.0, 0.25, 0.5, 0.75, 1.0].map(|at| curve_point(curve, at)));
    let roads = Bounds::from_points(points)
        .or_else(|| Bounds::from_points(nodes.map(|node| Vec2::new(node.x, node.y))))?;
    let stations = stations(world, level).into_iter().map(|station| station.place);
    let around = Bounds::from_points(stations.chain(lines(world, level).flatten()));
    Some(around.map_or(roads, |around| roads.union(around)))
}
