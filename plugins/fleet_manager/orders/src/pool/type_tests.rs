//! Orders for robot types.

use super::*;
use crate::file::parse_yaml;
use crate::load::Load;
use crate::places::Place;

/// Nodes of which each robot drives as many seconds as its number differs from theirs.
fn places() -> Arc<Places> {
    let places = Places::new((0..4).map(|id| Place { id, ..Place::default() }).collect());
    Arc::new(places.with_robot_types(["amr", "forklift"].map(str::to_owned).to_vec()))
}

fn driving(robot: u32, node: u32) -> Option<f64> {
    Some(f64::from(robot.abs_diff(node)))
}

/// Robots of which those with odd numbers are forklifts.
fn candidates(robots: &[u32]) -> Vec<Candidate> {
    let candidate =
        |robot: &u32| Candidate { robot: *robot, robot_type: *robot % 2, ..Candidate::default() };
    robots.iter().map(candidate).collect()
}

#[test]
fn an_order_waits_for_a_robot_of_its_type() {
    let mut pool = OrderPool::new(places());
    let orders = parse_yaml("- {name: a, stops: [1], robot_types: forklift}").expect("orders");
    pool.add_orders(&orders).expect("valid orders");
    pool.generate_until(0.0, 2);
    // The robots 0 and 2 are no forklifts, and nearer.
    assert_eq!(pool.assign(0.0, &candidates(&[0, 2]), &driving), Assignments::default());
    let changes = pool.assign(10.0, &candidates(&[0, 2, 7]), &driving);
    assert_eq!(changes.assigned, [(OrderId(1), 7)]);
}

#[test]
fn an_endless_load_for_a_type_has_as_many_orders_as_robots_of_it() {
    let places = places();
    let text = "generators:\n- {name: lifts, endless: robots, robot_types: [forklift]}\n\
                - {name: all, endless: robots}\n";
    let mut pool = OrderPool::new(places.clone());
    pool.add_load(&Load::parse(text, &places).expect("a load"));
    pool.set_fleet(vec![3, 2]);
    pool.generate_until(0.0, 5);
    let open = |name: &str| {
        pool.open_orders().filter(|order| order.content.name.as_str().contains(name)).count()
    };
    assert_eq!((open("lifts"), open("all")), (2, 5));
    let error = Load::parse("{endless: robots, robot_types: lift}", &places).expect_err("unknown");
    let error = error.to_string();
    assert!(error.ends_with("no robot type has the name `lift`; there are: amr, forklift"));
}
