//! Orders and vehicles of a running fleet manager over its web API, across `kill -9`.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::ChildStderr;

use regatta_orders::{Client, ClientError};
use regatta_plugin::FleetName;
use rustix::process::Signal;
use serde_json::{Value, json};

use crate::fleet::{Process, eventually, graphs, regatta, unique};

/// A running manager with its web API on a free port.
struct Served {
    process: Process,
    address: String,
    client: Client,
    /// Kept open: it may tell more.
    _stderr: BufReader<ChildStderr>,
}

impl Served {
    fn start(fleet: &FleetName, store: &Path) -> Self {
        let mut command = regatta();
        command.args([
            "plugin",
            "fleet-manager",
            "--http",
            "127.0.0.1:0",
            "--fleet",
            &fleet.to_string(),
            "--store",
        ]);
        let mut process = Process::start(command.arg(store));
        let mut stderr = BufReader::new(process.0.stderr.take().expect("piped"));
        let mut text = String::new();
        while !text.contains("orders at") {
            assert!(stderr.read_line(&mut text).expect("a line") > 0, "{text}");
        }
        let address = text.split("http://").nth(1).and_then(|rest| rest.split(',').next());
        let address = address.expect("an address").to_owned();
        let client = Client::new(&address, None).expect("an address");
        Self { process, address, client, _stderr: stderr }
    }

    fn get(&self, path: &str) -> Value {
        self.client.get(path).expect(path)
    }

    /// Asks for an order until it is in a state.
    fn order_in(&self, name: &str, state: &str) -> Value {
        let path = Client::order_path(name);
        eventually(state, || Some(self.get(&path)).filter(|order| order["state"] == state))
    }

    /// Runs `regatta orders list`.
    fn list(&self, args: &[&str]) -> String {
        let url = format!("http://{}", self.address);
        let output = regatta()
            .args(["orders", "list", "--url", &url])
            .args(args)
            .output()
            .expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    }
}

/// The header with the token of this user.
fn own_token() -> String {
    let token = regatta_kit::private::token().expect("a token");
    format!("Authorization: Bearer {token}\r\n")
}

/// Writes a scenario of robots with batteries that wait for orders.
fn scenario(folder: &Path) -> PathBuf {
    let text = format!(
        "graph: {}\nrate: 50\npublish_rate: 10\nseed: 3\n\
         robot_types:\n- name: amr\n  length: 0.9\n  width: 0.6\n  battery: \
         {{capacity: 800, drain_moving: 120, drain_standing: 20, charge_rate: 900}}\n\
         robots:\n- {{count: 10, routes: none}}\n",
        graphs("warehouse-chargers.yaml").display()
    );
    let path = folder.join("scenario.yaml");
    std::fs::write(&path, text).expect("written");
    path
}

fn engine(fleet: &FleetName, scenario: &Path) -> Process {
    let mut command = regatta();
    command.arg("engine").arg(scenario).args(["--speed", "10", "--fleet", &fleet.to_string()]);
    Process::start(&mut command)
}

/// An order to two nodes, at which the robot stays for so many seconds.
fn draft(nodes: [u32; 2], dwell: f64) -> Value {
    json!({"destinations": [
        {"locationName": nodes[0], "operation": "PICK", "dwell": dwell},
        {"locationName": nodes[1], "operation": "Drop", "dwell": dwell},
    ]})
}

fn times(order: &Value) -> Vec<f64> {
    order["history"]
        .as_array()
        .expect("a history")
        .iter()
        .filter_map(|entry| entry["time"].as_f64())
        .collect()
}

#[test]
fn vehicles_of_a_running_fleet_are_shown_and_their_changes_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let fleet = unique("served-vehicles");
    let engine = engine(&fleet, &scenario(folder.path()));
    let manager = Served::start(&fleet, &folder.path().join("orders.sqlite"));
    eventually("ten vehicles", || {
        (manager.get("/v1/vehicles").as_array()?.len() == 10).then_some(())
    });
    let vehicle = manager.get("/v1/vehicles/3");
    assert_eq!((&vehicle["name"], &vehicle["transportOrder"]), (&json!("3"), &Value::Null));
    assert_eq!((&vehicle["state"], &vehicle["activity"]), (&json!("idle"), &json!("idle")));
    assert!(
        vehicle["currentPosition"].is_string() && vehicle["position"][1].is_number(),
        "{vehicle}"
    );
    assert!(vehicle["energyLevel"].as_u64().is_some_and(|level| level <= 100), "{vehicle}");
    assert!(matches!(
        manager.client.get("/v1/vehicles/10"),
        Err(ClientError::Refused { status: 404, .. })
    ));

    let mut events = TcpStream::connect(&manager.address).expect("connected");
    let head = format!("GET /v1/sse HTTP/1.0\r\n{}", own_token());
    write!(events, "{head}Host: {}\r\n\r\n", manager.address).expect("sent");
    let mut events = BufReader::new(events).lines();
    assert!(events.any(|line| line.is_ok_and(|line| line.starts_with(": changes"))));
    manager.client.post("/v1/transportOrders/q1", &draft([20, 400], 2.0)).expect("kept");
    let changed = events.map_while(Result::ok).filter_map(|line| {
        let vehicle: Value = serde_json::from_str(line.strip_prefix("data: ")?).ok()?;
        (vehicle["transportOrder"] == "q1" && vehicle["activity"] == "fetching").then_some(vehicle)
    });
    let changed = changed.into_iter().next().expect("an event of the robot that has got the order");
    let robot = manager.get("/v1/transportOrders/q1")["processingVehicle"].clone();
    assert_eq!(changed["name"], robot);
    let path = format!("/v1/vehicles/{}", robot.as_str().expect("a robot"));
    eventually("it drives on an edge", || manager.get(&path)["edge"].as_u64());
    manager.process.interrupt();
    engine.interrupt();
}

