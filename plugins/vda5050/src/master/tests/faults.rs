//! Vehicles in trouble: others keep away from them until they can be steered again.

use regatta_plugin::order::StopAction;

use super::*;
use crate::master::post::Post;
use crate::message::{Connection, ConnectionState, Header};

fn connection(trial: &mut Trial, connection_state: ConnectionState) {
    let message = Connection { header: Header::default(), connection_state };
    trial.vehicle.take_connection(&message, trial.now);
    trial.wait(0.0);
}

#[test]
fn a_vehicle_that_is_gone_keeps_its_place_and_goes_on_with_its_order() {
    let mut trial = Trial::new(4);
    trial.route(&[11, 12], 0).release(11);
    let order = trial.order();
    trial.take(&order).tell(json!({"driving": true, "agvPosition": Trial::at(2.0)}));
    trial.events();
    connection(&mut trial, ConnectionState::ConnectionBroken);
    assert_eq!((trial.shown(), trial.place()), (RobotState::Broken, (0, 2.0)));
    assert_eq!((trial.vehicle.loose_at(), trial.events()), (None, vec![EventKind::BrokenDown]));
    assert_eq!(trial.release(12).say(), None, "nobody is there to be told");
    let lines = trial.vehicle.take_lines();
    assert_eq!(lines, ["its connection is broken; its path is kept free"]);

    trial.tell(json!({"lastNodeId": "N2", "lastNodeSequenceId": 2, "agvPosition": Trial::at(7.0)}));
    assert_eq!((trial.shown(), trial.place()), (RobotState::Driving, (1, 2.0)));
    assert!(trial.events().contains(&EventKind::Repaired));
    let update = trial.order();
    assert_eq!((&update.order_id, update.order_update_id), (&order.order_id, 1));
}

#[test]
fn a_vehicle_that_lost_its_order_gets_the_rest_again() {
    let mut trial = Trial::new(4);
    trial.route(&[11, 12], 0).release(11);
    let order = trial.order();
    trial.take(&order).tell(json!({"lastNodeId": "N2", "lastNodeSequenceId": 2,
        "agvPosition": Trial::at(5.0)}));
    // It was restarted.
    trial.tell(json!({"orderId": "", "orderUpdateId": 0, "lastNodeSequenceId": 0,
        "nodeStates": []}));
    let again = trial.order();
    assert_ne!(again.order_id, order.order_id);
    assert_eq!(nodes(&again), [("N2", 0, true), ("N3", 2, true), ("N4", 4, false)]);
    assert_eq!(trial.shown(), RobotState::Driving);
}

#[test]
fn a_rejected_order_is_told_and_tried_again_later() {
    let mut trial = Trial::new(4);
    trial.route(&[11], 0).release(10);
    let order = trial.order();
    let error = json!([{"errorType": "orderError", "errorLevel": "WARNING",
        "errorDescription": "too far", "errorReferences":
            [{"referenceKey": "orderId", "referenceValue": order.order_id}]}]);
    trial.tell(json!({"errors": error}));
    assert_eq!((trial.shown(), trial.say()), (RobotState::Broken, None));
    let lines = trial.vehicle.take_lines();
    assert_eq!(lines, ["it rejects its order: orderError: too far; its path is kept free"]);
    trial.wait(10.0);
    let again = trial.order();
    assert!(again.order_id != order.order_id && nodes(&again) == nodes(&order));
    trial.tell(json!({"errors": []})).take(&again);
    assert_eq!(trial.shown(), RobotState::Driving);
}

#[test]
fn an_error_about_an_instant_action_rejects_no_order() {
    let mut trial = Trial::new(4);
    trial.route(&[11], 0).release(10);
    let order = trial.order();
    let error = json!([{"errorType": "validationError", "errorLevel": "WARNING", "errorReferences":
        [{"referenceKey": "topic", "referenceValue": "instantActions"}]}]);
    trial.tell(json!({"errors": error}));
    assert_eq!(trial.shown(), RobotState::Driving);
    trial.take(&order);
    assert_eq!((trial.shown(), trial.vehicle.take_lines()), (RobotState::Driving, Vec::new()));
}

