//! `regatta plugin ros2` on a real engine, with real nodes of ROS 2 (rclpy) and Cyclone DDS.

use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::Command;

use rustix::process::Signal;
use serde_json::{Value, json};

use crate::fleet::{Fleet, Process, eventually, regatta, root, unique};

/// Returns Python with rclpy; `None` if there is none, which a message says.
fn python(script: &str, domain: u16) -> Option<Command> {
    let Some(program) = std::env::var_os("REGATTA_ROS2_PYTHON") else {
        println!("skipped: REGATTA_ROS2_PYTHON names no Python with rclpy");
        return None;
    };
    let mut command = Command::new(program);
    command.arg(root().join("plugins/ros2/tests").join(script));
    command.env("ROS_DOMAIN_ID", domain.to_string()).env("PYTHONDONTWRITEBYTECODE", "1");
    // A node that is killed leaves its shared memory behind; it is of no use here.
    command.env("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4");
    Some(command)
}

/// A domain that no other test of this run uses, with ports below those of outgoing connections.
fn domain(number: u32) -> u16 {
    (1 + std::process::id() % 9 * 10 + number) as u16
}

/// Runs a script to its end, and returns the JSON that it prints.
fn run(mut script: Command) -> Value {
    let output = script.output().expect("Python starts");
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{messages}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {messages}"))
}

/// A fleet of two robots on a square, at its south and north.
fn square(test: &str, speed: &str) -> Fleet {
    let graph = root().join("graphs/square.yaml");
    let scenario = format!(
        "graph: {}\nrate: 50\nrobot_types:\n- {{name: amr, length: 0.8, width: 0.6, \
         max_rotation_speed: 1.5}}\nrobots:\n- {{node: 1}}\n- {{node: 5}}\n",
        graph.display()
    );
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.yaml", unique(test)));
    std::fs::write(&path, scenario).expect("written");
    Fleet::start(test, path.to_str().expect("a path"), &["--speed", speed])
}

fn plugin(fleet: &Fleet, domain: u16, args: &[&str]) -> Process {
    let mut command = regatta();
    command.args(["plugin", "ros2", "--fleet", fleet.name.as_str()]);
    Process::start(command.args(["--domain", &domain.to_string()]).args(args))
}

#[test]
fn nodes_see_the_fleet() {
    let domain = domain(0);
    let Some(mut listen) = python("listen.py", domain) else { return };
    let fleet = Fleet::start("ros2-see", "thirty.yaml", &[]);
    let map = root().join("graphs/imported/ros-map/turtlebot3_world.yaml");
    let plugin = plugin(&fleet, domain, &["--map", map.to_str().expect("a path")]);
    let found = run({
        listen.args(["8", "/regatta/map:nav_msgs/OccupancyGrid:latched"]);
        listen.args(["/clock:rosgraph_msgs/Clock", "/regatta/poses:geometry_msgs/PoseArray"]);
        listen.args([
            "/regatta/robot_3/odom:nav_msgs/Odometry",
            "/diagnostics:diagnostic_msgs/DiagnosticArray",
            "/regatta/graph:visualization_msgs/MarkerArray:latched",
            "/regatta/robots:visualization_msgs/MarkerArray:latched",
            "/regatta/routes:visualization_msgs/MarkerArray",
        ]);
        listen
    });
    let last = |topic: &str| &found["topics"][topic]["last"];
    let count = |topic: &str| found["topics"][topic]["count"].as_u64().expect("a count");
    assert!(count("/clock") > count("/regatta/poses") && count("/regatta/poses") > 10, "{found}");
    assert_eq!(last("/regatta/poses")["poses"][3], json!({"length": 30}));
    assert_eq!(last("/regatta/poses")["header"]["frame_id"], "map");
    assert_eq!(last("/regatta/robot_3/odom")["child_frame_id"], "regatta/robot_3");
    assert_eq!(last("/diagnostics")["status"][1]["message"], "30 robots");
    let graph = &last("/regatta/graph")["markers"];
    assert_eq!((&graph[0]["action"], &graph[1]["type"]), (&json!(3), &json!(5)), "{graph}");
    assert_eq!(last("/regatta/robots")["markers"][3], json!({"length": 11}));
    let body = &last("/regatta/robots")["markers"][1];
    assert!((body["scale"]["x"].as_f64().expect("metres") - 0.9).abs() < 1e-6, "{body}");
    assert!(count("/regatta/routes") > 0);
    assert_eq!(last("/regatta/map")["info"]["width"], 384);
    let nodes = found["nodes"].as_array().expect("nodes");
    assert!(nodes.contains(&json!(["regatta", "/regatta"])), "{nodes:?}");
    let output = plugin.interrupt();
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && messages.contains("has no passwords"), "{messages}");
}

