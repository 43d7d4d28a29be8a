use proptest::prelude::*;

use super::*;

fn orders(urgencies: &[f64]) -> Vec<OpenOrder> {
    let id = |(number, urgency): (u32, &f64)| OpenOrder {
        id: OrderId(u64::from(number) + 1),
        node: number,
        position: Vec2::X * number as f32,
        urgency_secs: *urgency,
        robot: None,
    };
    (0..).zip(urgencies).map(id).collect()
}

/// Robots of the types 0 and 1 in turn.
fn robots(count: u32) -> Vec<Candidate> {
    let robot =
        |robot| Candidate { robot, robot_type: robot % 2, position: Vec2::X * robot as f32 };
    (0..count).map(robot).collect()
}

/// Returns a problem whose orders any robot may get.
fn problem<'call>(
    orders: &'call [OpenOrder],
    robots: &'call [Candidate],
    driving_secs: &'call dyn Fn(u32, u32) -> Option<f64>,
) -> Problem<'call> {
    static NONE: Limits = Limits::new();
    Problem { now_secs: 0.0, orders, robots, limits: &NONE, driving_secs }
}

/// Returns the number of possible pairs and their cost in milliseconds, of the best choice there is
/// for the orders from `at` on.
fn best(costs: &[Vec<Option<i64>>], at: usize, busy: &mut Vec<bool>) -> (i64, i64) {
    if at == costs.len() {
        return (0, 0);
    }
    let mut found = best(costs, at + 1, busy);
    for robot in 0..busy.len() {
        if let (Some(cost), false) = (costs[at][robot], busy[robot]) {
            busy[robot] = true;
            let (negative_pairs, total) = best(costs, at + 1, busy);
            found = found.min((negative_pairs - 1, total + cost));
            busy[robot] = false;
        }
    }
    found
}

proptest! {
    #[test]
    fn small_problems_are_solved_as_by_brute_force(
        driving in prop::collection::vec(prop::option::weighted(0.8, 0_i64..100), 25),
        urgencies in prop::collection::vec(0_i64..300, 0..5),
        count in 0_u32..5,
    ) {
        let orders = orders(&urgencies.iter().map(|urgency| *urgency as f64).collect::<Vec<_>>());
        let robots = robots(count);
        let secs = |robot: u32, node: u32| driving[(robot * 5 + node) as usize].map(|secs| secs as f64);
        let problem = problem(&orders, &robots, &secs);
        let pairs = Nearest::default().assign(&problem);
        let cost = |id: usize, robot: u32| secs(robot, id as u32).map(|secs| secs as i64 - urgencies[id]);
        let costs: Vec<Vec<_>> = (0..orders.len()).map(|id| (0..count).map(|robot| cost(id, robot)).collect()).collect();
        let total: i64 = pairs.iter().map(|(id, robot)| cost(id.0 as usize - 1, *robot).expect("a way")).sum();
        prop_assert_eq!((-(pairs.len() as i64), total), best(&costs, 0, &mut vec![false; count as usize]));
        prop_assert_eq!(allowed(&problem, pairs.clone()).len(), pairs.len());
    }

    #[test]
    fn greedy_pairs_are_valid_and_leave_no_robot_without_need(
        count in 0_u32..40, urgencies in prop::collection::vec(0.0..100.0, 0..40),
    ) {
        let (orders, robots) = (orders(&urgencies), robots(count));
        let secs = |robot: u32, node: u32| Some(f64::from(robot.abs_diff(node)));
        let problem = problem(&orders, &robots, &secs);
        let pairs = Nearest { exact_up_to: 0, nearest_robots: 100, ..Nearest::default() }.assign(&problem);
        prop_assert_eq!(allowed(&problem, pairs.clone()).len(), pairs.len());
        prop_assert_eq!(pairs.len(), orders.len().min(count as usize));
    }
}

#[test]
fn an_order_changes_its_robot_only_if_that_is_worth_it() {
    let mut orders = orders(&[0.0]);
    orders[0].robot = Some(0);
    let robots = robots(2);
    for (other_secs, robot) in [(25.0, 0), (15.0, 1)] {
        let secs = |robot: u32, _| Some(if robot == 0 { 30.0 } else { other_secs });
        let problem = problem(&orders, &robots, &secs);
        for mut assigner in [Nearest::default(), Nearest { exact_up_to: 0, ..Nearest::default() }] {
            assert_eq!(
                assigner.assign(&problem),
                [(OrderId(1), robot)],
                "{other_secs} {assigner:?}"
            );
        }
    }
}

