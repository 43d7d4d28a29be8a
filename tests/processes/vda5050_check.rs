//! `regatta vda5050 check` on recordings of a broker's traffic, and on a broker (Mosquitto).

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::fleet::{Process, eventually, regatta};

/// A vehicle comes online, is sent an order, and shows it.
const CORRECT: &str = r#"
1700000000.0 1 1 uagv/v2/KIT/0001/connection {HEADER,"connectionState":"ONLINE"}
1700000000.1 0 0 uagv/v2/KIT/0001/state {STATE,"orderId":"","nodeStates":[]}
1700000000.2 0 0 uagv/v2/KIT/0001/order {HEADER,"orderId":"o","orderUpdateId":0,
 "nodes":[{"nodeId":"a","sequenceId":0,"released":true,"actions":[]}],"edges":[]}
1700000000.3 1 1 uagv/v2/KIT/0001/connection {NEXT,"connectionState":"OFFLINE"}
"#;

fn header(number: u32) -> String {
    format!(
        r#""headerId":{number},"timestamp":"2023-11-14T22:13:20.{number}Z","version":"2.1.0",
 "manufacturer":"KIT","serialNumber":"0001""#
    )
}

fn recording(text: &str) -> String {
    let state = r#"HEADER,"orderUpdateId":0,"lastNodeId":"","lastNodeSequenceId":0,"edgeStates":[],
 "driving":false,"actionStates":[],"batteryState":{"batteryCharge":80,"charging":false},
 "operatingMode":"AUTOMATIC","errors":[],"safetyState":{"eStop":"NONE","fieldViolation":false}"#;
    text.replace("STATE", state).replace("HEADER", &header(0)).replace("NEXT", &header(1))
}

fn check(folder: &Path, text: &str, args: &[&str]) -> (Output, String) {
    let file = folder.join("traffic.txt");
    std::fs::write(&file, recording(text)).expect("written");
    let output =
        regatta().args(["vda5050", "check"]).arg(&file).args(args).output().expect("started");
    let text = String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into();
    (output, text)
}

#[test]
fn a_correct_recording_has_no_findings() {
    let folder = tempfile::tempdir().expect("a folder");
    let (output, text) = check(folder.path(), CORRECT, &["--strict"]);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("messages 4, vehicles 1, errors 0, warnings 0"), "{text}");
}

