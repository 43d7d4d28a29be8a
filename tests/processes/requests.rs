//! Requests to a real fleet manager: to send a robot somewhere, and to call it back.

use std::process::Output;

use regatta_plugin::WorldReader;

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};

fn command(fleet: &Fleet, arguments: &[&str]) -> Output {
    let mut command = regatta();
    command.arg("command").args(arguments).args(["--fleet", &fleet.name.to_string()]);
    command.output().expect("the program starts")
}

fn answer(fleet: &Fleet, arguments: &[&str]) -> String {
    let output = command(fleet, arguments);
    let text = if output.status.success() { output.stdout } else { output.stderr };
    String::from_utf8(text).expect("UTF-8").trim().to_owned()
}

/// A warehouse with robots that nobody moves yet.
fn fleet() -> (tempfile::TempDir, Fleet) {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = format!(
        "graph: {}\nrate: 50\npublish_rate: 10\nseed: 3\nrobot_types:\n- {{name: amr, length: 0.9, width: 0.6}}\n\
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
    let (folder, fleet) = fleet();
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
    let mut command = regatta();
    command
        .args(["plugin", "fleet-manager", "--fleet", &fleet.name.to_string(), "--load"])
        .arg(&load);
    let manager = Process::start(&mut command);
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
    assert!(
        regatta()
            .args(["pause", "--fleet", &fleet.name.to_string()])
            .status()
            .expect("it starts")
            .success()
    );
    assert!(answer(&fleet, &["send", "5", &goal]).starts_with("accepted"));
    assert_eq!(answer(&fleet, &["recall", "5"]), "accepted");
    assert!(manager.interrupt().status.success() && fleet.engine.interrupt().status.success());
}
