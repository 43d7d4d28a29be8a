//! The command line as a user sees it: runs, error messages, Ctrl-C.

use std::fs;
use std::io::{Read, Write};
use std::process::Stdio;
use std::time::Duration;

use regatta_plugin::health;
use rustix::process::Signal;

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, root, unique};

/// Runs a command that must fail with an error of one line, and returns this line.
fn error_line(args: &[&str]) -> String {
    let output = regatta().args(args).current_dir(root()).output().expect("regatta starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{args:?} succeeded");
    assert_eq!(message.trim_end().lines().count(), 1, "{args:?}: {message}");
    message
}

#[test]
fn an_error_is_one_line_that_names_the_mistake() {
    assert!(error_line(&["run", "no-such-file.yaml"]).contains("no-such-file.yaml"));
    assert!(error_line(&["engine", "graphs"]).contains("graphs"));
    assert!(error_line(&["engine", "Cargo.toml"]).contains("Cargo.toml"));
    assert!(error_line(&["engine", "graphs/imported/movingai/SOURCE.md"]).contains("SOURCE.md"));
    assert!(error_line(&["plugin", "nonsense"]).contains("hello"));
    assert!(error_line(&["graph", "check", "no-such-file.yaml"]).contains("no-such-file.yaml"));
    assert!(error_line(&["plugin"]).contains("hello"));
    assert!(error_line(&["nonsense"]).contains("'nonsense'"));
    assert!(error_line(&["robots", "many"]).contains("'many'"));
    assert!(error_line(&["robots"]).contains("<ROBOTS>"));
    assert!(error_line(&["engine", "--threads", "0"]).contains("give 1 to"));
    assert!(error_line(&["engine", "--threads", "100000"]).contains("cores"));
    assert!(
        error_line(&["engine", "--lockstep", "hello", "graphs/thirty.yaml"])
            .contains("before --lockstep")
    );
    assert!(error_line(&["plugin", "hello", "--after", "a/b"]).contains("'/' in the name"));
    assert!(error_line(&["plugin", "hello", "--after", "two words"]).contains("' ' in the name"));
    assert!(error_line(&["graph"]).contains("check"));
    let at = error_line(&["viewer", "run.mcap", "--at", "120s"]);
    assert!(at.contains("give --headless with --screenshot, or --svg"), "{at}");
    assert!(
        error_line(&["viewer", "--headless", "--record", "film.mp4", "--for", "0s"])
            .contains("above 0")
    );
}

#[test]
fn messages_in_a_file_have_no_escape_codes() {
    // Without a display, the viewer logs why it can't open a window.
    let output = regatta().args(["viewer", "-v"]).output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("viewer: info: "), "{text}");
    assert!(!text.contains('\u{1b}'), "{text:?}");
}

#[test]
fn an_error_has_no_words_of_the_program() {
    for (args, advice) in [
        (&["robots", "many"][..], "500, 10k or 1M"),
        (&["run", "--robots", "1.5"], "500, 10k or 1M"),
        (&["engine", "--rate", "x"], "give a number"),
        (&["engine", "--ticks", "x"], "give a whole number"),
        (&["step", "99999999999999999999"], "too large"),
        (&["seek", "soon"], "give seconds, or a number with a unit"),
        (&["run", "--for", "-1"], "unexpected argument '-1'"),
    ] {
        let line = error_line(args);
        assert!(line.contains(advice), "{line}");
        for words in ["invalid digit", "float literal", "as a value, use"] {
            assert!(!line.contains(words), "{line}");
        }
    }
}

#[test]
fn a_typo_gets_a_suggestion() {
    let folder = tempfile::tempdir().expect("a folder");
    let misspelt = scenario_with(&folder, "robots: [{node: 1}]\nplugins: [colision]");
    for (args, meant) in [
        (&["rum"][..], "'run'"),
        (&["graph", "chek", "a.yaml"], "'check'"),
        (&["run", "--robot", "5"], "'--robots'"),
        (&["engine", "--isa", "avx22"], "'avx2'"),
        (&["plugin", "helo"], "did you mean 'hello'?"),
        (&["plugin", "hello", "--rat", "5"], "'--rate'"),
        (&["run", &misspelt], "did you mean 'collision'?"),
    ] {
        let line = error_line(args);
        assert!(line.contains(meant), "{line}");
    }
}

