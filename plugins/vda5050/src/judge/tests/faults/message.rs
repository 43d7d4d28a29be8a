//! Faults of a message alone.

use serde_json::json;

use super::{Fault, V2_0, V2_1, V3_0};
use crate::judge::tests::conversation::Conversation;
use crate::judge::{Delivery, Rule};
use crate::message::Version;

/// Sets a number of a state, by the fields that lead to it.
fn state_with(talk: &mut Conversation, path: &[&str], number: f64) {
    let state = talk.at("state", 11);
    let field = path.iter().fold(state, |value, name| &mut value[*name]);
    *field = if number.fract() == 0.0 { json!(number as i64) } else { json!(number) };
}

pub(super) const FAULTS: &[Fault] = &[
    (Rule::Topic, V2_1, |talk| {
        let mut other = talk.messages[2].clone();
        other.topic = "uagv/v2/KIT/0001/status".to_owned();
        talk.messages.push(other);
    }),
    (Rule::SerialNumber, V2_1, |talk| {
        for sent in &mut talk.messages {
            sent.topic = sent.topic.replace("0001", "00 1");
            sent.content["serialNumber"] = "00 1".into();
        }
    }),
    (Rule::Json, V2_1, |talk| talk.sent("state", 2).bytes = Some(b"{\"a\":".to_vec())),
    (Rule::Json, V2_1, |talk| talk.sent("state", 2).bytes = Some(vec![0xff; 9])),
    (Rule::Json, V2_1, |talk| talk.sent("state", 2).bytes = Some(vec![b' '; 5 << 20])),
    (Rule::MissingField, V2_0, |talk| {
        talk.at("state", 11).as_object_mut().expect("an object").remove("safetyState");
    }),
    (Rule::FieldType, V2_1, |talk| talk.at("state", 11)["driving"] = "no".into()),
    (Rule::UnknownValue, V3_0, |talk| talk.at("state", 11)["operatingMode"] = "AUTO".into()),
    (Rule::ValueRange, V2_1, |talk| state_with(talk, &["batteryState", "batteryHealth"], 101.0)),
    (Rule::ValueRange, V2_0, |talk| state_with(talk, &["batteryState", "batteryCharge"], 180.0)),
    (Rule::ValueRange, V2_1, |talk| state_with(talk, &["batteryState", "batteryCharge"], -1.0)),
    (Rule::ValueRange, V3_0, |talk| state_with(talk, &["powerSupply", "stateOfCharge"], 100.5)),
    (Rule::ValueRange, V2_1, |talk| state_with(talk, &["batteryState", "reach"], -3.0)),
    (Rule::ValueRange, V2_0, |talk| state_with(talk, &["agvPosition", "theta"], 4.7)),
    (Rule::ValueRange, V2_1, |talk| state_with(talk, &["agvPosition", "theta"], -3.2)),
    (Rule::ValueRange, V3_0, |talk| state_with(talk, &["mobileRobotPosition", "theta"], 3.2)),
    (Rule::ValueRange, V2_1, |talk| state_with(talk, &["agvPosition", "localizationScore"], 1.1)),
    (Rule::ValueRange, V2_1, |talk| state_with(talk, &["distanceSinceLastNode"], -0.1)),
    (Rule::ValueRange, V2_1, |talk| {
        talk.at("visualization", 0)["agvPosition"]["theta"] = 9.into();
    }),
    (Rule::ValueRange, V2_1, |talk| talk.at("order", 0)["edges"][1]["maxSpeed"] = (-1).into()),
    (Rule::ValueRange, V3_0, |talk| talk.at("order", 0)["edges"][1]["maximumSpeed"] = (-1).into()),
    (Rule::ValueRange, V2_1, |talk| {
        talk.at("order", 0)["nodes"][1]["nodePosition"]["theta"] = 4.into();
    }),
    (Rule::ValueRange, V2_1, |talk| {
        talk.at("order", 0)["nodes"][1]["nodePosition"]["allowedDeviationTheta"] = (-1).into();
    }),
    (Rule::ValueRange, V2_1, |talk| {
        talk.at("factsheet", 0)["physicalParameters"]["speedMax"] = (-2).into();
    }),
    (Rule::ValueRange, V3_0, |talk| {
        talk.at("factsheet", 0)["physicalParameters"]["maximumSpeed"] = (-2).into();
    }),
    (Rule::Schema, V3_0, |talk| {
        let vertices = json!([{"x": 0, "y": 0}, {"x": 1, "y": 0}]);
        let zones = json!([{"zoneId": "z", "zoneType": "BLOCKED", "vertices": vertices}]);
        let mut sent = talk.sent("order", 0).clone();
        sent.topic = sent.topic.replace("order", "zoneSet");
        for field in ["orderId", "orderUpdateId", "nodes", "edges"] {
            sent.content.as_object_mut().expect("an object").remove(field);
        }
        sent.content["zoneSet"] = json!({"mapId": "m", "zoneSetId": "s", "zones": zones});
        talk.messages.push(sent);
    }),
    (Rule::VersionUnknown, V2_0, |talk| talk.at("state", 2)["version"] = "2.0".into()),
    (Rule::VersionOfTopic, V2_1, |talk| {
        for sent in &mut talk.messages {
            sent.topic = sent.topic.replace("/v2/", "/v3/");
        }
    }),
    (Rule::VersionChanges, Version::V2_1, |talk| talk.at("order", 0)["version"] = "2.0.0".into()),
    (Rule::HeaderIdGap, V2_1, |talk| talk.at("state", 11)["headerId"] = 40.into()),
    (Rule::HeaderIdRepeated, V2_1, |talk| talk.at("state", 11)["headerId"] = 10.into()),
    (Rule::TimestampForm, V2_1, |talk| {
        talk.at("visualization", 0)["timestamp"] = "2023-11-14T22:13:22.100+00:00".into();
    }),
    (Rule::TimestampBackwards, V2_1, |talk| {
        talk.at("state", 7)["timestamp"] = "2023-11-14T22:13:24.000Z".into();
    }),
    (Rule::ClockSkew, V2_1, |talk| {
        talk.at("order", 2)["timestamp"] = "2023-11-14T23:13:28.000Z".into();
    }),
    (Rule::Identity, V2_1, |talk| talk.at("state", 2)["serialNumber"] = "0002".into()),
    (Rule::Identity, V2_1, |talk| talk.at("order", 2)["manufacturer"] = "kit".into()),
    (Rule::QualityOfService, V2_1, |talk| {
        talk.sent("order", 0).delivery = Some(Delivery { quality: 1, retained: false });
    }),
    (Rule::QualityOfService, V2_1, |talk| {
        talk.sent("connection", 0).delivery = Some(Delivery { quality: 0, retained: true });
    }),
    (Rule::ConnectionNotRetained, V2_1, |talk| {
        talk.sent("connection", 0).delivery = Some(Delivery { quality: 1, retained: false });
    }),
    (Rule::FactsheetNotRetained, V3_0, |talk| {
        talk.sent("factsheet", 0).delivery = Some(Delivery { quality: 0, retained: false });
    }),
    (Rule::NoNodes, V2_1, |talk| {
        let mut order = talk.messages[0].clone();
        order.topic = "uagv/v2/KIT/0001/order".to_owned();
        order.time += 13.0;
        order.content = talk.at("order", 2).clone();
        order.content["headerId"] = 3.into();
        order.delivery = None;
        (order.content["nodes"], order.content["edges"]) = (json!([]), json!([]));
        order.content["orderId"] = "o3".into();
        order.content["timestamp"] = "2023-11-14T22:13:33.000Z".into();
        let mut online = talk.sent("connection", 1).clone();
        online.content["connectionState"] = "ONLINE".into();
        online.content["headerId"] = 2.into();
        let mut rejected = talk.sent("state", 11).clone();
        rejected.time = order.time + 0.2;
        rejected.content["headerId"] = 12.into();
        rejected.content["timestamp"] = "2023-11-14T22:13:33.200Z".into();
        rejected.content["errors"] = json!([{
            "errorType": "validationError",
            "errorLevel": "WARNING",
            "errorReferences": [{"referenceKey": "orderId", "referenceValue": "o3"}],
        }]);
        let mut offline = talk.sent("connection", 1).clone();
        offline.time = order.time + 1.0;
        offline.content["headerId"] = 3.into();
        talk.messages.extend([online, order, rejected, offline]);
    }),
];
