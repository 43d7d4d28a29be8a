//! The legs that a standing robot blocks, and the nodes where no other robot can stand.

use std::f64::consts::PI;

use regatta_base::cores;
use regatta_base::graph::{EdgeIndex, Gear, Leg, NodeIndex, SMOOTH_TURN};
use regatta_base::rows::Rows;
use regatta_base::sweep::{BodyHeading, Footprint, Grid, Outlines, Rectangle, Sweep, SweptBox};

use super::levels::Levels;
use super::network::{Network, leg_index, leg_of};
use super::robot::{RobotType, Turning};
use crate::model::angle::normalize_angle;
use crate::model::path::Path;
use crate::model::route_graph::{Edge, RouteGraph};
use crate::model::tags::Orientation;

/// The longest stretch of a straight edge that is driven along its tangent, and of all others, in
/// metres.
const STRAIGHT_STEP: f64 = 5.0;
const OTHER_STEP: f64 = 0.1;
/// Headings that differ by less than this, in radians, count as one.
const SAME_HEADING: f64 = 1e-3;

/// The sweeps of all edges.
#[derive(Debug)]
pub struct Sweeps {
    by_edge: Vec<Sweep>,
}

impl Sweeps {
    /// Samples all edges of a graph.
    pub fn new(graph: &RouteGraph) -> Self {
        let edges = graph.edges();
        Self { by_edge: cores::map(edges.len(), |edge| sweep(&edges[edge])) }
    }

    /// The outlines of a footprint along an edge.
    pub fn outlines(&self, edge: u32, footprint: &Footprint) -> Outlines<'_> {
        Outlines::new(self.by_edge[edge as usize].boxes(), footprint)
    }

    /// The outlines along all edges.
    fn all(&self, footprint: &Footprint) -> Vec<Outlines<'_>> {
        cores::map(self.by_edge.len(), |edge| self.outlines(edge as u32, footprint))
    }
}

fn sweep(edge: &Edge) -> Sweep {
    let is_plain = edge.orientation == Orientation::Tangential && is_straight(&edge.path);
    sweep_with(edge, if is_plain { STRAIGHT_STEP } else { OTHER_STEP })
}

/// Samples an edge with stretches of at most a number of metres.
pub fn sweep_with(edge: &Edge, step: f64) -> Sweep {
    let heading = match edge.orientation {
        Orientation::Tangential => BodyHeading::Tangential,
        Orientation::Offset(offset) => BodyHeading::Offset(offset),
        Orientation::Fixed(heading) => BodyHeading::Fixed(heading),
    };
    Sweep::with_step(heading, edge.path.cubics().map(|cubic| cubic.control_points), step)
}

/// Whether all control points of a path lie on the line through its ends.
pub fn is_straight(path: &Path) -> bool {
    let chord = path.end() - path.start();
    path.control_points()
        .all(|point| chord.perp_dot(point - path.start()).abs() <= 1e-9 * chord.length_squared())
}

/// The roads that robots at nodes block, by brute geometry: no relation between the roads counts.
#[derive(Debug)]
pub struct Conflicts {
    /// By leg: the nodes other than its start where a standing robot keeps others from driving it,
    /// its end among them.
    blockers: Rows<u32>,
    /// By node: the indices of the legs that a robot there keeps others from driving.
    blocked: Rows<u32>,
    /// By node: the other nodes where no robot can stand at the same time.
    touching: Rows<u32>,
    /// By node: the edges that don't meet there, on which robots touch one that stands there.
    touched: Rows<u32>,
    /// By node: further such edges, on which robots touch one that turns on the spot there.
    swept: Rows<u32>,
}

/// The things that a robot at a node touches.
struct Contacts {
    edges: Vec<u32>,
    nodes: Vec<u32>,
    /// Nodes where another robot that turns touches it.
    turns: Vec<u32>,
    /// Further edges, which it touches when it turns.
    swept: Vec<u32>,
}

