//! `regatta plugin vda5050` on a real engine and a real broker (Mosquitto).

pub mod master;
mod our_master;

use std::io::Write;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::Command;

use serde_json::{Value, json};

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};
use master::Master;

/// A broker on a free port of this machine.
pub struct Broker {
    process: Option<Process>,
    pub port: u16,
    config: PathBuf,
}

impl Broker {
    /// Starts a broker. Returns `None`, and says so, if Mosquitto isn't installed.
    pub fn start(test: &str) -> Option<Self> {
        let program = mosquitto()?;
        let port = TcpListener::bind("127.0.0.1:0").and_then(|socket| socket.local_addr());
        let port = port.expect("a free port").port();
        let config = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(unique(test).as_str());
        let mut file = std::fs::File::create(&config).expect("a file");
        write!(file, "listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\n")
            .expect("written");
        let mut broker = Self { process: None, port, config };
        broker.run(&program);
        Some(broker)
    }

    fn run(&mut self, program: &str) {
        self.process = Some(Process::start(Command::new(program).arg("-c").arg(&self.config)));
        eventually("the broker listens", || {
            std::net::TcpStream::connect(("127.0.0.1", self.port)).ok()
        });
    }

    /// Kills the broker and starts it again.
    fn restart(&mut self) {
        drop(self.process.take());
        self.run(&mosquitto().expect("it was there"));
    }

    pub fn url(&self) -> String {
        format!("mqtt://127.0.0.1:{}", self.port)
    }
}

/// The program of the broker.
fn mosquitto() -> Option<String> {
    let places = ["mosquitto", "/usr/sbin/mosquitto"];
    let found = places.into_iter().find(|place| {
        let started = Command::new(place).arg("-h").output();
        started.is_ok()
    });
    if found.is_none() {
        println!("skipped: mosquitto isn't installed (apt-get install mosquitto)");
    }
    found.map(str::to_owned)
}

/// A fleet of robots at nodes of a LIF file, five times as fast as real time.
fn fleet(test: &str, nodes: &[&str]) -> Fleet {
    let robots: String = nodes.iter().map(|node| format!("- {{node: {node}}}\n")).collect();
    let layout = graphs("imported/lif/ex_10_7.lif.json");
    let scenario = format!(
        "graph: {}\nrate: 50\nrobot_types:\n- {{name: amr, length: 0.8, width: 0.6, \
         max_rotation_speed: 1.5}}\nrobots:\n{robots}",
        layout.display()
    );
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.yaml", unique(test)));
    std::fs::write(&path, scenario).expect("written");
    Fleet::start(test, path.to_str().expect("a path"), &["--speed", "5"])
}

fn vehicles(fleet: &Fleet, broker: &Broker, args: &[&str]) -> Process {
    Process::start(
        regatta()
            .args(["plugin", "vda5050", "--fleet", fleet.name.as_str(), "--broker", &broker.url()])
            .args(args),
    )
}

/// A node of an order.
fn node(id: &str, place: u32, actions: Value) -> Value {
    json!({"nodeId": id, "sequenceId": place, "released": true, "actions": actions})
}

/// An order of 2.x along nodes; edges have the names of their ends.
fn order(id: &str, update: u32, first: u32, nodes: &[&str]) -> Value {
    let places = (first..).step_by(2);
    let list: Vec<Value> =
        nodes.iter().zip(places).map(|(id, place)| node(id, place, json!([]))).collect();
    let edges: Vec<Value> = nodes
        .windows(2)
        .zip((first + 1..).step_by(2))
        .map(|(ends, place)| {
            json!({"edgeId": format!("{}-{}", ends[0], ends[1]), "sequenceId": place,
                   "released": true, "startNodeId": ends[0], "endNodeId": ends[1], "actions": []})
        })
        .collect();
    json!({"orderId": id, "orderUpdateId": update, "nodes": list, "edges": edges})
}

#[test]
fn a_master_drives_an_order_and_its_update_to_the_end() {
    let Some(broker) = Broker::start("vda-order") else { return };
    let fleet = fleet("vda-order", &["N3"]);
    let plugin = vehicles(&fleet, &broker, &["--serial", "agv-{}"]);
    let mut master = Master::connect(broker.port, "uagv/v2/regatta/agv-0");

    let online = master.wait("connection", |message| message["connectionState"] == "ONLINE");
    assert_eq!((&online["version"], &online["serialNumber"]), (&json!("2.0.0"), &json!("agv-0")));
    let factsheet = master.wait("factsheet", |_| true);
    assert_eq!(factsheet["typeSpecification"]["seriesName"], "amr");
    let state = master.wait("state", |state| state["lastNodeId"] == "N3");
    assert_eq!((&state["orderId"], &state["driving"]), (&json!(""), &json!(false)));

    let pick = json!([{"actionId": "p", "actionType": "pick", "blockingType": "HARD",
        "actionParameters": [{"key": "loadId", "value": "box"}]}]);
    let mut first = order("o-1", 0, 0, &["N3", "N11", "N1"]);
    first["nodes"][1]["actions"] = pick;
    master.send("order", first);
    let state = master.wait("state", |state| state["orderId"] == "o-1");
    assert_eq!(state["nodeStates"].as_array().map(Vec::len), Some(2));
    master.wait("state", |state| state["driving"] == true && state["lastNodeId"] == "N3");
    let state = master.wait("state", |state| state["actionStates"][0]["actionStatus"] == "RUNNING");
    assert_eq!((&state["lastNodeId"], &state["driving"]), (&json!("N11"), &json!(false)));
    let state = master.wait("state", |state| state["lastNodeId"] == "N1");
    assert_eq!(state["loads"][0]["loadId"], "box");
    assert_eq!(state["lastNodeSequenceId"], 4);

    master.send("order", order("o-1", 1, 4, &["N1", "N3"]));
    let state =
        master.wait("state", |state| state["lastNodeId"] == "N3" && state["driving"] == false);
    assert_eq!(state["orderUpdateId"], 1);
    assert_eq!((&state["nodeStates"], &state["errors"]), (&json!([]), &json!([])));
    let x = state["agvPosition"]["x"].as_f64().expect("a position");
    assert!(x.abs() < 0.01, "N3 is at 0: {x}");

    assert!(plugin.interrupt().status.success());
    master.wait("connection", |message| message["connectionState"] == "OFFLINE");
}

