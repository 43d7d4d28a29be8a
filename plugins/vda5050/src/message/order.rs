//! Orders: nodes and edges to drive, with actions.

use serde::{Deserialize, Serialize};

use super::Message;
use super::action::Action;
use super::header::{Header, Topic, Version};

/// An order, or an update of one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Order {
    /// The header.
    #[serde(flatten)]
    pub header: Header,
    /// Tells the order from others.
    pub order_id: String,
    /// Counts the updates of an order, from 0.
    pub order_update_id: u32,
    /// A text for people; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order_description: Option<String>,
    /// The zone set that the vehicle has to use; 2.x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zone_set_id: Option<String>,
    /// The nodes, in the order in which they are reached.
    pub nodes: Vec<Node>,
    /// The edges between them: one less.
    pub edges: Vec<Edge>,
}

/// A node of an order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Node {
    /// Tells the node from others of the layout.
    pub node_id: String,
    /// Its place in the order, which it shares with edges: an even number.
    pub sequence_id: u32,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_descriptor: Option<String>,
    /// Whether it belongs to the base.
    pub released: bool,
    /// Its position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node_position: Option<NodePosition>,
    /// The actions to carry out there.
    #[serde(default)]
    pub actions: Vec<Action>,
}

/// The position of a node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct NodePosition {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians in [-π, π].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta: Option<f64>,
    /// The place around the node where the vehicle may be. The schema of 2.0 spells it
    /// `allowedDeviationXy`.
    #[serde(rename = "allowedDeviationXY", alias = "allowedDeviationXy")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed_deviation: Option<AllowedDeviation>,
    /// Radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed_deviation_theta: Option<f64>,
    /// The map on which the position is.
    pub map_id: String,
    /// A text for people; 2.x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_descriptor: Option<String>,
}

/// The place around a node in which it counts as reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AllowedDeviation {
    /// A circle of this radius, in metres; 2.x.
    Radius(f64),
    /// An ellipse; 3.0.
    Ellipse(Ellipse),
}

/// An ellipse around a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ellipse {
    /// The longer semi-axis, in metres.
    pub a: f64,
    /// The shorter semi-axis, in metres.
    pub b: f64,
    /// The angle of the longer axis, in radians.
    pub theta: f64,
}

impl AllowedDeviation {
    /// Whether a place is within it, so many metres east and north of the node.
    pub fn contains(self, east: f64, north: f64) -> bool {
        let Ellipse { a, b, theta } = self.ellipse();
        let (sin, cos) = theta.sin_cos();
        let along = east * cos + north * sin;
        let across = north * cos - east * sin;
        a > 0.0 && b > 0.0 && (along / a).powi(2) + (across / b).powi(2) <= 1.0
    }

    fn ellipse(self) -> Ellipse {
        match self {
            Self::Radius(radius) => Ellipse { a: radius, b: radius, theta: 0.0 },
            Self::Ellipse(ellipse) => ellipse,
        }
    }

    /// The circle within the ellipse, for 2.x; the ellipse, for 3.0.
    fn adapted(self, version: Version) -> Self {
        let ellipse = self.ellipse();
        match version {
            Version::V2_0 | Version::V2_1 => Self::Radius(ellipse.a.min(ellipse.b)),
            Version::V3_0 => Self::Ellipse(ellipse),
        }
    }
}

/// An edge of an order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Edge {
    /// Tells the edge from others of the layout.
    pub edge_id: String,
    /// Its place in the order, which it shares with nodes: an odd number.
    pub sequence_id: u32,
    /// A text for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge_descriptor: Option<String>,
    /// Whether it belongs to the base.
    pub released: bool,
    /// The node where it begins; 2.x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_node_id: Option<String>,
    /// The node where it ends; 2.x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_node_id: Option<String>,
    /// Metres per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_speed: Option<f64>,
    /// Metres: the height of vehicle and load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_mobile_robot_height: Option<f64>,
    /// Metres: the height of the load handling device.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum_load_handling_device_height: Option<f64>,
    /// Radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<f64>,
    /// The reference of the orientation; the tangent if it isn't given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_type: Option<OrientationType>,
    /// The way at a junction, for vehicles that follow lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<String>,
    /// Whether the vehicle may turn on the edge; 2.x.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_allowed: Option<bool>,
    /// Whether it has to turn before it enters the edge; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach_orientation_before_entering: Option<bool>,
    /// Radians per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maximum_rotation_speed: Option<f64>,
    /// The path of the edge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<Trajectory>,
    /// Metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// The space beside the path that the vehicle may use; from 2.1 on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corridor: Option<Corridor>,
    /// The actions to carry out on the edge.
    #[serde(default)]
    pub actions: Vec<Action>,
}

