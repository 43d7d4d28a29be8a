//! Files and folders of somebody else: nothing of them runs, falsifies an answer, writes outside of
//! its place, or blocks.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use regatta_study::job::{Job, Manager};
use serde_json::Value;
use tempfile::TempDir;

use crate::fleet::{Process, graphs, regatta};

/// The shortest study: two robots, two runs.
const SHORT: [&str; 8] =
    ["--robots", "2", "--duration", "2min", "--seeds", "2..2", "--reliefs", "0"];

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn study(folder: &Path) -> Output {
    let mut command = regatta();
    command.arg("study").arg(graphs("thirty.yaml")).args(SHORT).arg("--output").arg(folder);
    command.output().expect("regatta starts")
}

/// A folder with a finished study.
struct Finished {
    _outside: TempDir,
    folder: PathBuf,
    answer: Vec<u8>,
}

impl Finished {
    fn new() -> Self {
        let outside = tempfile::tempdir().expect("a folder");
        let folder = outside.path().join("s");
        let output = study(&folder);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let answer = fs::read(folder.join("study.json")).expect("an answer");
        Self { _outside: outside, folder, answer }
    }

    fn files(&self, part: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.folder.join(part)).expect("a folder");
        let files: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
        assert!(!files.is_empty(), "{part}");
        files
    }

    fn change(&self, part: &str, change: impl Fn(&str) -> String) {
        for path in self.files(part) {
            let before = fs::read_to_string(&path).expect("a text");
            let after = change(&before);
            assert_ne!(before, after, "{}", path.display());
            fs::write(&path, after).expect("written");
        }
    }

    /// Does the study again: the answer is the same, and `told` is told.
    fn assert_same_answer(&self, told: &str) {
        fs::remove_file(self.folder.join("study.json")).expect("an answer");
        let output = study(&self.folder);
        let message = text(&output.stderr);
        assert!(output.status.success() && message.contains(told), "{message}");
        let again = fs::read(self.folder.join("study.json")).expect("an answer");
        assert!(again == self.answer, "another answer: {}", text(&again));
    }
}

#[test]
fn a_job_of_a_stranger_is_neither_run_nor_counted() {
    let study = Finished::new();
    let [program, marker] = program(&study.folder);
    let command = serde_json::json!({"command": [program]});
    study.change("jobs", |job| {
        let mut job: Value = serde_json::from_str(job).expect("a job");
        job["manager"] = command.clone();
        format!("{job:#}\n")
    });
    for result in study.files("results") {
        fs::remove_file(result).expect("removed");
    }
    study.assert_same_answer("it was changed, and is written again");
    assert!(!marker.exists(), "the command of a stranger ran");
}

#[test]
fn results_and_layouts_that_were_changed_do_not_change_the_answer() {
    let study = Finished::new();
    study.change("results", |result| result.replace("\"secs\":120.0", "\"secs\":60.0"));
    study.assert_same_answer("or made by another user: its run is done again");
    study.change("results", |_| String::new());
    study.assert_same_answer("its run is done again");
    study.change("results", |result| result[..result.len() - 40].to_owned());
    study.assert_same_answer("its run is done again");
    study.change("files", |layout| layout.replace("Edges:", "# stranger\nEdges:"));
    study.change("results", |result| result.to_lowercase() + " ");
    study.assert_same_answer("it was changed, and is written again");
}

/// Makes a program that leaves a marker beside itself. It takes any arguments.
fn program(folder: &Path) -> [PathBuf; 2] {
    use std::os::unix::fs::PermissionsExt;
    let [program, marker] = ["program", "marker"].map(|name| folder.join(name));
    fs::write(&program, format!("#!/bin/sh\ntouch '{}'\n", marker.display())).expect("written");
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("executable");
    [program, marker]
}

/// Writes a job under the name of its content into a folder, and its layout.
fn forged(study: &Finished, change: impl FnOnce(&mut Job)) -> PathBuf {
    let text = fs::read_to_string(&study.files("jobs")[0]).expect("a job");
    let mut job: Job = serde_json::from_str(&text).expect("a job");
    change(&mut job);
    let path = study.folder.join("jobs").join(format!("{}.json", job.id()));
    fs::write(&path, job.text()).expect("written");
    path
}

fn study_run(job: &Path, args: &[&str]) -> Output {
    regatta().arg("study-run").arg(job).args(args).output().expect("regatta starts")
}

fn refused(job: &Path, reason: &str) {
    let output = study_run(job, &[]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains(reason) && message.lines().count() == 1, "{message}");
}

#[test]
fn a_job_runs_a_program_or_writes_a_file_only_with_trust() {
    let study = Finished::new();
    let [program, marker] = program(&study.folder);
    let words = vec![program.display().to_string()];
    let job = forged(&study, |job| job.manager = Manager::Command(words));
    refused(&job, "it wants to start '");
    assert!(!marker.exists());
    // The program ends at once, so that the run fails; but it was started.
    study_run(&job, &["--trust"]);
    assert!(marker.exists());

    let json = format!("--json={}", marker.display());
    let job = forged(&study, |job| job.manager = Manager::BuiltIn(vec![json]));
    refused(&job, "its manager has the argument '--json=");
    for graph in ["/etc/hostname", "../../x.yaml", "x.yaml"] {
        let job = forged(&study, |job| job.scenario.graph = graph.to_owned());
        refused(&job, &format!("its layout is '{graph}'"));
    }
}

