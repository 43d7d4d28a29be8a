//! Committed ways where opposing traffic shares tracks, against the model of a fleet.

use super::{Blocks, Committed, Rests};
use crate::model::{Model, TICK_SECS, places, worlds};
use crate::planner::{Planner, PlannerKind};
use crate::roads::Roads;
use crate::traffic::Robot;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, Orientation, WorldData};

fn committed(roads: &Roads) -> Box<dyn Planner> {
    Box::new(Committed::new(roads))
}

/// Drives robots from random node to random node; returns the model.
fn drive(name: &str, world: &WorldData, (robots, seed): (usize, u64), secs: u32) -> Model {
    let settings = PlannerKind::Committed.settings();
    let mut model = Model::new(world, &places(world, robots, seed), seed, settings, committed);
    model.run((secs as f32 / TICK_SECS) as u32);
    println!(
        "{name}, {robots} robots, {secs} s: {} goals, fewest {:?}, longest {:.0} s; {:?}",
        model.total(),
        model.arrivals.iter().min(),
        model.longest_secs(),
        model.counts()
    );
    model
}

#[test]
fn opposing_traffic_shares_a_track() {
    // As many robots as rest places hardly get on.
    for (robots, fewest) in [(1, 10), (2, 10), (3, 10), (4, 10), (5, 10), (6, 1)] {
        let model = drive("track", &worlds::single_track(7), (robots, 1), 1_200);
        assert!(model.arrivals.iter().all(|&goals| goals >= fewest), "{:?}", model.arrivals);
    }
}

#[test]
fn a_lone_robot_gets_its_way_in_the_cycle_in_which_it_is_sent() {
    let world = worlds::single_track(7);
    let settings = PlannerKind::Committed.settings();
    let mut model = Model::new(&world, &places(&world, 1, 1), 1, settings, committed);
    for cycle in 0..10_000 {
        model.run(1);
        let needs_route = model.steering.robot(0).is_some_and(Robot::needs_route);
        assert!(!needs_route, "cycle {cycle}, {} goals", model.total());
    }
    assert!(model.total() > 10);
}

#[test]
fn a_robot_at_work_is_not_sent_away() {
    let world = worlds::single_track(7);
    for seed in 1..5 {
        let settings = PlannerKind::Committed.settings();
        let starts = places(&world, 4, seed);
        let mut model = Model::new(&world, &starts, seed, settings, committed);
        model.pinned = 1;
        let base = |model: &Model| model.steering.claims().end(0).copied();
        model.run(1);
        let before = base(&model);
        model.run(600);
        assert!(model.steering.robot(0).is_some_and(Robot::is_pinned), "seed {seed}");
        assert_eq!(base(&model), before, "seed {seed}");
    }
}

#[test]
fn a_dead_end_is_left_before_it_is_entered() {
    for robots in 1..=4 {
        let model = drive("stub", &worlds::ring_with_stub(3), (robots, 3), 1_200);
        assert!(model.arrivals.iter().all(|&goals| goals >= 4), "{:?}", model.arrivals);
    }
}

/// Robots that drive to and fro between a dock and a node of a ring, which also has a lay-by.
fn from_dock_to_ring(robots: usize) -> u32 {
    let points = [[10.0, 0.0], [30.0, 0.0], [30.0, 12.0], [10.0, 12.0], [0.0, 0.0], [0.0, 12.0]];
    let ring = [[0, 1], [1, 2], [2, 3], [3, 0]];
    let dead_ends = [[4, 0], [0, 4], [5, 3], [3, 5]];
    let edges = [ring, dead_ends].concat();
    let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Fixed(0.0));
    let settings = PlannerKind::Committed.settings();
    let mut model = Model::new(&world, &places(&world, robots, 1), 1, settings, committed);
    model.stops = vec![4, 2];
    model.run((3_600.0 / TICK_SECS) as u32);
    println!("{robots}: {:?}", model.arrivals);
    model.total()
}

#[test]
fn a_robot_leaves_its_place_of_rest_to_one_whose_goal_it_is() {
    let (one, two) = (from_dock_to_ring(1), from_dock_to_ring(2));
    assert!(10 * two > 17 * one, "{two} goals of two robots, {one} of one");
}

/// Roads of two parts: robots in the smaller one have places to rest, too.
#[test]
fn each_part_of_the_roads_has_rest_places() {
    let mut world = worlds::single_track(4);
    let (nodes, edges) = (world.nodes.len() as u32, world.edges.len());
    let second = worlds::single_track(2);
    world.nodes.extend(second.nodes.iter().map(|node| NodeRecord { y: node.y + 50.0, ..*node }));
    let view = second.view(1, 1);
    for edge in view.edges() {
        let (origin, destination) = (nodes + edge.origin, nodes + edge.destination);
        let [curve] = view.curves(edge) else { panic!("straight edges") };
        let points = curve.control_points.map(|[x, y]| [x, y + 50.0]);
        let edge = EdgeRecord { origin, destination, ..*edge };
        world.add_edge(edge, [CurveRecord { control_points: points }]);
    }
    let roads = Roads::new(&world.view(1, 1));
    let mut blocks = Blocks::default();
    let rests = Rests::new(&roads, &mut blocks);
    let count = |range: std::ops::Range<u32>| range.filter(|&node| rests.contains(node)).count();
    assert!(count(0..nodes) > 1 && count(nodes..roads.nodes()) > 1, "{edges} edges in the first");
}

#[test]
fn robots_cross_a_grid() {
    let model = drive("grid", &worlds::cells(8), (12, 1), 600);
    assert!(model.arrivals.iter().all(|&goals| goals >= 20), "{:?}", model.arrivals);
}
