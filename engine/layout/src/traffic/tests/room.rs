//! The bound on robots anywhere on the roads against robots that are put there.

use glam::Vec2;
use proptest::prelude::*;
use regatta_base::sweep::Rectangle;

use super::layouts::{layout, robot};
use crate::model::route_graph::{Edge, RouteGraph};
use crate::traffic::network::Network;
use crate::traffic::{Certificate, RobotType};

/// Poses on each edge.
const POSES: u32 = 150;

/// The outlines of robots at poses along an edge.
fn outlines(edge: &Edge, robot: &RobotType) -> impl Iterator<Item = Rectangle> {
    (0..=POSES).map(|pose| {
        let (point, tangent) = edge.path.at(f64::from(pose) / f64::from(POSES));
        let heading = edge.orientation.heading(tangent.to_angle()) as f32;
        let half = robot.footprint().half;
        Rectangle { centre: point.as_vec2(), heading: Vec2::from_angle(heading), half }
    })
}

/// Puts robots on edges of the main part, one after the other in their order, wherever they touch
/// none. Returns how many.
fn placed(graph: &RouteGraph, robot: &RobotType, order: &[usize]) -> usize {
    let network = Network::new(graph);
    let mut placed: Vec<Rectangle> = Vec::new();
    for &index in order {
        let edge = &graph.edges()[index % graph.edges().len()];
        if network.is_main(edge.origin.0) && network.is_main(edge.destination.0) {
            for outline in outlines(edge, robot) {
                if !placed.iter().any(|other| other.touches(&outline)) {
                    placed.push(outline);
                }
            }
        }
    }
    placed.len()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn no_more_robots_than_the_bound_fit_on_the_roads(
        graph in layout(),
        robot in robot(),
        order in prop::collection::vec(0_usize..40, 1..40),
    ) {
        let bound = Certificate::new(&graph, &robot).under_way.anywhere;
        let placed = placed(&graph, &robot, &order);
        prop_assert!(placed as u64 <= bound, "{placed} robots, but at most {bound}");
    }
}
