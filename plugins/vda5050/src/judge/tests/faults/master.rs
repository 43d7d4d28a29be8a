//! Faults of masters.

use serde_json::json;

use super::{Fault, V2_0, V2_1, V3_0};
use crate::judge::Rule;
use crate::judge::tests::conversation::{Conversation, IDLE, Shown, edge, node};
use crate::message::{ActionStatus, ConnectionState};

/// An action as JSON.
fn action(id: &str, kind: &str) -> serde_json::Value {
    json!({"actionId": id, "actionType": kind, "blockingType": "NONE", "actionParameters": []})
}

/// Goes on with an update of the first order, sent at 3 s in place of the correct one.
fn update(talk: &mut Conversation, id: u32, nodes: &[(&str, u32)]) {
    talk.cut(3.0);
    let nodes: Vec<_> = nodes.iter().map(|(name, id)| node(name, *id, true)).collect();
    let edges: Vec<_> = nodes.iter().skip(1).map(|node| edge(node.sequence_id - 1, true)).collect();
    talk.order(3.0, ("o1", id), &nodes, &edges);
}

/// Sends a new order at 11 s, when the vehicle is idle at 8.8 m.
fn new_order(talk: &mut Conversation, update: u32, first: u32) {
    talk.cut(11.0);
    let nodes = [node("n2", first, true), node("n3", first + 2, true)];
    talk.order(11.0, ("o3", update), &nodes, &[edge(first + 1, true)]);
}

