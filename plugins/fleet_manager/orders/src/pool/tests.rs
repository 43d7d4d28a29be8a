use glam::Vec2;
use proptest::prelude::*;
use regatta_plugin::world::Role;

use super::*;
use crate::file::parse_yaml;
use crate::load::Load;
use crate::places::Place;

fn places() -> Arc<Places> {
    let role = |id| if id < 5 { Role::Pick } else { Role::Drop };
    let place =
        |id| Place { id, role: role(id), position: Vec2::X * id as f32, ..Place::default() };
    Arc::new(Places::new((0..10).map(place).collect()))
}

fn pool(orders: &str) -> OrderPool {
    let mut pool = OrderPool::new(places());
    pool.add_orders(&parse_yaml(orders).expect("orders")).expect("valid orders");
    pool.generate_until(0.0, 0);
    pool
}

fn candidates(robots: &[u32]) -> Vec<Candidate> {
    robots
        .iter()
        .map(|robot| Candidate {
            robot: *robot,
            position: Vec2::X * *robot as f32,
            ..Candidate::default()
        })
        .collect()
}

fn driving(robot: u32, node: u32) -> Option<f64> {
    Some(f64::from(robot.abs_diff(node)) * 10.0)
}

#[test]
fn an_order_goes_from_stop_to_stop() {
    let mut pool = pool("- {name: a, stops: [{at: 3, action: pick, dwell: 5}, 7]}");
    assert_eq!(pool.assign(0.0, &candidates(&[8, 2]), &driving).assigned, [(OrderId(1), 2)]);
    assert_eq!(pool.current_stop(2).map(|stop| (stop.node, stop.dwell_secs)), Some((3, 5.0)));
    assert!(
        pool.handled(2, 1.0).is_none() && pool.arrived(8, 1.0).is_none(),
        "neither is at a stop"
    );
    assert!(pool.arrived(2, 10.0).is_some() && pool.arrived(2, 11.0).is_none());
    assert!(matches!(pool.handled(2, 15.0), Some(Next::Stop(Stop { node: 7, .. }))));
    assert_eq!(pool.withdraw(2, 15.0), Err(WithdrawError::Begun));
    assert!(pool.arrived(2, 60.0).is_some());
    assert_eq!((pool.handled(2, 61.0), pool.order_of(2)), (Some(Next::Done), None));
    let figures = pool.figures(3600.0);
    assert_eq!((figures.orders.finished, figures.orders_per_hour), (1, 1.0));
    let recent = |pool: &OrderPool, now| pool.figures(now).recent_orders_per_hour.map(f64::round);
    let rates = [59.9, 61.0, 600.0, 660.0, 661.0].map(|now| recent(&pool, now));
    let expected = [None, Some(59.0), Some(6.0), Some(6.0), Some(0.0)];
    assert_eq!(rates, expected, "an order in the last ten minutes, or none");
    pool.begin_rate(61.0);
    let rates = [120.0, 121.0].map(|now| recent(&pool, now));
    assert_eq!(rates, [None, Some(0.0)], "the order was finished in the warm-up");
    assert_eq!((figures.waiting.mean_secs, figures.service.mean_secs), (10.0, 61.0));
    let events: Vec<_> = pool.events().map(|event| event.change).collect();
    assert_eq!(events.len(), 9, "{events:?}");
    assert_eq!(
        events[3..5],
        [Change::Assigned { robot: 2 }, Change::Arrived { robot: 2, stop: 0, wait_secs: 0.0 }]
    );
}

#[test]
fn orders_wait_for_their_time() {
    let mut pool = pool("- {time: 50, earliest: 60, stops: [1]}\n- {time: 20, stops: [1]}");
    assert_eq!(pool.open_orders().count(), 0);
    pool.generate_until(55.0, 0);
    let states: Vec<_> = pool.open_orders().map(|order| order.state.name()).collect();
    assert_eq!(states, ["waiting", "created"]);
    pool.generate_until(60.0, 0);
    assert_eq!(pool.waiting.len(), 2);
}

#[test]
fn a_nearer_robot_takes_over_until_the_pick() {
    let mut pool = pool("- {stops: [5]}");
    assert_eq!(pool.assign(0.0, &candidates(&[0]), &driving).assigned, [(OrderId(1), 0)]);
    assert_eq!(
        pool.assign(1.0, &candidates(&[0, 4]), &driving),
        Assignments::default(),
        "not every tick"
    );
    let changes = pool.assign(5.0, &candidates(&[0, 4]), &driving);
    assert_eq!(
        (changes.withdrawn, changes.assigned),
        (vec![(OrderId(1), 0)], vec![(OrderId(1), 4)])
    );
    assert!(pool.arrived(4, 6.0).is_some());
    assert_eq!(pool.assign(11.0, &candidates(&[0, 4, 5]), &driving), Assignments::default());
}