#[test]
fn an_order_survives_the_death_of_the_broker() {
    let Some(mut broker) = Broker::start("vda-restart") else { return };
    let fleet = fleet("vda-restart", &["N3"]);
    let plugin = vehicles(&fleet, &broker, &["--protocol", "3.0"]);
    let mut master = Master::connect(broker.port, "vda5050/v3/regatta/0");
    master.wait("state", |state| state["lastNodeId"] == "N3");
    master.send("order", order("o", 0, 0, &["N3", "N21", "N2", "N3"]));
    master.wait("state", |state| state["driving"] == true);
    broker.restart();

    let mut master = Master::connect(broker.port, "vda5050/v3/regatta/0");
    master.wait("connection", |message| message["connectionState"] == "ONLINE");
    master.wait("factsheet", |sheet| sheet["mobileRobotGeometry"].is_object());
    let state = master.wait("state", |state| state["nodeStates"] == json!([]));
    assert_eq!((&state["orderId"], &state["lastNodeSequenceId"]), (&json!("o"), &json!(6)));

    // A vehicle whose process dies leaves its last will.
    plugin.signal(rustix::process::Signal::KILL);
    master.wait("connection", |message| message["connectionState"] == "CONNECTION_BROKEN");
}

#[test]
fn broken_messages_are_errors_of_the_sender_and_disturb_nobody() {
    let Some(broker) = Broker::start("vda-broken") else { return };
    let fleet = fleet("vda-broken", &["N3", "N1"]);
    let _plugin = vehicles(&fleet, &broker, &[]);
    let mut one = Master::connect(broker.port, "uagv/v2/regatta/0");
    let mut other = Master::connect(broker.port, "uagv/v2/regatta/1");
    one.wait("state", |state| state["lastNodeId"] == "N3");
    other.wait("state", |state| state["lastNodeId"] == "N1");

    one.send_text("order", "{\"orderId\": \"half");
    one.wait("state", |state| state["errors"][0]["errorType"] == "validationError");
    other.send("order", order("o", 0, 0, &["N1", "N3"]));
    let far: Vec<&str> = ["N3", "N11", "N1"].into_iter().cycle().take(10_000).collect();
    one.send("order", order("far", 0, 0, &far));
    let state = one.wait("state", |state| state["orderId"] == "far");
    assert_eq!(
        (state["nodeStates"].as_array().map(Vec::len), &state["errors"]),
        (Some(9_999), &json!([]))
    );
    let cancel = json!([{"actionId": "c", "actionType": "cancelOrder", "blockingType": "NONE"}]);
    one.send("instantActions", json!({"instantActions": cancel}));
    let state = one.wait("state", |state| {
        state["actionStates"].as_array().is_some_and(|all| {
            all.iter().any(|it| it["actionId"] == "c" && it["actionStatus"] == "FINISHED")
        })
    });
    assert_eq!((&state["nodeStates"], &state["driving"]), (&json!([]), &json!(false)));
    other.wait("state", |state| state["lastNodeId"] == "N3" && state["nodeStates"] == json!([]));
}

#[test]
fn without_a_broker_the_plugin_is_one_and_tells_user_and_password() {
    let fleet = fleet("vda-own", &["N3"]);
    let mut plugin = Process::start(regatta().args([
        "plugin",
        "vda5050",
        "--fleet",
        fleet.name.as_str(),
        "--listen",
        "127.0.0.1:0",
    ]));
    let mut line = String::new();
    let stderr = plugin.0.stderr.take().expect("piped");
    std::io::BufRead::read_line(&mut std::io::BufReader::new(stderr), &mut line).expect("a line");
    let words: Vec<&str> = line.split_whitespace().collect();
    let port = words[3].rsplit(':').next().expect(&line).parse().expect(&line);
    let password = words.last().expect(&line);
    let mut master = Master::connect_as(port, "uagv/v2/regatta/0", "regatta", password);
    master.wait("connection", |message| message["connectionState"] == "ONLINE");
    master.wait("state", |state| state["lastNodeId"] == "N3");
    master.send("order", order("o", 0, 0, &["N3", "N11"]));
    master.wait("state", |state| state["lastNodeId"] == "N11");
    assert!(plugin.interrupt().status.success());
}

#[test]
fn a_run_gives_the_robots_of_a_layout_to_a_master() {
    let Some(broker) = Broker::start("vda-run") else { return };
    let layout = graphs("imported/opentcs/Demo-01.xml");
    let name = unique("vda-run");
    let mut command = regatta();
    command.arg("run").arg(layout).args(["--fleet", name.as_str(), "--robots", "2"]);
    let run = Process::start(command.arg(format!("--vda5050={}", broker.url())));
    // Robots that were put anywhere are brought to a node, where orders can begin.
    for robot in ["0", "1"] {
        let mut master = Master::connect(broker.port, &format!("uagv/v2/regatta/{robot}"));
        let state = master.wait("state", |state| state["lastNodeId"] != "");
        assert_eq!(state["errors"], json!([]));
    }
    let output = run.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