/// Returns what the program prints with arguments that ask for help.
fn help(args: &[&str]) -> String {
    let output = regatta().args(args).output().expect("regatta starts");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn help_lists_plugins_and_their_options() {
    assert!(help(&["plugin", "hello", "--help"]).contains("--rate"));
    assert!(help(&["plugin", "--help"]).contains("hello"));
    assert!(help(&["--help"]).contains("graph"));
    assert!(help(&["plugin", "hello", "--help"]).contains("Usage: regatta plugin hello"));
    assert!(help(&["--version"]).starts_with("regatta "));
}

#[test]
fn the_version_names_commit_contract_and_iceoryx2() {
    let output = regatta().arg("--version").output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines: Vec<_> = text.lines().collect();
    let commit = lines[0].split(['(', ')']).nth(1);
    assert_eq!(commit.is_some(), root().join(".git").exists(), "{text}");
    let mut digits = commit.unwrap_or_default().trim_end_matches("-modified").bytes();
    assert!(digits.all(|byte| byte.is_ascii_hexdigit()), "{text}");
    assert_eq!(lines[1], format!("contract {}", regatta_plugin::frame::CONTRACT_VERSION));
    assert!(
        lines[2].strip_prefix("iceoryx2 ").is_some_and(|version| version.starts_with("0.")),
        "{text}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn output_to_a_full_disk_is_reported_in_one_line() {
    let full = fs::File::options().write(true).open("/dev/full").expect("opened");
    let output =
        regatta().args(["completions", "bash"]).stdout(full).output().expect("regatta starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message.starts_with("regatta: can't write") && message.lines().count() == 1,
        "{message}"
    );
}

fn scenario_with(folder: &tempfile::TempDir, text: &str) -> String {
    fs::copy(graphs("square.yaml"), folder.path().join("square.yaml")).expect("copied");
    let path = folder.path().join("scenario.yaml");
    fs::write(&path, format!("graph: square.yaml\n{text}")).expect("written");
    path.to_string_lossy().into_owned()
}

#[test]
fn an_invalid_scenario_is_refused_and_the_error_names_the_entry() {
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
    for (text, expected) in cases {
        let path = scenario_with(&folder, text);
        let message = error_line(&["run", &path]);
        assert!(message.contains(expected), "{text}: {message}");
    }
}

#[test]
fn run_prints_a_line_per_second_and_ends_after_its_time_limit() {
    let name = unique("run-for").to_string();
    let output =
        regatta().args(["run", "--for", "3s", "--fleet", &name]).output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.lines().filter(|line| line.contains("rtf")).count() >= 2, "{text}");
    assert!(text.contains(" 0 contacts"), "the demo's fleet manager keeps robots apart: {text}");
    assert!(text.contains("\norders  "), "it prints what it has done at the end: {text}");
    assert!(text.contains("\nrobots' time ") && !text.contains("|---"), "for people: {text}");
}

#[test]
fn the_unmanaged_demo_has_contacts() {
    let name = unique("run-unmanaged").to_string();
    let args = ["run", "--unmanaged", "--for", "3s", "--fleet", &name];
    let output = regatta().args(args).output().expect("regatta starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success() && text.contains("worst edges") && !text.contains(" 0 contacts"),
        "{text}"
    );
    assert!(error_line(&["run", "--unmanaged", "graphs/thirty.yaml"]).contains("--unmanaged"));
}

#[test]
fn run_announces_the_number_of_robots_that_it_runs() {
    let name = unique("run-robots").to_string();
    let args = [
        "run",
        "graphs/thirty.yaml",
        "--robots",
        "0.1k",
        "--for",
        "1.5",
        "--json",
        "--fleet",
        &name,
    ];
    let output = regatta().args(args).current_dir(root()).output().expect("regatta starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines: Vec<serde_json::Value> =
        lines.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
    assert_eq!(lines[0]["robots"], 100);
    assert_eq!(lines[1]["robots"], 100);
    let plain = regatta()
        .args(["run", "--robots", "50", "--for", "1", "--fleet", &name])
        .output()
        .expect("starts");
    let plain = String::from_utf8_lossy(&plain.stdout).into_owned();
    assert!(plain.starts_with(&format!("fleet '{name}': 50 robots on ")), "{plain}");
}

#[test]
fn a_scenario_can_come_from_standard_input() {
    let text = "graph: graphs/square.yaml\nrobots: [{count: 7, routes: random}]";
    for (command, expected) in
        [(&["engine", "--ticks", "3"][..], "3 ticks"), (&["run", "--for", "1.5"], "robots 7")]
    {
        let name = unique(command[0]).to_string();
        let mut child = regatta()
            .args([command, &["--fleet", &name, "-"]].concat())
            .current_dir(root())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("regatta starts");
        child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("written");
        let output = child.wait_with_output().expect("an output");
        let printed = [output.stdout, output.stderr]
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
            .concat();
        assert!(output.status.success() && printed.contains(expected), "{printed}");
    }
}

#[test]
fn ctrl_c_stops_engine_and_plugins_cleanly() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scenario_with(&folder, "robots: [{count: 5, routes: random}]\nplugins: [hello]");
    let name = unique("run-ctrl-c");
    let run = Process::start(regatta().args(["run", &path, "--fleet", &name.to_string()]));
    eventually("the engine answers", || {
        regatta()
            .args(["status", "--fleet", &name.to_string()])
            .output()
            .ok()
            .filter(|output| output.status.success())
    });
    let output = run.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(health::services_of(&name).expect("listable").is_empty());
}

#[test]
fn a_plugin_that_fails_is_named_and_the_run_fails_at_its_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let plugin = "plugins: [{name: broken, command: [\"false\"]}]";
    let path = scenario_with(&folder, &format!("robots: [{{routes: random}}]\n{plugin}"));
    let name = unique("run-broken").to_string();
    let output =
        Process::start(regatta().args(["run", &path, "--trust", "--for", "2s", "--fleet", &name]))
            .finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("broken failed"), "{message}");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    // A status each second: the first says 0 s.
    assert!(
        text.lines().filter(|line| line.starts_with("t ")).count() >= 2,
        "the run continued: {text}"
    );
}

