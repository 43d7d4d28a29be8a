//! The recorder: it stores every frame bit for bit, and keeps its file readable when it is killed or the disk is full.

use std::path::{Path, PathBuf};
use std::process::Command;

use regatta_engine::digest::Digest;
use regatta_plugin::FleetName;
use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};
use regatta_record::{ReadingError, Recording, Topic};
use rustix::process::Signal;
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, root, unique};
use crate::readers::costs_no_late_tick;

/// Starts a recorder with the name by which lockstep identifies it.
pub fn recorder(fleet: &FleetName, file: &Path, args: &[&str]) -> Process {
    let fleet = fleet.to_string();
    let mut command = regatta();
    Process::start(command.args(["record", "--fleet", &fleet, "--name", "recorder", "-o"]).arg(file).args(args))
}

/// Records this many ticks of a shipped scenario in lockstep, and returns the engine's digest.
pub fn record(test: &str, scenario: &str, ticks: u32, file: &Path, args: &[&str]) -> String {
    let fleet = unique(test);
    let common = ["--lockstep", "recorder", "--speed", "max", "--digest", "--fleet", &fleet.to_string()];
    let mut command = regatta();
    command.arg("engine").arg(graphs(scenario)).args(common).args(["--ticks", &ticks.to_string()]);
    let engine = Process::start(&mut command);
    let recorder = recorder(&fleet, file, args);
    let output = engine.finish();
    assert!(output.status.success(), "{output:?}");
    let recorded = recorder.interrupt();
    assert!(recorded.status.success(), "{recorded:?}");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Returns the digest of a recording's frames. Like the engine's digest it covers only the first frame of each tick.
pub fn digest(file: &Path) -> String {
    let recording = Recording::open(file).expect("a recording");
    let mut digest = Digest::default();
    let mut last = None;
    recording
        .frames(|_, frame| -> Result<(), ReadingError> {
            if last.replace(frame.tick()) != Some(frame.tick()) {
                let mut lines = vec![Line::default(); frame_lines(frame.len())];
                let copy = ColumnsMut::split(&mut lines, frame.len());
                let (robots, columns) = (frame.len(), frame.columns());
                copy.x[..robots].copy_from_slice(columns.x);
                copy.y[..robots].copy_from_slice(columns.y);
                copy.theta[..robots].copy_from_slice(columns.theta);
                copy.speed[..robots].copy_from_slice(columns.speed);
                copy.s[..robots].copy_from_slice(columns.s);
                copy.edge[..robots].copy_from_slice(columns.edge);
                copy.state[..robots].copy_from_slice(columns.state);
                digest.frame(frame.tick(), robots, &copy);
            }
            Ok(())
        })
        .expect("readable");
    format!("{:032x}", digest.value())
}

pub fn file(folder: &TempDir) -> PathBuf {
    folder.path().join("run.mcap")
}

#[test]
fn every_frame_is_recorded_bit_for_bit() {
    for compression in ["lz4", "zstd", "none"] {
        let folder = TempDir::new().expect("a folder");
        let name = format!("record-{compression}");
        let golden = record(&name, "thirty.yaml", 500, &file(&folder), &["--compression", compression]);
        let recording = Recording::open(&file(&folder)).expect("a recording");
        // Ticks 0 to 500. The last frame may be published again at the end of the run.
        assert!(recording.is_closed() && [501, 502].contains(&recording.count(&Topic::Frames)));
        assert_eq!(digest(&file(&folder)), golden, "{compression}");
    }
}

/// Returns Python if it has the packages that the script needs. If they are missing, the test is skipped, unless the
/// variable `REGATTA_PYTHON_TESTS` requires them.
fn python() -> Option<Command> {
    let mut probe = Command::new("python3");
    let found = probe.args(["-c", "import mcap, mcap_protobuf, xxhash"]).output().is_ok_and(|out| out.status.success());
    assert!(found || std::env::var_os("REGATTA_PYTHON_TESTS").is_none(), "python3 lacks packages that the tests need");
    found.then(|| Command::new("python3"))
}

#[test]
fn other_programs_read_a_recording() {
    let Some(mut python) = python() else { return };
    let folder = TempDir::new().expect("a folder");
    let golden = record("record-python", "thirty.yaml", 1000, &file(&folder), &[]);
    let script = root().join("plugins/record/tests/read_recording.py");
    let output = python.arg(script).arg(file(&folder)).output().expect("python3 starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["digest"], golden);
    // 10 s at 10 Hz, and the first frame.
    assert_eq!((&found["topics"]["/poses"], &found["topics"]["/robots"]), (&101.into(), &101.into()));
    assert_eq!((&found["topics"]["/world"], &found["topics"]["/graph"]), (&1.into(), &1.into()));
    assert!(found["topics"]["/events"].as_u64() > Some(0) && found["topics"]["/columns/type"].as_u64() > Some(0));
    assert_eq!(found["about"]["regatta.end"]["frames_missed"], "0");
}

#[test]
fn one_in_every_n_frames_is_recorded() {
    let folder = TempDir::new().expect("a folder");
    record("record-every", "thirty.yaml", 100, &file(&folder), &["--every", "10"]);
    let mut ticks = Vec::new();
    let recording = Recording::open(&file(&folder)).expect("a recording");
    let read = recording.frames(|_, frame| -> Result<(), ReadingError> {
        ticks.push(frame.tick());
        Ok(())
    });
    read.expect("readable");
    ticks.dedup();
    assert_eq!(ticks, [0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100]);
}

#[test]
fn the_file_of_a_killed_recorder_is_readable_and_can_be_repaired() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    costs_no_late_tick("record-kill", |fleet| {
        let recorder = recorder(&fleet.name, &path, &["--force"]);
        // The file is longer than its header as soon as it has a chunk.
        eventually("a chunk is written", || (std::fs::metadata(&path).ok()?.len() > 1000).then_some(()));
        fleet.let_ticks_pass(120);
        recorder.signal(Signal::KILL);
    });
    let recording = Recording::open(&path).expect("readable without a repair");
    let frames = recording.count(&Topic::Frames);
    assert!(!recording.is_closed() && frames > 0);
    let repaired = regatta().args(["record", "--repair"]).arg(&path).output().expect("regatta starts");
    assert!(repaired.status.success(), "{repaired:?}");
    let recording = Recording::open(&path).expect("a recording");
    assert_eq!((recording.is_closed(), recording.count(&Topic::Frames)), (true, frames));
    digest(&path);
}

#[test]
fn a_stopped_recorder_loses_frames_and_reports_it() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    costs_no_late_tick("record-stop", |fleet| {
        let recorder = recorder(&fleet.name, &path, &["--force"]);
        fleet.let_ticks_pass(100);
        recorder.signal(Signal::STOP);
        fleet.let_ticks_pass(100);
        recorder.signal(Signal::CONT);
        fleet.let_ticks_pass(100);
        let output = recorder.interrupt();
        let report = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && report.contains("that the recorder was too slow for"), "{report}");
    });
}