#[test]
fn priority_and_age_are_worth_a_way() {
    let mut first = pool("- {stops: [1]}\n- {stops: [8], priority: 5}");
    assert_eq!(first.assign(0.0, &candidates(&[0]), &driving).assigned, [(OrderId(2), 0)]);
    let mut second = pool("- {stops: [8]}\n- {time: 600, stops: [1]}");
    second.generate_until(600.0, 0);
    assert_eq!(second.assign(600.0, &candidates(&[0]), &driving).assigned, [(OrderId(1), 0)]);
}

#[test]
fn unroutable_orders_come_back() {
    let mut pool = pool("- {name: a, stops: [1]}");
    assert!(
        pool.unroutable(OrderId(1), 1.0, Unroutable::ClosedEdges)
            && !pool.unroutable(OrderId(1), 1.0, Unroutable::ClosedEdges)
    );
    assert_eq!(pool.assign(2.0, &candidates(&[0]), &driving), Assignments::default());
    assert_eq!(
        pool.order(OrderId(1)).map(|order| &*order.reason),
        Some("closed roads lead to its stop")
    );
    assert!(pool.reopen(OrderId(1), 3.0) && !pool.reopen(OrderId(1), 3.0));
    assert_eq!(pool.assign(4.0, &candidates(&[0]), &driving).assigned.len(), 1);
}

#[test]
fn an_order_is_unroutable_or_not_begun() {
    let mut pool = pool("- {name: a, stops: [1]}\n- {name: b, stops: [1]}");
    assert!(pool.unroutable(OrderId(1), 1.0, Unroutable::ClosedEdges));
    let figures = pool.figures(60.0);
    assert_eq!((figures.unserved, figures.orders.unroutable), (1, 1));
}

#[derive(Clone, Debug)]
enum Step {
    Generate,
    Assign(Vec<u32>),
    Arrive(u32),
    Handle(u32),
    Fail(u32),
    Withdraw(u32),
    Cancel(u64, bool),
    Unroutable(u64),
    Reopen(u64),
}

fn step() -> impl Strategy<Value = Step> {
    let robot = || 0_u32..6;
    prop_oneof![
        Just(Step::Generate),
        prop::collection::vec(robot(), 0..6).prop_map(Step::Assign),
        robot().prop_map(Step::Arrive),
        robot().prop_map(Step::Handle),
        robot().prop_map(Step::Fail),
        robot().prop_map(Step::Withdraw),
        (1_u64..30, any::<bool>()).prop_map(|(number, immediate)| Step::Cancel(number, immediate)),
        (1_u64..30).prop_map(Step::Unroutable),
        (1_u64..30).prop_map(Step::Reopen),
    ]
}

fn perform(pool: &mut OrderPool, step: &Step, now: f64) {
    match step {
        Step::Generate => pool.generate_until(now, 6),
        Step::Assign(robots) => drop(pool.assign(now, &candidates(robots), &driving)),
        Step::Arrive(robot) => {
            let arrivals = [pool.arrived(*robot, now), pool.arrived(*robot, now)];
            assert!(arrivals[1].is_none(), "{arrivals:?}");
        }
        Step::Handle(robot) => {
            assert!(pool.handled(*robot, now).is_none() || pool.handled(*robot, now).is_none())
        }
        Step::Fail(robot) => assert_eq!(pool.order_of(*robot), pool.failed(*robot, now, "broken")),
        Step::Withdraw(robot) => {
            let withdrawn = pool.withdraw(*robot, now);
            assert_eq!(
                withdrawn.is_err(),
                pool.order_of(*robot).is_some() || withdrawn == Err(WithdrawError::Unknown)
            );
        }
        Step::Cancel(number, immediate) => {
            let Some(order) = pool.order(OrderId(*number)).cloned() else { return };
            let is_cancelled = pool.cancel(&order.content.name, *immediate, now).is_ok();
            assert_eq!(is_cancelled, *immediate || !order.is_bound());
        }
        Step::Unroutable(number) => {
            assert!(
                !pool.unroutable(OrderId(*number), now, Unroutable::ClosedEdges)
                    || !pool.waiting.contains(&OrderId(*number))
            )
        }
        Step::Reopen(number) => {
            assert!(!pool.reopen(OrderId(*number), now) || pool.waiting.contains(&OrderId(*number)))
        }
    }
}

