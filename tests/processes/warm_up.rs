//! Runs that begin with a warm-up.

use std::fmt::Write as _;
use std::fs;

use regatta_plugin::FleetName;

use crate::fleet::{graphs, regatta, unique};

/// The warm-up of a test, in simulated seconds.
const WARM_UP_SECS: f64 = 40.0;

/// Runs sixty robots under the manager, with a warm-up and more arguments, and returns the lines on
/// standard output.
fn run(name: &FleetName, args: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = folder.path().join("warm.yaml");
    let mut text = String::new();
    let graph = graphs("warehouse.yaml");
    writeln!(text, "graph: {}\nrate: 50\nwarm_up: {WARM_UP_SECS}", graph.display()).expect("text");
    text += "robot_types: [{name: amr, length: 0.9, width: 0.6, max_speed: 1.5}]\n\
             robots: [{count: 60, routes: none}]\n\
             load: {per_hour: 3000, dwell: {min: 1, max: 2}}\n\
             plugins: [{name: fleet-manager, args: [--no-http]}]\nviewer: off\n";
    fs::write(&scenario, text).expect("written");
    let mut command = regatta();
    command.arg("run").arg(&scenario).args(["--fleet", name.as_str()]).args(args);
    let output = command.output().expect("regatta starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

/// The simulated seconds of a status line.
fn secs(line: &str) -> Option<f64> {
    line.strip_prefix("t ")?.split_whitespace().next()?.parse().ok()
}

/// The line of a table with a name.
fn figure<'a>(lines: &'a [String], name: &str) -> &'a str {
    lines.iter().find(|line| line.starts_with(name)).map_or("", String::as_str)
}

#[test]
fn the_first_status_is_that_of_a_fleet_at_work_which_goes_on_in_real_time() {
    let lines = run(&unique("warm-up"), &["--for", "3s"]);
    let times: Vec<f64> = lines.iter().filter_map(|line| secs(line)).collect();
    assert!(times.first().is_some_and(|first| *first >= WARM_UP_SECS), "{lines:?}");
    let last = times.last().expect("a status");
    assert!((WARM_UP_SECS + 1.0..WARM_UP_SECS + 5.0).contains(last), "in real time: {lines:?}");
    let first = lines.iter().find(|line| secs(line).is_some()).expect("a status");
    assert!(first.contains("driving ") || first.contains("fetching "), "{first}");
    // The manager gets frames after the warm-up, too.
    let managed = figure(&lines, "robots  ");
    let managed = managed.split_whitespace().nth(3).and_then(|secs| secs.parse::<f64>().ok());
    assert!(managed.is_some_and(|secs| secs > WARM_UP_SECS + 1.0), "{lines:?}");
}

#[test]
fn a_warm_up_repeats_and_can_be_left_out() {
    let args = ["--simulated", "40s"];
    let names = ["warm-up-one", "warm-up-two"].map(unique);
    let [one, other] = names.each_ref().map(|name| run(name, &args));
    for name in ["orders", "driven", "robots' time"] {
        assert!(!figure(&one, name).is_empty(), "{one:?}");
        assert_eq!(figure(&one, name), figure(&other, name), "the same in every run");
    }
    let cold = run(&unique("warm-up-none"), &["--warm-up", "0", "--for", "1s"]);
    let first = cold.iter().find_map(|line| secs(line)).expect("a status");
    assert!(first < WARM_UP_SECS, "{cold:?}");
}
