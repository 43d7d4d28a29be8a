//! `regatta master` on a real broker (Mosquitto), with our own vehicles and with ones that a test
//! plays.

use std::io::Write;
use std::path::PathBuf;
use std::process::Command;

use regatta_plugin::FleetName;
use serde_json::{Value, json};

use super::master::Master as Peer;
use super::{Broker, fleet, vehicles};
use crate::fleet::{Process, eventually, graphs, regatta, unique};

/// The layout of these tests.
const LAYOUT: &str = "imported/lif/ex_10_7.lif.json";

/// The rate at which vehicles lose their connections, in simulated hours.
const LOST: &str = "lost-connections=20/h";
/// The seed by which each of two vehicles loses its connection once in 500 simulated seconds: after
/// 67 s and after 169 s, for 12 s and 16 s of the wall clock.
const LOST_SEED: &str = "11955";

/// A master, and the name of its fleet.
struct OurMaster {
    process: Process,
    fleet: FleetName,
    orders: PathBuf,
}

impl OurMaster {
    fn start(test: &str, broker: &Broker, args: &[&str]) -> Self {
        let fleet = unique(&format!("{test}-master"));
        let mut command = regatta();
        command.arg("master").arg(graphs(LAYOUT)).args(["--vda5050", &broker.url()]);
        let process = Process::start(command.args(["--fleet", fleet.as_str()]).args(args));
        let file = format!("{}.csv", fleet.as_str());
        let orders = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(file);
        Self { process, fleet, orders }
    }