#[test]
fn the_engine_and_the_plugins_of_a_killed_run_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scenario_with(&folder, "robots: [{count: 5, routes: random}]\nplugins: [hello]");
    let name = unique("run-killed");
    let run = Process::start(regatta().args(["run", &path, "--fleet", &name.to_string()]));
    let processes = || {
        std::thread::sleep(Duration::from_millis(50));
        let node = format!("regatta/{name}/");
        let alive = health::occupants().expect("listable").into_iter();
        alive.filter(|occupant| occupant.name.starts_with(&node) && occupant.alive).count()
    };
    eventually("engine, plugin and control have joined", || (processes() >= 3).then_some(()));
    run.signal(Signal::KILL);
    eventually("all processes end", || (processes() == 0).then_some(()));
}

#[test]
fn lockstep_identifies_a_plugin_by_its_name_in_the_scenario() {
    let folder = tempfile::tempdir().expect("a folder");
    let plugin = format!(
        "plugins: [{{name: mine, command: [\"{}\", plugin, hello]}}]",
        env!("CARGO_BIN_EXE_regatta")
    );
    let path = scenario_with(&folder, &format!("robots: [{{count: 5, routes: random}}]\n{plugin}"));
    let name = unique("run-lockstep").to_string();
    let args = ["run", &path, "--lockstep", "mine", "--lockstep-timeout", "50", "--fleet", &name];
    let run = Process::start(regatta().args(args).arg("--trust"));
    eventually("ticks that the plugin has reported", || {
        let output = regatta()
            .args(["status", "--json", "--fleet", &name])
            .output()
            .expect("regatta starts");
        let status: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
        (status["tick"].as_u64()? > 20).then_some(())
    });
    let output = run.interrupt();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(printed.contains("tick 20: centre"), "{printed}");
}

#[test]
fn completions_are_printed_for_every_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = regatta().args(["completions", shell]).output().expect("regatta starts");
        let script = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && script.contains("regatta"), "{shell}");
        assert!(script.contains("udp-source") && script.contains("lockstep-timeout"), "{shell}");
        // The other shells' scripts complete no values.
        let has_values = ["avx512", "b_at_origin"].iter().all(|value| script.contains(value));
        assert!(has_values || ["elvish", "powershell"].contains(&shell), "{shell}");
    }
}

#[test]
fn man_pages_are_written_for_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = || regatta().arg("man").arg(folder.path()).output().expect("regatta starts");
    assert!(write().status.success());
    for name in
        ["regatta", "regatta-run", "regatta-graph-draw", "regatta-plugin-metrics", "regatta-viewer"]
    {
        let page = fs::read_to_string(folder.path().join(format!("{name}.1"))).expect("a page");
        assert!(page.contains(".TH") && page.contains("SYNOPSIS"), "{page}");
    }
    let again = write();
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force replaces it"), "{again:?}");
}

#[test]
fn a_program_ends_silently_when_the_reader_of_its_output_is_gone() {
    let fleet = Fleet::start("pipe", "thirty.yaml", &[]);
    let mut plugin = fleet.plugin("hello");
    let mut first = [0; 5];
    plugin.0.stdout.take().expect("a pipe").read_exact(&mut first).expect("the first line");
    assert_eq!(&first, b"tick ");
    let output = plugin.finish();
    assert_eq!(output.status.code(), Some(141), "as after SIGPIPE");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn a_plugin_whose_standard_error_is_closed_keeps_running() {
    let name = unique("closed-stderr").to_string();
    let mut plugin = Process::start(regatta().args(["plugin", "hello", "--fleet", &name]));
    drop(plugin.0.stderr.take());
    // After a second it prints that it waits for an engine.
    std::thread::sleep(Duration::from_millis(2_500));
    assert!(plugin.0.try_wait().expect("a status").is_none(), "the plugin ended");
}
