//! The manager against a model of a fleet.

use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::manager::{ManagerAnswer, ManagerRequest};
use regatta_plugin::world::{EdgeRecord, Orientation};

use crate::model::managed::Managed;
use crate::model::worlds;
use crate::planner::PlannerKind;
use regatta_orders::{Change, InTurn, OrderId, State, Unroutable};

/// A block with one way in and one way out, and streets round it.
const LOAD: &str = "load: {seed: 1, groups: {in: [0], out: [23]}, generators: [{name: a, from: in, to: out, per_hour: 90, dwell: 5}]}";

#[test]
fn breakdowns_that_are_repaired_only_delay_orders() {
    let world = worlds::streets(6, 6.0, true);
    for seed in 1..4 {
        let mut fleet = Managed::new(&world, 12, seed, LOAD, PlannerKind::Lanes);
        // Two breakdowns of each robot in an hour, of two minutes each.
        fleet.run(72_000, 56, 1_200);
        let figures = fleet.manager.orders().figures(7_200.0);
        assert_eq!(figures.orders.failed, 0, "{figures:?}");
        assert!(
            figures.orders.finished > 140 && figures.service.longest_secs < 1_800.0,
            "{figures:?}"
        );
        // Once all are repaired, all orders are carried out.
        let created = figures.orders;
        fleet.run(12_000, 0, 0);
        let open = fleet.manager.orders().figures(8_400.0).orders;
        assert_eq!(open.unroutable, 0, "{created:?} {open:?}");
        assert!(open.waiting < 10, "{created:?} {open:?}");
    }
}

/// A track that is driven both ways, with so few orders that robots are idle now and then, are sent
/// aside, and get orders on their way.
#[test]
fn orders_on_a_single_track_are_carried_out_in_spite_of_breakdowns() {
    let load = "load: {seed: 3, generators: [{name: a, per_hour: 60, dwell: {min: 2, max: 30}}]}";
    let world = worlds::single_track(7);
    for (robots, seed) in [(2, 1), (3, 2), (4, 3), (4, 4)] {
        let mut fleet = Managed::new(&world, robots, seed, load, PlannerKind::Committed);
        fleet.run(36_000, 56, 600);
        fleet.run(6_000, 0, 0);
        let orders = fleet.manager.orders().figures(4_200.0).orders;
        assert!(orders.finished > 45 && orders.waiting < 10, "{robots} {seed}: {orders:?}");
        assert_eq!((orders.failed, orders.unroutable), (0, 0), "{robots} {seed}: {orders:?}");
    }
}

/// An order ends where the action at its first or its second stop fails, and nothing else does.
#[test]
fn an_order_whose_action_fails_is_over_and_its_robot_gets_another_one() {
    for handled in [0, 1] {
        let world = worlds::streets(6, 6.0, true);
        let mut fleet = Managed::new(&world, 2, 1, LOAD, PlannerKind::Lanes);
        let is_there = |fleet: &Managed| {
            let orders = fleet.manager.orders();
            orders.open_orders().any(|order| {
                matches!(order.state, State::Handling(0)) && order.handled_stops == handled
            })
        };
        fleet.manager.fail_action(0);
        while !is_there(&fleet) {
            fleet.run(1, 0, 0);
        }
        let id = fleet.manager.orders().order_of(0).expect("an order");
        fleet.manager.fail_action(0);
        fleet.manager.fail_action(7);
        assert_eq!(fleet.manager.orders().order_of(0), None);
        let events: Vec<_> = fleet.manager.orders_mut().events().collect();
        let reasons: Vec<_> = events
            .iter()
            .filter_map(|event| match &event.change {
                Change::Failed { robot: Some(0), reason } => Some((event.id, reason.as_str())),
                _ => None,
            })
            .collect();
        let place = [0, 23][handled];
        assert_eq!(reasons, [(id, &*format!("the robot's action at {place} has failed"))]);
        fleet.run(12_000, 0, 0);
        let orders = fleet.manager.orders().figures(1_200.0).orders;
        assert!(orders.failed == 1 && orders.finished > 20, "{orders:?}");
    }
}

/// Two rings that no road joins, with orders in the first alone, and some that lead across.
#[test]
fn orders_go_to_robots_that_can_carry_them_out() {
    let ring = |x: f32| [[x, 0.0], [x + 20.0, 0.0], [x + 20.0, 20.0], [x, 20.0]];
    let points = [ring(0.0), ring(100.0)].concat();
    let edges = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4]];
    let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
    let load = "load: {groups: {first: [0, 1, 2, 3], second: [4, 5]}, generators: [\
                {name: a, endless: 3, among: first}, \
                {name: b, per_hour: 60, from: first, to: second}]}";
    for (assigner, seed) in [(true, 1), (true, 2), (false, 1)] {
        let mut fleet = Managed::new(&world, 4, seed, load, PlannerKind::Lanes);
        if assigner {
            fleet.manager.orders_mut().set_assigner(InTurn);
        }
        fleet.run(18_000, 0, 0);
        let orders = fleet.manager.orders().figures(1_800.0).orders;
        assert!(orders.finished > 60 && orders.failed == 0, "{seed}: {orders:?}");
        assert!(orders.unroutable > 20 && orders.waiting < 5, "{seed}: {orders:?}");
    }
}

