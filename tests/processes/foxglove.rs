//! `regatta plugin foxglove` on a real engine: with Foxglove's own client (npm's
//! `@foxglove/ws-protocol`, on Node), and with clients that behave badly.

use std::io::{BufRead, BufReader, Read};
use std::net::{SocketAddr, TcpStream};
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};

use serde_json::{Value, json};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Message, WebSocket, client};

use crate::fleet::{Fleet, Process, TIMEOUT, eventually, regatta, root, unique};

/// The plugin, its address and its messages.
struct Plugin {
    process: Process,
    address: SocketAddr,
    messages: Receiver<String>,
}

impl Plugin {
    fn start(fleet: &Fleet, args: &[&str]) -> Self {
        let mut command = regatta();
        command.args(["plugin", "foxglove", "--fleet", fleet.name.as_str()]);
        let mut process = Process::start(command.args(["--listen", "127.0.0.1:0"]).args(args));
        let stderr = BufReader::new(process.0.stderr.take().expect("its messages"));
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            for line in stderr.lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        let first: String = messages.recv_timeout(TIMEOUT).expect("an address");
        let (_, rest) = first.split_once("ws://").unwrap_or_else(|| panic!("{first}"));
        let end = rest.find(['/', ';']).expect("an end");
        Self { process, address: rest[..end].parse().expect("an address"), messages }
    }

    /// Waits for a message with this text.
    fn says(&self, text: &str) {
        let mut seen = Vec::new();
        while let Ok(line) = self.messages.recv_timeout(TIMEOUT) {
            if line.contains(text) {
                return;
            }
            seen.push(line);
        }
        panic!("'{text}' isn't among {seen:?}");
    }

    fn client(&self) -> Client {
        self.connect("/", &[("sec-websocket-protocol", "foxglove.sdk.v1")]).expect("a client")
    }

    /// Connects with these headers.
    fn connect(&self, path: &str, headers: &[(&'static str, &str)]) -> Result<Client, String> {
        let url = format!("ws://{}{path}", self.address);
        let mut request = url.into_client_request().expect("a request");
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().expect("a value"));
        }
        let stream = TcpStream::connect(self.address).expect("it listens");
        stream.set_read_timeout(Some(TIMEOUT)).expect("a timeout");
        let connected = client(request, stream).map_err(|error| error.to_string())?;
        Ok(Client(connected.0))
    }
}

/// A client without manners.
struct Client(WebSocket<TcpStream>);

impl Client {
    fn send(&mut self, message: &Value) {
        self.0.send(Message::text(message.to_string())).expect("sent");
    }

    fn subscribe(&mut self, topic: &str) {
        let channels = self.until(|message| message["op"] == "advertise");
        let channels = channels["channels"].as_array().expect("channels").clone();
        let channel = channels.iter().find(|channel| channel["topic"] == topic).expect("a channel");
        let subscription = json!({"id": 1, "channelId": channel["id"]});
        self.send(&json!({"op": "subscribe", "subscriptions": [subscription]}));
    }

    /// Reads up to a text that fits.
    fn until(&mut self, fits: impl Fn(&Value) -> bool) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().expect("a message") {
                let value: Value = serde_json::from_str(&text).expect("JSON");
                if fits(&value) {
                    return value;
                }
            }
        }
    }

    /// Reads messages of the channel, and returns the times of this many.
    fn times(&mut self, count: usize) -> Vec<u64> {
        let mut times = Vec::new();
        while times.len() < count {
            if let Message::Binary(bytes) = self.0.read().expect("a message")
                && bytes[0] == 1
            {
                times.push(u64::from_le_bytes(bytes[5..13].try_into().expect("a time")));
            }
        }
        times
    }

    /// Reads to the end, and returns the reason that the server gives.
    fn end(&mut self) -> String {
        loop {
            match self.0.read() {
                Ok(Message::Close(frame)) => {
                    return frame.map(|frame| frame.reason.to_string()).unwrap_or_default();
                }
                Ok(_) => {}
                Err(error) => return error.to_string(),
            }
        }
    }
}

/// Runs Foxglove's client, and returns what it has seen; `None` without Node or its packages, which
/// a message says.
fn foxglove(plugin: &Plugin, seconds: u32, args: &[&str]) -> Option<Value> {
    if std::env::var_os("REGATTA_FOXGLOVE_NODE").is_none() {
        println!("skipped: REGATTA_FOXGLOVE_NODE names no folder with Foxglove's client");
        return None;
    }
    let script = root().join("plugins/foxglove/tests/client.mjs");
    let output = Command::new("node")
        .arg(script)
        .args([format!("ws://{}", plugin.address), seconds.to_string()])
        .args(args)
        .output()
        .expect("Node starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    Some(serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {errors}")))
}