#[test]
fn a_node_steers_a_robot_and_the_clock() {
    let domain = domain(1);
    let Some(mut steer) = python("steer.py", domain) else { return };
    let fleet = square("ros2-steer", "2");
    let plugin = plugin(&fleet, domain, &[]);
    let found = run({
        steer.args(["10", "8"]);
        steer
    });
    assert_eq!((&found["paused"], &found["resumed"]), (&json!(true), &json!(true)));
    assert_eq!(found["advance_while_paused"], 0.0);
    assert!(found["advance_at_speed_8"].as_f64().expect("seconds") > 4.0, "{found}");
    let log = &found["logs"][0];
    assert_eq!(*log, "goal of robot_0 refused: its frame is 'moon'; give a pose in the frame map");
    let messages = plugin.interrupt().stderr;
    let messages = String::from_utf8_lossy(&messages);
    assert_eq!(messages.matches("refused").count(), 1, "{messages}");
}

#[test]
fn a_manager_sends_robots_to_the_goals_of_nodes() {
    let domain = domain(2);
    let Some(mut steer) = python("steer.py", domain) else { return };
    let fleet = square("ros2-manager", "2");
    let _manager = fleet.plugin("fleet-manager");
    eventually("the manager moves the robots", || {
        fleet.status()["owner"].as_str().is_some_and(|it| it.contains("manager")).then_some(())
    });
    let _plugin = plugin(&fleet, domain, &[]);
    let found = run({
        steer.args(["10", "8"]);
        steer
    });
    assert_eq!(found["place"], json!([10.0, 8.0]), "{found}");
}

#[test]
fn tools_for_simulators_pause_step_and_spawn() {
    let domain = domain(3);
    let Some(mut simulate) = python("simulate.py", domain) else { return };
    let fleet = square("ros2-simulate", "2");
    let _plugin = plugin(&fleet, domain, &[]);
    let found = run({
        simulate.arg(domain.to_string());
        simulate
    });
    let code = |call: &str| found[call]["result"]["result"].as_u64();
    for (call, wanted) in [
        ("entities", 1),
        ("unknown_entity", 2),
        ("step_while_playing", 4),
        ("pause", 1),
        ("pause_again", 101),
        ("stop", 0),
        ("step", 1),
        ("play", 1),
        ("spawn", 1),
        ("spawn_far", 109),
        ("spawn_by_name", 102),
        ("delete", 1),
    ] {
        assert_eq!(code(call), Some(wanted), "{call}: {}", found[call]);
    }
    let states = [&found["paused"], &found["playing"]].map(|answer| &answer["state"]["state"]);
    assert_eq!(states, [&json!(2), &json!(1)]);
    assert!((found["stepped"].as_f64().expect("seconds") - 0.5).abs() < 1e-6, "{found}");
    assert_eq!(found["entities_by_pattern"]["entities"], json!(["robot_1"]));
    assert_eq!(found["spawn"]["entity_name"], "robot_2");
    let lists = ["entities_then", "entities_at_last"].map(|call| &found[call]["entities"]);
    assert_eq!(lists[0], &json!(["robot_0", "robot_1", "robot_2"]));
    assert_eq!(lists[1], &json!(["robot_0", "robot_1"]));
}

