//! Messages to a vehicle: orders, updates, actions.

use regatta_plugin::event::BASE_WANTED;
use regatta_plugin::order::StopAction;

use super::*;
use crate::master::options::Parameter;

#[test]
fn a_base_grows_by_updates_each_after_the_one_before_was_taken() {
    let mut trial = Trial::new(5);
    assert_eq!((trial.shown(), trial.say()), (RobotState::Idle, None));
    trial.route(&[11, 12, 13], 0).release(10);
    let order = trial.order();
    assert_eq!(order.order_update_id, 0);
    assert_eq!(
        nodes(&order),
        [("N1", 0, true), ("N2", 2, true), ("N3", 4, false), ("N4", 6, false), ("N5", 8, false)]
    );
    assert_eq!(order.edges[0].start_node_id.as_deref(), Some("N1"));
    trial.release(11);
    assert_eq!(trial.say(), None, "the vehicle hasn't taken the order yet");
    trial.take(&order);
    let update = trial.order();
    assert_eq!((&update.order_id, update.order_update_id), (&order.order_id, 1));
    assert_eq!(nodes(&update)[..2], [("N2", 2, true), ("N3", 4, true)]);
    trial.take(&update).tell(json!({"lastNodeSequenceId": 0, "driving": true}));
    assert_eq!(trial.say(), None, "there is nothing new to tell");
}

#[test]
fn a_message_without_an_answer_is_sent_again_as_it_was() {
    let mut trial = Trial::new(4);
    trial.route(&[11], 0).release(10);
    let order = trial.order();
    assert_eq!(trial.wait(1.0).say(), None);
    for _ in 0..3 {
        assert_eq!(trial.wait(2.0).order(), order);
        assert_eq!(trial.shown(), RobotState::Driving);
    }
    assert_eq!(trial.wait(2.0).shown(), RobotState::Broken, "it doesn't answer");
    trial.take(&order);
    assert_eq!(trial.shown(), RobotState::Driving);
}

#[test]
fn a_robot_follows_its_vehicle_and_the_next_order_begins_where_the_last_one_ended() {
    let mut trial = Trial::new(4);
    trial.route(&[11, 12], 0).release(11);
    let order = trial.order();
    let horizon = json!([{"nodeId": "N4", "sequenceId": 6, "released": false}]);
    trial.take(&order).tell(json!({"driving": true, "agvPosition": Trial::at(2.0)}));
    assert_eq!((trial.place(), trial.shown()), ((0, 2.0), RobotState::Driving));
    trial.tell(json!({"lastNodeId": "N2", "lastNodeSequenceId": 2, "agvPosition": Trial::at(6.0)}));
    let (edge, s) = trial.place();
    assert!(edge == 1 && (s - 1.0).abs() < 1e-6, "{edge} {s}");
    trial.tell(json!({"lastNodeId": "N3", "lastNodeSequenceId": 4, "driving": false,
        "nodeStates": horizon, "agvPosition": Trial::at(10.0)}));
    assert_eq!((trial.place(), trial.shown()), ((1, 5.0), RobotState::Waiting));
    assert!(trial.events().contains(&EventKind::ReachedNode));

    // The horizon is taken back by an update of one node; then the order is done.
    trial.vehicle.course_mut().expect("a course").drop_horizon();
    let update = trial.order();
    assert_eq!((nodes(&update), update.order_update_id), (vec![("N3", 4, true)], 1));
    trial.take(&update);
    assert_eq!(trial.shown(), RobotState::Idle);
    trial.route(&[12], 1);
    let next = trial.order();
    assert_eq!((nodes(&next)[0], next.order_update_id), (("N3", 0, true), 0));
    assert_ne!(next.order_id, order.order_id);
}

#[test]
fn a_stop_is_handled_before_the_vehicle_drives_on() {
    let mut trial = Trial::new(4);
    trial.vehicle.handle(StopAction::Pick, |_| Vec::new());
    assert_eq!(trial.shown(), RobotState::Stalled);
    trial.route(&[11], 0).release(10);
    let order = trial.order();
    let action = &order.nodes[0].actions[0];
    let first = ("N1", 0, true);
    assert_eq!((nodes(&order)[0], action.action_type.as_str()), (first, "pick"));
    assert!(!order.nodes[1].released, "it stands until then");
    let state = |status: &str| json!([{"actionId": action.action_id, "actionStatus": status}]);
    trial.take(&order).tell(json!({"actionStates": state("RUNNING")}));
    assert_eq!(trial.shown(), RobotState::Stalled);
    // The manager may release more: it follows the action.
    let update = trial.order();
    assert_eq!((&update.order_id, update.order_update_id), (&order.order_id, 1));
    assert_eq!(nodes(&update)[..2], [("N1", 0, true), ("N2", 2, true)]);
    trial.take(&update).tell(json!({"actionStates": state("FINISHED")}));
    assert_eq!(trial.shown(), RobotState::Driving);
}

#[test]
fn a_failed_action_is_told() {
    let mut trial = Trial::new(2);
    trial.vehicle.handle(StopAction::Drop, |_| Vec::new());
    let order = trial.order();
    let failed = json!([{"actionId": order.nodes[0].actions[0].action_id, "actionStatus": "FAILED",
        "resultDescription": "nothing to drop"}]);
    trial.take(&order).tell(json!({"actionStates": failed}));
    assert_eq!(trial.vehicle.take_lines(), ["its action drop has failed: nothing to drop"]);
    assert_eq!(trial.shown(), RobotState::Idle);
    let events = trial.vehicle.take_events();
    let failed = events.iter().find(|event| event.kind() == Some(EventKind::ActionFailed));
    assert_eq!(failed.map(|event| event.id), Some(1), "the id of N1: {events:?}");
}