#[test]
fn breaches_are_reported_as_text_as_json_and_for_a_ci() {
    let folder = tempfile::tempdir().expect("a folder");
    let junit = folder.path().join("report.xml");
    let faulty = CORRECT.replace(r#""released":true"#, r#""released":false"#);
    let args = ["--junit", junit.to_str().expect("a path")];
    let (output, text) = check(folder.path(), &faulty, &args);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let line = "2023-11-14T22:13:20.200Z error first-node-unreleased: uagv/v2/KIT/0001/order: \
                the first node 'a' isn't released (master; VDA 5050 2.1.0, 6.6.1)";
    assert!(text.contains(line), "{text}");
    let xml = std::fs::read_to_string(&junit).expect("the report");
    assert!(
        xml.contains("failures=\"1\"") && xml.contains("<failure message=\"1 times: "),
        "{xml}"
    );
    let (output, text) = check(folder.path(), &faulty, &["--json"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((&report["errors"], &report["messages"]), (&1.into(), &4.into()), "{report}");
    assert_eq!(report["findings"][0]["rule"], "first-node-unreleased", "{report}");
    let (output, text) = check(folder.path(), &faulty, &args);
    assert!(!output.status.success() && text.contains("--force replaces it"), "{text}");
}

#[test]
fn warnings_fail_only_if_they_are_asked_to() {
    let folder = tempfile::tempdir().expect("a folder");
    let faulty = CORRECT.replace(r#"{NEXT,"connectionState""#, r#"{LATE,"connectionState""#);
    let faulty = faulty.replace("LATE", &header(3));
    let (output, text) = check(folder.path(), &faulty, &[]);
    assert!(output.status.success() && text.contains("warning header-id-gap"), "{text}");
    let (output, text) = check(folder.path(), &faulty, &["--strict"]);
    assert_eq!(output.status.code(), Some(1), "{text}");
}

#[test]
fn a_stream_is_judged_as_it_comes() {
    let mut check = regatta()
        .args(["vda5050", "check", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let mut input = check.stdin.take().expect("a pipe");
    input.write_all(b"hello\nuagv/v2/KIT/0001/order {\nuagv/v2/KIT/0001/x y\n").expect("written");
    drop(input);
    let output = check.wait_with_output().expect("ended");
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("message 1 error json: ") && text.contains("1 lines"), "{text}");
}

#[test]
fn other_files_are_refused_with_the_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let (output, text) = check(folder.path(), "robots/1 {}\n", &[]);
    assert!(!output.status.success(), "{text}");
    assert!(text.contains("no message of VDA 5050 in 1 lines: record topics"), "{text}");
    let output = regatta().args(["vda5050", "check", "/dev/zero"]).output().expect("started");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("a pipe or a device"), "{text}");
}

/// The program of a broker; `None` if it isn't installed.
fn mosquitto() -> Option<&'static str> {
    let places = ["mosquitto", "/usr/sbin/mosquitto"];
    let found = places.into_iter().find(|place| Command::new(place).arg("-h").output().is_ok());
    if found.is_none() {
        println!("skipped: mosquitto isn't installed (apt-get install mosquitto)");
    }
    found
}

/// A packet of MQTT that begins with a text.
fn packet(kind: u8, text: &str, rest: &[u8]) -> Vec<u8> {
    let length = u8::try_from(2 + text.len() + rest.len()).expect("a short packet");
    let text_length = u8::try_from(text.len()).expect("a short text");
    [&[kind, length, 0, text_length], text.as_bytes(), rest].concat()
}

/// Publishes a message that the broker keeps for those who come later.
fn publish_kept(port: u16, topic: &str, payload: &str) {
    let mut socket = eventually("the broker listens", || TcpStream::connect(("::1", port)).ok());
    let hello = packet(0x10, "MQTT", &[4, 2, 0, 60, 0, 1, b't']);
    let message = packet(0x31, topic, payload.as_bytes());
    socket.write_all(&[hello, message, vec![0xe0, 0]].concat()).expect("sent");
    // The broker closes the connection when it has taken the message.
    let mut answer = Vec::new();
    socket.read_to_end(&mut answer).expect("answered");
    assert_eq!(answer, [0x20, 2, 0, 0]);
}

#[test]
fn a_broker_is_judged_until_it_is_enough() {
    let Some(program) = mosquitto() else { return };
    let socket = TcpListener::bind("[::1]:0").expect("a free port");
    let port = socket.local_addr().expect("an address").port();
    drop(socket);
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("mosquitto.conf");
    std::fs::write(&config, format!("listener {port} ::1\nallow_anonymous true\n"))
        .expect("written");
    let _broker = Process::start(Command::new(program).arg("-c").arg(&config));
    publish_kept(port, "uagv/v2/KIT/0001/order", "{");
    let url = format!("mqtt://[::1]:{port}");
    let mut check = Process::start(regatta().args(["vda5050", "check", &url]));
    let mut output = BufReader::new(check.0.stdout.take().expect("a pipe"));
    let mut line = String::new();
    output.read_line(&mut line).expect("a finding");
    assert!(line.contains("error json: uagv/v2/KIT/0001/order: "), "{line}");
    let ended = check.interrupt();
    output.read_to_string(&mut line).expect("the summary");
    assert_eq!(ended.status.code(), Some(1), "{line}");
    assert!(line.contains("messages 1, vehicles 1, errors 1, warnings 0"), "{line}");
}

#[test]
fn a_broker_that_is_not_there_is_told_with_the_remedy() {
    for (url, reason) in [
        ("mqtt://127.0.0.1:1", "start the broker, or give another address"),
        ("mqtts://127.0.0.1", "mqtts:// isn't supported"),
        ("mqtt://me:secret@127.0.0.1", "a password in an address can be read by others"),
    ] {
        let output = regatta().args(["vda5050", "check", url]).output().expect("started");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && text.contains(reason), "{url}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}