#[test]
fn the_spelling_of_instant_actions_is_learned_from_errors_of_2_0() {
    let error = |topic: &str| {
        let state = json!({"errorType": "validationError", "errorLevel": "WARNING",
            "errorReferences": [{"referenceKey": "topic", "referenceValue": topic}]});
        [serde_json::from_value(state).expect("an error")]
    };
    let mut post = Post::new("uagv/v2/KIT/1").expect("a version");
    assert!(!post.learn_spelling(&error("order")) && post.learn_spelling(&error("instantActions")));
    assert!(!post.learn_spelling(&error("instantActions")), "it is known");
    let mut third = Post::new("vda5050/v3/KIT/1").expect("a version");
    assert!(!third.learn_spelling(&error("instantActions")));
    assert!(Post::new("uagv/v1/KIT/1").is_none(), "1.1 isn't spoken");
}

#[test]
fn an_action_of_a_rejected_order_gets_another_id() {
    let mut trial = Trial::new(2);
    trial.vehicle.handle(StopAction::Pick, |_| Vec::new());
    let order = trial.order();
    let error = json!([{"errorType": "orderError", "errorLevel": "WARNING", "errorReferences":
        [{"referenceKey": "orderId", "referenceValue": order.order_id}]}]);
    trial.tell(json!({"errors": error})).wait(10.0);
    let again = trial.order();
    let id = |order: &Order| order.nodes[0].actions[0].action_id.clone();
    assert_ne!(id(&again), id(&order));
}

#[test]
fn others_keep_away_from_a_vehicle_that_a_person_drives_until_it_is_given_back() {
    let mut trial = Trial::new(4);
    trial.route(&[11, 12], 0).release(11);
    let order = trial.order();
    trial.take(&order);
    trial.tell(json!({"operatingMode": "MANUAL", "orderId": "", "nodeStates": [],
        "agvPosition": Trial::at(12.0)}));
    assert_eq!((trial.shown(), trial.say()), (RobotState::Broken, None));
    assert_eq!(trial.vehicle.loose_at(), Some([112.0, 200.0]));
    assert_eq!(trial.place(), (0, 0.0), "what it had stays its own");

    trial.tell(json!({"operatingMode": "AUTOMATIC"}));
    assert_eq!((trial.shown(), trial.vehicle.loose_at()), (RobotState::Idle, None));
    let (edge, s) = trial.place();
    assert!(edge == 2 && (s - 2.0).abs() < 1e-6, "it is where it stands: {edge} {s}");
    // An order begins at the last node, within the distance to it.
    trial.release(12);
    let next = trial.order();
    assert_eq!(nodes(&next), [("N3", 0, true), ("N4", 2, true)]);
    let position = next.nodes[0].node_position.as_ref().expect("a position");
    let is_within = position.allowed_deviation.is_some_and(|it| it.contains(2.0, 0.0));
    assert!(is_within, "{position:?}");
}

/// A vehicle that a person drove along its way isn't off it, and its next order begins elsewhere
/// all the same.
#[test]
fn a_vehicle_that_a_person_drove_along_its_base_continues_from_there() {
    for (node, metres, edge) in [("N3", 10.0, 1), ("N4", 15.0, 2)] {
        let mut trial = Trial::new(6);
        trial.route(&[11, 12, 13], 0).release(13);
        let order = trial.order();
        trial.take(&order);
        let place = json!({"lastNodeId": "N2", "lastNodeSequenceId": 2,
            "agvPosition": Trial::at(5.0)});
        trial.tell(place);
        trial.tell(json!({"operatingMode": "MANUAL", "orderId": "", "lastNodeSequenceId": 0,
            "nodeStates": []}));
        assert_eq!(trial.place(), (0, 5.0), "it has its place until it is given back");
        trial.tell(json!({"lastNodeId": node, "agvPosition": Trial::at(metres)}));
        trial.tell(json!({"operatingMode": "AUTOMATIC"}));
        assert_eq!((trial.place(), trial.vehicle.loose_at()), ((edge, 5.0), None));
        let next = trial.route(&[edge + 11], 1).order();
        let ids: Vec<_> = next.nodes.iter().map(|node| node.node_id.as_str()).collect();
        assert_eq!(ids[0], node, "{ids:?}");
    }
}

