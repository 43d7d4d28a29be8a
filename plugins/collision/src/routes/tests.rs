//! Routes are followed from edge to edge, and forgotten where they end.

use super::*;

const RUN: u64 = 7;

/// Returns an answer of a tick: the legs of robot 0, all released.
fn answer(tick: u64, legs: &[u32]) -> RouteResponse {
    let edges = legs.iter().map(|edge| (*edge, false));
    RouteResponse::unknown(RUN, tick, 0).with_legs(legs.len(), legs.len(), edges)
}

/// Follows robot 0 to an edge, and returns the legs after it.
fn ahead(routes: &mut Routes, tick: u64, edge: u32) -> Option<Vec<u32>> {
    routes.follow(RUN, tick, &[edge]);
    routes.ahead(0, edge).map(|route| route.legs.iter().map(|leg| leg.edge()).collect())
}

#[test]
fn a_route_is_followed_from_edge_to_edge() {
    let mut routes = Routes::default();
    assert_eq!(ahead(&mut routes, 1, 5), None);
    assert!(routes.is_wanted(0));
    routes.learn(&answer(1, &[5, 6, 7, 8]));
    assert_eq!(ahead(&mut routes, 2, 5), Some(vec![6, 7, 8]));
    assert_eq!(ahead(&mut routes, 3, 5), Some(vec![6, 7, 8]));
    assert_eq!(ahead(&mut routes, 4, 7), Some(vec![8]), "it has passed an edge between two frames");
    assert!(!routes.is_wanted(0), "its end is known");
    assert_eq!(ahead(&mut routes, 5, 99), None, "it has left its route");
    assert_eq!(ahead(&mut routes, 6, 8), None, "a route that was left is forgotten");
    assert!(routes.is_wanted(0));
}

#[test]
fn a_robot_that_waits_has_its_whole_route_ahead() {
    let mut routes = Routes::default();
    ahead(&mut routes, 1, 4);
    routes.learn(&answer(1, &[5, 6]));
    assert_eq!(ahead(&mut routes, 2, 4), Some(vec![5, 6]), "it stands at the end of an edge");
    assert_eq!(ahead(&mut routes, 3, 5), Some(vec![6]));
}

#[test]
fn an_answer_that_is_ahead_of_the_frames_counts_when_they_have_caught_up() {
    let mut routes = Routes::default();
    ahead(&mut routes, 1, 3);
    routes.learn(&answer(9, &[5, 6]));
    assert_eq!(ahead(&mut routes, 2, 3), None);
    assert_eq!(ahead(&mut routes, 9, 5), Some(vec![6]));
}

#[test]
fn only_the_released_base_counts_unless_the_robot_drives_on() {
    let edges = || [5, 6, 7, 8, 9].map(|edge| (edge, false)).into_iter();
    let base = RouteResponse::unknown(RUN, 1, 0).with_legs(2, 5, edges());
    let mut routes = Routes::default();
    ahead(&mut routes, 1, 5);
    routes.learn(&base);
    assert_eq!(ahead(&mut routes, 2, 5), Some(vec![6]));
    assert_eq!(routes.ahead(0, 5).expect("known").end, RouteEnd::Stop);
    routes.learn(&base.and_on());
    assert_eq!(ahead(&mut routes, 3, 5), Some(vec![6, 7, 8, 9]));
    assert_eq!(routes.ahead(0, 5).expect("known").end, RouteEnd::Open);
    assert!(!routes.is_wanted(0), "the answer is new");
    ahead(&mut routes, 4, 6);
    assert!(routes.is_wanted(0), "few legs are left");
}

#[test]
fn after_a_command_the_route_counts_until_a_later_answer_comes_but_not_for_long() {
    let mut routes = Routes::default();
    ahead(&mut routes, 1, 5);
    routes.learn(&answer(1, &[5, 6]));
    ahead(&mut routes, 2, 5);
    routes.mark_stale(0, 3);
    routes.learn(&answer(2, &[5, 7]));
    assert_eq!(ahead(&mut routes, 3, 5), Some(vec![6]), "an answer from before the command");
    assert!(routes.is_wanted(0));
    routes.learn(&answer(3, &[5, 8]));
    assert_eq!(ahead(&mut routes, 4, 5), Some(vec![8]));
    routes.mark_stale(0, 5);
    assert_eq!(ahead(&mut routes, 6 + MAX_STALE_TICKS, 5), None, "nobody answers");
}

#[test]
fn routes_of_robots_that_are_gone_and_of_other_runs_are_forgotten() {
    let mut routes = Routes::default();
    routes.follow(RUN, 1, &[5, 5, 5]);
    for robot in 0..3 {
        routes.learn(&RouteResponse { robot, ..answer(1, &[5, 6]) });
    }
    routes.follow(RUN, 2, &[99, 5]);
    assert_eq!([0, 1, 2].map(|robot| routes.ahead(robot, 5).is_some()), [false, true, false]);
    routes.follow(RUN + 1, 0, &[5, 5, 5]);
    assert!((0..3).all(|robot| routes.ahead(robot, 5).is_none()));
}