#[test]
fn foxgloves_client_reads_all_channels() {
    let fleet = Fleet::start("foxglove-read", "thirty.yaml", &[]);
    let plugin = Plugin::start(&fleet, &[]);
    let topics =
        ["/world", "/frames", "/poses", "/robots", "/graph", "/graph_points", "/figures", "/log"];
    for protocol in ["foxglove.sdk.v1", "foxglove.websocket.v1"] {
        let args: Vec<_> = topics.into_iter().chain(["--protocol", protocol]).collect();
        let Some(seen) = foxglove(&plugin, 6, &args) else { return };
        assert_eq!(seen["protocol"], protocol);
        assert_eq!(seen["statuses"], json!([]));
        let last = |topic: &str| &seen["topics"][topic]["last"];
        assert_eq!(last("/poses")["poses"]["length"], 30, "{seen}");
        assert_eq!(last("/poses")["frame_id"], "map");
        assert_eq!(last("/robots")["data"]["length"], 30 * 16);
        assert_eq!(last("/frames")["x"]["length"], 30);
        assert_eq!(last("/figures")["robots"]["all"], 30);
        assert_eq!(last("/graph")["entities"][0]["id"], "graph");
        assert!(last("/world")["edges"]["length"].as_u64() > Some(8), "{seen}");
        assert!(seen["topics"]["/frames"]["count"].as_u64() > Some(5), "{seen}");
        assert!(seen["times"].as_u64() > Some(5) && seen["time"].as_u64() > Some(0), "{seen}");
    }
}