#[test]
fn a_vehicle_that_was_to_stop_when_a_person_took_it_is_given_back() {
    // Its order is gone, or it still has it.
    for rest in [json!([]), json!([{"nodeId": "N2", "sequenceId": 2, "released": true}])] {
        let mut trial = Trial::new(4);
        trial.route(&[11, 12], 0).release(11);
        let order = trial.order();
        trial.take(&order);
        trial.tell(json!({"operatingMode": "MANUAL", "nodeStates": rest,
            "agvPosition": Trial::at(12.0)}));
        // The edges around it are closed, so the manager stops it.
        let roads = Roads::of(&line(4).0.view(1, 1), "map");
        trial.vehicle.cancel(&roads);
        trial.tell(json!({"operatingMode": "AUTOMATIC"}));
        assert_eq!((trial.place().0, trial.vehicle.loose_at()), (2, None));
        if rest != json!([]) {
            assert_eq!(trial.instant().0, "cancelOrder", "the order leads elsewhere");
        }
        trial.tell(json!({"orderId": "", "nodeStates": [], "driving": false}));
        assert_eq!(trial.shown(), RobotState::Idle);
    }
}

#[test]
fn a_vehicle_at_an_unknown_place_is_kept_away_from_until_it_has_one() {
    let mut trial = Trial::new(3);
    let away = json!({"x": 104.0, "y": 203.0, "theta": 0.0, "mapId": "map",
        "positionInitialized": true});
    let mut newcomer = Trial { vehicle: Vehicle::new("run-1".to_owned()), ..trial };
    newcomer.tell(json!({"lastNodeId": "", "agvPosition": away}));
    assert_eq!(newcomer.row().place, None);
    assert_eq!(
        (newcomer.shown(), newcomer.vehicle.loose_at()),
        (RobotState::Broken, Some([104.0, 203.0]))
    );
    newcomer.tell(json!({"lastNodeId": "N2", "agvPosition": Trial::at(5.0)}));
    assert_eq!((newcomer.place(), newcomer.shown()), ((0, 5.0), RobotState::Idle));
    trial = newcomer;
    assert_eq!(trial.vehicle.loose_at(), None);
}

#[test]
fn deviation_errors_and_emergency_stops_are_troubles() {
    let astray = json!({"x": 102.0, "y": 201.0, "theta": 0.0, "mapId": "map",
        "positionInitialized": true});
    let unlocalized = json!({"x": 100.0, "y": 200.0, "theta": 0.0, "mapId": "map",
        "positionInitialized": false});
    let fatal = json!([{"errorType": "motor", "errorLevel": "FATAL"}]);
    let stop = json!({"eStop": "MANUAL", "fieldViolation": false});
    for (changes, is_loose, text) in [
        (json!({"agvPosition": astray, "driving": true}), true, "1.0 m off its path"),
        (json!({"agvPosition": unlocalized}), true, "doesn't know its position"),
        (json!({"errors": fatal}), false, "error: motor"),
        (json!({"safetyState": stop}), false, "emergency stop"),
        (json!({"operatingMode": "SERVICE"}), true, "mode is Service"),
    ] {
        let mut trial = Trial::new(3);
        trial.tell(changes);
        assert_eq!(trial.shown(), RobotState::Broken, "{text}");
        assert_eq!(trial.vehicle.loose_at().is_some(), is_loose, "{text}");
        let lines = trial.vehicle.take_lines();
        assert!(lines.len() == 1 && lines[0].contains(text), "{lines:?}");
    }
    let mut silent = Trial::new(3);
    assert_eq!(silent.wait(40.0).shown(), RobotState::Broken);
    assert_eq!(
        silent.vehicle.take_lines(),
        ["it has sent nothing for 40 s; its path is kept free"]
    );
}
