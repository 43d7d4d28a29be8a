//! Faults of vehicles.

use serde_json::{Value, json};

use super::{Fault, V2_0, V2_1, V3_0};
use crate::judge::Rule;
use crate::judge::tests::conversation::{Conversation, IDLE, Shown, edge, node};
use crate::message::ActionStatus::{Failed, Finished};
use crate::message::ConnectionState;

/// The vehicle is asked to cancel an order that it doesn't have, and answers.
fn vain_cancel(talk: &mut Conversation, status: crate::message::ActionStatus, error: Value) {
    talk.cut(11.0);
    talk.instant(11.0, "i4", "cancelOrder");
    let instant = [("i3", Finished), ("i4", status)];
    let last = ("n2", 0);
    talk.state(11.2, &Shown { order: ("o2", 0), last, x: 8.8, instant: &instant, ..IDLE });
    talk.at("state", 12)["errors"] = error;
}

/// The vehicle rejects an order with an error.
fn rejection(talk: &mut Conversation, error: Value) {
    talk.cut(11.0);
    talk.order(11.0, ("o3", 0), &[node("n2", 0, true), node("n3", 2, true)], &[edge(1, true)]);
    let instant = [("i3", Finished)];
    let last = ("n2", 0);
    talk.state(11.2, &Shown { order: ("o2", 0), last, x: 8.8, instant: &instant, ..IDLE });
    talk.at("state", 12)["errors"] = error;
}

/// Sets a field of several states.
fn set(talk: &mut Conversation, states: &[usize], field: &str, value: &Value) {
    for number in states {
        talk.at("state", *number)[field] = value.clone();
    }
}

/// Another vehicle stands so many metres to the side of the first one's start.
fn beside(talk: &mut Conversation, y: f64) {
    let mut other = Conversation::empty(talk.version, "0002");
    other.arrive(0.3);
    other.at("state", 0)["agvPosition"]["y"] = y.into();
    talk.messages.extend(other.messages);
    talk.messages.sort_by(|one, other| one.time.total_cmp(&other.time));
}