impl Conflicts {
    /// Tests the robots that stand at each node against those on all edges and at all nodes.
    pub fn new(network: &Network<'_>, sweeps: &Sweeps, robot: &RobotType) -> Self {
        let finder = Finder::new(network.graph, sweeps, robot);
        let contacts = cores::map(network.nodes() as usize, |node| {
            let may_turn = turns_at(network, robot, node as u32);
            finder.contacts(node as u32, may_turn)
        });
        let touching = (0..).zip(&contacts).flat_map(|(node, found)| pairs(node, &found.nodes));
        let touched = (0..).zip(&contacts).flat_map(|(node, found)| pairs(node, &found.edges));
        let touching = Rows::of_sorted(contacts.len(), touching);
        let touched = Rows::of_sorted(contacts.len(), touched);
        let swept = (0..).zip(&contacts).flat_map(|(node, found)| pairs(node, &found.swept));
        let swept = Rows::of_sorted(contacts.len(), swept);
        let mut blocked = Vec::new();
        for (node, found) in (0..).zip(&contacts) {
            blocked.extend(legs_blocked(network, robot, node, found));
        }
        let by_leg = blocked.iter().map(|&(node, leg)| (leg, node)).collect();
        Self {
            blockers: Rows::new(2 * network.graph.edges().len(), by_leg),
            blocked: Rows::new(contacts.len(), blocked),
            touching,
            touched,
            swept,
        }
    }

    /// The nodes other than its start where a standing robot keeps others from driving a leg, in
    /// ascending order.
    pub fn blockers(&self, leg: Leg) -> &[u32] {
        self.blockers.row(leg_index(leg))
    }

    /// Whether a robot that stands at a node keeps others from driving a leg.
    pub fn is_blocked(&self, leg: Leg, by: u32) -> bool {
        self.blockers(leg).binary_search(&by).is_ok()
    }

    /// The legs that a robot at a node keeps others from driving; those that leave the node aren't
    /// among them, as nobody else can start there.
    pub fn blocked(&self, node: u32) -> impl Iterator<Item = Leg> + '_ {
        self.blocked.row(node).iter().map(|&index| leg_of(index))
    }

    /// The nodes where no robot can stand while one stands at `node`, in ascending order.
    pub fn touching(&self, node: u32) -> &[u32] {
        self.touching.row(node)
    }

    /// Whether robots at two different nodes touch.
    pub fn is_touching(&self, a: u32, b: u32) -> bool {
        self.touching(a).binary_search(&b).is_ok()
    }

    /// The edges that don't meet a node, on which robots touch one that stands there, in ascending
    /// order.
    pub fn touched(&self, node: u32) -> &[u32] {
        self.touched.row(node)
    }

    /// The further edges that don't meet a node, on which robots touch one that turns on the spot
    /// there, in ascending order.
    pub fn swept(&self, node: u32) -> &[u32] {
        self.swept.row(node)
    }
}

fn pairs(node: u32, others: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    others.iter().map(move |&other| (node, other))
}

/// Returns the legs that a robot at a node blocks, each with the node.
fn legs_blocked(
    network: &Network<'_>,
    robot: &RobotType,
    node: u32,
    found: &Contacts,
) -> Vec<(u32, u32)> {
    let edges = network.edges_at(node).into_iter().chain(found.edges.iter().copied());
    let mut blocked: Vec<Leg> = edges.flat_map(|edge| network.legs_of(edge)).collect();
    blocked.extend(found.nodes.iter().flat_map(|&end| network.arrivals(end)));
    if robot.turning() == Turning::OnTheSpot {
        let departures = found.turns.iter().flat_map(|&turn| network.departures(turn));
        blocked.extend(departures.filter(|leg| may_turn(network, **leg)));
    }
    blocked.retain(|&leg| network.start(leg) != node);
    let mut blocked: Vec<u32> = blocked.into_iter().map(leg_index).collect();
    blocked.sort_unstable();
    blocked.dedup();
    blocked.into_iter().map(|leg| (node, leg)).collect()
}

/// The heading of robots where an edge meets its origin or its destination, in radians.
fn heading(edge: &Edge, at_origin: bool) -> f64 {
    let tangent = if at_origin { edge.path.start_tangent() } else { edge.path.end_tangent() };
    edge.orientation.heading(tangent.to_angle())
}

/// Whether a robot that has arrived at the start of a leg may have to turn before it drives it.
fn may_turn(network: &Network<'_>, leg: Leg) -> bool {
    let ahead = heading(network.graph.edge(leg.edge), leg.gear == Gear::Forward);
    network.arrivals(network.start(leg)).iter().any(|before| {
        let edge = network.graph.edge(before.edge);
        let arrival = heading(edge, before.gear == Gear::Reverse);
        normalize_angle(ahead - arrival).abs() > SMOOTH_TURN
    })
}

/// Whether a robot may turn on the spot at a node.
fn turns_at(network: &Network<'_>, robot: &RobotType, node: u32) -> bool {
    let mut departures = network.departures(node).iter();
    robot.turning() == Turning::OnTheSpot && departures.any(|leg| may_turn(network, *leg))
}