/// A ring and two dead ends, where a robot is in some other one's way wherever it stands: an idle
/// one is sent from the route of the robot that waits for it.
#[test]
fn idle_robots_make_way_where_no_place_is_out_of_the_way() {
    let points = [[0., 0.], [30., 0.], [30., 20.], [0., 20.], [40., 0.], [-10., 20.]];
    let edges = [[0, 1], [1, 2], [2, 3], [3, 0], [1, 4], [4, 1], [3, 5], [5, 3]];
    let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
    let load = "load: {generators: [{name: a, per_hour: 0.001}]}";
    for seed in [1, 3, 4, 5] {
        let mut fleet = Managed::new(&world, 3, seed, load, PlannerKind::Lanes);
        for (node, now_secs) in [(2, 0.0), (0, 150.0), (2, 300.0), (0, 450.0)] {
            fleet.manager.orders_mut().send(0, node, 1, now_secs);
            fleet.run(1_500, 0, 0);
        }
        let orders = fleet.manager.orders().figures(600.0).orders;
        assert_eq!(orders.finished, 4, "{seed}: {orders:?}");
    }
}

#[test]
fn robots_whose_rows_are_gone_are_in_nobodys_way() {
    for planner in [PlannerKind::Lanes, PlannerKind::Committed] {
        let load = "load: {seed: 3, generators: [{name: a, endless: robots}]}";
        let mut fleet = Managed::new(&worlds::single_track(7), 4, 2, load, planner);
        fleet.run(1_000, 0, 0);
        fleet.keep(1);
        let before = fleet.manager.orders().figures(100.0).orders.finished;
        fleet.run(12_000, 0, 0);
        let orders = fleet.manager.orders().figures(1_300.0).orders;
        assert!(orders.finished > before + 10, "{planner:?}: {before}, then {orders:?}");
    }
}

/// Closes an edge by a command: the only one that leads to the goal of all orders, or one that can
/// be driven round.
#[test]
fn nobody_enters_an_edge_that_is_closed_by_command() {
    let world = worlds::streets(6, 6.0, true);
    let leading_to = |node: u32| world.edges.iter().filter(move |edge| edge.destination == node);
    let leaving = |node: u32| world.edges.iter().filter(move |edge| edge.origin == node);
    let is_detour = |edge: &&EdgeRecord| {
        leading_to(edge.destination).count() > 1 && leaving(edge.origin).count() > 1
    };
    let detour = world.edges.iter().find(is_detour).expect("an edge with another way round it");
    let only = leading_to(23).next().expect("an edge");
    assert_eq!(leading_to(23).count(), 1);
    for (edge, is_only) in [(detour, false), (only, true)] {
        let closed = &[ClosedEdge { edge: edge.id }];
        let mut fleet = Managed::new(&world, 12, 1, LOAD, PlannerKind::Lanes);
        fleet.run(6_000, 0, 0);
        let finished =
            |fleet: &Managed, secs: f64| fleet.manager.orders().figures(secs).orders.finished;
        let before = finished(&fleet, 600.0);
        fleet.manager.close_edges(closed);
        // The robots of the model drive on to the end of their bases, where the engine's would stop
        // before the edge.
        fleet.run(100, 0, 0);
        let mut edges = fleet.edges();
        for _ in 0..12_000 {
            fleet.run(1, 0, 0);
            for (now, before) in
                fleet.edges().into_iter().zip(&edges).filter(|(now, before)| now != *before)
            {
                assert!(
                    !closed.iter().any(|edge| edge.edge == now),
                    "from edge {before} to the closed edge {now}"
                );
            }
            edges = fleet.edges();
        }
        let during = finished(&fleet, 1_800.0) - before;
        assert_eq!(during > 10, !is_only, "{during} orders, {closed:?} closed");
        fleet.manager.close_edges(&[]);
        fleet.run(24_000, 0, 0);
        let figures = fleet.manager.orders().figures(4_200.0).orders;
        assert!(
            figures.unroutable == 0 && figures.failed == 0 && figures.waiting < 10,
            "{figures:?}"
        );
        assert!(figures.finished > 80, "{figures:?}");
    }
}

/// Of an endless load, only the orders that were open when their goal was closed wait for it.
#[test]
fn an_endless_load_makes_no_orders_that_wait_for_closed_roads() {
    let load = "load: {groups: {some: [5, 12, 23]}, generators: [\
                {name: a, endless: robots, from: some, to: some}]}";
    let world = worlds::streets(6, 6.0, true);
    let only = world.edges.iter().find(|edge| edge.destination == 23).expect("an edge");
    let mut fleet = Managed::new(&world, 6, 1, load, PlannerKind::Lanes);
    fleet.run(3_000, 0, 0);
    fleet.manager.close_edges(&[ClosedEdge { edge: only.id }]);
    fleet.run(100, 0, 0);
    let before = fleet.manager.orders().figures(310.0).orders;
    fleet.run(12_000, 0, 0);
    let during = fleet.manager.orders().figures(1_510.0).orders;
    assert!(during.finished > before.finished + 20, "{before:?} {during:?}");
    assert!(during.unroutable <= 6, "{before:?} {during:?}");
    fleet.manager.close_edges(&[]);
    fleet.run(12_000, 0, 0);
    let after = fleet.manager.orders().figures(2_710.0).orders;
    assert!(after.finished > during.finished + 20 && after.unroutable == 0, "{after:?}");
}