#[test]
fn a_client_of_nav2_navigates_to_a_pose() {
    let domain = domain(4);
    let Some(mut navigate) = python("navigate.py", domain) else { return };
    let fleet = square("ros2-navigate", "2");
    let _plugin = plugin(&fleet, domain, &[]);
    let found = run({
        navigate.args([&domain.to_string(), "10", "8"]);
        navigate
    });
    let accepted = ["accepted", "refused", "second_accepted"].map(|key| &found[key]);
    assert_eq!(accepted, [&json!(true), &json!(false), &json!(true)], "{found}");
    let statuses =
        ["status", "status_again", "unknown_status", "cancelled_status"].map(|key| &found[key]);
    assert_eq!(statuses, [&json!(4), &json!(4), &json!(0), &json!(5)], "{found}");
    assert_eq!(found["cancel"], json!({"code": 0, "goals": 1}));
    assert_eq!((&found["cancel_unknown"], &found["feedback_of_goal"]), (&json!(2), &json!(true)));
    assert!(found["feedback"]["distance_remaining"].as_f64().expect("metres") > 1.0);
}

#[test]
fn a_fleet_adapter_of_open_rmf_moves_a_robot_a_door_and_a_lift() {
    let domain = domain(5);
    let Some(mut rmf) = python("rmf.py", domain) else { return };
    let fleet = Fleet::start("ros2-rmf", "lift.yaml", &["--robots", "1", "--speed", "2"]);
    let _plugin = plugin(&fleet, domain, &["--open-rmf"]);
    let found = run({
        rmf.args([&domain.to_string(), fleet.name.as_str(), "9", "0", "ground"]);
        rmf
    });
    assert_eq!(found["robot"]["model"], "amr");
    assert_eq!((&found["destination"], &found["moving"]), (&json!("upper"), &json!(2)));
    assert_eq!(found["lift"]["available_floors"], json!(["ground", "upper"]));
    assert_eq!(found["paused"], json!(["task-8", 11]));
    assert_eq!(found["there"]["level_name"], "ground");
}

/// Datagrams that begin like those of RTPS, with pseudo-random bytes behind.
fn malformed() -> impl Iterator<Item = Vec<u8>> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u32
    };
    (0..3_000).map(move |number| {
        let mut bytes = b"RTPS\x02\x03\x01\x0f0123456789ab".to_vec();
        // A submessage of any kind, then rubbish.
        let length = next() % 300;
        bytes.extend([next() as u8 % 0x40, next() as u8, length as u8, (length >> 8) as u8]);
        bytes.extend((0..next() % 400).map(|_| next() as u8));
        bytes.truncate(if number % 7 == 0 { next() as usize % 30 } else { bytes.len() });
        bytes
    })
}

#[test]
fn malformed_datagrams_and_stopped_nodes_change_nothing() {
    let domain = domain(6);
    let topic = "/regatta/poses:geometry_msgs/PoseArray";
    let Some(mut stopped) = python("listen.py", domain) else { return };
    let fleet = Fleet::start("ros2-hostile", "thirty.yaml", &[]);
    let plugin = plugin(&fleet, domain, &[]);
    let stopped = Process::start(stopped.args(["60", topic]));
    std::thread::sleep(std::time::Duration::from_secs(4));
    stopped.signal(Signal::STOP);
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let base = 7_400 + 250 * domain;
    for bytes in malformed() {
        for port in [base, base + 1, base + 10, base + 11] {
            // A full buffer of the receiver is as good.
            let _ = socket.send_to(&bytes, ("127.0.0.1", port));
        }
    }
    let before = fleet.tick();
    let mut listen = python("listen.py", domain).expect("it was there");
    let found = run({
        listen.args(["8", topic]);
        listen
    });
    assert!(found["topics"]["/regatta/poses"]["count"].as_u64().expect("a count") > 10, "{found}");
    assert!(fleet.tick() > before + 300, "the engine goes on");
    stopped.signal(Signal::KILL);
    let output = plugin.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(!messages.contains("panicked"), "{messages}");
}