#[test]
fn a_job_that_is_none_is_told_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("job.json");
    let job = r#"{"manager":{"built-in":[]},"program":"x","rate_hz":10,"scenario":S,"secs":6}"#;
    let other = r#"{"graph":"a","rate":1,"seed":1,"robots":[],"load":[]}"#;
    for scenario in ["[]", "[1, 2, 3]", "null", "3", "{}", "[[]]", other] {
        fs::write(&path, job.replace('S', scenario)).expect("written");
        let message = text(&study_run(&path, &[]).stderr);
        let is_told = message.contains("not a job") || message.contains("it was changed");
        assert!(is_told && message.lines().count() == 1, "{scenario}: {message}");
    }
}

#[cfg(unix)]
#[test]
fn links_in_the_folder_of_a_study_are_not_followed() {
    let study = Finished::new();
    let precious = study.folder.with_extension("precious");
    fs::write(&precious, "text").expect("written");
    for name in ["study.json", "index.html", "throughput.png", "study.sqlite"] {
        fs::remove_file(study.folder.join(name)).expect(name);
        std::os::unix::fs::symlink(&precious, study.folder.join(name)).expect("a link");
    }
    study.assert_same_answer("");
    assert_eq!(fs::read_to_string(&precious).expect("a text"), "text");
    let results = study.folder.join("results");
    fs::rename(&results, study.folder.join("moved")).expect("renamed");
    std::os::unix::fs::symlink(study.folder.join("moved"), &results).expect("a link");
    let output = self::study(&study.folder);
    assert!(text(&output.stderr).contains("a link"), "{}", text(&output.stderr));
    assert!(!output.status.success());
}

#[cfg(unix)]
#[test]
fn the_folder_of_another_user_is_refused() {
    // Only root can make one.
    if !rustix::process::geteuid().is_root() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::chown(folder.path(), Some(12_345), None).expect("another owner");
    let output = study(folder.path());
    let message = text(&output.stderr);
    assert!(message.contains("it belongs to another user"), "{message}");
    assert!(!output.status.success());
}

/// Makes a folder with a scenario that starts a program, which leaves a marker.
fn scenario(folder: &Path, args: &str) -> PathBuf {
    let path = folder.join("scenario.yaml");
    let graph = graphs("porto.yaml");
    let scenario = format!(
        "graph: {}\nviewer: off\nrobots: [{{routes: random}}]\nplugins: [{{{args}}}]\n",
        graph.display()
    );
    fs::write(&path, scenario).expect("written");
    path
}

fn run(scenario: &Path, config: &Path, args: &[&str]) -> Output {
    let name = crate::fleet::unique("trust").to_string();
    let mut command = regatta();
    command.env("XDG_CONFIG_HOME", config).arg("run").arg(scenario);
    command.args(["--for", "1s", "--fleet", &name]).args(args);
    Process::start(&mut command).finish()
}

