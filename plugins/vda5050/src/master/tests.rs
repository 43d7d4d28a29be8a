//! Tests of the master, and the small plants that they use.

use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, RobotTypeRecord, WorldData};

/// A line of `nodes` nodes, 5 m apart, with the numbers 1, 2, 3 … and the names N1, N2, N3 …; the
/// edges between them have the numbers 10, 11 …, and its origin is at (100, 200). Also returns the
/// names of the nodes.
pub(super) fn line(nodes: u32) -> (WorldData, Vec<String>) {
    let mut world = WorldData { origin: [100.0, 200.0], ..WorldData::default() };
    let names: Vec<String> = (1..=nodes).map(|number| format!("N{number}")).collect();
    for (id, name) in (1..).zip(&names) {
        let name = world.texts.add(name);
        let x = 5.0 * (id - 1) as f32;
        world.nodes.push(NodeRecord { id, name, x, ..NodeRecord::default() });
    }
    for origin in 0..nodes - 1 {
        let destination = origin + 1;
        let (length, speed, id) = (5.0, 1.0, 10 + origin);
        let edge = EdgeRecord { id, origin, destination, length, speed, ..EdgeRecord::default() };
        let ends = [origin, destination].map(|node| [5.0 * node as f32, 0.0]);
        world.add_edge(edge, [CurveRecord::straight(ends[0], ends[1])]);
    }
    world.robot_types.push(RobotTypeRecord::new("amr", 0.8, 0.6));
    (world, names)
}
