//! The plugin `traffic` on real engines, in lockstep.

use std::fs;
use std::path::Path;

use regatta_plugin::{HistoryReader, Participant, TrafficReader};

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};

/// Runs a shipped scenario for 600 ticks, a minute, and returns what the plugin prints and the
/// figures of all edges.
fn counted(test: &str, scenario: &str, folder: &Path) -> (String, serde_json::Value, String) {
    let fleet = unique(test).to_string();
    let (csv, json) = (folder.join("traffic.csv"), folder.join("traffic.json"));
    let mut plugin = regatta();
    plugin
        .args(["plugin", "traffic", "--summary", "--fleet", &fleet])
        .arg("--csv")
        .arg(&csv)
        .arg("--json")
        .arg(&json);
    plugin.arg("--parquet").arg(folder.join("traffic.parquet"));
    let plugin = Process::start(&mut plugin);
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(graphs(scenario))
        .args(["--fleet", &fleet, "--rate", "10", "--ticks", "600"]);
    let output = Process::start(engine.args(["--speed", "max", "--lockstep", "traffic"])).finish();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = plugin.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json = serde_json::from_slice(&fs::read(json).expect("readable")).expect("JSON");
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        json,
        fs::read_to_string(csv).expect("readable"),
    )
}

#[test]
fn every_robot_counts_on_one_edge_at_a_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let (summary, json, csv) = counted("traffic", "thirty.yaml", folder.path());
    assert_eq!(json["secs"], 60.0);
    let edges = json["edges"].as_array().expect("edges");
    let sum = |key: &str| edges.iter().filter_map(|edge| edge[key].as_f64()).sum::<f64>();
    assert!((sum("occupancy") - 30.0).abs() < 1e-3, "thirty robots: {}", sum("occupancy"));
    assert!(
        sum("entered_per_hour") > 60.0 && sum("contact_secs") == 0.0,
        "no collision checker runs"
    );
    assert!(
        edges
            .iter()
            .all(|edge| (0.0..=1.001).contains(&edge["relative_speed"].as_f64().expect("a speed")))
    );
    assert_eq!(csv.lines().count(), edges.len() + 1);
    let parquet = fs::read(folder.path().join("traffic.parquet")).expect("readable");
    assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1"));
    assert!(summary.starts_with("traffic in 60 s"), "{summary}");
    let again = counted("traffic-again", "thirty.yaml", folder.path());
    assert_eq!((again.1, again.2), (json, csv), "a run in lockstep repeats");
}

#[test]
fn a_fleet_has_one_traffic_plugin_and_files_that_can_be_written() {
    let fleet = Fleet::start("traffic-live", "thirty.yaml", &[]);
    let _first = fleet.plugin("traffic");
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut reader = TrafficReader::open_on(&participant).expect("a reader");
    let robots = eventually("traffic", || {
        let traffic = reader
            .latest()
            .expect("readable")
            .filter(|traffic| traffic.header.period_secs[2] > 1.0)?;
        Some(traffic.periods[0].iter().map(|edge| edge.occupancy).sum::<f32>())
    });
    assert!((robots - 30.0).abs() < 1e-3, "{robots} robots at a time");
    let routes = eventually("routes", || {
        let traffic =
            reader.latest().expect("readable").filter(|traffic| traffic.header.has_routes == 1)?;
        let sum = traffic.periods[0].iter().map(|edge| edge.released + edge.planned).sum::<f32>();
        (sum > 0.0).then_some(sum)
    });
    assert!(routes.is_finite(), "routes over all edges: {routes}");
    // Whoever comes later knows the run from the time on at which the plugin began.
    let mut history = HistoryReader::open_on(&participant).expect("a reader");
    let (began, samples) = eventually("the history", || {
        history.update().expect("readable");
        let (header, samples) = history.samples()?;
        history.spots()?;
        Some((header.began_nanos as f64 * 1e-9, samples.to_vec()))
    });
    let (first, last) = (samples[0], samples[samples.len() - 1]);
    assert!(
        first.secs <= began + 1.0 && last.secs - first.secs > 1.0,
        "{began} s: {} to {} s",
        first.secs,
        last.secs
    );
    assert_eq!((last.robots(), last.touching()), (30, None), "nobody checks for contacts");
    let second =
        Process::start(regatta().args(["plugin", "traffic", "--fleet", &fleet.name.to_string()]))
            .finish();
    let error = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(
        !second.status.success()
            && error.contains("already published by")
            && error.lines().count() == 1,
        "{error}"
    );
    let output =
        Process::start(regatta().args(["plugin", "traffic", "--csv", "/missing/folder/file.csv"]))
            .finish();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && error.contains("/missing/folder/file.csv"), "{error}");
}