/// Finds what robots touch that stand at nodes.
struct Finder<'a> {
    graph: &'a RouteGraph,
    edges: Vec<Outlines<'a>>,
    edge_grid: Grid,
    /// By node: a rectangle for each heading of a robot that stands there.
    standing: Vec<Vec<Rectangle>>,
    node_grid: Grid,
    levels: Levels,
    footprint: Footprint,
    turning: Turning,
}

impl<'a> Finder<'a> {
    fn new(graph: &'a RouteGraph, sweeps: &'a Sweeps, robot: &RobotType) -> Self {
        let footprint = robot.footprint();
        let edges = sweeps.all(&footprint);
        let nodes = graph.nodes().len();
        let poses = poses(graph);
        let standing = cores::map(nodes, |node| standing(graph, &poses, node as u32, &footprint));
        let rectangles: Vec<&[Rectangle]> = edges.iter().map(Outlines::rectangles).collect();
        let places: Vec<&[Rectangle]> = standing.iter().map(Vec::as_slice).collect();
        let cell = 2.0 * footprint.radius().max(0.5);
        Self {
            edge_grid: Grid::new(&rectangles, cell),
            node_grid: Grid::new(&places, cell),
            edges,
            standing,
            graph,
            levels: Levels::new(graph),
            footprint,
            turning: robot.turning(),
        }
    }

    fn contacts(&self, node: u32, may_turn: bool) -> Contacts {
        let edges = self.edges(node, &self.standing[node as usize]);
        let mut swept = Vec::new();
        if may_turn {
            swept = self.edges(node, &[self.disc(node)]);
            swept.retain(|edge| edges.binary_search(edge).is_err());
        }
        Contacts { nodes: self.nodes(node), turns: self.turns(node), edges, swept }
    }

    /// The edges that don't meet a node, on which robots touch one with some outlines there, in
    /// ascending order.
    fn edges(&self, node: u32, outlines: &[Rectangle]) -> Vec<u32> {
        let mut near = self.edge_grid.near(outlines);
        near.retain(|&edge| {
            let ends = self.graph.edge(EdgeIndex(edge));
            ends.origin.0 != node
                && ends.destination.0 != node
                && self.levels.join_edge(node, edge)
                && touches_any(outlines, self.edges[edge as usize].rectangles())
        });
        near
    }

    /// The other nodes where a robot touches one that stands at `node`.
    fn nodes(&self, node: u32) -> Vec<u32> {
        let standing = &self.standing[node as usize];
        let mut near = self.node_grid.near(standing);
        near.retain(|&other| {
            other != node
                && self.levels.join_nodes(node, other)
                && touches_any(standing, &self.standing[other as usize])
        });
        near
    }

    /// The outline of a robot that turns on the spot at a node.
    fn disc(&self, node: u32) -> Rectangle {
        let position = self.graph.node(NodeIndex(node)).position;
        SweptBox::disc(position.as_vec2()).rectangle(&self.footprint)
    }

    /// The other nodes where a robot that turns touches one that stands at `node`.
    fn turns(&self, node: u32) -> Vec<u32> {
        if self.turning == Turning::Never {
            return Vec::new();
        }
        let standing = &self.standing[node as usize];
        let mut near = self.node_grid.near(&[self.disc(node)]);
        near.retain(|&other| {
            other != node
                && self.levels.join_nodes(node, other)
                && touches_any(standing, &[self.disc(other)])
        });
        near
    }
}

/// Returns the headings of robots at each node, in radians: where edges start and end.
fn poses(graph: &RouteGraph) -> Rows<f64> {
    let ends = graph.edges().iter().flat_map(|edge| {
        [(edge.origin.0, heading(edge, true)), (edge.destination.0, heading(edge, false))]
    });
    Rows::by_row(graph.nodes().len(), ends.collect())
}

/// Returns a rectangle for each heading of a robot that stands at a node, none for a node without
/// roads.
fn standing(
    graph: &RouteGraph,
    poses: &Rows<f64>,
    node: u32,
    footprint: &Footprint,
) -> Vec<Rectangle> {
    // A rectangle is the same half a turn further.
    let mut angles: Vec<f64> = poses.row(node).iter().map(|angle| angle.rem_euclid(PI)).collect();
    angles.sort_unstable_by(f64::total_cmp);
    angles.dedup_by(|next, kept| *next - *kept < SAME_HEADING);
    let position = graph.node(NodeIndex(node)).position.as_vec2();
    let rectangles = angles
        .into_iter()
        .map(|angle| SweptBox::standing(position, angle as f32).rectangle(footprint));
    rectangles.collect()
}

fn touches_any(standing: &[Rectangle], others: &[Rectangle]) -> bool {
    standing.iter().any(|rectangle| others.iter().any(|other| rectangle.touches(other)))
}