pub(super) const FAULTS: &[Fault] = &[
    (Rule::EdgeCount, V2_1, |talk| talk.at("order", 0)["edges"] = json!([])),
    (Rule::SequenceIds, V2_1, |talk| talk.at("order", 0)["nodes"][1]["sequenceId"] = 3.into()),
    (Rule::SequenceIds, V3_0, |talk| talk.at("order", 0)["edges"][1]["sequenceId"] = 1.into()),
    (Rule::SequenceStart, V2_1, |talk| new_order(talk, 0, 4)),
    (Rule::EdgeEnds, V2_0, |talk| talk.at("order", 0)["edges"][0]["endNodeId"] = "n9".into()),
    (Rule::EdgeBeforeNode, V2_1, |talk| talk.at("order", 0)["edges"][1]["released"] = true.into()),
    (Rule::ReleasedAfterHorizon, V2_1, |talk| {
        talk.at("order", 0)["edges"][0]["released"] = false.into();
    }),
    (Rule::FirstNodeUnreleased, V3_0, |talk| {
        talk.at("order", 0)["nodes"][0]["released"] = false.into();
    }),
    (Rule::ActionIdTwice, V2_1, |talk| {
        talk.at("order", 0)["nodes"][2]["actions"] = json!([action("a1", "drop")]);
    }),
    (Rule::ActionIdTwice, V3_0, |talk| {
        talk.at("instantActions", 1)["actions"][0]["actionId"] = "i1".into();
    }),
    (Rule::MapMissing, V2_1, |talk| {
        talk.at("order", 0)["nodes"][1]["nodePosition"]["mapId"] = "".into();
    }),
    (Rule::Trajectory, V2_1, |talk| {
        talk.at("order", 0)["edges"][0]["trajectory"] = json!({
            "degree": 2,
            "knotVector": [0, 0, 0, 1, 1],
            "controlPoints": [{"x": 0, "y": 0}, {"x": 1, "y": 0}, {"x": 4, "y": 0}],
        });
    }),
    (Rule::FirstUpdateId, V2_1, |talk| new_order(talk, 3, 0)),
    (Rule::UpdateIdBackwards, V2_1, |talk| {
        talk.cut(4.0);
        talk.order(4.0, ("o1", 0), &[node("n2", 4, true)], &[]);
    }),
    (Rule::UpdateIdReused, V3_0, |talk| {
        talk.cut(4.0);
        talk.order(4.0, ("o1", 1), &[node("n2", 4, true)], &[]);
    }),
    (Rule::BaseSentAgain, V2_1, |talk| update(talk, 1, &[("n0", 0), ("n1", 2), ("n2", 4)])),
    (Rule::Stitching, V2_1, |talk| update(talk, 1, &[("n2", 4), ("n3", 6)])),
    (Rule::Stitching, V3_0, |talk| update(talk, 1, &[("n9", 2), ("n2", 4)])),
    (Rule::StitchingNodeChanged, V2_1, |talk| {
        talk.at("order", 1)["nodes"][0]["nodePosition"]["y"] = 1.into();
    }),
    (Rule::OrderWhileActive, V2_1, |talk| {
        talk.cut(3.0);
        talk.order(3.0, ("o9", 0), &[node("n0", 0, true)], &[]);
    }),
    (Rule::UpdateAfterCancel, V3_0, |talk| {
        talk.cut(11.0);
        let nodes = [node("n3", 2, true), node("n4", 4, true)];
        talk.order(11.0, ("o2", 1), &nodes, &[edge(3, true)]);
    }),
    (Rule::UpdateTooEarly, V2_1, |talk| {
        update(talk, 1, &[("n1", 2), ("n2", 4)]);
        let nodes = [node("n2", 4, true), node("n3", 6, true)];
        talk.order(3.05, ("o1", 2), &nodes, &[edge(5, true)]);
    }),
    (Rule::OrderOffline, V2_1, |talk| {
        talk.order(13.0, ("o3", 0), &[node("n2", 0, true)], &[]);
    }),
    (Rule::OrderOffline, V3_0, |talk| {
        talk.connection(12.5, ConnectionState::ConnectionBroken);
        talk.order(13.0, ("o3", 0), &[node("n2", 0, true)], &[]);
    }),
    (Rule::OrderInMode, V2_1, |talk| {
        new_order(talk, 0, 0);
        talk.at("state", 11)["operatingMode"] = "SERVICE".into();
    }),
    (Rule::StartOutOfRange, V2_1, |talk| {
        talk.cut(11.0);
        talk.order(11.0, ("o3", 0), &[node("n5", 0, true)], &[]);
    }),
    (Rule::StartOutOfRange, V3_0, |talk| {
        new_order(talk, 0, 0);
        talk.at("order", 3)["nodes"][0]["nodePosition"]["mapId"] = "other".into();
    }),
    (Rule::HorizonNotReleased, V2_1, |talk| {
        talk.cut(3.0);
        let waiting = Shown {
            order: ("o1", 0),
            last: ("n1", 2),
            nodes: &[("n2", -4)],
            x: 4.0,
            actions: &[("a1", ActionStatus::Finished)],
            ..IDLE
        };
        (2..=8).for_each(|tens| talk.state(f64::from(tens) * 10.0, &waiting));
    }),
    (Rule::ActionScope, V2_1, |talk| {
        talk.at("order", 0)["nodes"][1]["actions"][0]["actionType"] = "cancelOrder".into();
    }),
    (Rule::ActionScope, V3_0, |talk| {
        talk.at("instantActions", 0)["actions"][0]["actionType"] = "pick".into();
    }),
    (Rule::ActionScope, V2_0, |talk| {
        talk.at("order", 0)["edges"][0]["actions"] = json!([action("a9", "waitForTrigger")]);
    }),
    (Rule::InstantBlocking, V3_0, |talk| {
        talk.at("instantActions", 0)["actions"][0]["blockingType"] = "HARD".into();
    }),
    (Rule::InstantInMode, V3_0, |talk| {
        talk.at("state", 4)["operatingMode"] = "INTERVENED".into();
    }),
    (Rule::InstantInMode, V3_0, |talk| {
        talk.at("state", 5)["operatingMode"] = "SERVICE".into();
    }),
    (Rule::CancelWithoutOrder, V2_1, |talk| {
        talk.cut(11.0);
        talk.instant(11.0, "i4", "cancelOrder");
    }),
    (Rule::HeadOn, V2_1, |talk| {
        let mut other = Conversation::empty(talk.version, "0002");
        other.arrive(0.5);
        other.order(1.5, ("x", 0), &[node("n1", 0, true), node("n0", 2, true)], &[edge(1, true)]);
        talk.messages.extend(other.messages);
        talk.messages.sort_by(|one, other| one.time.total_cmp(&other.time));
    }),
];