#[test]
fn the_oldest_orders_are_first_when_there_are_too_many() {
    let orders = orders(&(0..1000).map(|age| f64::from(age) * 10.0).collect::<Vec<_>>());
    let secs = |_, node: u32| Some(f64::from(node % 7));
    let robots = robots(1);
    let problem = problem(&orders, &robots, &secs);
    assert_eq!(Nearest::default().assign(&problem), [(OrderId(1000), 0)]);
}

#[test]
fn wrong_pairs_of_an_assigner_are_ignored() {
    let (orders, robots) = (orders(&[0.0, 0.0]), robots(2));
    let secs = |_, _| Some(1.0);
    let problem = problem(&orders, &robots, &secs);
    let pairs =
        vec![(OrderId(1), 7), (OrderId(9), 0), (OrderId(1), 1), (OrderId(1), 0), (OrderId(2), 1)];
    assert_eq!(allowed(&problem, pairs), BTreeMap::from([(OrderId(1), 1)]));
}

#[test]
fn robots_keep_their_orders_in_a_problem_that_is_too_large_to_be_solved_at_once() {
    let count = 2_000;
    let mut orders = orders(&vec![0.0; count as usize]);
    orders.iter_mut().zip(0..).skip(1).for_each(|(id, robot)| id.robot = Some(robot));
    let secs = |robot: u32, node: u32| Some(f64::from(robot.abs_diff(node)));
    let robots = robots(count);
    let problem = problem(&orders, &robots, &secs);
    let pairs = allowed(&problem, Nearest::default().assign(&problem));
    assert!(pairs.iter().all(|(id, robot)| id.0 == u64::from(*robot) + 1), "{pairs:?}");
    assert_eq!(pairs.len(), count as usize);
}

#[test]
fn in_turn_nobody_loses_an_order_and_the_waiting_ones_are_given_by_number() {
    let mut orders = orders(&[0.0; 3]);
    orders[1].robot = Some(0);
    let anywhere = |_: u32, _: u32| Some(1.0);
    let robots = robots(3);
    let problem = problem(&orders, &robots, &anywhere);
    let pairs = InTurn.assign(&problem);
    assert_eq!(pairs, [(OrderId(2), 0), (OrderId(1), 1), (OrderId(3), 2)]);
    let not_robot_1 = |robot: u32, _: u32| (robot != 1).then_some(1.0);
    let pairs = InTurn.assign(&Problem { driving_secs: &not_robot_1, ..problem });
    assert_eq!(pairs, [(OrderId(2), 0), (OrderId(1), 2)], "robot 1 can't drive there");
}

#[test]
fn orders_go_to_robots_of_their_types_alone() {
    let orders = orders(&[0.0; 3]);
    let robots = robots(4);
    let secs = |robot: u32, node: u32| Some(f64::from(robot.abs_diff(node)));
    // The robots 0 and 2 are of type 0, 1 and 3 of type 1. Each order is nearest to its own number.
    let limits = Limits::from([(OrderId(1), vec![1]), (OrderId(3), vec![1])]);
    let problem = Problem { limits: &limits, ..problem(&orders, &robots, &secs) };
    let pairs = allowed(&problem, Nearest::default().assign(&problem));
    // Order 2 is nearest to robot 1, which order 1 or order 3 needs.
    assert_eq!((pairs[&OrderId(1)], pairs[&OrderId(2)] % 2, pairs[&OrderId(3)]), (1, 0, 3));
    let mut greedy = Nearest { exact_up_to: 0, ..Nearest::default() };
    let pairs = greedy.assign(&problem);
    assert_eq!(pairs, [(OrderId(2), 1), (OrderId(3), 3)], "only robots 1 and 3 could get order 1");
    assert_eq!(InTurn.assign(&problem), [(OrderId(1), 1), (OrderId(2), 0), (OrderId(3), 3)]);
    assert_eq!(allowed(&problem, vec![(OrderId(1), 0)]), BTreeMap::new(), "of the wrong type");
}

#[test]
fn urgent_orders_for_others_hide_none_from_a_robot() {
    // A thousand urgent orders are for type 1, whose only robot is busy elsewhere.
    let mut urgencies = vec![500.0; 1000];
    urgencies.push(0.0);
    let orders = orders(&urgencies);
    let limits = (1..=1000).map(|number| (OrderId(number), vec![1])).collect();
    let robots = robots(1);
    let secs = |_, _| Some(1.0);
    let problem = Problem { limits: &limits, ..problem(&orders, &robots, &secs) };
    assert_eq!(Nearest::default().assign(&problem), [(OrderId(1001), 0)]);
}
