//! Spellings of peers, and fields that may not be lost.

use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;

fn read<M: Message>(message: &Value) -> M {
    decode(message.to_string().as_bytes()).expect("a message")
}

#[test]
fn orders_of_all_versions_become_the_same_model() {
    let edge = |speed: &str, deviation: Value, descriptor: &str| {
        let mut edge = json!({"edgeId": "e", "sequenceId": 1, "released": true, "actions": []});
        edge[speed] = json!(0.5);
        edge[descriptor] = json!("a ramp");
        let position = json!({"x": 1, "y": 2.5, "mapId": "m", "allowedDeviationXY": deviation});
        let node = |place: u32| {
            json!({"nodeId": place.to_string(), "sequenceId": place, "released": true,
                   "nodePosition": position, "actions": []})
        };
        let nodes = [node(0), node(2)];
        let order = json!({"headerId": 7, "timestamp": "", "version": "", "manufacturer": "r",
            "serialNumber": "1", "orderId": "o", "orderUpdateId": 0, "nodes": nodes,
            "edges": [edge]});
        read::<Order>(&order)
    };
    let old = edge("maxSpeed", json!(0.25), "edgeDescription");
    let ellipse = json!({"a": 0.25, "b": 0.25, "theta": 0});
    let mut new = edge("maximumSpeed", ellipse, "edgeDescriptor");
    assert_eq!(old.edges, new.edges);
    new.adapt(Version::V2_1);
    assert_eq!(old.nodes, new.nodes);
    assert_eq!(new.edges[0].end_node_id.as_deref(), Some("2"));
}

#[test]
fn instant_actions_are_read_as_masters_spell_them() {
    for (list, kind) in [("actions", "actionType"), ("instantActions", "actionName")] {
        let mut action = json!({"actionId": "a", "blockingType": "HARD", "unknown": {"x": 1}});
        action[kind] = json!("cancelOrder");
        let mut message = json!({"headerId": 0});
        message[list] = json!([action]);
        let read: InstantActions = read(&message);
        assert_eq!(read.actions[0].action_type, "cancelOrder", "{message}");
    }
}

#[test]
fn a_broken_message_tells_the_reason_and_what_it_was_about() {
    for (text, reason, order) in [
        ("{", "EOF", None),
        ("[]", "invalid type", None),
        (r#"{"orderId":"o"}"#, "missing field `orderUpdateId`", Some("o")),
        (r#"{"orderId":"o","orderUpdateId":-1}"#, "invalid value: integer `-1`", Some("o")),
    ] {
        let error = decode::<Order>(text.as_bytes()).expect_err(text);
        assert!(error.reason().contains(reason), "{text}: {error}");
        assert_eq!(error.field("orderId").as_deref(), order);
    }
}

#[test]
fn parameters_of_actions_keep_their_names() {
    let value = json!({"maximumSpeed": 1, "list": [{"localized": true}]});
    let parameter = ActionParameter { key: "x".into(), value };
    let action = Action { action_parameters: vec![parameter], ..Action::default() };
    let node = Node { actions: vec![action.clone(), action], ..Node::default() };
    let edge = Edge { maximum_speed: Some(1.0), ..Edge::default() };
    let order = Order { nodes: vec![node], edges: vec![edge], ..Order::default() };
    for version in Version::ALL {
        assert_eq!(decode::<Order>(&encode(&order, version)).expect("an order"), order);
    }
}

proptest! {
    #[test]
    fn texts_and_numbers_survive_every_version(
        id in "\\PC*",
        x in -1e9..1e9_f64,
        update in any::<u32>(),
        version in prop::sample::select(Version::ALL.to_vec()),
    ) {
        let position = Position { x, map_id: id.clone(), localized: true, ..Position::default() };
        let state = State {
            order_id: id.clone(),
            order_update_id: update,
            mobile_robot_position: Some(position),
            node_states: vec![NodeState { node_id: id, ..NodeState::default() }],
            operating_mode: OperatingMode::TeachIn,
            ..State::default()
        };
        prop_assert_eq!(decode::<State>(&encode(&state, version)).expect("a state"), state);
    }

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = decode::<Order>(&bytes);
        let _ = decode::<InstantActions>(&bytes);
    }
}