pub(super) const FAULTS: &[Fault] = &[
    (Rule::NeverOnline, V2_1, |talk| talk.remove("connection", 0)),
    (Rule::OfflineGoesOn, V2_1, |talk| {
        let instant = [("i3", Finished)];
        let last = ("n2", 0);
        talk.state(13.0, &Shown { order: ("o2", 0), last, x: 8.8, instant: &instant, ..IDLE });
    }),
    (Rule::OfflineGoesOn, V3_0, |talk| {
        talk.connection(12.5, ConnectionState::ConnectionBroken);
        talk.visualization(13.0, 8.8);
    }),
    (Rule::StateOverdue, V2_1, |talk| talk.remove("connection", 1)),
    (Rule::OrderUnanswered, V3_0, |talk| {
        talk.remove("connection", 1);
        talk.order(13.0, ("o3", 0), &[node("n2", 0, true)], &[]);
    }),
    (Rule::ActionUnanswered, V2_1, |talk| {
        talk.remove("connection", 1);
        talk.instant(13.0, "i5", "stateRequest");
    }),
    (Rule::OrderNeverSent, V2_1, |talk| set(talk, &[2], "orderId", &json!("o7"))),
    (Rule::UpdateNeverSent, V2_1, |talk| set(talk, &[2], "orderUpdateId", &json!(7))),
    (Rule::SequenceBackwards, V2_1, |talk| set(talk, &[7], "lastNodeSequenceId", &json!(0))),
    (Rule::NodeStates, V2_1, |talk| talk.at("state", 2)["nodeStates"][0]["nodeId"] = "n7".into()),
    (Rule::NodeStates, V3_0, |talk| {
        talk.at("state", 2)["nodeStates"][1]["released"] = true.into();
    }),
    (Rule::EdgeStates, V2_1, |talk| talk.at("state", 2)["edgeStates"][0]["edgeId"] = "e7".into()),
    (Rule::EdgeStates, V2_0, |talk| set(talk, &[7], "edgeStates", &json!([]))),
    (Rule::NodeUnnamed, V2_1, |talk| set(talk, &[4], "lastNodeSequenceId", &json!(0))),
    (Rule::NodeUnnamed, V3_0, |talk| {
        set(talk, &[7], "nodeStates", &json!([]));
        set(talk, &[7], "edgeStates", &json!([]));
    }),
    (Rule::LastNode, V2_1, |talk| set(talk, &[4], "lastNodeId", &json!("n0"))),
    (Rule::HorizonDriven, V2_1, |talk| {
        talk.cut(2.5);
        let actions = [("a1", Finished)];
        let beyond = Shown { order: ("o1", 0), last: ("n2", 4), x: 8.0, actions: &actions, ..IDLE };
        talk.state(2.6, &beyond);
    }),
    (Rule::ActionStateMissing, V2_1, |talk| set(talk, &[1], "actionStates", &json!([]))),
    (Rule::ActionStateUnknown, V3_0, |talk| {
        talk.at("state", 2)["actionStates"]
            .as_array_mut()
            .expect("a list")
            .push(json!({"actionId": "a7", "actionStatus": "WAITING"}));
    }),
    (Rule::ActionStateDropped, V2_1, |talk| set(talk, &[5], "actionStates", &json!([]))),
    (Rule::ActionStatus, V2_1, |talk| {
        talk.at("state", 7)["actionStates"][0]["actionStatus"] = "RUNNING".into();
    }),
    (Rule::ActionStatus, V3_0, |talk| {
        talk.at("state", 5)["actionStates"][0]["actionStatus"] = "WAITING".into();
    }),
    (Rule::DrivingWhilePaused, V2_1, |talk| set(talk, &[1, 2], "paused", &json!(true))),
    (Rule::DrivingWithAction, V2_1, |talk| set(talk, &[4], "driving", &json!(true))),
    (Rule::DrivingInEmergency, V2_1, |talk| {
        let stop = json!({"eStop": "MANUAL", "fieldViolation": false});
        set(talk, &[1, 2], "safetyState", &stop);
    }),
    (Rule::DrivingUnlocalized, V3_0, |talk| {
        for number in [1, 2] {
            talk.at("state", number)["mobileRobotPosition"]["localized"] = false.into();
        }
    }),
    (Rule::ActionsInParallel, V2_1, |talk| {
        let second = json!({"actionId": "a2", "actionType": "drop", "blockingType": "NONE",
            "actionParameters": []});
        for number in [0, 1] {
            let place = 1 - number;
            talk.at("order", number)["nodes"][place]["actions"]
                .as_array_mut()
                .expect("a list")
                .push(second.clone());
        }
        for number in 1..=8 {
            let status = if number == 4 { "RUNNING" } else { "WAITING" };
            talk.at("state", number)["actionStates"]
                .as_array_mut()
                .expect("a list")
                .push(json!({"actionId": "a2", "actionStatus": status}));
        }
    }),
    (Rule::PauseUntold, V2_1, |talk| set(talk, &[5], "paused", &json!(false))),
    (Rule::PauseUntold, V3_0, |talk| set(talk, &[6], "paused", &json!(true))),
    (Rule::OrderInManualMode, V2_1, |talk| set(talk, &[2], "operatingMode", &json!("MANUAL"))),
    (Rule::OrderInManualMode, V3_0, |talk| set(talk, &[2], "operatingMode", &json!("SERVICE"))),
    (Rule::CancelledOrderKept, V2_1, |talk| set(talk, &[10], "driving", &json!(true))),
    (Rule::CancelNotRefused, V2_1, |talk| vain_cancel(talk, Finished, json!([]))),
    (Rule::CancelNotRefused, V3_0, |talk| vain_cancel(talk, Failed, json!([]))),
    (Rule::RejectionType, V2_1, |talk| {
        rejection(
            talk,
            json!([{"errorType": "nope", "errorLevel": "WARNING", "errorReferences":
            [{"referenceKey": "orderId", "referenceValue": "o3"}]}]),
        );
    }),
    (Rule::RejectionReferences, V3_0, |talk| {
        rejection(talk, json!([{"errorType": "VALIDATION_FAILURE", "errorLevel": "WARNING"}]));
    }),
    (Rule::SpeedLimit, V2_1, |talk| set(talk, &[2], "velocity", &json!({"vx": 2.2}))),
    (Rule::NodeOutOfRange, V2_1, |talk| talk.at("state", 4)["agvPosition"]["x"] = 3.0.into()),
    (Rule::OffTrajectory, V2_1, |talk| {
        let points = json!([{"x": 0, "y": 0}, {"x": 0, "y": 4}, {"x": 4, "y": 0}]);
        talk.at("order", 0)["edges"][0]["trajectory"] =
            json!({"degree": 1, "knotVector": [0, 0, 0.5, 1, 1], "controlPoints": points});
    }),
    (Rule::OffEdge, V2_1, |talk| talk.at("state", 2)["agvPosition"]["y"] = 3.0.into()),
    (Rule::Visualization, V2_1, |talk| {
        talk.at("visualization", 0)["agvPosition"]["x"] = 5.0.into();
    }),
    (Rule::Contact, V2_1, |talk| beside(talk, 0.4)),
];

