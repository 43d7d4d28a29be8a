//! The table of conflicts against poses.

use glam::Vec2;
use proptest::prelude::*;
use regatta_base::graph::Gear;
use regatta_base::sweep::Rectangle;

use super::layouts::{layout, robot};
use crate::NodeIndex;
use crate::model::route_graph::{Edge, RouteGraph};
use crate::traffic::conflicts::{Conflicts, Sweeps};
use crate::traffic::network::Network;
use crate::traffic::tracks::{TrackKind, Tracks};
use crate::traffic::{RobotType, Turning};

/// Poses on each edge.
const POSES: u32 = 200;
/// Metres by which the outlines of the table may exceed those of robots, at most: the margin, and
/// what bends add to the middle of a stretch.
const EXCESS: f64 = 0.13;

/// The outline of a robot on an edge, larger on all sides by some metres.
fn outline(edge: &Edge, fraction: f64, robot: &RobotType, more: f64) -> Rectangle {
    let (point, tangent) = edge.path.at(fraction);
    let heading = edge.orientation.heading(tangent.to_angle());
    let footprint = robot.footprint().grown(more as f32);
    footprint.at(point.as_vec2(), Vec2::from_angle(heading as f32))
}

fn outlines(edge: &Edge, robot: &RobotType, more: f64) -> Vec<Rectangle> {
    let fractions = (0..=POSES).map(|pose| f64::from(pose) / f64::from(POSES));
    fractions.map(|fraction| outline(edge, fraction, robot, more)).collect()
}

/// The outlines of robots that stand at a node.
fn standing(graph: &RouteGraph, node: u32, robot: &RobotType, more: f64) -> Vec<Rectangle> {
    let mut outlines = Vec::new();
    for edge in graph.edges() {
        for (end, fraction) in [(edge.origin, 0.0), (edge.destination, 1.0)] {
            outlines.extend((end.0 == node).then(|| outline(edge, fraction, robot, more)));
        }
    }
    outlines
}

fn touch(some: &[Rectangle], others: &[Rectangle]) -> bool {
    some.iter().any(|rectangle| others.iter().any(|other| rectangle.touches(other)))
}

/// Whether a robot can stand somewhere on an edge while another one drives all of another edge.
fn has_room(edge: &[Rectangle], other: &[Rectangle]) -> bool {
    edge.iter().any(|rectangle| !touch(&[*rectangle], other))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever touches is in the table, and what is in the table touches if robots are a little
    /// larger.
    #[test]
    fn robots_that_touch_are_in_the_table(graph in layout(), robot in robot()) {
        let network = Network::new(&graph);
        let conflicts = Conflicts::new(&network, &Sweeps::new(&graph), &robot);
        for node in 0..network.nodes() {
            let [exact, larger] = [0.0, EXCESS].map(|more| standing(&graph, node, &robot, more));
            for (index, edge) in (0..).zip(graph.edges()) {
                if edge.origin.0 == node || edge.destination.0 == node {
                    continue;
                }
                let is_touched = conflicts.touched(node).contains(&index);
                prop_assert!(is_touched || !touch(&exact, &outlines(edge, &robot, 0.0)));
                prop_assert!(!is_touched || touch(&larger, &outlines(edge, &robot, EXCESS)));
            }
            for other in (0..network.nodes()).filter(|other| *other != node) {
                let is_touching = conflicts.is_touching(node, other);
                let there = |more: f64| standing(&graph, other, &robot, more);
                prop_assert!(is_touching || !touch(&exact, &there(0.0)));
                prop_assert!(!is_touching || touch(&larger, &there(EXCESS)));
                prop_assert_eq!(is_touching, conflicts.is_touching(other, node));
            }
        }
    }

    /// A leg is blocked by robots that touch its edge, or its start where robots turn.
    #[test]
    fn legs_are_blocked_by_robots_in_the_way(graph in layout(), robot in robot()) {
        let network = Network::new(&graph);
        let conflicts = Conflicts::new(&network, &Sweeps::new(&graph), &robot);
        let circle = f64::from(robot.footprint().radius());
        for leg in (0..graph.edges().len() as u32).flat_map(|edge| network.legs_of(edge)) {
            let edge = graph.edge(leg.edge);
            let start = if leg.gear == Gear::Forward { edge.origin } else { edge.destination };
            for node in (0..network.nodes()).filter(|node| *node != start.0) {
                let meets = edge.origin.0 == node || edge.destination.0 == node;
                let touches = meets
                    || conflicts.is_touching(node, network.end(leg))
                    || conflicts.touched(node).contains(&leg.edge.0);
                let is_blocked = conflicts.is_blocked(leg, node);
                prop_assert!(is_blocked || !touches);
                if is_blocked && !touches {
                    let [here, there] =
                        [start, NodeIndex(node)].map(|node| graph.node(node).position);
                    prop_assert!(robot.turning() == Turning::OnTheSpot);
                    prop_assert!(here.distance(there) < 3.0 * circle + EXCESS);
                }
            }
        }
    }

    /// Two robots pass on a double track, and don't on a single one if they are a little larger.
    #[test]
    fn robots_pass_on_double_tracks_only(graph in layout(), robot in robot()) {
        let network = Network::new(&graph);
        for track in Tracks::new(&network, &Sweeps::new(&graph), &robot).all {
            let ways = |more: f64| {
                let all = track.edges.iter().map(|&edge| graph.edge(crate::EdgeIndex(edge)));
                let all: Vec<(&Edge, Vec<Rectangle>)> =
                    all.map(|edge| (edge, outlines(edge, &robot, more))).collect();
                let opposite = |a: &Edge, b: &Edge| {
                    a.id != b.id && (a.origin != b.origin
                        || a.reverse_speed.is_some() || b.reverse_speed.is_some())
                };
                all.iter().any(|(a, one)| {
                    all.iter().any(|(b, other)| opposite(a, b) && has_room(one, other))
                })
            };
            match track.kind {
                TrackKind::Double => prop_assert!(ways(0.0)),
                TrackKind::Single => prop_assert!(!ways(EXCESS)),
                TrackKind::OneWay | TrackKind::Closed => (),
            }
        }
    }
}
