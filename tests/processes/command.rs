//! `regatta command` and `regatta robots break|repair`: commands from the command line.

use std::process::Output;

use regatta_plugin::Subscriber;
use regatta_plugin::frame::RobotState;
use tempfile::TempDir;

use crate::fleet::{Fleet, eventually, regatta, unique};

/// Starts an engine with a robot that stands on node 1 of a square, whose node 3 is called `far`.
fn square(test: &str, folder: &TempDir) -> Fleet {
    let graph = crate::fleet::graphs("square.yaml");
    let path = folder.path().join("square.yaml");
    let text =
        format!("graph: {}\nnodes: {{3: {{name: far}}}}\nrobots:\n- node: 1\n", graph.display());
    std::fs::write(&path, text).expect("written");
    Fleet::restart(unique(test), path.to_str().expect("a path"), &[])
}

fn command(fleet: &Fleet, arguments: &[&str]) -> Output {
    let mut command = regatta();
    command.args(arguments).args(["--fleet", &fleet.name.to_string()]);
    command.output().expect("the program starts")
}

fn accepted(fleet: &Fleet, arguments: &[&str]) -> String {
    let output = command(fleet, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

fn refused(fleet: &Fleet, arguments: &[&str]) -> String {
    let output = command(fleet, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).trim().to_owned()
}

/// Waits until the first robot is in a state.
fn wait_for(fleet: &Fleet, state: RobotState) {
    let mut frames = Subscriber::open(&fleet.name).expect("opened");
    eventually("the state", || {
        let frame = frames.latest().expect("readable")?;
        (frame.state_of(0) == state).then_some(())
    });
}

#[test]
fn commands_are_sent_and_their_answers_printed() {
    let folder = TempDir::new().expect("a folder");
    let fleet = square("command", &folder);
    accepted(&fleet, &["command", "hold", "0"]);
    wait_for(&fleet, RobotState::Held);
    assert_eq!(accepted(&fleet, &["command", "assign", "0", "far"]), "accepted: robot 0");
    accepted(&fleet, &["robots", "break", "0"]);
    wait_for(&fleet, RobotState::Broken);
    accepted(&fleet, &["command", "resume", "0"]);
    accepted(&fleet, &["robots", "repair", "0"]);
    wait_for(&fleet, RobotState::Idle);
    assert_eq!(accepted(&fleet, &["command", "spawn", "1"]), "accepted: robot 1");
    accepted(&fleet, &["command", "assign", "1", "--edges", "1,11"]);
    accepted(&fleet, &["command", "remove", "1"]);
    assert!(fleet.engine.interrupt().status.success());
}

#[test]
fn a_refused_command_says_why() {
    let folder = TempDir::new().expect("a folder");
    let fleet = square("command-refused", &folder);
    for (arguments, reason) in [
        (&["command", "hold", "9"][..], "there is no robot 9"),
        (&["command", "assign", "9", "far"], "there is no robot 9"),
        (&["command", "assign", "0", "nowhere"], "no node has the id or the name 'nowhere'"),
        (&["command", "assign", "0", "--edges", "99"], "there is no edge 99"),
        (&["command", "release", "0", "1", "2.5"], "not ahead"),
    ] {
        let found = refused(&fleet, arguments);
        assert!(found.contains(reason) && found.lines().count() == 1, "{arguments:?}: {found}");
    }
    assert!(fleet.engine.interrupt().status.success());
}
