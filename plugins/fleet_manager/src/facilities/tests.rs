//! Requests of doors and lifts for robots of a model.

use regatta_plugin::world::{DoorRecord, LiftRecord, Orientation, WorldData, ZoneRecord};

use super::*;
use crate::model::{Model, worlds};
use crate::planner::PlannerKind;
use crate::steering::Settings;

/// A road through a door (edge 1) to a lift, in it from node 3 to node 4, and on at the other
/// level; and back.
fn plant() -> WorldData {
    let points: Vec<[f32; 2]> = (0..7).map(|node| [8.0 * node as f32, 0.0]).collect();
    let there = (0..6).map(|node| [node, node + 1]);
    let edges: Vec<[u32; 2]> = there.chain((0..6).map(|node| [node + 1, node])).collect();
    let mut world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Fixed(0.0));
    let levels = ["L1", "L2"].map(|name| world.texts.add(name));
    for (node, level) in world.nodes.iter_mut().zip([0, 0, 0, 0, 1, 1, 1]) {
        node.level = levels[level];
    }
    world.add_door(DoorRecord { opening_secs: 4.0, ..DoorRecord::default() }, [1, 7]);
    let lift = LiftRecord {
        level_secs: 8.0,
        opening_secs: 3.0,
        closing_secs: 2.0,
        ..LiftRecord::default()
    };
    world.add_lift(lift, [(levels[0], [3]), (levels[1], [4])], [3, 9]);
    let zone = ZoneRecord { capacity: 1, ..ZoneRecord::default() };
    world.add_zone(zone, [3, 4], [3, 9]);
    world
}

/// The commands of a run of the model with one robot, from node 1 to a goal.
fn commands(goal: u32) -> Vec<(u32, FacilityCommand)> {
    let world = plant();
    let mut facilities = Facilities::new(&world.view(1, 1));
    let lanes = |roads: &_| PlannerKind::Lanes.planner(roads, 1, None).0;
    let mut model = Model::new(&world, &[(Leg::new(0, false), 1.0)], 1, Settings::default(), lanes);
    model.stops = vec![goal];
    let mut all = Vec::new();
    for tick in 0..600 {
        model.run(1);
        let requests = facilities.request(&model.steering, f64::from(tick) / 10.0);
        all.extend(requests.iter().map(|command| (tick, *command)));
        if model.total() > 0 {
            break;
        }
    }
    all
}

#[test]
fn doors_and_lifts_are_requested_ahead_and_released_behind() {
    let all = commands(6);
    let first =
        |ask: Ask| all.iter().find(|(_, command)| command.ask == ask).map(|(tick, _)| *tick);
    let opened = first(Ask::Door(1)).expect("the door is requested");
    let released = first(Ask::ReleaseDoor(1)).expect("and released");
    assert!(opened < 30 && released > 100, "{opened} {released}: 7 m before it, and behind it");
    let [called, ridden, left] = [Ask::Lift(3), Ask::Lift(4), Ask::ReleaseLift(4)].map(first);
    assert!(called.expect("called") < 150, "before the robot is there: {called:?}");
    assert!(ridden > called && left > ridden, "{called:?} {ridden:?} {left:?}");
    let count = all.iter().filter(|(_, command)| command.ask == Ask::Lift(4)).count();
    assert!(count > 1, "it is called again while it is needed");
}

#[test]
fn routes_cost_what_doors_and_lifts_cost() {
    let world = plant();
    let roads = Roads::new(&world.view(1, 1));
    let delays: Vec<f32> = roads.edges().iter().map(|road| road.delay_secs).collect();
    // The ride of 8 m at 1 m/s takes as long as the cabin.
    assert_eq!(delays[..6], [0.0, 4.0, 9.0, 0.0, 3.0, 0.0]);
}

/// A robot that has a ride up in its base, and a new plan that leads down again from there.
#[test]
fn a_cabin_is_called_to_where_the_robot_turns_back() {
    let world = plant();
    let (facilities, roads) = (Facilities::new(&world.view(1, 1)), Roads::new(&world.view(1, 1)));
    let way = |edges: &[u32]| -> Vec<Step> {
        edges.iter().map(|edge| Step { leg: Leg::new(*edge, false), metres: 8.0 }).collect()
    };
    let stop = |edges: &[u32]| facilities.stop(&roads, Part::Ride, &way(edges));
    assert_eq!(stop(&[3, 4]), Some(4));
    assert_eq!(stop(&[3, 9, 8]), Some(4), "up first, and then down");
    assert_eq!(stop(&[9, 8]), Some(3));
}
