//! Reliefs of a study, on plants with one fault each: the change that repairs it comes first.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::fleet::{graphs, regatta};

/// Studies a plant of `graphs/faults` with a number of robots, and returns its reliefs.
fn reliefs(folder: &Path, plant: &str, robots: u32, duration: &str) -> Value {
    let output = regatta()
        .arg("study")
        .arg(graphs(&format!("faults/{plant}.yaml")))
        .args(["--robots", &robots.to_string(), "--duration", duration, "--seeds", "3..8"])
        .arg("--output")
        .arg(folder.join(plant))
        .output()
        .expect("regatta starts");
    assert!(output.status.success(), "{plant}: {}", String::from_utf8_lossy(&output.stderr));
    let answer = fs::read(folder.join(plant).join("study.json")).expect("an answer");
    let answer: Value = serde_json::from_slice(&answer).expect("JSON");
    answer["reliefs"].clone()
}

/// Checks that a change helps, and is the best one of several.
fn check_first(plant: &str, robots: u32, duration: &str, remedy: &Value) {
    let folder = tempfile::tempdir().expect("a folder");
    let reliefs = reliefs(folder.path(), plant, robots, duration);
    let tried = reliefs["tried"].as_array().expect("reliefs");
    assert!(tried.len() > 1, "{plant}: {reliefs:#}");
    assert_eq!(
        (&tried[0]["verdict"], &tried[0]["remedy"]),
        (&"helps".into(), remedy),
        "{reliefs:#}"
    );
}

#[test]
fn one_operator_too_few_comes_first() {
    check_first("operator", 8, "30min", &json!({"operator": [24, 25, 26]}));
}

#[test]
fn a_station_without_a_queue_comes_first() {
    check_first("queue", 8, "30min", &json!({"queue": 24}));
}

#[test]
fn a_charger_too_few_comes_first() {
    check_first("charger", 6, "60min", &json!({"charger": 25}));
}

#[test]
fn an_aisle_of_the_wrong_direction_comes_first() {
    check_first("aisle", 6, "15min", &json!({"reversed": [29, 30]}));
}

#[test]
fn a_track_without_a_place_to_pass_comes_first() {
    check_first("track", 10, "30min", &json!({"second_track": [1, 13, 14, 7]}));
}

#[test]
fn a_slow_edge_comes_first() {
    check_first("slow", 8, "15min", &json!({"usual_speed": {"edges": [8], "speed": 1.5}}));
}