/// The reference of an orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OrientationType {
    /// The map.
    Global,
    /// The tangent of the edge.
    #[default]
    Tangential,
}

/// A path as a NURBS curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Trajectory {
    /// The degree; 1 if it isn't given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<u32>,
    /// The knots, in [0, 1].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub knot_vector: Option<Vec<f64>>,
    /// The control points.
    pub control_points: Vec<ControlPoint>,
}

/// A control point of a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlPoint {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// The weight; 1 if it isn't given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

/// The space beside a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Corridor {
    /// Metres.
    pub left_width: f64,
    /// Metres.
    pub right_width: f64,
    /// The part of the vehicle that has to be in it; the centre if it isn't given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corridor_reference_point: Option<CorridorReference>,
    /// Whether the vehicle has to ask first; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_required: Option<bool>,
    /// The behaviour if the release is lost; 3.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_loss_behavior: Option<LossBehavior>,
}

/// The part of a vehicle that has to be in a corridor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum CorridorReference {
    /// Its centre.
    KinematicCenter,
    /// All of it.
    Contour,
}

/// The behaviour of a vehicle that loses the release of its corridor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum LossBehavior {
    /// It stops.
    Stop,
    /// It returns to the path.
    Return,
}

impl Message for Order {
    const TOPIC: Topic = Topic::Order;

    fn adapt(&mut self, version: Version) {
        for node in &mut self.nodes {
            node.actions.iter_mut().for_each(|action| action.adapt(version));
            if let Some(position) = &mut node.node_position {
                position.allowed_deviation =
                    position.allowed_deviation.map(|deviation| deviation.adapted(version));
            }
        }
        for (edge, ends) in self.edges.iter_mut().zip(self.nodes.windows(2)) {
            edge.adapt(version, [&ends[0].node_id, &ends[1].node_id]);
        }
        if version == Version::V3_0 {
            self.zone_set_id = None;
        } else {
            self.order_description = None;
        }
    }
}

impl Edge {
    /// Expresses the edge between two nodes as a version can.
    fn adapt(&mut self, version: Version, ends: [&String; 2]) {
        self.actions.iter_mut().for_each(|action| action.adapt(version));
        if version == Version::V3_0 {
            (self.start_node_id, self.end_node_id, self.rotation_allowed) = (None, None, None);
            return;
        }
        self.start_node_id.get_or_insert_with(|| ends[0].clone());
        self.end_node_id.get_or_insert_with(|| ends[1].clone());
        self.reach_orientation_before_entering = None;
        if let Some(trajectory) = &mut self.trajectory {
            trajectory.complete();
        }
        if version == Version::V2_0 {
            (self.corridor, self.orientation_type) = (None, None);
        }
    }
}

impl Trajectory {
    /// Adds degree, knots and weights, which 2.x requires.
    pub(super) fn complete(&mut self) {
        for point in &mut self.control_points {
            point.weight.get_or_insert(1.0);
        }
        let degree = *self.degree.get_or_insert(1) as usize;
        let spans = self.control_points.len().saturating_sub(degree).max(1);
        self.knot_vector.get_or_insert_with(|| {
            let inner = (1..spans).map(|knot| knot as f64 / spans as f64);
            let ends = [0.0, 1.0].map(|end| std::iter::repeat_n(end, degree + 1));
            let [first, last] = ends;
            first.chain(inner).chain(last).collect()
        });
    }
}
