//! `regatta report`: it ends whatever its options, replaces nothing, and leaves nothing behind when
//! it is interrupted.

use std::fs;
use std::path::Path;
use std::process::Output;

use regatta_plugin::health;

use crate::fleet::{Process, eventually, regatta};

fn report(folder: &Path, args: &[&str]) -> Output {
    regatta().arg("report").args(args).arg("--out").arg(folder).output().expect("regatta starts")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_report_of_a_few_robots_ends_and_is_replaced_only_by_force() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = ["scaling", "--max-robots", "10", "--speed", "100", "--secs", "1"];
    let output = report(folder.path(), &args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(folder.path()), ["scaling.json", "scaling.md", "scaling.svg"]);
    let json: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("scaling.json")).expect("readable"))
            .expect("JSON");
    assert_eq!(
        (&json["loads"][0]["robots"], json["loads"].as_array().map(Vec::len)),
        (&10.into(), Some(1))
    );

    let refused = report(folder.path(), &args);
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && message.contains("--force replaces it"), "{message}");
    assert!(refused.stdout.is_empty(), "nothing is measured in vain");
}

#[test]
fn options_out_of_range_are_refused_before_anything_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, expected) in [
        (["scaling", "--speed", "0"], "from 0.001 to 1000"),
        (["scaling", "--speed", "max"], "from 0.001 to 1000"),
        (["scaling", "--secs", "0"], "1..=86400"),
        (["scaling", "--secs", "18446744073709551615"], "1..=86400"),
        (["scaling", "--threads", "0"], "give 1 to"),
        (["scaling", "--max-robots", "0"], "at least 1 robot"),
        (["udp", "--secs", "0"], "1..=86400"),
        (["management", "--duration", "39"], "give 40 s to 7 days"),
        (["management", "--rate", "9"], "10..=1000"),
        (["management", "--only", "rest"], "possible values"),
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

#[test]
fn an_interrupted_report_leaves_nothing() {
    let (folder, temporary) =
        (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let mut command = regatta();
    command
        .args(["report", "udp", "--secs", "600", "--robots", "10", "--hz", "10", "--out"])
        .arg(folder.path());
    let report = Process::start(command.env("TMPDIR", temporary.path()));
    let node = format!("regatta/report-udp-{}", report.0.id());
    let processes = || {
        let occupants = health::occupants().expect("listable").into_iter();
        occupants.filter(|occupant| occupant.alive && occupant.name.starts_with(&node)).count()
    };
    eventually("engine, sender and receiver have joined", || (processes() >= 4).then_some(()));
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

/// Standard error isn't a terminal here.
#[test]
fn progress_is_a_line_where_there_is_no_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = report(folder.path(), &["udp", "--secs", "3", "--robots", "10", "--hz", "10"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{message}");
    assert_eq!(message, "sending 10 robots at 10 Hz: 0 of 1 done after 1 s\n");
}