#[test]
fn a_scenario_starts_nothing_until_its_folder_is_trusted() {
    let (folder, config) = (tempfile::tempdir().expect("one"), tempfile::tempdir().expect("two"));
    let [program, marker] = program(folder.path());
    let plugin = format!("name: own, command: [{}]", program.display());
    let recorder = format!("name: record, args: [--output, {}]", marker.display());
    for (plugin, wish) in [(plugin, "program'"), (recorder, "'record --output ")] {
        let path = scenario(folder.path(), &plugin);
        let output = run(&path, config.path(), &[]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        let is_told = message.contains(wish) && message.contains("start it with --trust");
        assert!(is_told && message.lines().count() == 1, "{message}");
        assert!(!marker.exists());
        run(&path, config.path(), &["--trust"]);
        assert!(marker.exists(), "{plugin}");
        fs::remove_file(&marker).expect("a marker");
    }
    assert!(!config.path().join("regatta/trusted").exists(), "--trust is for one run");
    // Nobody is asked for plugins that take part in the fleet, and do nothing else.
    let path = scenario(folder.path(), "name: collision, args: [--margin, '0.3', --summary]");
    let output = run(&path, config.path(), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn a_folder_that_the_user_has_made_is_trusted() {
    let (outside, config) = (tempfile::tempdir().expect("one"), tempfile::tempdir().expect("two"));
    let folder = outside.path().join("plant");
    let new = || {
        let mut command = regatta();
        command.env("XDG_CONFIG_HOME", config.path()).arg("new").arg(graphs("porto.yaml"));
        command.arg("--output").arg(&folder).arg("--force").output().expect("regatta starts")
    };
    assert!(new().status.success());
    let [program, marker] = program(&folder);
    let plugin = format!("name: own, command: [{}]", program.display());
    run(&scenario(&folder, &plugin), config.path(), &[]);
    assert!(marker.exists());
    // One that was there before may hold anything.
    fs::remove_file(config.path().join("regatta/trusted")).expect("a list");
    assert!(new().status.success());
    assert!(!config.path().join("regatta/trusted").exists());
}

#[test]
fn a_study_file_starts_a_manager_only_with_trust() {
    let folder = tempfile::tempdir().expect("a folder");
    let ([program, marker], path) = (program(folder.path()), folder.path().join("s.yaml"));
    let study = format!(
        "plant: {}\nrobots: [2]\nduration: 2min\nreliefs: 0\nvary: {{manager: ['{}']}}\n",
        graphs("thirty.yaml").display(),
        program.display()
    );
    fs::write(&path, study).expect("written");
    let mut command = regatta();
    command.current_dir(folder.path()).arg("study").arg(&path);
    let message = text(&command.output().expect("regatta starts").stderr);
    assert!(message.contains("it wants to start '"), "{message}");
    assert!(!marker.exists() && message.lines().count() == 1, "{message}");
    command.arg("--trust").output().expect("regatta starts");
    assert!(marker.exists());
}

/// The longest time until a command refuses a file. Test machines may be busy.
const REFUSED_WITHIN: Duration = Duration::from_secs(20);

#[cfg(unix)]
#[test]
fn pipes_devices_and_sparse_files_are_refused_everywhere() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let folder = tempfile::tempdir().expect("a folder");
    let pipe = folder.path().join("pipe.mcap");
    mknodat(CWD, &pipe, FileType::Fifo, Mode::from_raw_mode(0o600), 0).expect("a pipe");
    let sparse = folder.path().join("sparse.yaml");
    let file = fs::File::create(&sparse).expect("a file");
    file.set_len(1 << 40).expect("a sparse file");
    let commands: [&[&str]; 13] = [
        &["graph", "check", "FILE"],
        &["graph", "draw", "FILE", "-o", "-"],
        &["graph", "check", "SQUARE", "--background", "FILE"],
        &["run", "FILE"],
        &["run", "FILE", "--in-process", "--simulated", "1s"],
        &["engine", "FILE"],
        &["new", "FILE"],
        &["study", "FILE"],
        &["study-run", "FILE"],
        &["info", "FILE"],
        &["validate", "FILE"],
        &["orders", "import", "FILE"],
        &["orders", "list", "--url", "http://127.0.0.1:9", "--token-file", "FILE"],
    ];
    let square = graphs("square.yaml");
    for file in [pipe.as_path(), &sparse, Path::new("/dev/zero")] {
        for command in commands {
            let words = command.iter().map(|word| match *word {
                "FILE" => file.as_os_str(),
                "SQUARE" => square.as_os_str(),
                word => word.as_ref(),
            });
            let started = Instant::now();
            let mut command = regatta();
            let output = Process::start(command.current_dir(folder.path()).args(words)).finish();
            let message = format!("{command:?}: {}{}", text(&output.stdout), text(&output.stderr));
            assert!(!output.status.success(), "{message}");
            assert!(started.elapsed() < REFUSED_WITHIN, "{message}");
            // A recording may have any size: it isn't read at once.
            let reasons = ["a pipe or a device", "too large", "like an MCAP file"];
            assert!(reasons.iter().any(|reason| message.contains(reason)), "{message}");
        }
    }
}

#[test]
fn small_files_that_take_parsers_long_are_refused_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = 400_000;
    for (before, repeated) in [
        ("graph: x\nrobots: ", "["),
        ("graph: x\nrobots: ", "{a: "),
        ("Vertices: ", "["),
        ("plant: x\nvary: ", "["),
        ("{\"type\": \"FeatureCollection\", \"features\": ", "["),
        ("{\"layouts\": [], \"metaInformation\": ", "[{"),
        ("image: a.pgm\nresolution: 0.05\norigin: ", "["),
        ("", "%TAG !a! b\n"),
    ] {
        let path = folder.path().join("plant");
        fs::write(&path, before.to_owned() + &repeated.repeat(bytes / repeated.len()))
            .expect("written");
        for command in [["graph", "check"].as_slice(), &["run"], &["study"], &["orders", "import"]]
        {
            let started = Instant::now();
            let mut process = regatta();
            let output = Process::start(process.args(command).arg(&path)).finish();
            let message = text(&output.stderr) + &text(&output.stdout);
            assert!(!output.status.success(), "{repeated} {command:?}: {message}");
            assert!(started.elapsed() < REFUSED_WITHIN, "{before}{repeated} {command:?}");
        }
    }
}

#[cfg(unix)]
#[test]
fn a_program_that_waits_for_standard_input_can_be_ended() {
    use rustix::process::Signal;
    let mut command = Command::new(env!("CARGO_BIN_EXE_regatta"));
    command.args(["run", "-"]);
    command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::null());
    let process = Process(command.spawn().expect("regatta starts"));
    // It waits from now on, whatever it has done before.
    std::thread::sleep(Duration::from_millis(300));
    process.signal(Signal::TERM);
    assert!(!process.finish().status.success());
}
