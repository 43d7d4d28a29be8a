//! Engines that are killed, restarted, interrupted, or started twice.

use crate::fleet::{Fleet, Process, eventually, graphs, regatta};
use rustix::process::Signal;

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
    let services = || regatta_plugin::health::services_of(&name).expect("listable");
    fleet.let_ticks_pass(10);
    assert!(!services().is_empty());
    assert!(fleet.engine.interrupt().status.success());
    assert!(plugin.interrupt().status.success());
    let left = services();
    assert!(left.is_empty(), "{left:?}");
}
