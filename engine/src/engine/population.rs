//! The number of robots, and the world and types that the engine publishes.

use regatta_plugin::PublishError;
use regatta_plugin::producer::Session;
use regatta_plugin::world::{EdgeRecord, NodeRecord, RobotTypeRecord};

use super::{EngineError, Simulation};
use crate::fleet::{Placement, RobotType, RouteSource};
use crate::graph::EdgeIndex;
use crate::scenario::Start;

impl Simulation {
    /// Spawns robots as the scenario defines them, or removes those with the highest ids, until there are `wanted`.
    pub(super) fn place_robots(&mut self, wanted: u32) {
        let wanted = wanted as usize;
        self.fleet.reserve(wanted);
        while self.fleet.present() > wanted {
            let last = self.fleet.robots() as u32 - 1;
            self.fleet.remove(last, &mut self.events).expect("the last row always holds a robot");
        }
        while self.fleet.present() < wanted {
            let robot = self.fleet.present() as u32;
            let group = self.scenario.group_of(robot);
            let (placement, route) = match &group.start {
                Start::Route { legs, repeat } => (
                    Placement::Node(self.scenario.graph.leg_start(legs[0])),
                    RouteSource::Listed(legs.clone(), *repeat),
                ),
                Start::Random => (self.random_place(robot), RouteSource::Random),
                Start::Node(node) => (Placement::Node(*node), RouteSource::None),
            };
            let spawned = self.fleet.spawn(placement, group.robot_type, route, 0, &mut self.events);
            spawned.expect("the scenario's routes are connected and its places on the graph");
        }
    }

    /// Returns a random place on a random edge, determined by the scenario's seed and the robot.
    fn random_place(&self, robot: u32) -> Placement {
        let random = mix(self.scenario.seed ^ mix(u64::from(robot)));
        let edges = self.scenario.graph.edges().len() as u64;
        let edge = EdgeIndex((((random >> 32) * edges) >> 32) as u32);
        let part = (random & 0xff_ffff) as f32 / (1 << 24) as f32;
        Placement::Edge(edge, self.tracks.edge_length(edge) as f32 * part)
    }

    /// Publishes the graph and the robot types.
    pub(super) fn publish_world(&mut self, session: &mut Session) -> Result<(), EngineError> {
        let graph = &self.scenario.graph;
        let nodes: Vec<_> = graph.nodes().iter().map(node_record).collect();
        let lengths = (0..).map(|index| self.tracks.edge_length(EdgeIndex(index)) as f32);
        let edges: Vec<_> = graph.edges().iter().zip(lengths).map(|(edge, length)| edge_record(edge, length)).collect();
        let types: Vec<_> = self.scenario.robot_types.iter().map(robot_type_record).collect();
        session.ports().publish_world(&nodes, &edges, &types)?;
        Ok(())
    }

    /// Publishes each robot's type as a column.
    pub(super) fn publish_types(&mut self, session: &mut Session) -> Result<(), EngineError> {
        self.robot_types.clear();
        self.robot_types.extend_from_slice(self.fleet.robot_types());
        let types: Vec<f32> = self.robot_types.iter().map(|&robot_type| f32::from(robot_type)).collect();
        let tick = session.tick();
        let published = session.ports().publish_column("type", tick, &types);
        if matches!(published, Err(PublishError::MemoryFull { .. })) {
            // They are published when there is room again.
            self.robot_types.clear();
        }
        Ok(session.unless_full(published)?)
    }
}

/// SplitMix64's finaliser (Steele, Lea, Flood: Fast splittable pseudorandom number generators, 2014).
fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
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
    RobotTypeRecord {
        name: RobotTypeRecord::padded_name(&robot_type.name),
        shape: robot_type.shape as u32,
        length: robot_type.length,
        width: robot_type.width,
        max_speed: robot_type.max_speed,
        max_acceleration: robot_type.max_acceleration,
    }
}