    /// Runs a command about its fleet, and returns what it prints if it succeeds.
    fn ask(&self, args: &[&str]) -> Option<String> {
        let output =
            regatta().args(args).args(["--fleet", self.fleet.as_str()]).output().expect("it runs");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Gives it transport orders, once it takes them: each from a node to another.
    fn order(&self, ways: &[[&str; 2]]) {
        let mut text = "name,stops\n".to_owned();
        for (number, [from, to]) in ways.iter().enumerate() {
            text += &format!("o{number},{from}:pick:1 {to}:drop:1\n");
        }
        self.order_by(&text);
    }

    /// Gives it transport orders, once it takes them: those of a text of CSV.
    fn order_by(&self, text: &str) {
        let mut file = std::fs::File::create(&self.orders).expect("a file");
        file.write_all(text.as_bytes()).expect("written");
        let path = self.orders.to_str().expect("a path");
        eventually("orders are taken", || self.ask(&["orders", "import", path]));
    }

    /// Waits until so many orders are finished.
    fn wait_for(&self, finished: usize) {
        eventually("orders are finished", || {
            let list = self.ask(&["orders", "list", "--state", "finished", "--json"])?;
            let list: Value = serde_json::from_str(&list).ok()?;
            let count = list.as_array().map(Vec::len);
            (count? == finished).then_some(())
        });
    }

    /// Waits until so many robots are in a state.
    fn wait_until(&self, state: &str, robots: u64) {
        eventually(&format!("{robots} {state}"), || {
            let status: Value = serde_json::from_str(&self.ask(&["status", "--json"])?).ok()?;
            (status["robots_by_state"][state] == robots).then_some(())
        });
    }

    /// Ends it, and returns its messages.
    fn end(self) -> String {
        std::fs::remove_file(&self.orders).ok();
        let output = self.process.interrupt();
        let messages = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{messages}");
        messages
    }
}

/// Listens to a broker by `regatta vda5050 check`.
fn judge(broker: &Broker) -> Process {
    Process::start(regatta().args(["vda5050", "check", &broker.url(), "--json"]))
}

/// Ends a judge, and returns its report.
fn report(judge: Process) -> Value {
    serde_json::from_slice(&judge.interrupt().stdout).expect("JSON")
}

fn findings(report: &Value) -> Vec<&Value> {
    report["findings"].as_array().expect("a list").iter().collect()
}

fn is_error_of_master(finding: &Value) -> bool {
    finding["side"] == "master" && finding["severity"] == "error"
}

/// The findings of a judge that are errors.
fn errors(judge: Process) -> (Value, u64) {
    let report = report(judge);
    (report["errors"].clone(), report["messages"].as_u64().expect("a count"))
}

#[test]
fn our_manager_steers_vehicles_of_three_versions_by_the_standard() {
    let Some(broker) = Broker::start("own-master") else { return };
    let fleet = fleet("own-master", &["N3", "N1", "N21"]);
    let judge = judge(&broker);
    let _vehicles = vehicles(
        &fleet,
        &broker,
        &["--protocol", "2.0,2.1,3.0", "--action", "pick=1", "--action", "drop=1"],
    );
    let validator = fleet.plugin("validator");
    let master = OurMaster::start("own-master", &broker, &[]);
    master.order(&[["N3", "N1"], ["N1", "N3"], ["N11", "N2"]]);
    master.wait_for(3);
    let messages = master.end();
    for version in ["2.0.0", "2.1.0", "3.0.0"] {
        assert!(messages.contains(&format!("(VDA 5050 {version})")), "{messages}");
    }
    let (errors, judged) = errors(judge);
    assert!(errors == 0 && judged > 100, "{errors} errors in {judged} messages");
    assert!(validator.interrupt().status.success(), "vehicles have touched");
}

/// A vehicle without a load can't drop one. Its order has failed, and it goes on with the next.
#[test]
fn an_order_whose_action_fails_has_failed() {
    let Some(broker) = Broker::start("own-failed") else { return };
    let fleet = fleet("own-failed", &["N3"]);
    let _vehicles = vehicles(&fleet, &broker, &["--action", "pick=1", "--action", "drop=1"]);
    let master = OurMaster::start("own-failed", &broker, &[]);
    master.order_by("name,stops\nempty,N1:drop:1\nfull,N3:pick:1 N1:drop:1\n");
    master.wait_for(1);
    let list = master.ask(&["orders", "list", "--state", "failed", "--json"]).expect("a list");
    let list: Value = serde_json::from_str(&list).expect("JSON");
    let failed: Vec<_> = list.as_array().into_iter().flatten().collect();
    let [order] = failed[..] else { panic!("{list}") };
    assert_eq!(order["name"], "empty");
    assert_eq!(order["reason"], "the robot's action at N1 has failed");
    let messages = master.end();
    assert!(messages.contains("its action drop has failed: there is no such load"), "{messages}");
}

/// Messages are lost, doubled and late, vehicles stop, and an operator drives them: orders are
/// carried all the same, and nobody touches another one.
#[test]
fn orders_survive_vehicles_that_are_disturbed() {
    let Some(broker) = Broker::start("own-disturbed") else { return };
    let fleet = fleet("own-disturbed", &["N3", "N1", "N21"]);
    let disturbances = "lost-messages=2%,doubled-messages=5%,delay=0.05s,emergency-stops=30/h,\
                        manual-mode=10/h";
    let _vehicles = vehicles(
        &fleet,
        &broker,
        &["--action", "pick=1", "--action", "drop=1", "--disturb", disturbances],
    );
    let validator = fleet.plugin("validator");
    let master = OurMaster::start("own-disturbed", &broker, &[]);
    master.order(&[["N3", "N1"], ["N1", "N3"]]);
    master.wait_for(2);
    master.end();
    assert!(validator.interrupt().status.success(), "vehicles have touched");
}

#[test]
fn orders_survive_brokers_that_die() {
    let Some(mut broker) = Broker::start("own-soak") else { return };
    let fleet = fleet("own-soak", &["N3", "N1"]);
    let _vehicles = vehicles(&fleet, &broker, &["--action", "pick=1", "--action", "drop=1"]);
    let validator = fleet.plugin("validator");
    let master = OurMaster::start("own-soak", &broker, &[]);
    master.order(&[["N3", "N1"], ["N1", "N3"], ["N11", "N2"], ["N2", "N11"]]);
    for finished in 1..=3 {
        master.wait_for(finished);
        broker.restart();
    }
    master.wait_for(4);
    master.end();
    assert!(validator.interrupt().status.success(), "vehicles have touched");
}

/// Vehicles lose their connections without a word, and come back: the broker tells the master, and
/// orders are carried on.
#[test]
fn orders_survive_connections_that_are_lost() {
    let Some(broker) = Broker::start("own-lost") else { return };
    let fleet = fleet("own-lost", &["N3", "N1"]);
    let judge = judge(&broker);
    let _vehicles = vehicles(
        &fleet,
        &broker,
        &[
            "--action",
            "pick=1",
            "--action",
            "drop=1",
            "--disturb",
            LOST,
            "--disturb-seed",
            LOST_SEED,
        ],
    );
    let validator = fleet.plugin("validator");
    let master = OurMaster::start("own-lost", &broker, &[]);
    master.order(&[["N3", "N1"], ["N1", "N3"], ["N11", "N2"]]);
    master.wait_until("broken", 1);
    for finished in 1..=3 {
        master.wait_for(finished);
    }
    let messages = master.end();
    for news in ["its connection is broken; its path is kept free", "it can be steered again"] {
        assert!(messages.contains(news), "{news}: {messages}");
    }
    let report = report(judge);
    let of_master: Vec<_> =
        findings(&report).into_iter().filter(|one| is_error_of_master(one)).collect();
    assert!(of_master.is_empty(), "{of_master:#?}");
    assert!(validator.interrupt().status.success(), "vehicles have touched");
}

/// The master waits for a vehicle whose last will it has seen, and the judge knows that it went on
/// without a word.
#[test]
fn the_last_will_of_a_vehicle_is_seen_by_the_master_and_the_judge() {
    let Some(broker) = Broker::start("own-will") else { return };
    let judge = judge(&broker);
    let prefix = "uagv/v2/KIT/9";
    let mut vehicle = Peer::connect_with_will(broker.port, prefix);
    vehicle.send_kept("connection", json!({"connectionState": "ONLINE"}));
    let master = OurMaster::start("own-will", &broker, &["--vehicles", "uagv/v2/KIT/+"]);
    vehicle.wait("instantActions", |_| true);
    vehicle.send("state", state(json!({})));
    master.wait_until("idle", 1);
    // Nothing ends the connection but its loss.
    drop(vehicle);
    master.wait_until("broken", 1);
    let mut vehicle = Peer::connect(broker.port, prefix);
    vehicle.wait("connection", |message| message["connectionState"] == "CONNECTIONBROKEN");
    vehicle.send("state", state(json!({})));
    master.wait_until("idle", 1);
    master.order(&[["N11", "N1"]]);
    vehicle.wait("order", |order| order["nodes"][0]["nodeId"] == "N3");
    let messages = master.end();
    assert!(messages.contains("its connection is broken; its path is kept free"), "{messages}");
    let report = report(judge);
    let seen = findings(&report).into_iter().any(|one| one["rule"] == "offline-goes-on");
    assert!(seen, "{report}");
}

/// The state of a vehicle that a test plays.
fn state(changes: Value) -> Value {
    let mut state = json!({"orderId": "", "orderUpdateId": 0, "lastNodeId": "N3",
        "lastNodeSequenceId": 0, "nodeStates": [], "edgeStates": [], "driving": false,
        "actionStates": [], "batteryState": {"batteryCharge": 80.0, "charging": false},
        "operatingMode": "AUTOMATIC", "errors": [],
        "agvPosition": {"x": 0.0, "y": 0.0, "theta": 0.0, "mapId": "map",
            "positionInitialized": true},
        "safetyState": {"eStop": "NONE", "fieldViolation": false}});
    for (key, value) in changes.as_object().expect("an object") {
        state[key] = value.clone();
    }
    state
}

#[test]
fn a_vehicle_that_rejects_or_is_driven_by_a_person_is_told_and_given_back() {
    let Some(broker) = Broker::start("own-faults") else { return };
    let mut vehicle = Peer::connect(broker.port, "uagv/v2/KIT/7");
    vehicle.send_kept("connection", json!({"connectionState": "ONLINE"}));
    let master = OurMaster::start("own-faults", &broker, &["--vehicles", "uagv/v2/KIT/+"]);
    vehicle.wait("instantActions", |message| message["actions"][0]["actionType"] == "stateRequest");
    vehicle.send("state", state(json!({})));
    master.order(&[["N11", "N1"]]);
    let order = vehicle.wait("order", |_| true);
    assert_eq!((&order["nodes"][0]["nodeId"], &order["orderUpdateId"]), (&json!("N3"), &json!(0)));

    let references = json!([{"referenceKey": "orderId", "referenceValue": order["orderId"]}]);
    let error = json!([{"errorType": "orderError", "errorLevel": "WARNING",
        "errorDescription": "no way", "errorReferences": references}]);
    vehicle.send("state", state(json!({"errors": error})));
    master.wait_until("broken", 1);
    let again = vehicle.wait("order", |message| message["orderId"] != order["orderId"]);
    vehicle.send(
        "state",
        state(json!({"orderId": again["orderId"],
        "nodeStates": [{"nodeId": "N11", "sequenceId": 2, "released": true}]})),
    );
    master.wait_until("driving", 1);

    vehicle.send("state", state(json!({"operatingMode": "MANUAL"})));
    master.wait_until("broken", 1);
    // A person has driven it back to the last node of the layout.
    let place = json!({"x": 9.2, "y": 3.4, "theta": 0.0, "mapId": "map",
        "positionInitialized": true});
    vehicle.send("state", state(json!({"lastNodeId": "N1", "agvPosition": place})));
    let next = vehicle.wait("order", |message| message["nodes"][0]["nodeId"] == "N1");
    assert_eq!(next["orderUpdateId"], 0);
    vehicle.send("connection", json!({"connectionState": "CONNECTIONBROKEN"}));
    master.wait_until("broken", 1);
    let messages = master.end();
    for news in [
        "robot 0 (uagv/v2/KIT/7): it rejects its order: orderError: no way; its path is kept free",
        "robot 0 (uagv/v2/KIT/7): its operating mode is Manual; the edges around it are closed",
        "robot 0 (uagv/v2/KIT/7): it can be steered again",
        "robot 0 (uagv/v2/KIT/7): its connection is broken; its path is kept free",
    ] {
        assert!(messages.contains(news), "{news}: {messages}");
    }
}

#[test]
fn vehicles_may_come_late_and_off_the_roads_and_those_of_1_1_are_told() {
    let Some(broker) = Broker::start("own-late") else { return };
    let mut first = Peer::connect(broker.port, "uagv/v2/KIT/1");
    first.send_kept("connection", json!({"connectionState": "ONLINE"}));
    let master = OurMaster::start("own-late", &broker, &[]);
    first.wait("instantActions", |_| true);
    first.send("state", state(json!({})));
    master.wait_until("idle", 1);

    let mut old = Peer::connect(broker.port, "uagv/v1/KIT/2");
    old.send("connection", json!({"connectionState": "ONLINE"}));
    let mut late = Peer::connect(broker.port, "vda5050/v3/KIT/3");
    let away = json!({"x": 4.0, "y": 2.5, "theta": 0.0, "mapId": "map",
        "positionInitialized": true});
    late.send("state", state(json!({"lastNodeId": "", "agvPosition": away})));
    master.wait_until("broken", 1);
    let place = json!({"x": 9.2, "y": 3.4, "theta": 0.0, "mapId": "map",
        "positionInitialized": true});
    late.send("state", state(json!({"lastNodeId": "N1", "agvPosition": place})));
    master.wait_until("idle", 2);
    let messages = master.end();
    for news in [
        "uagv/v1/KIT/2 is ignored: it speaks none of VDA 5050 2.0, 2.1 and 3.0",
        "robot 1 (vda5050/v3/KIT/3): it is at no node or edge of the layout; the edges around it",
        "robot 1 (vda5050/v3/KIT/3): it can be steered again",
    ] {
        assert!(messages.contains(news), "{news}: {messages}");
    }
}

#[test]
fn plants_and_addresses_that_cannot_do_are_refused_in_a_line() {
    let square = graphs("square.yaml");
    let doors = graphs("two-levels.yaml");
    for (args, reason) in [
        (vec!["master", square.to_str().expect("a path")], "--vda5050"),
        (
            vec![
                "vda5050",
                "vehicles",
                doors.to_str().expect("a path"),
                "--vda5050",
                "mqtt://127.0.0.1:1",
            ],
            "doors or lifts",
        ),
        (
            vec![
                "vda5050",
                "vehicles",
                square.to_str().expect("a path"),
                "--vda5050",
                "mqtt://127.0.0.1:1",
                "--vehicles",
                "uagv/#",
            ],
            "four levels of topics",
        ),
    ] {
        let fleet = unique("own-refused");
        let mut command: Command = regatta();
        let output = command.args(&args).args(["--fleet", fleet.as_str()]).output().expect("runs");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(reason), "{args:?}: {message}");
    }
}
