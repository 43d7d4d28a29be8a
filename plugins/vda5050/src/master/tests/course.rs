//! Commands make the course of a robot as those of an engine do.

use regatta_plugin::event::Refusal;

use super::*;
use crate::master::course::Course;

fn course(roads: &Roads) -> Course {
    let (leg, travelled) = roads.stance(0).expect("a place");
    Course::at(leg, travelled)
}

fn step(roads: &Roads, edge: u32, released: bool) -> Step {
    Step { leg: roads.leg(edge, false).expect("an edge"), released }
}

#[test]
fn routes_that_do_not_fit_are_refused_and_change_nothing() {
    let roads = Roads::of(&line(5).0.view(1, 1), "map");
    let mut course = course(&roads);
    let [far, next] = [12, 11].map(|edge| step(&roads, edge, false));
    let refused = course.extend(&[far], &roads).expect_err("a gap");
    assert_eq!((refused.reason, refused.id), (Refusal::NotConnected, 12));
    let late = Step { released: true, ..far };
    let refused = course.extend(&[next, late], &roads).expect_err("a released leg after horizon");
    assert_eq!(refused.reason, Refusal::MalformedRoute);
    assert!(course.ahead().is_empty());
    let back = roads.leg(11, true).expect("an edge");
    let refused = course.release(back, 1.0, &roads).expect_err("not ahead");
    assert_eq!((refused.reason, refused.id), (Refusal::NotAhead, 11));
}

#[test]
fn whole_legs_are_released_and_parts_wait_for_the_rest() {
    let roads = Roads::of(&line(5).0.view(1, 1), "map");
    let mut course = course(&roads);
    let legs = [11, 12, 13].map(|edge| step(&roads, edge, false));
    course.extend(&legs, &roads).expect("a route");
    assert_eq!(course.base_end(&roads), course.first(&roads), "nothing is released");
    // The robot stands at the start of edge 10, as no edge leads to its node.
    course.release(legs[1].leg, 2.0, &roads).expect("ahead");
    let released: Vec<bool> = course.ahead().iter().map(|step| step.released).collect();
    assert_eq!(released, [true, false, false], "half of an edge can't be told");
    course.release(legs[1].leg, f64::INFINITY, &roads).expect("ahead");
    course.release(legs[0].leg, 1.0, &roads).expect("sent again");
    assert_eq!(course.base_end(&roads) - course.first(&roads), 3);
    course.drop_horizon();
    assert_eq!(course.ahead().len(), 2);
}

#[test]
fn a_robot_never_goes_back_and_reaches_nodes_one_after_the_other() {
    let roads = Roads::of(&line(5).0.view(1, 1), "map");
    let mut course = course(&roads);
    let legs = [11, 12, 13].map(|edge| step(&roads, edge, true));
    course.extend(&legs, &roads).expect("a route");
    let first = course.first(&roads);
    course.drive(first, 3.0, &roads);
    course.drive(first, 2.0, &roads);
    assert_eq!(course.place().1, 3.0);
    course.drive(first, 7.0, &roads);
    assert!(!course.is_at_end(&roads), "it is there when it says so");
    let mut reached = Vec::new();
    course.finish(first + 2, &roads, |node| reached.push(node));
    assert_eq!((reached, course.is_at_end(&roads)), (vec![1, 2], true));
    course.drive(first + 2, 0.4, &roads);
    assert_eq!(course.place(), (legs[1].leg, 0.4));
}
