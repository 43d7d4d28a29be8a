//! What a person meets at the command line: runs, mistakes, Ctrl-C.

use std::fs;
use std::io::Read;
use std::time::Duration;

use rustix::process::Signal;

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, root, unique};

/// Runs with arguments that must fail, and gives the one line that it says.
fn complaint(args: &[&str]) -> String {
    let output = regatta().args(args).current_dir(root()).output().expect("regatta starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{args:?} succeeded");
    assert_eq!(message.trim_end().lines().count(), 1, "{args:?}: {message}");
    message
}

#[test]
fn mistakes_get_one_line_that_names_them() {
    assert!(complaint(&["run", "no-such-file.yaml"]).contains("no-such-file.yaml"));
    assert!(complaint(&["engine", "graphs"]).contains("graphs"));
    assert!(complaint(&["engine", "Cargo.toml"]).contains("Cargo.toml"));
    assert!(complaint(&["engine", "graphs/porto.yaml"]).contains("porto.yaml"));
    assert!(complaint(&["plugin", "nonsense"]).contains("hello"));
    assert!(complaint(&["graph", "check", "no-such-file.yaml"]).contains("no-such-file.yaml"));
}

fn scenario_with(folder: &tempfile::TempDir, text: &str) -> String {
    fs::copy(graphs("square.yaml"), folder.path().join("square.yaml")).expect("copied");
    let path = folder.path().join("scenario.yaml");
    fs::write(&path, format!("graph: square.yaml\n{text}")).expect("written");
    path.to_string_lossy().into_owned()
}

#[test]
fn a_bad_scenario_is_refused_with_the_entry_that_is_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = [
        ("robots: [{route: [999]}]", "no edge 999"),
        ("robots: [{route: [1]}, {count: 0, routes: random}]", "entry 2"),
        ("robots: []", "at least one"),
        ("rate: 0\nrobots: [{routes: random}]", "rate"),
        ("publish_rate: 200\nrobots: [{routes: random}]", "publish_rate"),
        ("robots: [{routes: random, type: tank}]", "tank"),
        ("robots: [{routes: random}]\ncolour: red", "colour"),
        ("robots: [{routes: random}]\nplugins: [nonsense]", "nonsense"),
    ];
    for (text, wanted) in cases {
        let path = scenario_with(&folder, text);
        let message = complaint(&["run", &path]);
        assert!(message.contains(wanted), "{text}: {message}");
    }
}

#[test]
fn run_prints_a_line_a_second_and_ends_in_time() {
    let name = unique("run-for").to_string();
    let output = regatta().args(["run", "--for", "3s", "--fleet", &name]).output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.lines().filter(|line| line.contains("rtf")).count() >= 2, "{text}");
}

#[test]
fn ctrl_c_stops_engine_and_plugins_cleanly() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scenario_with(&folder, "robots: [{count: 5, routes: random}]\nplugins: [hello]");
    let name = unique("run-ctrl-c");
    let run = Process::start(regatta().args(["run", &path, "--fleet", &name.to_string()]));
    eventually("the engine answers", || {
        regatta().args(["status", "--fleet", &name.to_string()]).output().ok().filter(|output| output.status.success())
    });
    let output = run.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(regatta_plugin::health::services_of(&name).expect("listable").is_empty());
}

#[test]
fn a_child_that_fails_is_named_and_fails_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let plugin = "plugins: [{name: broken, command: [\"false\"]}]";
    let path = scenario_with(&folder, &format!("robots: [{{routes: random}}]\n{plugin}"));
    let name = unique("run-broken").to_string();
    let output = Process::start(regatta().args(["run", &path, "--fleet", &name])).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("broken failed"), "{message}");
}

#[test]
fn a_killed_run_takes_its_engine_along() {
    let name = unique("run-killed");
    let run = Process::start(regatta().args(["run", "--fleet", &name.to_string()]));
    let alive = || {
        let output = regatta().args(["status", "--fleet", &name.to_string()]).output().expect("regatta starts");
        output.status.success()
    };
    eventually("the engine answers", || alive().then_some(()));
    run.signal(Signal::KILL);
    eventually("the engine ends", || {
        std::thread::sleep(Duration::from_millis(50));
        (!alive()).then_some(())
    });
}

#[test]
fn completions_are_printed_for_every_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = regatta().args(["completions", shell]).output().expect("regatta starts");
        assert!(output.status.success() && String::from_utf8_lossy(&output.stdout).contains("regatta"), "{shell}");
    }
}

#[test]
fn a_reader_of_the_output_that_goes_away_ends_a_program_quietly() {
    let fleet = Fleet::start("pipe", "thirty.yaml", &[]);
    let mut plugin = fleet.plugin("hello");
    let mut first = [0; 5];
    plugin.0.stdout.take().expect("a pipe").read_exact(&mut first).expect("its first line");
    assert_eq!(&first, b"tick ");
    let output = plugin.finish();
    assert_eq!(output.status.code(), Some(141), "as after SIGPIPE");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
