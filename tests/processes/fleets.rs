//! The life of fleets: `regatta list` and `regatta stop`; engines that are killed, restarted,
//! interrupted, or started twice.

use regatta_plugin::FleetName;
use regatta_plugin::health::services_of;
use rustix::process::Signal;
use serde_json::{Value, json};

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};

/// Returns a fleet's entry in `regatta list --json`.
fn listed(fleet: &FleetName) -> Option<Value> {
    let output = regatta().args(["list", "--json"]).output().expect("regatta starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let list: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    list.as_array().expect("a list").iter().find(|entry| entry["fleet"] == fleet.as_str()).cloned()
}

fn command(args: &[&str], fleet: &FleetName) -> std::process::Output {
    regatta().args(args).args(["--fleet", fleet.as_str()]).output().expect("regatta starts")
}

#[test]
fn list_shows_who_produces_a_fleet_and_how_it_is() {
    let fleet = Fleet::start("list", "thirty.yaml", &["--rate", "50"]);
    let pid = fleet.engine.0.id();
    let entry = eventually("the first tick", || {
        listed(&fleet.name).filter(|entry| !entry["rate_hz"].is_null())
    });
    let name = fleet.name.as_str();
    let expected = json!({
        "fleet": name, "producer": "engine", "pid": pid, "robots": 30, "rate_hz": 50.0,
        "state": "running",
    });
    assert_eq!(entry, expected);
    assert!(command(&["pause"], &fleet.name).status.success());
    assert_eq!(listed(&fleet.name).expect("listed")["state"], "paused");
    let output = regatta().arg("list").output().expect("regatta starts");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = table.lines().find(|line| line.starts_with(name)).expect("the fleet's line");
    assert!(
        table.starts_with("FLEET") && line.contains("50 Hz") && line.ends_with("paused"),
        "{table}"
    );

    fleet.engine.signal(Signal::STOP);
    assert_eq!(listed(&fleet.name).expect("listed")["state"], "no answer");
    fleet.engine.signal(Signal::CONT);
}

#[test]
fn list_shows_readers_that_wait_for_a_producer() {
    let name = unique("list-waiting");
    let _reader = Process::start(regatta().args(["plugin", "hello", "--fleet", name.as_str()]));
    let entry = eventually("the reader is listed", || listed(&name));
    assert_eq!((&entry["state"], &entry["pid"]), (&json!("no producer"), &Value::Null));
}

#[test]
fn stop_ends_a_whole_run_with_success() {
    let name = unique("stop");
    let run = Process::start(
        regatta().arg("run").arg(graphs("thirty.yaml")).args(["--fleet", name.as_str()]),
    );
    eventually("the run is listed", || listed(&name).filter(|entry| entry["state"] == "running"));
    let output = command(&["stop"], &name);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), format!("fleet '{name}' has ended\n"));
    let run = run.finish();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    // A list that another test makes may hold its services a moment longer.
    eventually("it isn't listed any more", || listed(&name).is_none().then_some(()));
    assert!(!command(&["stop"], &name).status.success(), "nothing is left to stop");
}

#[test]
fn a_reader_continues_when_the_engine_is_killed_and_restarted() {
    let fleet = Fleet::start("restart", "thirty.yaml", &[]);
    let mut reader = fleet.subscriber();
    let first =
        eventually("a frame", || reader.latest().expect("readable").map(|frame| frame.run_id()));
    let plugin = fleet.plugin("hello");

    let name = fleet.name.clone();
    fleet.engine.signal(Signal::KILL);
    assert!(!fleet.engine.finish().status.success());
    let fleet = Fleet::restart(name, "thirty.yaml", &[]);
    let second = eventually("a frame of the new run", || {
        reader.latest().expect("readable").map(|frame| frame.run_id()).filter(|run| *run != first)
    });
    assert_ne!(first, second);
    fleet.let_ticks_pass(50);
    let output = plugin.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_second_engine_of_the_same_fleet_is_refused() {
    let fleet = Fleet::start("second", "thirty.yaml", &[]);
    let mut command = regatta();
    command.arg("engine").arg(graphs("thirty.yaml")).args(["--fleet", &fleet.name.to_string()]);
    let output = Process::start(&mut command).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success());
    assert!(message.contains(&fleet.name.to_string()) && message.lines().count() == 1, "{message}");
    fleet.let_ticks_pass(10);
}

#[test]
fn ctrl_c_leaves_nothing_in_shared_memory() {
    let fleet = Fleet::start("ctrl-c", "thirty.yaml", &[]);
    let name = fleet.name.clone();
    let plugin = fleet.plugin("hello");
    fleet.let_ticks_pass(10);
    assert!(!services_of(&name).expect("listable").is_empty());
    assert!(fleet.engine.interrupt().status.success());
    assert!(plugin.interrupt().status.success());
    let left = services_of(&name).expect("listable");
    assert!(left.is_empty(), "{left:?}");
}
