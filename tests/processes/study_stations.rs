//! Stations with operators against queueing theory. Robots drive through each other (`--bound`), so
//! that nothing but the operators keeps them.
//!
//! Orders come at random, and robots are never rare: the arrivals at a station are those of the
//! orders, later by ways that don't depend on each other, and so they come at random, too. Of a
//! closed network, mean value analysis is exact: Reiser and Lavenberg, Journal of the ACM 27
//! (1980).
//! For batches: Gross and Harris, Fundamentals of Queueing Theory (1998), section 3.1.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::fleet::regatta;
use crate::study_theory::{LOOP, bays, wait_in_services};

/// The mean time of a service, in seconds.
const SERVICE_SECS: f64 = 15.0;

/// Times of service as a distribution of the load, with their mean and squared coefficient of
/// variation.
struct Services {
    text: String,
    mean_secs: f64,
    squared_variation: f64,
}

/// Returns the quantiles of an exponential distribution, each with the same probability.
fn exponential() -> Services {
    const QUANTILES: usize = 400;
    let part = |index: usize| (index as f64 + 0.5) / QUANTILES as f64;
    let secs: Vec<f64> =
        (0..QUANTILES).map(|index| -SERVICE_SECS * (1.0 - part(index)).ln()).collect();
    let mean = |secs: &[f64]| secs.iter().sum::<f64>() / secs.len() as f64;
    let mean_secs = mean(&secs);
    let squares: Vec<f64> = secs.iter().map(|secs| (secs - mean_secs).powi(2)).collect();
    let texts: Vec<String> = secs.iter().map(|secs| format!("{secs:.3}")).collect();
    let text = format!("{{samples: [{}]}}", texts.join(", "));
    Services { text, mean_secs, squared_variation: mean(&squares) / mean_secs.powi(2) }
}

/// Returns times that are uniform from 0 to twice their mean.
fn uniform() -> Services {
    let text = format!("{{min: 0, max: {}}}", 2.0 * SERVICE_SECS);
    Services { text, mean_secs: SERVICE_SECS, squared_variation: 1.0 / 3.0 }
}

/// Studies a plant and returns the only point of its bound.
fn study(folder: &Path, layout: &str, load: &str, robots: u32, duration: &str) -> Value {
    fs::write(folder.join("plant.csv"), layout).expect("written");
    let scenario = folder.join("s.yaml");
    let text = format!(
        "graph: plant.csv\nrobot_types: [{{name: amr, length: 0.9, width: 0.6}}]\n\
         robots: [{{routes: none}}]\nload: {load}\n\
         plugins: [{{name: fleet-manager, args: [--in-turn]}}]\n"
    );
    fs::write(&scenario, text).expect("written");
    let robots = robots.to_string();
    let output = regatta()
        .arg("study")
        .arg(&scenario)
        .args(["--robots", &robots, "--duration", duration, "--seeds", "6..6"])
        .args(["--reliefs", "0", "--bound", "--output"])
        .arg(folder.join("s"))
        .output()
        .expect("regatta starts");
    let answer = fs::read(folder.join("s/study.json"));
    let answer = answer.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    let answer: Value = serde_json::from_slice(&answer).expect("JSON");
    answer["variants"][1]["points"][0].clone()
}

/// Returns the mean and half of the 95 % interval of a figure.
fn interval(figure: &Value) -> (f64, f64) {
    let [mean, half_width] =
        ["mean", "half_width"].map(|key| figure[key].as_f64().expect("a figure"));
    (mean, half_width)
}

fn part(point: &Value, name: &str) -> (f64, f64) {
    let parts = point["order_time"].as_array().expect("parts");
    let part = parts.iter().find(|part| part["name"] == name).expect("the part");
    interval(&part["value"])
}

/// Bays of which every other one is to pick, and the others to drop.
fn stations() -> String {
    const BAYS: usize = 24;
    let mut layout = bays(BAYS);
    for index in (1..BAYS).step_by(2) {
        let line = layout.lines().find(|line| line.starts_with(&format!("B{index},")));
        let line = line.expect("a bay").to_owned();
        layout = layout.replace(&line, &line.replace(",pick", ",drop"));
    }
    layout
}