#[test]
fn a_vehicle_works_again_when_the_load_of_its_failed_order_is_gone() {
    for is_unloaded in [true, false] {
        let mut trial = Trial::new(2);
        trial.tell(json!({"loads": [{"loadId": "box"}]}));
        assert_eq!(trial.shown(), RobotState::Idle, "it may have come with a load");
        trial.vehicle.handle(StopAction::Drop, |_| Vec::new());
        let order = trial.order();
        let id = &order.nodes[0].actions[0].action_id;
        let failed = json!([{"actionId": id, "actionStatus": "FAILED"}]);
        trial.take(&order).tell(json!({"actionStates": failed}));
        assert_eq!(trial.shown(), RobotState::Broken);
        assert_eq!(
            trial.vehicle.take_lines(),
            [
                "its action drop has failed: it reports no result",
                "it still has the load of an order that has failed; its path is kept free"
            ]
        );
        if is_unloaded {
            trial.tell(json!({"loads": []}));
            assert!(!trial.vehicle.accept_load(), "it has none");
        } else {
            assert!(trial.vehicle.accept_load());
            trial.wait(1.0);
        }
        assert_eq!(trial.shown(), RobotState::Idle);
    }
}

#[test]
fn a_held_vehicle_is_paused_and_a_cancelled_one_stops_at_its_node() {
    let mut trial = Trial::new(4);
    trial.route(&[11, 12], 0).release(12);
    let order = trial.order();
    trial.take(&order).tell(json!({"driving": true, "agvPosition": Trial::at(2.0)}));
    trial.vehicle.hold(true);
    assert_eq!((trial.instant().0.as_str(), trial.shown()), ("startPause", RobotState::Held));
    trial.tell(json!({"paused": true, "driving": false}));
    trial.vehicle.hold(false);
    assert_eq!(trial.wait(2.0).instant().0, "stopPause");
    trial.tell(json!({"paused": false, "driving": true}));

    let roads = Roads::of(&line(4).0.view(1, 1), "map");
    trial.vehicle.cancel(&roads);
    let (kind, id) = trial.instant();
    assert_eq!((kind.as_str(), trial.shown()), ("cancelOrder", RobotState::Driving));
    let (kind, again) = trial.wait(2.0).instant();
    assert!(kind == "cancelOrder" && again != id, "an action id stands for one action");
    trial.tell(json!({"lastNodeId": "N2", "lastNodeSequenceId": 2, "driving": false,
        "agvPosition": Trial::at(5.0), "nodeStates": [],
        "actionStates": [{"actionId": id, "actionStatus": "FINISHED"}]}));
    assert_eq!((trial.place(), trial.shown()), ((0, 5.0), RobotState::Idle));
    assert!(trial.vehicle.course().expect("a course").ahead().is_empty());
}

#[test]
fn an_order_of_somebody_else_is_cancelled_first() {
    let mut trial = Trial::new(4);
    trial.tell(json!({"orderId": "foreign",
        "nodeStates": [{"nodeId": "N2", "sequenceId": 2, "released": false}]}));
    trial.route(&[11], 0).release(10);
    let (kind, id) = trial.instant();
    assert_eq!(kind, "cancelOrder");
    trial.tell(json!({"nodeStates": [],
        "actionStates": [{"actionId": id, "actionStatus": "FINISHED"}]}));
    assert_eq!(nodes(&trial.order())[..2], [("N1", 0, true), ("N2", 2, true)]);
}

#[test]
fn actions_have_the_parameters_of_the_command_line() {
    let mut trial = Trial::new(2);
    let options = ["pick.loadType=EPAL", "pick.height=0.5", "drop.loadType=box"];
    let parameters: Vec<Parameter> = options.iter().map(|it| it.parse().expect(it)).collect();
    let shown: Vec<String> = parameters.iter().map(ToString::to_string).collect();
    assert_eq!(shown[..2], ["pick.loadType=\"EPAL\"", "pick.height=0.5"]);
    let of_pick = |kind: &str| parameters.iter().filter_map(|it| it.of(kind)).collect();
    trial.vehicle.handle(StopAction::Pick, of_pick);
    let order = trial.order();
    let action = &order.nodes[0].actions[0];
    assert_eq!((action.text("loadType"), action.number("height")), (Some("EPAL"), Some(0.5)));
    assert!("pick=1".parse::<Parameter>().is_err());
}

/// It is no wish any more while it hasn't taken all that it was given.
#[test]
fn a_vehicle_that_asks_for_a_longer_base_is_heard() {
    let asks = |trial: &mut Trial, changes: Value| {
        trial.tell(changes).vehicle.take_events().iter().any(|event| {
            event.kind() == Some(EventKind::WaitingForRelease) && event.detail == BASE_WANTED
        })
    };
    let mut trial = Trial::new(5);
    trial.route(&[11, 12, 13], 0).release(10);
    let order = trial.order();
    assert!(!asks(&mut trial, json!({"newBaseRequest": true})), "it hasn't taken the order");
    trial.take(&order);
    assert!(asks(&mut trial, json!({"driving": true})));
    trial.release(11);
    assert!(!asks(&mut trial, json!({})), "a longer base is on its way");
    let update = trial.order();
    trial.take(&update);
    assert!(asks(&mut trial, json!({})), "it still comes to the end of its base");
    assert!(!asks(&mut trial, json!({"newBaseRequest": false})));
}
