//! The fleet manager on real engines: no contact, no order lost, and runs that repeat.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use regatta_plugin::FleetName;
use rustix::process::Signal;

use crate::fleet::{Process, eventually, graphs, regatta, unique};

/// Writes a scenario of robots that wait for orders, and a load that keeps them busy.
fn scenario(folder: &Path, robots: usize, robot_type: &str) -> PathBuf {
    let graph = graphs("warehouse.yaml");
    let text = format!(
        "graph: {}\nrate: 50\npublish_rate: 10\nseed: 3\n\
         robot_types:\n- {{name: amr, length: 0.9, width: 0.6{robot_type}}}\n\
         robots:\n- {{count: {robots}, routes: none}}\n",
        graph.display()
    );
    std::fs::write(folder.join("load.yaml"), "load: {seed: 5, endless: robots, dwell: 2}\n")
        .expect("written");
    let path = folder.join("scenario.yaml");
    std::fs::write(&path, text).expect("written");
    path
}

fn manager(fleet: &FleetName, folder: &Path, args: &[&str]) -> Process {
    let fleet = fleet.to_string();
    let load = folder.join("load.yaml");
    let mut command = regatta();
    command
        .args(["plugin", "fleet-manager", "--summary", "--fleet", &fleet, "--load"])
        .arg(load)
        .args(args);
    Process::start(&mut command)
}

fn validator(fleet: &FleetName) -> Process {
    // Robots without an order are no fault of a manager that has as many orders as robots, now and
    // then.
    let args = ["plugin", "validator", "--after", "fleet-manager", "--fleet"];
    Process::start(regatta().args(args).arg(fleet.to_string()))
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

fn finished(summary: &str) -> u64 {
    let line = summary.lines().find(|line| line.starts_with("orders ")).unwrap_or_default();
    line.split_whitespace()
        .nth(1)
        .and_then(|number| number.replace(",", "").parse().ok())
        .unwrap_or(0)
}

/// The part of the robots' time with an activity, in per cent, as a summary has it.
fn share(summary: &str, activity: &str) -> f64 {
    let after = summary.split_once(&format!("{activity} ")).map_or("", |(_, rest)| rest);
    after.split_whitespace().next().and_then(|number| number.parse().ok()).unwrap_or(0.0)
}

/// Runs a managed fleet in lockstep for five minutes; returns the digest of its frames.
fn managed_run(test: &str, robots: usize, robot_type: &str, args: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), robots, robot_type);
    let fleet = unique(test);
    let (manager, validator) = (manager(&fleet, folder.path(), &[]), validator(&fleet));
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(scenario)
        .args(["--ticks", "15000", "--speed", "max", "--digest", "--fleet"]);
    engine
        .arg(fleet.to_string())
        .args(["--lockstep", "fleet-manager", "--lockstep", "validator"])
        .args(args);
    let engine = Process::start(&mut engine).finish();
    assert!(engine.status.success(), "{}", text(&engine));
    let (summary, verdict) = (text(&manager.interrupt()), validator.interrupt());
    assert!(verdict.status.success(), "{}", text(&verdict));
    assert!(finished(&summary) > robots as u64, "{summary}");
    let digest = String::from_utf8(engine.stdout).expect("a digest");
    assert_eq!(digest.trim().len(), 32, "{digest}");
    digest
}

#[test]
fn a_managed_fleet_has_no_contact_and_repeats_bit_by_bit() {
    let first = managed_run("managed-once", 120, "", &["--threads", "1"]);
    let second = managed_run("managed-again", 120, "", &["--threads", "2"]);
    assert_eq!(first, second);
}

#[test]
fn robots_with_acceleration_limits_have_no_contact_either() {
    managed_run("managed-limited", 120, ", max_speed: 1.5, max_acceleration: 0.8", &[]);
}

