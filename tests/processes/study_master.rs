//! `regatta study --vda5050`: a master of known capacity is sized, and what it does wrong is named.
//! The master is the example of `plugins/vda5050`, with faults that can be chosen.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};

use crate::fleet::{Process, regatta};
use crate::vda5050::Broker;
use crate::vda5050::master::Master as Peer;

/// The nodes of a long side of the road, and metres between two nodes.
const SIDE: usize = 8;
const SPACE: f64 = 1.5;

/// The options of the vehicles.
const VEHICLES: &str = "--listen 127.0.0.1:0 --action pick=0.2 --action drop=0.2";

/// A road round a long block, one way or both ways, with a station at every second node.
fn layout(is_two_way: bool) -> Value {
    let side = 0..=SIDE;
    let there = side.clone().map(|place| [place as f64 * SPACE, 0.0]);
    let back = side.rev().map(|place| [place as f64 * SPACE, 2.0 * SPACE]);
    let ends = [[SIDE as f64 * SPACE, SPACE], [0.0, SPACE]];
    let places: Vec<[f64; 2]> = there.chain([ends[0]]).chain(back).chain([ends[1]]).collect();
    let count = places.len();
    let nodes = places.iter().enumerate().map(|(index, [x, y])| {
        json!({"nodeId": format!("N{index}"), "nodePosition": {"x": x, "y": y},
            "vehicleTypeNodeProperties": [{"vehicleTypeId": "v"}]})
    });
    let mut edges = Vec::new();
    for (from, to) in (0..count).map(|index| (index, (index + 1) % count)) {
        edges.push(edge(from, to));
        if is_two_way {
            edges.push(edge(to, from));
        }
    }
    let stations = (0..count).step_by(2).map(|index| {
        json!({"stationId": format!("S{index}"), "interactionNodeIds": [format!("N{index}")]})
    });
    json!({"metaInformation": {"lifVersion": "1.0.0"}, "layouts": [{"layoutId": "l",
        "layoutVersion": "1", "nodes": nodes.collect::<Value>(), "edges": edges,
        "stations": stations.collect::<Value>()}]})
}

fn edge(from: usize, to: usize) -> Value {
    json!({"edgeId": format!("N{from}-N{to}"), "startNodeId": format!("N{from}"),
        "endNodeId": format!("N{to}"), "vehicleTypeEdgeProperties": [{"vehicleTypeId": "v",
        "vehicleOrientation": 0.0, "rotationAllowed": true, "maxSpeed": 8.0}]})
}

/// A plant in a folder of its own, and the master's file with the roads.
struct Plant {
    folder: tempfile::TempDir,
}

impl Plant {
    fn new(is_two_way: bool) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("plant.lif.json"), layout(is_two_way).to_string())
            .expect("written");
        let scenario = "graph: plant.lif.json\nrobot_types:\n- {name: amr, length: 0.8, \
            width: 0.6, max_speed: 8, max_acceleration: 30, max_rotation_speed: 30}\n\
            robots:\n- {count: 1, routes: none}\n";
        fs::write(folder.path().join("plant.yaml"), scenario).expect("written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A study with short actions, each number once.
    fn study(&self, args: &[&str]) -> Command {
        let mut command = regatta();
        command.arg("study").arg(self.path("plant.yaml")).arg("--output").arg(self.path("s"));
        command.args(["--repeats", "1", "--vehicle-options", VEHICLES]);
        command.args(args).arg("--vda5050");
        command
    }

    /// The command of the master.
    fn master(&self, options: &str) -> String {
        let roads = self.path("plant.lif.json");
        format!("'{}' {{broker}} '{}' {options}", master().display(), roads.display())
    }

    fn answer(&self) -> Value {
        let text = fs::read(self.path("s/study.json")).expect("study.json");
        serde_json::from_slice(&text).expect("JSON")
    }
}

