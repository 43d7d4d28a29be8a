//! Runs that begin with a warm-up.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use regatta_plugin::frame::ClockState;
use regatta_plugin::{FleetName, Subscriber};

use crate::fleet::{Process, eventually, graphs, regatta, unique};

/// The warm-up of a test, in simulated seconds.
const WARM_UP_SECS: f64 = 40.0;

/// Runs sixty robots under the manager, with a warm-up and more arguments, and returns the lines on
/// standard output.
fn run(name: &FleetName, args: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), "");
    let mut command = regatta();
    command.arg("run").arg(&scenario).args(["--fleet", name.as_str()]).args(args);
    let output = command.output().expect("regatta starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

/// Writes the scenario of sixty robots under the manager, with a warm-up and more plugins, and
/// returns its path.
fn scenario(folder: &Path, plugins: &str) -> PathBuf {
    let path = folder.join("warm.yaml");
    let mut text = String::new();
    let graph = graphs("warehouse.yaml");
    writeln!(text, "graph: {}\nrate: 50\nwarm_up: {WARM_UP_SECS}", graph.display()).expect("text");
    text += "robot_types: [{name: amr, length: 0.9, width: 0.6, max_speed: 1.5}]\n\
             robots: [{count: 60, routes: none}]\n\
             load: {per_hour: 3000, dwell: {min: 1, max: 2}}\n\
             viewer: off\n";
    writeln!(text, "plugins: [{{name: fleet-manager, args: [--no-http]}}{plugins}]").expect("text");
    fs::write(&path, text).expect("written");
    path
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

#[test]
fn a_recording_begins_at_the_end_of_the_warm_up_with_all_that_a_late_reader_would_know() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("warm.mcap");
    let recorder = format!(", {{name: record, args: [-o, {}]}}", file.display());
    let scenario = scenario(folder.path(), &recorder);
    let name = unique("warm-up-recorded");
    let mut command = regatta();
    command.arg("run").arg(&scenario).args(["--fleet", name.as_str(), "--for", "2s"]);
    let output = command.output().expect("regatta starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.contains("no frame lost"), "{errors}");
    let table = folder.path().join("warm.csv");
    let exported = regatta().arg("export").arg(&file).arg("-o").arg(&table).output();
    assert!(exported.expect("regatta starts").status.success());
    let text = fs::read_to_string(table).expect("a table");
    let mut rows = text.lines();
    let header: Vec<&str> = rows.next().expect("a header").split(',').collect();
    let first: Vec<&str> = rows.next().expect("a row").split(',').collect();
    let value = |name: &str| header.iter().position(|column| *column == name).map(|at| first[at]);
    let begin = value("time_s").and_then(|secs| secs.parse::<f64>().ok());
    assert_eq!(begin, Some(WARM_UP_SECS), "{header:?} {first:?}");
    assert_eq!(value("type"), Some("0"), "a column that was published once: {first:?}");
    assert!(value("activity").is_some_and(|activity| !activity.is_empty()), "{first:?}");
}

#[test]
fn frames_of_the_warm_up_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), "");
    let name = unique("warm-up-told");
    let mut command = regatta();
    command.arg("run").arg(&scenario).args(["--fleet", name.as_str()]);
    let process = Process::start(&mut command);
    let mut frames = eventually("the fleet can be read", || Subscriber::open(&name).ok());
    let mut warm_up_frames = 0;
    let first = eventually("the run begins", || {
        let frame = frames.wait(Duration::from_secs(1)).expect("readable")?;
        let header = *frame.header();
        warm_up_frames += u32::from(header.is_warm_up());
        (!header.is_warm_up()).then_some(header)
    });
    assert!(warm_up_frames > 0 && first.clock == ClockState::Running as u32);
    assert!(first.sim_time_nanos as f64 >= WARM_UP_SECS * 1e9, "{first:?}");
    assert!(process.interrupt().status.success());
}