#[test]
fn vehicles_side_by_side_do_not_touch() {
    let mut talk = Conversation::correct(V2_1);
    beside(&mut talk, 0.6);
    let findings = talk.judged(0.0);
    assert!(findings.iter().all(|finding| finding.rule != Rule::Contact), "{findings:#?}");
}

/// A vehicle that can't stop between nodes drives to the next one, and shows that one alone.
#[test]
fn a_vehicle_may_drive_to_the_next_node_to_cancel_an_order() {
    let mut talk = Conversation::correct(V2_1);
    let (mut node, mut edge) =
        (talk.at("order", 2)["nodes"][1].clone(), talk.at("order", 2)["edges"][0].clone());
    (node["nodeId"], node["sequenceId"]) = ("n4".into(), 4.into());
    (edge["edgeId"], edge["sequenceId"]) = ("e3".into(), 3.into());
    (edge["startNodeId"], edge["endNodeId"]) = ("n3".into(), "n4".into());
    let order = talk.at("order", 2);
    order["nodes"].as_array_mut().expect("nodes").push(node);
    order["edges"].as_array_mut().expect("edges").push(edge);
    let (next, ahead) =
        (talk.at("state", 9)["nodeStates"].clone(), talk.at("state", 9)["edgeStates"].clone());
    let begun = talk.at("state", 9);
    let last = json!({"nodeId": "n4", "sequenceId": 4, "released": true});
    let last_edge = json!({"edgeId": "e3", "sequenceId": 3, "released": true});
    begun["nodeStates"].as_array_mut().expect("nodes").push(last);
    begun["edgeStates"].as_array_mut().expect("edges").push(last_edge);
    let stopping = talk.at("state", 10);
    (stopping["nodeStates"], stopping["edgeStates"]) = (next, ahead);
    stopping["driving"] = true.into();
    stopping["actionStates"][0]["actionStatus"] = "RUNNING".into();
    assert_eq!(talk.judged(0.0), []);
}

#[test]
fn a_rejection_and_a_refused_cancel_by_the_standard_have_no_findings() {
    let mut talk = Conversation::correct(V2_1);
    rejection(
        &mut talk,
        json!([{"errorType": "orderError", "errorLevel": "WARNING",
        "errorReferences": [{"referenceKey": "orderId", "referenceValue": "o3"}]}]),
    );
    talk.connection(12.0, ConnectionState::Offline);
    assert_eq!(talk.judged(100.0), []);
    let mut talk = Conversation::correct(V2_1);
    vain_cancel(
        &mut talk,
        Failed,
        json!([{"errorType": "noOrderToCancel",
        "errorLevel": "WARNING",
        "errorReferences": [{"referenceKey": "actionId", "referenceValue": "i4"}]}]),
    );
    talk.connection(12.0, ConnectionState::Offline);
    let rules: Vec<_> = talk.judged(100.0).iter().map(|finding| finding.rule).collect();
    assert_eq!(rules, [Rule::CancelWithoutOrder]);
}