/// Compares the wait at a station with theory: at a load of 70 %, with some operators.
fn check_station(operators: u32, services: &Services) {
    let folder = tempfile::tempdir().expect("a folder");
    let offered = 0.7 * f64::from(operators);
    let per_hour = offered * 3600.0 / services.mean_secs;
    let load = format!(
        "{{per_hour: {per_hour}, from: pick, to: drop, dwell: {{drop: {}}}, \
         stations: [{{at: drop, operators: {operators}}}]}}",
        services.text
    );
    let point = study(folder.path(), &stations(), &load, 10 + 6 * operators, "90min");
    let (secs, half_width) = part(&point, "waiting at a station");
    let expected =
        services.mean_secs * wait_in_services(operators, offered, services.squared_variation);
    assert!(
        (secs - expected).abs() <= half_width,
        "{operators} operators: {secs} ± {half_width} s, by the formula {expected} s"
    );
    assert!(half_width < 0.7 * expected, "an interval that tells something: ± {half_width} s");
    let (traffic, _) = part(&point, "waiting in traffic");
    assert!(traffic < 0.5, "nothing but operators keeps robots: {traffic} s");
}

#[test]
fn exponential_services_agree_with_erlang() {
    check_station(2, &exponential());
}

#[test]
fn uniform_services_agree_with_pollaczek_and_khinchine() {
    check_station(1, &uniform());
}

#[test]
fn several_operators_agree_with_theory_for_any_services() {
    check_station(2, &uniform());
}

#[test]
fn batches_agree_with_the_formula_for_a_single_server() {
    const BATCH: f64 = 3.0;
    let folder = tempfile::tempdir().expect("a folder");
    let stops = "from: pick, to: drop, dwell: {min: 2, max: 18}";
    let busy = study(folder.path(), LOOP, &format!("{{endless: robots, {stops}}}"), 1, "90min");
    let service_secs = 3600.0 / interval(&busy["orders_per_hour"]).0;
    let variance = 2.0 * 16.0_f64.powi(2) / 12.0;
    let folder = tempfile::tempdir().expect("a folder");
    let per_hour = 33.0;
    let load = format!("{{per_hour: {per_hour}, batch: {BATCH}, {stops}}}");
    let point = study(folder.path(), LOOP, &load, 1, "5h");
    let (secs, half_width) = interval(&point["service_mean_secs"]);
    let rate = per_hour / 3600.0;
    let second_moment = service_secs.powi(2) + variance;
    let wait =
        (rate * second_moment + (BATCH - 1.0) * service_secs) / (2.0 * (1.0 - rate * service_secs));
    let expected = service_secs + wait;
    assert!(
        (secs - expected).abs() <= half_width,
        "from creation to end: {secs} ± {half_width} s, by the formula {expected} s"
    );
}

#[test]
fn a_closed_network_agrees_with_mean_value_analysis() {
    const ROBOTS: u32 = 6;
    let services = exponential();
    let load = format!(
        "{{endless: robots, from: pick, to: drop, dwell: {{drop: {}}}, \
         stations: [{{at: drop, operators: 1}}]}}",
        services.text
    );
    let orders = |robots: u32| {
        let folder = tempfile::tempdir().expect("a folder");
        let point = study(folder.path(), &stations(), &load, robots, "90min");
        interval(&point["orders_per_hour"])
    };
    let (alone, alone_half) = orders(1);
    // A lone robot never waits: the rest of its time is the way.
    let way_secs = 3600.0 / alone - services.mean_secs;
    let (mut queue, mut expected) = (0.0, 0.0);
    for robots in 1..=ROBOTS {
        let response = services.mean_secs * (1.0 + queue);
        let rate = f64::from(robots) / (way_secs + response);
        (queue, expected) = (rate * response, rate * 3600.0);
    }
    let (measured, half_width) = orders(ROBOTS);
    let error = half_width + alone_half * expected / alone / f64::from(ROBOTS);
    assert!(
        (measured - expected).abs() <= error,
        "{measured} ± {half_width} orders an hour, by mean value analysis {expected}"
    );
}