/// The program of the master, which is built with the tests.
fn master() -> PathBuf {
    let path = Path::new(env!("CARGO_BIN_EXE_regatta")).with_file_name("examples").join("master");
    assert!(path.exists(), "build it: cargo build --workspace --example master");
    path
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// A port that is free now.
fn free_port() -> u16 {
    let socket = std::net::TcpListener::bind("127.0.0.1:0").and_then(|it| it.local_addr());
    socket.expect("a free port").port()
}

#[test]
fn a_master_of_known_capacity_is_sized_and_its_orders_are_counted() {
    let (plant, port) = (Plant::new(false), free_port());
    let master = plant.master(&format!("--base 1 --capacity 5 --delay 2 --http {port}"));
    let url = format!("http://127.0.0.1:{port}/");
    let output = plant
        .study(&["--robots", "4..8", "--duration", "14", "--late", "1.5s", "--manager", &master])
        .args(["--order-url", &url])
        .output()
        .expect("regatta starts");
    let (answer, text) = (plant.answer(), text(&output));
    // Within 10 % of 5 vehicles there is no other number.
    assert_eq!((&answer["copes"], &answer["fails"]), (&json!(5), &json!(6)), "{text}");
    assert!(
        text.contains("The master copes with 5 vehicles on this layout; from 6 on, bases come"),
        "{text}"
    );
    let points = answer["points"].as_array().expect("points");
    let tried: Vec<u64> = points.iter().filter_map(|point| point["vehicles"].as_u64()).collect();
    assert_eq!(tried, [4, 5, 6, 8]);
    let run = &points[1]["runs"][0];
    assert!(run["finished_orders"].as_u64() > Some(1), "{run}");
    assert!(run["service"]["p50_secs"].as_f64().is_some_and(|secs| secs > 0.4), "{run}");
    assert_eq!((&run["contacts"], &run["breaches"]), (&json!(0), &json!([])), "{run}");
    let page = fs::read_to_string(plant.path("s/index.html")).expect("a page");
    assert!(page.contains("How many vehicles does the master cope with on plant?"), "{page}");
    assert_eq!(output.status.code(), Some(0), "{text}");
}

#[test]
fn a_master_that_lets_orders_meet_head_on_is_named() {
    let plant = Plant::new(true);
    let master = plant.master("--careless --own-load");
    let output = plant
        .study(&["--robots", "6", "--duration", "6", "--manager", &master])
        .output()
        .expect("regatta starts");
    let text = text(&output);
    assert!(text.contains("The master doesn't cope with 6 vehicles"), "{text}");
    assert!(text.contains("the master lets orders meet head-on"), "{text}");
    assert!(text.contains("vehicles touch"), "{text}");
    assert_eq!(output.status.code(), Some(1), "{text}");
}

#[test]
fn what_gives_no_answer_is_told_in_a_line() {
    let plant = Plant::new(false);
    let told = |mut command: Command| {
        let output = command.output().expect("regatta starts");
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        text(&output)
    };
    let with =
        |manager: &str| plant.study(&["--robots", "2", "--duration", "5", "--manager", manager]);
    let line = "Not known: master failed (exit status: 3): no licence.";
    let text = told(with("sh -c 'echo no licence; exit 3'"));
    assert!(text.contains(line), "{text}");
    let text = told(with("/no/such/program"));
    assert!(text.contains("Not known: can't start master (/no/such/program)"), "{text}");
    let mut absent = regatta();
    absent.arg("study").arg(plant.path("plant.yaml")).arg("--output").arg(plant.path("s"));
    absent.args(["--robots", "2", "--vda5050", "mqtt://127.0.0.1:1"]);
    let text = told(absent);
    assert!(text.contains("Not known: mqtt://127.0.0.1:1: can't connect"), "{text}");
}

#[test]
fn an_interrupted_study_tells_what_it_has_measured() {
    let plant = Plant::new(false);
    let master = plant.master("--own-load");
    let mut study = plant
        .study(&["--robots", "2,3", "--duration", "10", "--manager", &master])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("regatta starts");
    let lines = BufReader::new(study.stderr.take().expect("a pipe")).lines();
    let second =
        lines.map_while(Result::ok).find(|line| line.starts_with("study: 3 vehicles, run 1"));
    assert!(second.is_some(), "the second point begins");
    let pid = Pid::from_raw(study.id() as i32).expect("a process");
    kill_process(pid, Signal::INT).expect("it runs");
    let text = text(&study.wait_with_output().expect("it ends"));
    assert!(text.contains("The master copes with 2 vehicles on this layout"), "{text}");
    assert!(text.contains("Interrupted: the study was stopped early"), "{text}");
    assert_eq!(plant.answer()["points"].as_array().map(Vec::len), Some(1));
}

/// The time in which a master on a busy machine starts and answers a state.
const ANSWER: Duration = Duration::from_secs(3);

/// A state of a vehicle that stands at a node, with the first version of an order, if any.
fn state(order: &str, node: &str) -> Value {
    json!({"orderId": order, "orderUpdateId": 0, "lastNodeId": node, "lastNodeSequenceId": 0,
        "nodeStates": [], "edgeStates": [], "driving": false, "actionStates": [],
        "batteryState": {"batteryCharge": 80.0, "charging": false}, "operatingMode": "AUTOMATIC",
        "newBaseRequest": true, "errors": [],
        "safetyState": {"eStop": "NONE", "fieldViolation": false}})
}

#[test]
fn the_example_master_waits_for_the_node_of_each_vehicle_and_keeps_that_of_a_lost_one() {
    let Some(broker) = Broker::start("places") else { return };
    let plant = Plant::new(false);
    let [mut near, mut far] =
        ["a", "b"].map(|serial| Peer::connect(broker.port, &format!("uagv/v2/regatta/{serial}")));
    for vehicle in [&mut near, &mut far] {
        vehicle.send_kept("connection", json!({"connectionState": "ONLINE"}));
    }
    // What a vehicle has sent is with the broker once it has come back.
    far.wait("connection", |_| true);
    near.wait("connection", |_| true);
    let mut command = Command::new(master());
    command.arg(broker.url()).arg(plant.path("plant.lif.json")).arg("--own-load");
    let _master = Process::start(&mut command);
    near.send_kept("state", state("", "N0"));
    assert_eq!(near.wait_at_most("order", ANSWER), None, "the node of the other isn't known");
    far.send_kept("state", state("", "N1"));
    far.wait("state", |_| true);
    let order = near.wait("order", |_| true);
    let released = |place: usize| order["nodes"][place]["released"].clone();
    assert_eq!([released(0), released(1)], [json!(true), json!(false)], "{order}");
    far.send_kept("connection", json!({"connectionState": "CONNECTIONBROKEN"}));
    far.wait("connection", |message| message["connectionState"] == "CONNECTIONBROKEN");
    near.send("state", state(order["orderId"].as_str().expect("an id"), "N0"));
    assert_eq!(near.wait_at_most("order", ANSWER), None, "the other one still stands there");
    far.send_kept("connection", json!({"connectionState": "OFFLINE"}));
    far.wait("connection", |message| message["connectionState"] == "OFFLINE");
    assert_eq!(near.wait("order", |_| true)["nodes"][1]["released"], json!(true));
}
