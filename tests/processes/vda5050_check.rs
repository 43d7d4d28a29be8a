//! `regatta vda5050 check` on recordings of a broker's traffic.

use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use crate::fleet::regatta;

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
