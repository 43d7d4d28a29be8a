//! The validator on real engines, in lockstep, and on a recording.

use std::process::Output;

use crate::fleet::{Process, graphs, regatta, unique};

/// Runs a shipped scenario for some ticks under the validator, and returns what that says.
fn validated(test: &str, scenario: &str, ticks: &str, args: &[&str]) -> Output {
    let fleet = unique(test).to_string();
    let validator =
        Process::start(regatta().args(["plugin", "validator", "--fleet", &fleet]).args(args));
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(graphs(scenario))
        .args(["--fleet", &fleet, "--ticks", ticks, "--speed", "max"]);
    let output = Process::start(engine.args(["--lockstep", "validator"])).finish();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    validator.interrupt()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn robots_of_shipped_scenarios_move_as_they_should() {
    for (scenario, ticks) in [("square.yaml", "6000"), ("thirty.yaml", "6000")] {
        let output = validated("validator-clean", scenario, ticks, &["--allow", "contact"]);
        assert!(output.status.success(), "{scenario}: {}", text(&output));
        assert!(
            text(&output).contains("validator: ") && !text(&output).contains("missed"),
            "{}",
            text(&output)
        );
    }
}

#[test]
fn the_demo_without_a_manager_has_contacts_and_no_other_fault() {
    let folder = tempfile::tempdir().expect("a folder");
    let json = folder.path().join("report.json");
    let markdown = folder.path().join("report.md");
    let files = ["--json", json.to_str().unwrap(), "--markdown", markdown.to_str().unwrap()];
    let output = validated("validator-demo", "warehouse-1000.yaml", "500", &files);
    assert!(!output.status.success(), "contacts are findings: {}", text(&output));
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(json).unwrap()).expect("JSON");
    for kind in report["kinds"].as_array().expect("kinds") {
        let is_contact = kind["kind"] == "contact";
        assert_eq!(kind["count"].as_u64().unwrap() > 100, is_contact, "{kind}");
        assert!(is_contact || kind["count"] == 0, "{kind}");
    }
    assert!(std::fs::read_to_string(markdown).unwrap().contains("## contact"));
}

#[test]
fn a_recording_is_judged_as_its_fleet_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let fleet = unique("validator-recording").to_string();
    let recorder = Process::start(regatta().args(["record", "--fleet", &fleet, "-o"]).arg(&file));
    let mut engine = regatta();
    engine
        .arg("engine")
        .arg(graphs("thirty.yaml"))
        .args(["--fleet", &fleet, "--ticks", "1000", "--speed", "max"]);
    assert!(Process::start(engine.args(["--lockstep", "record"])).finish().status.success());
    assert!(recorder.interrupt().status.success());
    let validate =
        |args: &[&str]| Process::start(regatta().arg("validate").arg(&file).args(args)).finish();
    let output = validate(&["--allow", "contact"]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("1001 frames of 30 robots in 10.00 s"), "{}", text(&output));
    let output = validate(&["--allow", "collisions"]);
    assert!(text(&output).contains("invalid value 'collisions'"), "{}", text(&output));
}
