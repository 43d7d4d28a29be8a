//! Each range and each enumeration of the official schemas is judged.

use serde_json::{Value, json};

use super::*;
use crate::judge::finding::Finding;

/// The findings about the form of a message.
fn judged(content: &Value, subject: Subject, version: Version) -> Vec<Finding> {
    let mut findings = Vec::new();
    let (time, number, vehicle) = (None, 1, "v");
    let mut notes = Notes { findings: &mut findings, vehicle, subject, version, time, number };
    Book::shared().judge(content, &mut notes);
    findings
}

#[test]
fn all_official_schemas_are_compiled() {
    assert_eq!(Book::new().indices.len(), TEXTS.len());
}

#[test]
fn a_node_state_of_2_0_needs_no_heading() {
    let position = json!({"x": 1, "y": 2, "mapId": "m"});
    let state = json!({"nodeStates": [{"nodePosition": position}]});
    let findings = judged(&state, Subject::Read(Topic::State), Version::V2_0);
    let about_nodes: Vec<_> =
        findings.iter().filter(|one| one.message.contains("nodeStates/0")).collect();
    assert_eq!(about_nodes.len(), 1, "{findings:#?}");
    assert!(!about_nodes[0].message.contains("theta"), "{findings:#?}");
}

/// The schema of 2.1 wants the list itself to be one of the blocking types.
#[test]
fn the_blocking_types_of_a_factsheet_are_a_list() {
    let actions = json!([{"blockingTypes": ["NONE", "HARD"]}]);
    let sheet = json!({"protocolFeatures": {"agvActions": actions}});
    for version in [Version::V2_0, Version::V2_1] {
        let findings = judged(&sheet, Subject::Read(Topic::Factsheet), version);
        assert!(findings.iter().all(|one| !one.message.contains("blockingTypes")), "{findings:#?}");
    }
}

/// A value that a schema forbids, and the fields that lead to it.
struct Bad {
    path: Vec<String>,
    value: Value,
    rule: Rule,
}

/// Adds a bad value for each range and enumeration of a schema. Lists are entered by `0`.
fn find(root: &Value, schema: &Value, path: &[String], bad: &mut Vec<Bad>) {
    if let Some(name) = schema["$ref"].as_str() {
        let target = root.pointer(name.trim_start_matches('#')).expect("a definition");
        return find(root, target, path, bad);
    }
    let mut add = |value: Value, rule: Rule| bad.push(Bad { path: path.to_vec(), value, rule });
    if let Some(least) = schema["minimum"].as_f64() {
        add(json!(least.floor() as i64 - 1), Rule::ValueRange);
    }
    if let Some(most) = schema["maximum"].as_f64() {
        add(json!(most.ceil() as i64 + 1), Rule::ValueRange);
    }
    if schema["enum"].is_array() && schema["type"] != "array" {
        add(json!("NONE OF THESE"), Rule::UnknownValue);
    }
    let fields = schema["properties"].as_object().into_iter().flatten();
    for (name, field) in fields {
        find(root, field, &[path, std::slice::from_ref(name)].concat(), bad);
    }
    if schema["items"].is_object() {
        find(root, &schema["items"], &[path, &["0".to_owned()]].concat(), bad);
    }
}

/// A message that has nothing but a value.
fn wrapped(path: &[String], value: &Value) -> Value {
    path.iter().rev().fold(value.clone(), |inner, step| match step.as_str() {
        "0" => json!([inner]),
        field => json!({field: inner}),
    })
}

fn is_found(bad: &Bad, subject: Subject, version: Version) -> bool {
    let place = format!("'/{}'", bad.path.join("/"));
    let findings = judged(&wrapped(&bad.path, &bad.value), subject, version);
    findings.iter().any(|one| one.rule == bad.rule && one.message.starts_with(&place))
}

#[test]
fn each_range_and_each_enumeration_of_the_schemas_is_judged() {
    let mut tried = 0;
    for (folder, name, text) in TEXTS {
        let version = Version::ALL.into_iter().find(|version| version.number() == folder);
        let (version, subject) = (version.expect("a version"), Subject::of(name).expect("a topic"));
        let schema: Value = serde_json::from_str(text).expect("JSON");
        let mut bad = Vec::new();
        find(&schema, &schema, &[], &mut bad);
        for one in &bad {
            let told = format!("{folder} {name}: {} in {:?}", one.value, one.path);
            assert!(is_found(one, subject, version), "{told}");
        }
        tried += bad.len();
    }
    assert!(tried > 150, "{tried}");
}

/// The factors of zones depend on their type.
#[test]
fn the_factors_of_zones_are_judged() {
    for (kind, field) in [("PRIORITY", "priorityFactor"), ("PENALTY", "penaltyFactor")] {
        for factor in [-0.5, 1.5] {
            let zones = json!([{"zoneType": kind, field: factor}]);
            let message = json!({"zoneSet": {"zones": zones}});
            let findings = judged(&message, Subject::ZoneSet, Version::V3_0);
            let is_found = findings.iter().any(|one| one.rule == Rule::ValueRange);
            assert!(is_found, "{kind} {factor}: {findings:#?}");
        }
    }
}