#[test]
fn foxgloves_client_steers_the_fleet() {
    let fleet = Fleet::start("foxglove-steer", "thirty.yaml", &[]);
    let plugin = Plugin::start(&fleet, &[]);
    let args = ["/frames", "--call", "/pause={}", "--call", r#"/step={"ticks":25}"#]
        .into_iter()
        .chain(["--set", "speed=2", "--set", "robots=20", "--get", "--call", "/step={\"ticks\":0}"])
        .collect::<Vec<_>>();
    let Some(seen) = foxglove(&plugin, 8, &args) else { return };
    let answers = seen["answers"].as_array().expect("answers");
    assert_eq!((&answers[0]["success"], &answers[0]["paused"]), (&json!(true), &json!(true)));
    let ticks = answers[1]["tick"].as_u64().expect("a tick");
    assert_eq!(Some(ticks - 25), answers[0]["tick"].as_u64(), "{seen}");
    let failure = answers[2]["failure"].as_str().expect("a failure");
    assert!(failure.contains("from 1 to"), "{seen}");
    let status = fleet.status();
    assert_eq!((&status["speed"], &status["robots"]), (&json!(2.0), &json!(20)));
    let mut values = seen["parameters"].as_array().expect("parameters").iter();
    let all = values.rfind(|values| values["id"] == "all").expect("all values");
    assert_eq!(all["parameters"][0], json!({"name": "paused", "value": true}));
}

#[test]
fn nobody_steers_through_a_plugin_that_only_reads() {
    let fleet = Fleet::start("foxglove-read-only", "thirty.yaml", &[]);
    let plugin = Plugin::start(&fleet, &["--read-only"]);
    let mut client = plugin.client();
    let info = client.until(|message| message["op"] == "serverInfo");
    assert!(!info["capabilities"].as_array().expect("some").contains(&json!("services")));
    let parameters = json!([{"name": "paused", "value": true}]);
    client.send(&json!({"op": "setParameters", "parameters": parameters}));
    let status = client.until(|message| message["op"] == "status");
    assert!(status["message"].as_str().expect("a text").contains("--read-only"), "{status}");
    assert_eq!(fleet.status()["clock"], "running");
}

#[test]
fn strangers_are_refused() {
    let fleet = Fleet::start("foxglove-strangers", "thirty.yaml", &[]);
    let token = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(unique("token").as_str());
    std::fs::write(&token, "a-token-of-mine\n").expect("written");
    let token = token.to_str().expect("a path");
    let allowed = "https://studio.example";
    let plugin = Plugin::start(&fleet, &["--token-file", token, "--allow-origin", allowed]);
    let protocol = ("sec-websocket-protocol", "foxglove.sdk.v1");
    let right = "/?token=a-token-of-mine";
    for (path, headers, is_admitted) in [
        (right, &[protocol][..], true),
        (right, &[protocol, ("origin", allowed)], true),
        (right, &[protocol, ("origin", "https://evil.example")], false),
        (right, &[protocol, ("host", "rebound.example")], false),
        ("/", &[protocol], false),
    ] {
        let connected = plugin.connect(path, headers);
        assert_eq!(connected.is_ok(), is_admitted, "{path} {headers:?}");
    }
    plugin.says("--allow-origin https://evil.example");
    plugin.says("the token is missing or wrong");
}

#[test]
fn a_paused_fleet_is_seen_by_those_who_come_later() {
    let fleet = Fleet::start("foxglove-paused", "thirty.yaml", &[]);
    let plugin = Plugin::start(&fleet, &[]);
    fleet.control(&["pause"]);
    for topic in ["/robots", "/graph", "/world", "/poses", "/frames", "/robots"] {
        let mut client = plugin.client();
        client.subscribe(topic);
        assert_eq!(client.times(1).len(), 1, "{topic}");
    }
}

#[test]
fn a_new_run_is_a_new_session() {
    let Fleet { name, engine } = Fleet::start("foxglove-runs", "thirty.yaml", &[]);
    let fleet = Fleet { name: name.clone(), engine };
    let plugin = Plugin::start(&fleet, &[]);
    let mut client = plugin.client();
    client.subscribe("/frames");
    client.times(3);
    drop(fleet);
    let _fleet = Fleet::restart(name, "thirty.yaml", &[]);
    let info = client.until(|message| message["op"] == "serverInfo");
    assert!(info["sessionId"].as_str().is_some_and(|id| id.len() == 16), "{info}");
    client.times(3);
}

#[test]
fn bad_clients_cost_others_nothing() {
    let fleet = Fleet::start("foxglove-bad", "thirty.yaml", &["--speed", "1"]);
    let plugin = Plugin::start(&fleet, &["--rate", "all"]);
    let mut good = plugin.client();
    good.subscribe("/robots");
    good.times(1);
    // Two read nothing, and one goes without a word.
    let mut deaf: Vec<Client> = (0..3).map(|_| plugin.client()).collect();
    for client in &mut deaf {
        client.subscribe("/frames");
    }
    drop(deaf.pop());
    // One sends what isn't of the protocol, and one too much of what is.
    let mut malformed = plugin.client();
    for number in 0..120_u8 {
        let message = if number % 2 == 0 {
            Message::text("{\"op\": \"nothing\"}")
        } else {
            Message::binary(vec![number; 7])
        };
        if malformed.0.send(message).is_err() {
            break;
        }
    }
    assert!(malformed.end().contains("of the protocol"));
    plugin.says("not a message of the protocol");
    let mut long = plugin.client();
    let _ = long.0.send(Message::binary(vec![0; 1 << 20]));
    long.end();
    let flood = flood(plugin.client());
    plugin.says("messages a second");
    let times = good.times(50);
    assert!(times.is_sorted(), "{times:?}");
    let late = fleet.late_ticks();
    let before = fleet.tick();
    fleet.let_ticks_pass(50);
    assert!(fleet.tick() > before && good.times(20).is_sorted(), "{late} ticks were late");
    drop(flood);
    let Plugin { process, messages, .. } = plugin;
    let output = process.interrupt();
    assert!(output.status.success(), "{:?}", messages.try_iter().collect::<Vec<_>>());
}

/// Asks for parameters without pause on a thread, until the connection ends.
fn flood(mut client: Client) -> TcpStream {
    let handle = client.0.get_ref().try_clone().expect("a handle");
    let mut reader = handle.try_clone().expect("a handle");
    std::thread::spawn(move || {
        let question = json!({"op": "getParameters", "parameterNames": []}).to_string();
        while client.0.send(Message::text(question.clone())).is_ok() {}
    });
    std::thread::spawn(move || {
        let mut bytes = [0; 1 << 16];
        while reader.read(&mut bytes).is_ok_and(|count| count > 0) {}
    });
    handle
}

#[test]
fn a_layout_is_written_for_the_fleet() {
    let fleet = Fleet::start("foxglove-layout", "thirty.yaml", &[]);
    let name = format!("{}.json", unique("layout"));
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let write = || {
        let mut command = regatta();
        command.args(["plugin", "foxglove", "--fleet", fleet.name.as_str(), "--layout"]);
        Process::start(command.arg(&path)).finish()
    };
    let output = write();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let layout: Value =
        serde_json::from_slice(&std::fs::read(&path).expect("a file")).expect("JSON");
    assert!(layout["configById"]["3D!regatta"]["cameraState"]["distance"].as_f64() > Some(1.0));
    let again = write();
    assert!(!again.status.success());
    assert!(String::from_utf8_lossy(&again.stderr).contains("exists already"));
}

#[test]
fn a_port_in_use_is_told_with_the_remedy() {
    let fleet = Fleet::start("foxglove-port", "thirty.yaml", &[]);
    let first = Plugin::start(&fleet, &[]);
    let mut command = regatta();
    command.args(["plugin", "foxglove", "--fleet", fleet.name.as_str(), "--listen"]);
    let output = Process::start(command.arg(first.address.to_string())).finish();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("--listen"), "{message}");
    eventually("the first one goes on", || first.client().0.read().ok());
}
