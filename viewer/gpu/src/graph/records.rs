//! The records of a graph's curves and nodes on the GPU.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord};
use regatta_scene::curves::{curve_length, middle};

/// A curve of an edge, or of none. The same as `Curve` in curves.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct CurveInstance {
    /// Index of the edge in the world.
    edge: u32,
    /// Metres.
    length: f32,
    /// Metres; 0 if the curve belongs to no edge, and isn't drawn.
    edge_length: f32,
    /// The edge's speed in reverse gear in metres per second; 0 if that isn't allowed.
    reverse_speed: f32,
    control_points: [[f32; 2]; 4],
    /// The parameter of the edge's arrow, or a negative number if the arrow is on another curve.
    arrow: f32,
    reserved: f32,
}

/// Returns the world's curves, at their indices in the world.
pub fn curve_instances(world: &World<'_>, level: Option<&str>) -> Vec<CurveInstance> {
    let unused = |curve: &CurveRecord| CurveInstance {
        edge: u32::MAX,
        control_points: curve.control_points,
        arrow: -1.0,
        ..CurveInstance::zeroed()
    };
    let mut instances: Vec<_> = world.all_curves().iter().map(unused).collect();
    let is_shown = |text: u32| level.is_none_or(|level| world.text(text) == level);
    for (index, edge) in (0..).zip(world.edges()).filter(|(_, edge)| is_shown(edge.level)) {
        let curves = world.curves(edge);
        let first = edge.first_curve as usize;
        if let Some(instances) = instances.get_mut(first..first + curves.len()) {
            assign(instances, (index, edge), curves);
        }
    }
    instances
}

/// Assigns curves to their edge.
fn assign(
    instances: &mut [CurveInstance],
    (index, edge): (u32, &EdgeRecord),
    curves: &[CurveRecord],
) {
    let total: f32 = curves.iter().map(curve_length).sum();
    let scale = edge.length / total.max(1e-6);
    let (with_arrow, parameter) = middle(curves);
    for (number, (instance, curve)) in instances.iter_mut().zip(curves).enumerate() {
        instance.edge = index;
        instance.length = if curves.len() == 1 { edge.length } else { curve_length(curve) * scale };
        instance.edge_length = edge.length;
        instance.reverse_speed = edge.reverse_speed;
        instance.arrow = if number == with_arrow { parameter } else { -1.0 };
    }
}

/// A node. The same as `Node` in curves.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct NodeInstance {
    position: [f32; 2],
}

/// Returns the world's nodes, at their indices in the world. Those of other levels have no place,
/// and are never in sight.
pub fn node_instances(world: &World<'_>, level: Option<&str>) -> Vec<NodeInstance> {
    let is_shown = |node: &NodeRecord| level.is_none_or(|level| world.text(node.level) == level);
    let place = |node: &NodeRecord| NodeInstance {
        position: if is_shown(node) { [node.x, node.y] } else { [f32::NAN; 2] },
    };
    world.nodes().iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;

    #[test]
    fn every_curve_knows_its_edge_and_one_has_the_arrow() {
        let line = CurveRecord::straight;
        let mut world = WorldData::default();
        let edge = |length| EdgeRecord { length, reverse_speed: 0.5, ..EdgeRecord::default() };
        world.add_edge(edge(2.0), [line([0.0, 0.0], [2.0, 0.0])]);
        world.add_edge(edge(8.0), [line([2.0, 0.0], [2.0, 2.0]), line([2.0, 2.0], [8.0, 2.0])]);
        world.curves.push(line([0.0, 0.0], [1.0, 1.0]));
        let instances = curve_instances(&world.view(1, 1), None);
        assert_eq!(
            instances.iter().map(|instance| instance.edge).collect::<Vec<_>>(),
            [0, 1, 1, u32::MAX]
        );
        let near = |numbers: [f32; 4], expected: [f32; 4]| {
            numbers.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3)
        };
        let column =
            |of: fn(&CurveInstance) -> f32| [0, 1, 2, 3].map(|index| of(&instances[index]));
        assert!(near(column(|instance| instance.length), [2.0, 2.0, 6.0, 0.0]));
        assert!(
            near(column(|instance| instance.arrow), [0.5, -1.0, 1.0 / 3.0, -1.0]),
            "{instances:?}"
        );
        assert!(near(column(|instance| instance.edge_length), [2.0, 8.0, 8.0, 0.0]));
        assert_eq!(instances[2].control_points, world.curves[2].control_points);
    }
}