/// Follows the events alone: who has which order, and which stops are handled.
#[derive(Default)]
struct Model {
    robots: BTreeMap<u32, OrderId>,
    handled: BTreeMap<OrderId, u32>,
    stops: BTreeMap<OrderId, u32>,
    over: BTreeSet<OrderId>,
}

impl Model {
    fn take(&mut self, event: &OrderEvent) {
        let id = event.id;
        assert!(!self.over.contains(&id), "{event:?} after the end");
        match &event.change {
            Change::Created { stops, .. } => assert_eq!(self.stops.insert(id, *stops), None),
            Change::Assigned { robot } => {
                assert_eq!(self.robots.insert(*robot, id), None, "one robot, one order");
                assert_eq!(
                    self.robots.values().filter(|other| **other == id).count(),
                    1,
                    "one order, one robot"
                );
            }
            Change::Withdrawn { robot } => {
                assert_eq!(self.robots.remove(robot), Some(id));
                assert_eq!(self.handled.get(&id), None, "begun orders stay");
            }
            Change::Handled { robot, stop } => {
                assert_eq!(self.robots.get(robot), Some(&id));
                assert_eq!(
                    self.handled.insert(id, *stop).map_or(0, |last| last + 1),
                    *stop,
                    "each stop once"
                );
            }
            Change::Finished { robot } => {
                assert_eq!(
                    self.handled.get(&id).map(|last| last + 1),
                    self.stops.get(&id).copied()
                );
                self.end(id, Some(*robot));
            }
            Change::Failed { robot, .. } | Change::Cancelled { robot, .. } => self.end(id, *robot),
            _ => {}
        }
    }

    fn end(&mut self, id: OrderId, robot: Option<u32>) {
        if let Some(robot) = robot {
            assert_eq!(self.robots.remove(&robot), Some(id));
        }
        self.over.insert(id);
    }
}

fn check(pool: &OrderPool, model: &Model) {
    let by_robot: BTreeMap<_, _> =
        pool.by_robot.iter().map(|(robot, held)| (*robot, held.id)).collect();
    assert_eq!(by_robot, model.robots);
    assert_eq!(pool.open.len() + model.over.len(), model.stops.len(), "no order is lost");
    for order in pool.open.values() {
        let held = Held { id: order.id, is_bound: order.is_bound() };
        let holds = order.state.robot().is_none_or(|robot| pool.held(robot) == Some(held));
        assert!(
            holds && !order.state.is_final() && order.handled_stops < order.content.stops.len(),
            "{order:?}"
        );
        assert_eq!(order.state == State::Waiting, pool.waiting.contains(&order.id));
        assert_eq!(pool.names.get(&order.content.name), Some(&order.id));
    }
    assert_eq!((pool.names.len(), pool.made_by.len() <= pool.open.len()), (pool.open.len(), true));
    for (index, source) in pool.sources.iter().enumerate() {
        let made: Vec<_> = pool.made_by.iter().filter(|(_, maker)| **maker == index).collect();
        let unroutable = made.iter().filter(|(id, _)| pool.open[id].state == State::Unroutable);
        assert_eq!((source.open, source.unroutable), (made.len(), unroutable.count()));
    }
    let figures = pool.figures(1e4).orders;
    let over = figures.finished + figures.failed + figures.cancelled;
    assert_eq!(over, model.over.len());
}

proptest! {
    #[test]
    fn no_order_is_lost_or_done_twice(steps in prop::collection::vec(step(), 1..300)) {
        let text = "load: {generators: [{per_hour: 600, deadline: 60}, {endless: 3}]}";
        let mut pool = OrderPool::new(places());
        pool.add_load(&Load::parse(text, &places()).expect("a load"));
        let mut model = Model::default();
        for (step, now) in steps.iter().zip(1..) {
            perform(&mut pool, step, f64::from(now));
            pool.events().for_each(|event| model.take(&event));
            check(&pool, &model);
        }
    }
}