#[test]
fn a_killed_manager_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), 80, ", max_acceleration: 0.8");
    let fleet = unique("managed-killed");
    let validator = validator(&fleet);
    let store = folder.path().join("orders.sqlite");
    let store = ["--store", store.to_str().expect("a path")];
    let first = manager(&fleet, folder.path(), &store);
    let mut engine = regatta();
    engine.arg("engine").arg(scenario).args(["--speed", "10", "--fleet"]).arg(fleet.to_string());
    let engine = Process::start(&mut engine);
    wait_until(&fleet, 90.0);
    first.signal(Signal::KILL);
    drop(first);
    wait_until(&fleet, 110.0);
    let second = manager(&fleet, folder.path(), &store);
    wait_until(&fleet, 360.0);
    let summary = text(&second.interrupt());
    let verdict = validator.interrupt();
    assert!(engine.interrupt().status.success());
    assert!(verdict.status.success(), "{}\n{summary}", text(&verdict));
    assert!(finished(&summary) > 80, "{summary}");
}

#[test]
fn readers_that_are_held_up_lose_no_event_and_no_entry_of_the_order_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), 80, "");
    let fleet = unique("held-up");
    let recording = folder.path().join("run.mcap");
    let mut recorder = regatta();
    recorder.arg("record").arg("-o").arg(&recording).args(["--fleet", fleet.as_str()]);
    let manager = manager(&fleet, folder.path(), &[]);
    let (recorder, validator) = (Process::start(&mut recorder), validator(&fleet));
    let mut engine = regatta();
    engine.arg("engine").arg(scenario).args(["--speed", "10", "--fleet", fleet.as_str()]);
    let engine = Process::start(&mut engine);
    wait_until(&fleet, 30.0);
    // Half a second is 250 ticks, almost all of which have events.
    for process in [&manager, &recorder, &validator] {
        process.signal(Signal::STOP);
        std::thread::sleep(std::time::Duration::from_millis(500));
        process.signal(Signal::CONT);
        std::thread::sleep(std::time::Duration::from_millis(500));
    }
    assert!(engine.interrupt().status.success());
    let (manager, recorder) = (text(&manager.interrupt()), text(&recorder.interrupt()));
    let verdict = text(&validator.interrupt());
    assert!(!manager.contains("ticks lost"), "{manager}");
    assert!(!recorder.contains("other messages lost"), "{recorder}");
    assert!(!verdict.contains("samples of the order log missed"), "{verdict}");
    assert!(!verdict.contains("ticks lost"), "{verdict}");
}

/// Ten robots on `porto.yaml` for ten minutes, in lockstep under the validator; returns how many
/// orders were finished.
fn drive_porto(test: &str, manager: &mut Command) -> u64 {
    let folder = tempfile::tempdir().expect("a folder");
    let (scenario, load) = (folder.path().join("scenario.yaml"), folder.path().join("load.yaml"));
    let graph = graphs("porto.yaml");
    let description = format!(
        "graph: {}\nrate: 20\npublish_rate: 10\nseed: 3\n\
         robot_types:\n- {{name: amr, length: 0.9, width: 0.6}}\n\
         robots:\n- {{count: 10, routes: none}}\n",
        graph.display()
    );
    std::fs::write(&scenario, description).expect("written");
    std::fs::write(&load, "load: {seed: 5, endless: robots}\n").expect("written");
    let fleet = unique(test);
    let manager = Process::start(
        manager.args(["--summary", "--fleet"]).arg(fleet.to_string()).arg("--load").arg(load),
    );
    let validator = validator(&fleet);
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(&scenario)
        .args(["--ticks", "12000", "--speed", "max", "--fleet"])
        .arg(fleet.to_string());
    engine.args(["--lockstep", "fleet-manager", "--lockstep", "validator"]);
    let engine = Process::start(&mut engine).finish();
    assert!(engine.status.success(), "{}", text(&engine));
    let (summary, verdict) = (text(&manager.interrupt()), validator.interrupt());
    assert!(verdict.status.success(), "{}\n{summary}", text(&verdict));
    finished(&summary)
}

#[test]
fn every_planner_drives_the_engine() {
    for (planner, fewest) in [("lanes", 40), ("tea", 40), ("pibt", 20)] {
        let mut manager = regatta();
        let orders =
            drive_porto(planner, manager.args(["plugin", "fleet-manager", "--planner", planner]));
        assert!(orders >= fewest, "{planner}: {orders} orders");
    }
}

#[test]
fn a_planner_of_a_users_own_drives_the_engine() {
    // An example of the fleet manager's crate, which is built beside the tests.
    let program =
        Path::new(env!("CARGO_BIN_EXE_regatta")).with_file_name("examples").join("own_planner");
    let mut manager = Command::new(program);
    manager.env("REGATTA_PLUGIN_NAME", "fleet-manager");
    let orders = drive_porto("own-planner", &mut manager);
    assert!(orders >= 20, "{orders} orders");
}

