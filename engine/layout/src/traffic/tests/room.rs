//! The bound on robots anywhere on the roads against robots that are put there.

use std::f32::consts::PI;

use glam::Vec2;
use proptest::prelude::*;
use regatta_base::sweep::{MARGIN, Rectangle};

use super::layouts::{layout, robot};
use crate::model::options::ReadOptions;
use crate::model::route_graph::{Edge, RouteGraph};
use crate::parse;
use crate::traffic::network::Network;
use crate::traffic::{Certainty, Certificate, Count, RobotType, Turning};

/// Poses on each edge.
const POSES: u32 = 150;
/// Headings of a robot that turns at a node.
const HEADINGS: u32 = 7;

/// The outlines of robots at poses along an edge; those that turn have other headings at its ends,
/// too.
fn outlines(edge: &Edge, robot: &RobotType) -> impl Iterator<Item = Rectangle> {
    let footprint = robot.footprint().grown(MARGIN);
    let turns = robot.turning() == Turning::OnTheSpot;
    (0..=POSES).flat_map(move |pose| {
        let (point, tangent) = edge.path.at(f64::from(pose) / f64::from(POSES));
        let heading = edge.orientation.heading(tangent.to_angle()) as f32;
        let headings = if turns && pose % POSES == 0 { HEADINGS } else { 1 };
        (0..headings).map(move |turn| {
            let heading = Vec2::from_angle(heading + PI * turn as f32 / HEADINGS as f32);
            footprint.at(point.as_vec2(), heading)
        })
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

/// A closed polygon of corners at a distance from the middle, driven in one direction.
fn ring(names: &str, corners: u32, radius: f64, order: impl Fn(u32) -> [u32; 2]) -> [String; 2] {
    let corner = |corner: u32| {
        let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
        format!("{names}{corner},{},{}\n", radius * angle.cos(), radius * angle.sin())
    };
    let road = |corner: u32| {
        let [from, to] = order(corner).map(|corner| corner % corners);
        format!("{names}{from},{names}{to}\n")
    };
    [(0..corners).map(corner).collect(), (0..corners).map(road).collect()]
}

fn most_anywhere(nodes: &str, edges: &str, robot: &RobotType) -> (u64, usize) {
    let text = format!("id,x,y\n{nodes}\nfrom,to\n{edges}");
    let (graph, _) = parse(&text, "plant.csv", &ReadOptions::default()).expect("a graph");
    let order: Vec<usize> = (0..graph.edges().len()).collect();
    (Certificate::new(&graph, robot).under_way.anywhere, placed(&graph, robot, &order))
}

/// Bounds that are far above what fits would let planners hope for room that isn't there.
#[test]
fn the_bound_is_close_to_what_fits() {
    let robot = |length, width| RobotType::new(length, width, Turning::OnTheSpot).expect("a size");
    let loop_of = |sides: [&str; 4]| sides.map(|side| format!("{side}\n")).concat();
    let lanes = loop_of(["A,0,0", "B,40,0", "C,40,1", "D,0,1"]);
    let lanes_there_and_back = loop_of(["A,B", "B,C", "C,D", "D,A"]);
    for (length, width) in [(0.9, 0.6), (1.0, 1.0), (1.2, 0.9), (2.0, 1.0)] {
        let robot = robot(length, width);
        let (bound, placed) = most_anywhere(&lanes, &lanes_there_and_back, &robot);
        assert!(placed as u64 <= bound && 7 * bound <= 10 * placed as u64, "{bound} {placed}");
    }
    // Edges barely longer than a robot, one after the other.
    let [nodes, edges] = ring("N", 20, 3.342, |corner| [corner, corner + 1]);
    let (bound, placed) = most_anywhere(&nodes, &edges, &robot(0.9, 0.6));
    assert!(placed as u64 <= bound && bound <= 26, "{bound} {placed}");
}

#[test]
fn both_directions_of_a_loop_share_the_room_where_robots_touch_across() {
    let [mut nodes, mut edges] = ring("O", 16, 12.0, |corner| [corner, corner + 1]);
    let [inner, back] = ring("I", 16, 11.0, |corner| [corner + 1, corner]);
    nodes += &inner;
    edges += &back;
    edges += "O0,I0\nI0,O0\n";
    let wide = RobotType::new(1.2, 1.0, Turning::OnTheSpot).expect("a size");
    let (bound, placed) = most_anywhere(&nodes, &edges, &wide);
    assert!(placed as u64 <= bound && bound <= 100, "{bound} {placed}");
}

/// Ten nodes 1.2 m apart: discs of 0.9 m clear all but the node ahead, squares that turn don't.
#[test]
fn all_but_one_node_of_a_ring_are_for_discs() {
    let [nodes, edges] = ring("N", 10, 1.9416, |corner| [corner, corner + 1]);
    let text = format!("id,x,y\n{nodes}\nfrom,to\n{edges}");
    let (graph, _) = parse(&text, "plant.csv", &ReadOptions::default()).expect("a graph");
    let disc = RobotType::round(0.9, Turning::OnTheSpot).expect("a size");
    let most = Certificate::new(&graph, &disc).under_way;
    assert_eq!(most.at_nodes, Count { robots: 9, certainty: Certainty::Exact });
    // The ring is 12 m long: 13 diameters.
    assert!((12..=15).contains(&most.anywhere), "{}", most.anywhere);
    let square = RobotType::new(0.9, 0.9, Turning::OnTheSpot).expect("a size");
    assert!(Certificate::new(&graph, &square).under_way.at_nodes.robots < 9);
}