/// The recorder runs with a limit on the size of files, so that a write fails as it does on a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_ends_the_recording_but_not_the_file() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    let fleet = Fleet::start("record-full", "warehouse-1000.yaml", &["--robots", "5000"]);
    let mut command = Command::new("sh");
    let script = "ulimit -f 12000; exec \"$@\"";
    command.args(["-c", script, "sh", env!("CARGO_BIN_EXE_regatta"), "record", "-o"]).arg(&path);
    let recorder = Process::start(command.args(["--compression", "none", "--fleet", &fleet.name.to_string()]));
    // Well over 12 MB: a block of the limit has 512 or 1024 bytes.
    fleet.let_ticks_pass(200);
    let output = recorder.interrupt();
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{report}");
    assert!(report.contains("nothing is recorded from here on") && report.contains("could not be written"), "{report}");
    let recording = Recording::open(&path).expect("a recording");
    assert!(recording.is_closed() && recording.count(&Topic::Frames) > 0, "{report}");
    digest(&path);
    assert!(fleet.engine.interrupt().status.success());
}

/// Ctrl-C arrives twice if a parent process forwards a signal that the terminal has sent to the whole process group.
#[test]
fn a_second_interrupt_does_not_damage_the_recording() {
    let folder = TempDir::new().expect("a folder");
    let fleet = Fleet::start("record-twice", "thirty.yaml", &[]);
    let recorder = recorder(&fleet.name, &file(&folder), &[]);
    fleet.let_ticks_pass(50);
    recorder.signal(Signal::INT);
    let output = recorder.interrupt();
    assert!(output.status.success(), "{output:?}");
    assert!(Recording::open(&file(&folder)).expect("a recording").is_closed());
}