/// Sends each robot to a node in the middle of its work, whatever it is about, and calls some back.
#[test]
fn robots_that_are_sent_somewhere_arrive_and_go_on_with_orders() {
    let world = worlds::streets(6, 6.0, true);
    let mut fleet = Managed::new(&world, 12, 1, LOAD, PlannerKind::Lanes);
    fleet.run(3_300, 0, 0);
    let ask = |fleet: &mut Managed, request| fleet.manager.request(&request, 1).answer();
    let node = world.nodes[14].id;
    for (request, answer) in [
        (ManagerRequest::send(12, node), ManagerAnswer::UnknownRobot),
        (ManagerRequest::send(3, 9_999), ManagerAnswer::UnknownNode),
        (ManagerRequest::recall(3), ManagerAnswer::NotSent),
        (ManagerRequest { kind: 9, ..ManagerRequest::recall(3) }, ManagerAnswer::UnknownKind),
    ] {
        assert_eq!(ask(&mut fleet, request), Some(answer), "{request:?}");
    }
    let mut answers = Vec::new();
    for robot in 0..12 {
        let response = fleet.manager.request(&ManagerRequest::send(robot, node), 1);
        answers.push(response.answer().expect("an answer"));
        fleet.run(1, 0, 0);
        let is_sent =
            |fleet: &Managed| fleet.manager.orders().order(OrderId(response.order)).is_some();
        assert!(is_sent(&fleet), "{response:?}");
        let arrived = (0..6_000).any(|_| {
            fleet.run(1, 0, 0);
            !is_sent(&fleet)
        });
        assert!(arrived, "robot {robot} is not there after ten minutes: {response:?}");
        assert_eq!(
            ask(&mut fleet, ManagerRequest::recall(robot)),
            Some(ManagerAnswer::NotSent),
            "it was there"
        );
    }
    assert!(
        answers.contains(&ManagerAnswer::Now) && answers.contains(&ManagerAnswer::Later),
        "{answers:?}"
    );
    assert!(answers.iter().all(|answer| answer.is_granted()));
    assert_eq!(
        ask(&mut fleet, ManagerRequest::send(3, node)).map(ManagerAnswer::is_granted),
        Some(true)
    );
    assert_eq!(ask(&mut fleet, ManagerRequest::recall(3)), Some(ManagerAnswer::Now));
    fleet.run(12_000, 0, 0);
    let figures = fleet.manager.orders().figures(0.0).orders;
    assert!(figures.failed == 0 && figures.waiting < 10, "{figures:?}");
}

/// A robot alone on a loop, whose own breakdowns close the loop.
#[test]
fn a_repaired_robot_goes_on_without_an_unroutable_order() {
    let points = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]];
    let edges = [[0, 1], [1, 2], [2, 3], [3, 0]];
    let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
    let load = "load: {endless: robots, from: 0, to: 2, dwell: 3}";
    let mut fleet = Managed::new(&world, 1, 1, load, PlannerKind::Lanes);
    let mut withdrawn = 0;
    for _ in 0..36_000 {
        fleet.run(1, 1_000, 700);
        for event in fleet.manager.orders_mut().events() {
            let is_impossible =
                matches!(event.change, Change::Unroutable { reason: Unroutable::NoWay, .. });
            assert!(!is_impossible, "{event:?}");
            withdrawn += u32::from(matches!(event.change, Change::Withdrawn { .. }));
        }
    }
    assert!(withdrawn > 3, "breakdowns take orders away: {withdrawn}");
}

/// A person may drive a vehicle to where no way leads on, and back.
#[test]
fn orders_are_carried_out_when_a_robot_is_moved_back_to_where_it_can_reach_them() {
    let points = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [-20.0, 0.0]];
    let edges = [[0, 1], [1, 2], [2, 0], [0, 3]];
    let world = worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
    let load = "load: {seed: 1, groups: {in: [1], out: [2]}, generators: [\
                {name: a, from: in, to: out, per_hour: 120, dwell: 1}]}";
    let mut fleet = Managed::new(&world, 1, 1, load, PlannerKind::Lanes);
    fleet.put(0, 3);
    fleet.run(1_200, 0, 0);
    let lost = fleet.manager.orders().figures(120.0).orders;
    assert!(lost.unroutable > 0 && lost.finished == 0, "{lost:?}");
    fleet.put(0, 2);
    fleet.run(6_000, 0, 0);
    let after = fleet.manager.orders().figures(720.0).orders;
    assert!(after.unroutable == 0 && after.finished > lost.unroutable, "{after:?}");
}
