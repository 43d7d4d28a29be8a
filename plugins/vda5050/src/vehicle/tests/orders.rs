//! Orders and updates (2.x: 6.6.1, 6.6.2; 3.0: 6.1.1, 6.1.2).

use super::*;

#[test]
fn an_order_is_driven_to_its_end() {
    for version in Version::ALL {
        let mut trial = Trial::new(version);
        assert_eq!(trial.state().last_node_id, "A");
        trial.order(&order("o", 0, 0, "A B C"));
        assert_eq!((trial.ahead(), trial.last_legs()), ("B C".to_owned(), vec![1, 3]));
        assert!(!trial.vehicle.is_idle());
        trial.drive();
        assert!(trial.state().driving);
        trial.pass("B");
        assert_eq!((trial.ahead(), trial.state().last_node_sequence_id), ("C".to_owned(), 2));
        trial.reach("C");
        let state = trial.state();
        assert_eq!((state.last_node_id.as_str(), state.order_id.as_str()), ("C", "o"));
        assert!(trial.vehicle.is_idle() && state.edge_states.is_empty() && !state.driving);
        trial.order(&order("next", 0, 0, "C D"));
        assert_eq!((trial.errors(), trial.last_legs()), (vec![], vec![5]));
    }
}

#[test]
fn a_vehicle_stops_at_the_end_of_its_base_and_asks_for_more() {
    let mut trial = Trial::new(Version::V2_0);
    trial.order(&order("o", 0, 0, "A B | C D"));
    assert_eq!((trial.ahead(), trial.last_legs()), ("B (C) (D)".to_owned(), vec![1, -3, -5]));
    assert_eq!(trial.state().new_base_request, Some(false));
    trial.reach("B");
    assert_eq!(trial.state().new_base_request, Some(true));
    assert!(!trial.vehicle.is_idle(), "it waits for an update");
}

#[test]
fn an_update_begins_at_the_decision_point_and_takes_the_place_of_the_horizon() {
    let mut trial = Trial::new(Version::V2_1);
    trial.order(&order("o", 0, 0, "A B:x,pick,NONE | C:y,drop,NONE"));
    trial.drive();
    trial.order(&order("o", 1, 2, "B:x,pick,NONE A"));
    assert_eq!((trial.ahead(), trial.last_legs()), ("B A".to_owned(), vec![2]));
    assert_eq!((trial.status("x").as_str(), trial.status("y").as_str()), ("Waiting", "none"));
    trial.reach("B");
    assert_eq!(trial.status("x"), "Running");
    trial.reach("A");
    trial.wait(10.0);
    assert!(trial.vehicle.is_idle());
    // The order is complete: an update may follow (figure 8, 8 and 10).
    trial.order(&order("o", 2, 4, "A B"));
    assert_eq!((trial.errors(), trial.ahead()), (vec![], "B".to_owned()));
}

#[test]
fn an_update_may_add_actions_at_the_node_where_the_vehicle_stands() {
    let mut trial = Trial::new(Version::V3_0);
    trial.order(&order("o", 0, 0, "A B"));
    trial.reach("B");
    trial.order(&order("o", 1, 2, "B B:late,pick,HARD C"));
    assert_eq!((trial.status("late").as_str(), trial.ahead().as_str()), ("Running", "C"));
    assert_eq!(trial.last_legs(), [1], "it stands until the action has ended");
    trial.wait(10.0);
    assert_eq!((trial.status("late").as_str(), trial.last_legs()), ("Finished", vec![3]));
}

#[test]
fn an_edge_is_driven_in_reverse_gear_where_the_layout_lets_it() {
    let mut trial = Trial::new(Version::V2_0);
    trial.order(&order("o", 0, 0, "A B C D C"));
    assert_eq!(trial.last_legs(), [1, 3, 5, 5]);
    let Some(Command::Extend(legs)) = trial.commands.last() else { panic!("a route") };
    assert_eq!(legs.iter().map(|leg| leg.reverse).collect::<Vec<_>>(), [false, false, false, true]);
}

#[test]
fn the_first_node_may_be_one_that_only_its_deviation_makes_the_place() {
    // After a cancel (2.x: 6.6.3.1; 3.0: 6.1.3.1): the last node with a large deviation, or a node
    // made up for the place.
    let mut trial = Trial::new(Version::V2_0);
    trial.order(&order("o", 0, 0, "A B"));
    trial.reach("B");
    let mut large = order("large", 0, 0, "A B C");
    large["nodes"][0]["nodePosition"] =
        json!({"x": 0, "y": 0, "mapId": "map", "allowedDeviationXY": 10.5});
    trial.order(&large);
    assert_eq!((trial.errors(), trial.ahead(), trial.last_legs()), (vec![], "C".into(), vec![3]));
    trial.reach("C");
    let mut made_up = order("made-up", 0, 0, "here D");
    made_up["nodes"][0]["nodePosition"] = json!({"x": 20.05, "y": 0, "mapId": "map"});
    made_up["edges"][0]["edgeId"] = json!("CD");
    trial.order(&made_up);
    assert_eq!((trial.errors(), trial.last_legs()), (vec![], vec![5]));
}

#[test]
fn a_robot_that_stands_within_an_edge_is_brought_to_a_node_first() {
    let (site, mut vehicle) = (site(), Vehicle::new(Version::V2_0));
    let seen = Seen {
        time: 0.0,
        x: 4.0,
        y: 0.0,
        theta: 0.0,
        speed: 0.0,
        s: 4.0,
        edge: Some(0),
        state: RobotState::Idle,
        charge: Some(50.0),
    };
    vehicle.see(seen, &site);
    assert!(
        matches!(vehicle.take_outbox().commands[..], [Command::FinishEdge(leg)] if leg.edge == 2)
    );
    vehicle.see(Seen { s: 9.0, x: 9.0, speed: 1.0, state: RobotState::Driving, ..seen }, &site);
    vehicle.see(Seen { s: 10.0, x: 10.0, ..seen }, &site);
    let state = vehicle.state(Header::default(), &site);
    assert_eq!((state.last_node_id.as_str(), state.power_supply.state_of_charge), ("B", 50.0));
}

#[test]
fn a_heading_of_half_a_turn_is_within_the_bounds_of_the_schemas() {
    // π in 32 bits is more than the schemas' 3.14159265359.
    for theta in [std::f32::consts::PI, -std::f32::consts::PI] {
        let mut trial = Trial::new(Version::V2_0);
        let seen = trial.vehicle.seen.expect("seen");
        trial.vehicle.see(Seen { theta: theta.into(), ..seen }, &trial.site);
        let position = trial.state().mobile_robot_position.expect("a position");
        let (theta, most) = (position.theta.abs(), std::f64::consts::PI);
        assert!((most - 1e-5..=most).contains(&theta), "{theta}");
    }
}
