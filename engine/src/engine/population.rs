//! How many robots there are, and what the world says of them.

use regatta_plugin::column::ColumnHeader;
use regatta_plugin::world::{EdgeRecord, NodeRecord, RobotTypeRecord};

use super::{Engine, EngineError};
use crate::fleet::{Placement, RobotType, RouteSource};
use crate::scenario::Start;

impl Engine {
    /// Spawns robots as the scenario says, or removes those with the highest ids.
    pub(super) fn set_robots(&mut self, wanted: u32) {
        while self.fleet.present() > wanted {
            self.fleet.remove_last();
        }
        while self.fleet.present() < wanted {
            let group = self.scenario.group_of(self.fleet.next_id());
            let (placement, route) = match &group.start {
                Start::Route { legs, repeat } => {
                    (Placement::StartOf(legs[0]), RouteSource::Listed(legs.clone(), *repeat))
                }
                Start::Random => (Placement::Random, RouteSource::Random),
                Start::Node(node) => (Placement::Node(*node), RouteSource::None),
            };
            self.fleet.spawn(placement, group.robot_type, route);
        }
    }

    /// Publishes the graph and the robot types.
    pub(super) fn publish_world(&mut self) -> Result<(), EngineError> {
        let graph = &self.scenario.graph;
        let nodes: Vec<_> = graph.nodes().iter().map(node_record).collect();
        let lengths = (0..).map(|index| self.fleet.tracks().edge_length(crate::graph::EdgeIndex(index)));
        let edges: Vec<_> = graph.edges().iter().zip(lengths).map(|(edge, length)| edge_record(edge, length)).collect();
        let types: Vec<_> = self.scenario.robot_types.iter().map(robot_type_record).collect();
        self.producer.publish_world(&nodes, &edges, &types)?;
        Ok(())
    }

    /// Publishes each robot's type as the column `type`.
    pub(super) fn publish_types(&mut self) -> Result<(), EngineError> {
        let types: Vec<f32> = self.fleet.robot_types().map(f32::from).collect();
        let header = ColumnHeader { run_id: self.run_id, tick: self.tick, ..ColumnHeader::default() };
        Ok(self.producer.publish_column("type", header, &types)?)
    }
}

fn node_record(node: &crate::graph::Node) -> NodeRecord {
    let [x, y] = node.position.as_vec2().to_array();
    NodeRecord { id: node.id, x, y, theta: node.theta as f32 }
}

fn edge_record(edge: &crate::graph::Edge, length: f32) -> EdgeRecord {
    EdgeRecord {
        id: edge.id,
        origin: edge.origin.0,
        destination: edge.destination.0,
        length,
        control_points: edge.curve.control_points.map(|point| point.as_vec2().to_array()),
        velocity_forward: edge.velocity_forward as f32,
        velocity_backwards: edge.velocity_backwards.unwrap_or(0.0) as f32,
        ..EdgeRecord::default()
    }
}

fn robot_type_record(robot_type: &RobotType) -> RobotTypeRecord {
    let mut name = [0; 48];
    let mut end = robot_type.name.len().min(name.len());
    while !robot_type.name.is_char_boundary(end) {
        end -= 1;
    }
    name[..end].copy_from_slice(&robot_type.name.as_bytes()[..end]);
    RobotTypeRecord {
        name,
        length: robot_type.length,
        width: robot_type.width,
        max_speed: robot_type.max_speed,
        max_acceleration: robot_type.max_acceleration,
    }
}