#[test]
fn orders_of_a_killed_manager_are_found_and_their_times_go_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let fleet = unique("served-killed");
    let engine = engine(&fleet, &scenario(folder.path()));
    let store = folder.path().join("orders.sqlite");
    let first = Served::start(&fleet, &store);
    let answer = first.client.post("/v1/transportOrders/q1", &draft([20, 400], 0.5)).expect("kept");
    let before = first.order_in("q1", "finished");
    assert_eq!(
        (&before["created"], &before["history"][0]["time"]),
        (&answer["created"], &answer["created"])
    );
    first.client.post("/v1/transportOrders/q2", &draft([200, 20], 1.0)).expect("kept");
    let assigned = times(&first.order_in("q2", "travelling"));
    first.process.signal(Signal::KILL);
    drop(first);

    let second = Served::start(&fleet, &store);
    assert_eq!(second.get("/v1/transportOrders/q1"), before);
    let again = second.client.post("/v1/transportOrders/q1", &draft([20, 400], 0.5));
    assert!(matches!(again, Err(ClientError::Refused { status: 409, .. })), "{again:?}");
    let list: Vec<Value> = serde_json::from_str(&second.list(&["--json"])).expect("a list");
    assert_eq!(list.iter().map(|order| order["name"].clone()).collect::<Vec<_>>(), ["q1", "q2"]);
    assert!(second.list(&["--state", "finished"]).contains("q1"));
    assert!(!second.list(&["--state", "open"]).contains("q1"));
    let after = second.order_in("q2", "finished");
    let times = times(&after);
    assert!(times.is_sorted() && times[0] > 0.0, "{after}");
    let withdrawn = after["history"]
        .as_array()
        .into_iter()
        .flatten()
        .find(|entry| entry["event"] == "withdrawn");
    let withdrawn =
        withdrawn.and_then(|entry| entry["time"].as_f64()).expect("taken back at the restart");
    assert!(Some(&withdrawn) > assigned.last(), "{after}");
    second.process.interrupt();
    engine.interrupt();
}

#[test]
fn a_web_api_that_cannot_be_served_is_refused_at_once() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("an address");
    let taken = listener.local_addr().expect("an address").to_string();
    let folder = tempfile::tempdir().expect("a folder");
    let token = folder.path().join("token").display().to_string();
    std::fs::write(&token, "a-secret-token").expect("written");
    for (args, reason) in [
        (&["--http", "0.0.0.0:0"][..], "--token-file"),
        (
            &["--http", "192.0.2.1:55200", "--token-file", &token],
            "can't serve orders on 192.0.2.1:55200",
        ),
        (
            &["--http", "0.0.0.0:0", "--token-file", "/no/such/file"],
            "can't use the token of /no/such/file",
        ),
        (&["--http", &taken], "choose another port with --http"),
    ] {
        let mut command = regatta();
        command
            .args(["plugin", "fleet-manager", "--fleet"])
            .arg(unique("served-never").to_string())
            .args(args);
        // There is no engine to wait for.
        let output = Process::start(&mut command).finish();
        let mut text = String::from_utf8(output.stderr).expect("text");
        text.truncate(text.trim_end().len());
        assert_eq!((output.status.code(), text.lines().count()), (Some(1), 1), "{args:?}: {text}");
        assert!(text.contains(reason), "{args:?}: {text}");
    }
}

/// The largest resident memory of a process so far, in bytes.
fn peak_memory(process: &Process) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.0.id()));
    let status = status.expect("the process runs");
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).expect("its memory");
    let kilobytes = line.split_whitespace().nth(1).and_then(|text| text.parse::<u64>().ok());
    kilobytes.expect("a number") << 10
}

#[test]
fn answers_that_nobody_reads_cost_little_memory_and_keep_nobody_waiting() {
    let folder = tempfile::tempdir().expect("a folder");
    let fleet = unique("served-budget");
    let engine = engine(&fleet, &scenario(folder.path()));
    let manager = Served::start(&fleet, &folder.path().join("orders.sqlite"));
    let many = json!(vec![draft([20, 400], 2.0); 1_000]);
    for _ in 0..30 {
        let kept = manager.client.post("/v1/transportOrders", &many).expect("kept");
        assert_eq!(kept.as_array().map(Vec::len), Some(1_000));
    }
    let before = peak_memory(&manager.process);
    let (token, host) = (own_token(), &manager.address);
    let asks = format!("GET /v1/transportOrders HTTP/1.1\r\nHost: {host}\r\n{token}\r\n");
    let slow = format!(
        "POST /v1/transportOrders HTTP/1.1\r\nHost: {host}\r\n{token}Content-Length: 15000000\r\n\r\n"
    );
    let mut clients = Vec::new();
    for _ in 0..60 {
        for (head, body) in [(&asks, 0), (&slow, 2 << 20)] {
            let mut stream = TcpStream::connect(host).expect("connected");
            stream.set_nonblocking(true).expect("set");
            // A client that is too slow may be cut off for another.
            let _ = stream.write_all(head.repeat(if body == 0 { 20 } else { 1 }).as_bytes());
            let _ = stream.write(&vec![b' '; body]);
            clients.push(stream);
        }
        let start = std::time::Instant::now();
        assert!(manager.get("/v1/status")["openOrders"].as_u64() > Some(20_000));
        assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
    }
    let page = manager.get("/v1/transportOrders");
    assert_eq!(page.as_array().map(Vec::len), Some(1_000));
    let grown = peak_memory(&manager.process) - before;
    assert!(grown < 160 << 20, "{} MiB more", grown >> 20);
    drop(clients);
    manager.process.interrupt();
    engine.interrupt();
}