#[test]
fn robots_with_small_batteries_charge_in_time() {
    let fleet = unique("managed-charging");
    let name = fleet.to_string();
    let scenario = graphs("warehouse-charging.yaml");
    let mut manager = regatta();
    manager
        .args(["plugin", "fleet-manager", "--summary", "--fleet", &name, "--load"])
        .arg(&scenario);
    let (manager, validator) = (Process::start(&mut manager), validator(&fleet));
    let mut engine = regatta();
    // An hour, in which every battery lasts for forty minutes of driving at most.
    engine
        .arg("engine")
        .arg(scenario)
        .args(["--rate", "10", "--ticks", "36000", "--speed", "max", "--fleet", &name]);
    engine.args(["--lockstep", "fleet-manager", "--lockstep", "validator"]);
    let engine = Process::start(&mut engine).finish();
    assert!(engine.status.success(), "{}", text(&engine));
    let (summary, verdict) = (text(&manager.interrupt()), validator.interrupt());
    assert!(verdict.status.success(), "{}\n{summary}", text(&verdict));
    assert!(finished(&summary) > 600, "{summary}");
    // At chargers, too, and not only on the way to one.
    assert!(share(&summary, "charging") > 5.0, "{summary}");
}

/// Waits until a fleet has reached a simulated time in seconds.
fn wait_until(fleet: &FleetName, secs: f64) {
    eventually("simulated time passes", || {
        (status(fleet)?["sim_time_secs"].as_f64()? > secs).then_some(())
    });
}

fn status(fleet: &FleetName) -> Option<serde_json::Value> {
    let output =
        regatta().args(["status", "--json", "--fleet", &fleet.to_string()]).output().ok()?;
    serde_json::from_slice(&output.stdout).ok()
}

#[test]
fn a_second_manager_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), 10, "");
    let fleet = unique("managed-twice");
    let engine = Process::start(
        regatta().arg("engine").arg(scenario).args(["--fleet"]).arg(fleet.to_string()),
    );
    let first = manager(&fleet, folder.path(), &[]);
    eventually("the first manager steers", || {
        (status(&fleet)?["robots_by_state"]["driving"].as_u64()? > 0).then_some(())
    });
    let output = manager(&fleet, folder.path(), &["--name", "another"]).finish();
    assert!(!output.status.success());
    let (text, owner) = (text(&output), first.0.id().to_string());
    assert!(text.contains("has a fleet manager already") && text.contains(&owner), "{text}");
    first.interrupt();
    engine.interrupt();
}

/// Runs `regatta command` for robot 0.
fn command(fleet: &FleetName, args: &[&str]) -> Output {
    regatta()
        .arg("command")
        .args(args)
        .args(["--fleet", &fleet.to_string()])
        .output()
        .expect("regatta runs")
}

#[test]
fn a_manager_owns_the_movement_of_its_fleet_until_it_is_killed() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario(folder.path(), 10, "");
    let fleet = unique("managed-owned");
    let engine = Process::start(
        regatta().arg("engine").arg(scenario).args(["--fleet"]).arg(fleet.to_string()),
    );
    let manager = manager(&fleet, folder.path(), &[]);
    let owner = format!("fleet-manager (process {})", manager.0.id());
    eventually("the manager owns the fleet", || {
        (status(&fleet)?["owner"] == owner.as_str()).then_some(())
    });
    let node = ["assign", "0", "1"];
    for args in [&node[..], &["cancel", "0"], &["release", "0", "1", "inf"]] {
        let output = command(&fleet, args);
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains(&owner) && error.lines().count() == 1, "{args:?}: {error}");
    }
    for args in [["hold", "0"], ["resume", "0"], ["break", "1"], ["repair", "1"]] {
        assert!(command(&fleet, &args).status.success(), "{args:?}");
    }
    manager.signal(Signal::KILL);
    eventually("robots belong to nobody", || {
        command(&fleet, &["cancel", "0"]).status.success().then_some(())
    });
    assert!(status(&fleet).expect("a status")["owner"].is_null());
    engine.interrupt();
}