#[test]
fn a_run_repeats_bit_by_bit() {
    let run = || {
        let mut pool = OrderPool::new(places());
        pool.add_load(&Load::parse("load: {endless: robots}", &places()).expect("a load"));
        let mut events = Vec::new();
        for tick in 0..500 {
            let now = f64::from(tick) * 0.5;
            pool.generate_until(now, 6);
            pool.assign(now, &candidates(&[0, 1, 2, 3, 4, 5]), &driving);
            (0..6).filter(|robot| (tick + robot) % 3 == 0).for_each(|robot| {
                pool.handled(robot, now);
                pool.arrived(robot, now);
            });
            events.extend(pool.events());
        }
        assert!(pool.figures(250.0).orders.finished > 300, "{:?}", pool.figures(250.0));
        events
    };
    assert_eq!(run(), run());
}

#[test]
fn an_endless_load_replaces_orders_that_cannot_be_carried_out() {
    let mut pool = pool("[]");
    pool.add_load(&Load::parse("load: {endless: 2}", &places()).expect("a load"));
    pool.generate_until(0.0, 2);
    assert_eq!(pool.open_orders().count(), 2);
    assert!(pool.unroutable(OrderId(1), 1.0, Unroutable::ClosedEdges));
    pool.generate_until(1.0, 2);
    assert_eq!(pool.open_orders().count(), 3);
}

/// Orders of a rate come in any case; an endless load makes feasible ones.
#[test]
fn an_endless_load_makes_feasible_orders_only() {
    let load = "load: {generators: [{name: a, endless: 40}, {name: b, per_hour: 3600}]}";
    let load = Load::parse(load, &places()).expect("a load");
    let stops = |pool: &OrderPool, name: &str| -> Vec<u32> {
        let orders = pool.open_orders().filter(|order| order.content.name.as_str().contains(name));
        orders.map(|order| order.content.stops[0].node).collect()
    };
    let mut pool = pool("[]");
    pool.add_load(&load);
    for _ in 0..3 {
        pool.generate_feasible_until(100.0, 2, &|_| false);
    }
    assert!(stops(&pool, ":a-").is_empty() && stops(&pool, ":b-").len() > 50);
    pool.generate_feasible_until(100.0, 2, &|order| order.stops[0].node % 2 == 0);
    assert_eq!(stops(&pool, ":a-").len(), 40);
    assert!(stops(&pool, ":a-").iter().all(|node| node % 2 == 0), "{:?}", stops(&pool, ":a-"));
    assert!(stops(&pool, ":a-").windows(2).any(|pair| pair[0] != pair[1]));
}

#[test]
fn what_is_for_one_robot_goes_to_no_other() {
    let mut pool = pool("- {name: a, robot: 8, stops: [3]}\n- {name: b, stops: [7]}");
    let nearest = pool.assign(0.0, &candidates(&[2, 6]), &driving);
    assert_eq!(
        nearest.assigned,
        [(OrderId(2), 6)],
        "robot 2 is the nearest to order a, which is for robot 8"
    );
    assert_eq!(pool.assign(1.0, &candidates(&[2, 8]), &driving).assigned, [(OrderId(1), 8)]);
    let anew = pool.assign(60.0, &candidates(&[2, 6, 8]), &driving);
    assert!(!anew.withdrawn.contains(&(OrderId(1), 8)), "nor is it given to another one: {anew:?}");
}

#[test]
fn a_robot_is_sent_at_once_or_after_the_order_that_it_has_begun() {
    let mut pool = pool("- {name: a, stops: [{at: 3, action: pick}, 7]}");
    pool.assign(0.0, &candidates(&[2]), &driving);
    let (sent, is_free) = pool.send(2, 9, 0xAB, 1.0);
    assert!(is_free && pool.order_of(2).is_none(), "order a was not begun");
    assert_eq!(
        pool.assign(1.0, &candidates(&[2, 5]), &driving).assigned,
        [(sent, 2), (OrderId(1), 5)]
    );
    assert!(pool.recall(2, 2.0) && !pool.recall(2, 2.0) && pool.order_of(2).is_none());
    assert!(pool.arrived(5, 3.0).is_some() && pool.handled(5, 3.0).is_some());
    let (later, is_free) = pool.send(5, 9, 0xAB, 4.0);
    assert!(!is_free && pool.order_of(5) == Some(OrderId(1)));
    assert!(pool.assign(60.0, &candidates(&[5]), &driving).assigned.is_empty());
    assert!(pool.arrived(5, 61.0).is_some() && pool.handled(5, 61.0) == Some(Next::Done));
    let (replaced, is_free) = pool.send(5, 1, 0xAB, 61.0);
    assert!(
        is_free && replaced != later && pool.order(later).is_none(),
        "a request replaces the one before"
    );
    assert_eq!(pool.assign(61.0, &candidates(&[5]), &driving).assigned, [(replaced, 5)]);
}
