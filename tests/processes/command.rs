//! `regatta command` and `regatta robots break|repair`: commands to robots, and requests to the
//! fleet manager.

use std::process::Output;

use regatta_plugin::frame::RobotState;
use regatta_plugin::{Subscriber, WorldReader};
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};

/// Starts an engine with a robot that stands on node 1 of a square, whose node 3 is called `far`.
fn square(test: &str, folder: &TempDir) -> Fleet {
    let graph = graphs("square.yaml");
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
    accepted(&fleet, &["command", "assign", "1", "--edges", "1..2,11"]);
    accepted(&fleet, &["command", "close", "4..5"]);
    accepted(&fleet, &["command", "open", "4..5"]);
    assert_eq!(accepted(&fleet, &["command", "spawn", "--edge", "far..4"]), "accepted: robot 2");
    accepted(&fleet, &["command", "remove", "2"]);
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
        (&["command", "close", "far..1"], "no edge leads from node far to node 1"),
        (&["command", "open", "elsewhere"], "there is no edge elsewhere"),
        (&["command", "release", "0", "1", "2.5"], "not ahead"),
    ] {
        let found = refused(&fleet, arguments);
        assert!(found.contains(reason) && found.lines().count() == 1, "{arguments:?}: {found}");
    }
    assert!(fleet.engine.interrupt().status.success());
}

/// Returns what a subcommand of `regatta command` prints.
fn answer(fleet: &Fleet, arguments: &[&str]) -> String {
    let output = command(fleet, &[&["command"], arguments].concat());
    let text = if output.status.success() { output.stdout } else { output.stderr };
    String::from_utf8(text).expect("UTF-8").trim().to_owned()
}

/// A warehouse with robots that nobody moves yet.
fn warehouse() -> (TempDir, Fleet) {
    let folder = TempDir::new().expect("a folder");
    let scenario = format!(
        "graph: {}\nrate: 50\npublish_rate: 10\nseed: 3\n\
         robot_types:\n- {{name: amr, length: 0.9, width: 0.6}}\n\
         robots:\n- {{count: 20, routes: none}}\n",
        graphs("warehouse.yaml").display()
    );
    let path = folder.path().join("scenario.yaml");
    std::fs::write(&path, scenario).expect("written");
    let fleet =
        Fleet::restart(unique("requests"), path.to_str().expect("a path"), &["--speed", "8"]);
    (folder, fleet)
}

#[test]
fn a_manager_sends_robots_on_request() {
    let (folder, fleet) = warehouse();
    let nobody = answer(&fleet, &["send", "3", "12"]);
    assert!(nobody.contains("has no fleet manager that takes requests"), "{nobody}");

    let mut worlds = WorldReader::open(&fleet.name).expect("a reader");
    let (node, place) = eventually("a world", || {
        let world = worlds.latest().expect("readable")?;
        let node = world.nodes()[world.nodes().len() / 2];
        Some((node.id, [node.x, node.y]))
    });
    let load = folder.path().join("load.yaml");
    std::fs::write(&load, "load: {seed: 5, endless: robots, dwell: 2}\n").expect("written");
    let mut manager = regatta();
    manager.args(["plugin", "fleet-manager", "--fleet", fleet.name.as_str(), "--load"]).arg(&load);
    let manager = Process::start(&mut manager);
    let goal = node.to_string();
    eventually("the manager takes it", || {
        answer(&fleet, &["send", "3", &goal]).starts_with("accepted").then_some(())
    });
    let mut frames = fleet.subscriber();
    eventually("robot 3 is there", || {
        let frame = frames.latest().expect("readable")?;
        let [x, y] = [frame.x()[3] - place[0], frame.y()[3] - place[1]];
        // It stops only for a moment, and a busy machine shows this test few of its frames.
        (x.hypot(y) < 3.0).then_some(())
    });
    let over = eventually("it goes on", || {
        let text = answer(&fleet, &["recall", "3"]);
        text.contains("was not sent anywhere").then_some(text)
    });
    assert!(!over.contains('\n'), "{over}");
    for (arguments, reason) in [
        (&["send", "20", "12"][..], "there is no robot 20"),
        (&["send", "3", "no-such-node"], "no-such-node"),
        (&["recall", "20"], "robot 20 was not sent anywhere"),
    ] {
        let text = answer(&fleet, arguments);
        assert!(text.contains(reason) && !text.contains('\n'), "{text}");
    }

    // Also while the clock is paused, and undone before anything has moved.
    fleet.control(&["pause"]);
    assert!(answer(&fleet, &["send", "5", &goal]).starts_with("accepted"));
    assert_eq!(answer(&fleet, &["recall", "5"]), "accepted");
    assert!(manager.interrupt().status.success() && fleet.engine.interrupt().status.success());
}