#[test]
fn an_existing_file_is_not_overwritten() {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(file(&folder), "precious").expect("written");
    let output = recorder(&unique("record-exists"), &file(&folder), &[]).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("--force") && message.lines().count() == 1, "{message}");
    assert_eq!(std::fs::read_to_string(file(&folder)).expect("readable"), "precious");
}

#[test]
fn a_recording_continues_when_the_engine_restarts() {
    let folder = TempDir::new().expect("a folder");
    let fleet = Fleet::start("record-restart", "thirty.yaml", &[]);
    let recorder = recorder(&fleet.name, &file(&folder), &[]);
    fleet.let_ticks_pass(100);
    let name = fleet.name.clone();
    assert!(fleet.engine.interrupt().status.success());
    let fleet = Fleet::restart(name, "thirty.yaml", &[]);
    fleet.let_ticks_pass(100);
    assert!(recorder.interrupt().status.success());
    let (mut runs, mut times) = (Vec::new(), Vec::new());
    let read = Recording::open(&file(&folder)).expect("a recording").frames(|time, frame| {
        runs.push(frame.run_id());
        times.push(time);
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    runs.dedup();
    assert_eq!(runs.len(), 2, "the frames of one run follow those of the other");
    assert!(times.is_sorted());
}

#[test]
fn a_scenario_starts_the_recorder() {
    let folder = TempDir::new().expect("a folder");
    let (path, scenario) = (file(&folder), folder.path().join("scenario.yaml"));
    let text = std::fs::read_to_string(graphs("thirty.yaml")).expect("readable");
    let text = text.replace("graph: porto.yaml", &format!("graph: {}", graphs("porto.yaml").display()));
    let plugin = format!("plugins:\n  - name: record\n    args: [\"-o\", \"{}\"]\n", path.display());
    std::fs::write(&scenario, text + &plugin).expect("written");
    let mut command = regatta();
    command.arg("run").arg(&scenario).args(["--for", "3s", "--fleet", &unique("record-run").to_string()]);
    let output = Process::start(&mut command).finish();
    assert!(output.status.success(), "{output:?}");
    let recording = Recording::open(&path).expect("a recording");
    assert!(recording.is_closed() && recording.count(&Topic::Frames) > 0);
}

#[test]
fn a_recording_is_exported_to_tables_and_plotted() {
    let folder = TempDir::new().expect("a folder");
    record("record-export", "thirty.yaml", 200, &file(&folder), &[]);
    let in_folder = |name: &str| folder.path().join(name);
    let run = |command: &str, args: &[&str]| {
        let output = regatta().arg(command).arg(file(&folder)).args(args).current_dir(folder.path()).output();
        let output = output.expect("regatta starts");
        assert!(output.status.success(), "{output:?}");
    };
    run("export", &["--csv", "tables", "--robots", "3,7", "--parquet", "all.parquet"]);
    let table = std::fs::read_to_string(in_folder("tables/robot-7.csv")).expect("a table");
    let last: Vec<_> = table.lines().last().expect("a line").split(',').collect();
    let mut x = None;
    let read = Recording::open(&file(&folder)).expect("a recording").frames(|_, frame| {
        x = Some(frame.x()[7]);
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    assert_eq!((table.lines().count(), last[2], last[5].parse().ok()), (202, "200", x));
    assert!(std::fs::metadata(in_folder("all.parquet")).is_ok_and(|file| file.len() > 0));
    run("plot", &["--robot", "7", "-o", "robot7.svg"]);
    let picture = std::fs::read_to_string(in_folder("robot7.svg")).expect("a picture");
    assert!(picture.starts_with("<svg") && picture.contains("Robot 7") && picture.ends_with("</svg>\n"));
}
