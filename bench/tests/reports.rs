//! `regatta-bench`: its reports end whatever their options, count no run that failed, and leave
//! nothing behind when they are interrupted. It measures the program `regatta` beside it, which
//! `cargo test --workspace` builds.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use regatta_plugin::health;
use rustix::process::{Pid, Signal, kill_process};

/// The longest time that a test waits for anything; test machines may be busy.
const TIMEOUT: Duration = Duration::from_secs(60);

fn bench() -> Command {
    Command::new(env!("CARGO_BIN_EXE_regatta-bench"))
}

fn report(folder: &Path, args: &[&str]) -> Output {
    bench().args(args).arg("--out").arg(folder).output().expect("regatta-bench starts")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A running report, which is killed when the value is dropped, also if the test fails.
struct Report(Option<Child>);

impl Report {
    fn start(command: &mut Command) -> Self {
        let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(Some(command.spawn().expect("regatta-bench starts")))
    }

    fn id(&self) -> u32 {
        self.0.as_ref().expect("it runs").id()
    }

    /// Sends SIGINT as Ctrl-C does, waits for the end of the process and returns its output.
    fn interrupt(mut self) -> Output {
        let pid = Pid::from_raw(self.id() as i32).expect("a pid");
        kill_process(pid, Signal::INT).expect("the process exists");
        self.0.take().expect("it runs").wait_with_output().expect("its output")
    }
}

impl Drop for Report {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            // An error means that the process has ended already.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

#[test]
fn a_missing_program_is_an_error_that_says_what_to_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = report(folder.path(), &["--regatta", "/no/regatta", "study"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        message.starts_with("regatta-bench: can't run /no/regatta: ")
            && message.contains("`cargo build --release`"),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn options_out_of_range_are_refused_before_anything_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, expected) in [
        (["udp", "--secs", "0"], "1..=86400"),
        (["management", "--duration", "39"], "give 40 s to 7 days"),
        (["management", "--rate", "9"], "10..=1000"),
        (["management", "--only", "rest"], "possible values"),
        (["plants", "--seeds", "1"], "2..=1000"),
        (["plants", "--planners", "lanes,lanes"], "give it once"),
        (["plants", "--planners", "lanes,tram"], "unknown planner 'tram'"),
        (["plants", "--only", "atlantis"], "no plant has such a name"),
        (["plants", "--layouts", "/no/plants"], "/no/plants: can't read"),
        (["scaling", "--only", "edges,edges"], "give it once"),
        (["scaling", "--max-robots", "0"], "at least 1"),
    ] {
        let output = report(folder.path(), &args);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(expected), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    assert!(names(folder.path()).is_empty());
}

#[test]
fn an_error_of_the_engine_is_the_error_of_the_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = report(folder.path(), &["udp", "--robots", "17M", "--hz", "1"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && message.contains("17000000 robots are too many"),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn costs_are_measured_by_robots_readers_and_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let parts = ["--only", "robots,readers,runs", "--secs", "1"];
    let sizes = ["--max-robots", "10", "--max-readers", "1", "--max-runs", "10"];
    let output = report(folder.path(), &[&["scaling"], &parts[..], &sizes[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["scaling.json", "scaling.md", "scaling.svg"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("scaling.json")).expect("a file"))
            .expect("JSON");
    let amounts = |table: usize| -> Vec<_> {
        let lines = json["tables"][table]["series"][0]["lines"].as_array().expect("lines");
        lines.iter().map(|line| line["amount"].as_u64().expect("a number")).collect()
    };
    assert_eq!([amounts(0), amounts(1), amounts(2)], [vec![1, 10], vec![0, 1], vec![10]]);
    let robots = &json["tables"][0]["series"][0]["lines"][1];
    assert!(robots["tick_cost_p50_ms"].as_f64() > Some(0.0), "{robots}");
    assert!(robots["ticks"].as_u64() > Some(50), "{robots}");
    assert!(json["tables"][2]["series"][0]["lines"][0]["secs"].as_f64() > Some(0.0), "{json}");
}

/// A report of few robots for a short time. The manager has enough to do for a comparison with the
/// bound.
#[test]
fn the_fleet_manager_is_measured_without_contacts() {
    let folder = tempfile::tempdir().expect("a folder");
    let parts = ["--only", "throughput,stalls,breakdowns,hour"];
    let sizes = ["--robots", "12", "--seeds", "7", "--duration", "60"];
    let output = report(folder.path(), &[&["management"], &parts[..], &sizes[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["management.json", "management.md", "management.svg"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("management.json")).expect("readable"))
            .expect("JSON");
    let runs = json["runs"].as_array().expect("runs");
    // Free and limited with their bounds; 10 and 30 % that stall, free and limited; 1, 5 and 12 (of
    // 20) broken.
    assert_eq!(runs.len(), 4 + 4 + 3, "{runs:#?}");
    for run in runs {
        assert_eq!((&run["contacts"], &run["setup"]["robots"]), (&0.into(), &12.into()), "{run}");
        assert!(
            run["mean_cycle_ms"].as_f64() > Some(0.0)
                && run["real_time_factor"].as_f64() > Some(0.0),
            "{run}"
        );
        let all_broken = run["setup"]["broken"] == 12;
        assert_eq!(run["goals_per_sec"].as_f64() > Some(0.0), !all_broken, "{run}");
    }
    let text = String::from_utf8(output.stdout).expect("Markdown");
    for heading in ["## Throughput", "## Stalls", "## Breakdowns", "## Speed in lockstep"] {
        assert!(text.contains(heading), "{text}");
    }
    let rows = text.lines().filter(|line| line.starts_with("| 12 | ")).count();
    assert_eq!(rows, 2 + 6 + 4 + 1, "{text}");
}

/// A plant that holds eight robots, and a layout that the program refuses.
#[test]
fn planners_are_measured_on_plants() {
    let (folder, site) =
        (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    fs::write(site.path().join("broken.yaml"), "Vertices: []\n").expect("it is written");
    let layouts = ["--layouts", site.path().to_str().expect("a path"), "--only", "square,broken"];
    let sizes = ["--robots", "16,2", "--seeds", "2", "--minutes", "2", "--planners", "pibt,lanes"];
    let output = report(folder.path(), &[&["plants"], &layouts[..], &sizes[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["plants.json", "plants.md"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("plants.json")).expect("readable"))
            .expect("JSON");
    let runs = json["plants"][0]["runs"].as_array().expect("runs");
    assert_eq!(runs.len(), 2 * 2, "{json:#}");
    assert!(runs.iter().all(|run| run["robots"] == 2 && run["contacts"] == 0), "{json:#}");
    let refused = json["refused"].as_array().expect("a list");
    assert!(refused.len() == 1 && refused[0]["reason"].as_str() > Some(""), "{json:#}");
    let text = String::from_utf8(output.stdout).expect("Markdown");
    assert!(text.contains("| graphs/square.yaml | pibt | ") && text.contains(" | – | "), "{text}");
}

/// No contact is found in runs that didn't take place.
#[test]
fn a_run_that_fails_is_told_and_counts_for_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let layout = folder.path().join("missing.yaml");
    let layout = ["--layout", layout.to_str().expect("a path")];
    let output = report(
        folder.path(),
        &[&["management", "--only", "hour", "--quick"], &layout[..]].concat(),
    );
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("missing.yaml"), "{message}");
    let text = String::from_utf8(output.stdout).expect("Markdown");
    assert!(text.contains("## Runs that failed") && text.contains("| 300 | – |"), "{text}");
}

/// Standard error isn't a terminal here.
#[test]
fn progress_is_a_line_where_there_is_no_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = report(folder.path(), &["udp", "--secs", "3", "--robots", "10", "--hz", "10"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert_eq!(message, "regatta: sending 10 robots at 10 Hz: 0 of 1 done after 1 s\n");
}

#[test]
fn an_interrupted_report_leaves_nothing() {
    let (folder, temporary) =
        (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let mut command = bench();
    command
        .args(["udp", "--secs", "600", "--robots", "10", "--hz", "10", "--out"])
        .arg(folder.path());
    let report = Report::start(command.env("TMPDIR", temporary.path()));
    let node = format!("regatta/report-udp-{}", report.id());
    let processes = || {
        let occupants = health::occupants().expect("listable").into_iter();
        occupants.filter(|occupant| occupant.alive && occupant.name.starts_with(&node)).count()
    };
    let started = Instant::now();
    while processes() < 4 {
        assert!(started.elapsed() < TIMEOUT, "engine, sender and receiver have not joined");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(!names(temporary.path()).is_empty(), "the experiment has a temporary folder");
    let output = report.interrupt();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && message.ends_with("interrupted; no report was written\n"),
        "{message}"
    );
    assert!(names(temporary.path()).is_empty() && names(folder.path()).is_empty());
    assert_eq!(processes(), 0);
}
