//! The recorder: it stores every frame bit for bit, and keeps its file readable when it is killed
//! or the disk is full.

#[cfg(target_os = "linux")]
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};
use std::process::Command;

use regatta_engine::digest::Digest;
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};
use regatta_plugin::{FleetName, Subscriber, WorldReader};
use regatta_record::{ReadingError, Recording, Topic};
use rustix::process::Signal;
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, graphs, python_with, regatta, root, unique};
use crate::readers::costs_no_late_tick;

/// Starts a recorder with the name by which lockstep identifies it.
pub fn recorder(fleet: &FleetName, file: &Path, args: &[&str]) -> Process {
    let fleet = fleet.to_string();
    let mut command = regatta();
    Process::start(
        command
            .args(["record", "--fleet", &fleet, "--name", "recorder", "-o"])
            .arg(file)
            .args(args),
    )
}

/// Records this many ticks of a shipped scenario in lockstep, and returns the engine's digest.
pub fn record(test: &str, scenario: &str, ticks: u32, file: &Path, args: &[&str]) -> String {
    let fleet = unique(test);
    let common =
        ["--lockstep", "recorder", "--speed", "max", "--digest", "--fleet", &fleet.to_string()];
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

/// Returns the digest of a recording's frames. Like the engine's digest it covers only the first
/// frame of each tick.
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
        let golden =
            record(&name, "thirty.yaml", 500, &file(&folder), &["--compression", compression]);
        let recording = Recording::open(&file(&folder)).expect("a recording");
        // Ticks 0 to 500. The last frame may be published again at the end of the run.
        assert!(recording.is_closed() && [501, 502].contains(&recording.count(&Topic::Frames)));
        assert_eq!(digest(&file(&folder)), golden, "{compression}");
    }
}

#[test]
fn other_programs_read_a_recording() {
    let Some(mut python) = python_with("mcap, mcap_protobuf, xxhash") else { return };
    let folder = TempDir::new().expect("a folder");
    let golden = record("record-python", "thirty.yaml", 1000, &file(&folder), &[]);
    let script = root().join("plugins/record/tests/read_recording.py");
    let output = python.arg(script).arg(file(&folder)).output().expect("python3 starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["digest"], golden);
    // 10 s at 10 Hz, and the first frame.
    assert_eq!(
        (&found["topics"]["/poses"], &found["topics"]["/robots"]),
        (&101.into(), &101.into())
    );
    // Recorded once, and repeated so that no lost chunk costs them.
    assert_eq!((&found["topics"]["/world"], &found["topics"]["/graph"]), (&2.into(), &2.into()));
    assert!(
        found["topics"]["/events"].as_u64() > Some(0)
            && found["topics"]["/columns/type"].as_u64() > Some(0)
    );
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

/// Records a fleet and its contacts in lockstep, ticks 0 to 150.
pub fn record_contacts(test: &str, file: &Path, args: &[&str]) {
    let fleet = unique(test);
    let mut command = regatta();
    command.arg("engine").arg(graphs("warehouse-1000.yaml")).args([
        "--robots",
        "300",
        "--fleet",
        &fleet.to_string(),
    ]);
    command.args(["--lockstep", "recorder", "collision", "--speed", "max", "--ticks", "150"]);
    let engine = Process::start(&mut command);
    let collision =
        Process::start(regatta().args(["plugin", "collision", "--fleet", &fleet.to_string()]));
    let recorder = recorder(&fleet, file, &[&["--poses-rate", "0"], args].concat());
    assert!(engine.finish().status.success());
    for process in [collision, recorder] {
        assert!(process.interrupt().status.success());
    }
}

/// Returns the ticks of all lists of contacts, and checks that each list has as many pairs as its
/// header says.
fn lists_of_contacts(recording: &Recording) -> Vec<u64> {
    let mut ticks = Vec::new();
    let read = recording.contacts(|_, header, pairs| {
        let touching =
            pairs.iter().filter(|pair| pair.level == ContactLevel::Touching as u32).count();
        assert_eq!(
            (header.touching as usize, (header.touching + header.possible) as usize),
            (touching, pairs.len())
        );
        ticks.push(header.tick);
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    ticks
}

#[test]
fn contacts_are_recorded_as_changes() {
    let folder = TempDir::new().expect("a folder");
    record_contacts("record-contacts", &file(&folder), &[]);
    let recording = Recording::open(&file(&folder)).expect("a recording");
    assert_eq!(lists_of_contacts(&recording), (0..=150).collect::<Vec<_>>());
    let lists = [Topic::Contacts, Topic::ContactUpdates].map(|topic| recording.count(&topic));
    assert!(lists[0] <= 4 && lists[0] + lists[1] == 151, "whole lists and updates: {lists:?}");
}

#[test]
fn what_belongs_to_frames_that_are_not_recorded_is_left_out() {
    let folder = TempDir::new().expect("a folder");
    record_contacts("record-thinned", &file(&folder), &["--every", "10"]);
    let recording = Recording::open(&file(&folder)).expect("a recording");
    let tens: Vec<u64> = (0..=150).step_by(10).collect();
    assert_eq!(lists_of_contacts(&recording), tens);
    let counts = ["/frames", "/columns/collision", "/columns/type"]
        .map(|name| recording.count(&Topic::from_name(name).expect("a topic")));
    assert!([16, 17].contains(&counts[0]) && counts[1] == 16, "{counts:?}");
    assert!((1..=4).contains(&counts[2]), "the column that doesn't change is there: {counts:?}");
}

#[test]
fn a_recorder_says_how_fast_the_file_grows() {
    let folder = TempDir::new().expect("a folder");
    let fleet = Fleet::start("record-growth", "thirty.yaml", &[]);
    let recorder = recorder(&fleet.name, &file(&folder), &[]);
    // Said after five seconds.
    fleet.let_ticks_pass(700);
    let output = recorder.interrupt();
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines: Vec<_> = report.lines().filter(|line| line.contains("/s; the disk has ")).collect();
    assert!(
        output.status.success() && lines.len() == 2 && lines[0].contains("it grows by"),
        "{report}"
    );
}

#[test]
fn a_recorder_records_the_chosen_topics_only() {
    let folder = TempDir::new().expect("a folder");
    record_contacts("record-topics", &file(&folder), &["--topics", "events,contacts"]);
    let recording = Recording::open(&file(&folder)).expect("a recording without frames");
    let topics: Vec<_> = recording.topics().iter().map(Topic::name).collect();
    assert_eq!(topics, ["/world", "/events", "/contacts", "/contact_updates"]);
    let output = regatta().arg("replay").arg(file(&folder)).output().expect("regatta starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && message.contains("no frames") && message.lines().count() == 1,
        "{message}"
    );
}

#[test]
fn a_ring_ends_as_one_file_of_the_newest_frames() {
    let folder = TempDir::new().expect("a folder");
    let golden = record("record-ring", "thirty.yaml", 2_000, &file(&folder), &["--ring", "8s"]);
    assert!(!golden.is_empty());
    let files = std::fs::read_dir(folder.path()).expect("a folder").count();
    let recording = Recording::open(&file(&folder)).expect("a recording");
    let mut ticks = Vec::new();
    let read = recording.frames(|_, frame| {
        ticks.push(frame.tick());
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    ticks.dedup();
    let first = ticks[0];
    assert!(
        (1_000..=1_200).contains(&first) && files == 1,
        "8 s to 10 s are kept, from tick {first}, in {files} files"
    );
    assert_eq!(ticks, (first..=2_000).collect::<Vec<_>>());
}

/// The first chunks of a recording have its world and its definitions.
#[test]
fn a_recording_that_lost_its_first_chunk_is_replayed_with_its_world() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    record("record-zeros", "thirty.yaml", 300, &path, &[]);
    let mut bytes = std::fs::read(&path).expect("readable");
    let length = |at: usize| {
        9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("8 bytes")) as usize
    };
    // The records begin after the magic bytes; chunks have the opcode 6.
    let records = std::iter::successors(Some(8), |at| Some(at + length(*at)));
    let first = records.into_iter().find(|at| bytes[*at] == 6).expect("a chunk");
    let end = first + length(first);
    bytes[first..end].fill(0);
    std::fs::write(&path, &bytes).expect("written");
    let repaired =
        regatta().args(["record", "--repair"]).arg(&path).output().expect("regatta starts");
    assert!(repaired.status.success(), "{repaired:?}");

    let fleet = unique("record-zeros-replay");
    let mut command = regatta();
    let replay = Process::start(command.arg("replay").arg(&path).args([
        "--hold",
        "--fleet",
        &fleet.to_string(),
    ]));
    let mut worlds = eventually("the fleet", || WorldReader::open(&fleet).ok());
    let edges = eventually("the world", || {
        worlds.latest().expect("readable").map(|world| world.edges().len())
    });
    assert!(edges > 0);
    let mut frames = eventually("frames", || Subscriber::open(&fleet).ok());
    let robots =
        eventually("a frame", || frames.latest().expect("readable").map(|frame| frame.len()));
    assert_eq!(robots, 30);
    assert!(replay.interrupt().status.success());
}

/// Starts a recorder on a disk of 64 MB, in a mount namespace of its own. Returns `None` if this
/// system doesn't allow users to have one.
#[cfg(target_os = "linux")]
fn recorder_on_small_disk(fleet: &FleetName, disk: &Path) -> Option<Process> {
    let namespace = ["--user", "--map-root-user", "--mount"];
    let mut probe = Command::new("unshare");
    probe.args(namespace).args(["mount", "-t", "tmpfs", "tmpfs"]).arg(disk);
    probe.output().ok().filter(|output| output.status.success())?;
    let script = "mount -t tmpfs -o size=64m tmpfs \"$1\" && dd if=/dev/zero of=\"$1/filler\" bs=1M count=52 2>/dev/null \
                  && exec \"$2\" record -o \"$1/run.mcap\" --poses-rate 0 --compression none --fleet \"$3\"";
    let mut command = Command::new("unshare");
    command.args(namespace).args(["sh", "-c", script, "sh"]).arg(disk);
    Some(Process::start(command.arg(env!("CARGO_BIN_EXE_regatta")).arg(fleet.to_string())))
}

#[cfg(target_os = "linux")]
#[test]
fn a_recording_goes_on_when_a_full_disk_has_room_again() {
    let folder = TempDir::new().expect("a folder");
    let fleet = Fleet::start("record-resume", "warehouse-1000.yaml", &["--robots", "2000"]);
    let Some(recorder) = recorder_on_small_disk(&fleet.name, folder.path()) else { return };
    // The disk as the recorder sees it. It stays as long as it is open.
    let disk = format!("/proc/{}/root{}", recorder.0.id(), folder.path().display());
    let filler = Path::new(&disk).join("filler");
    eventually("the disk", || std::fs::metadata(&filler).ok());
    let handle = std::fs::File::open(&disk).expect("opened");
    let disk = PathBuf::from(format!("/proc/self/fd/{}", handle.as_raw_fd()));
    let closed = |name: &str| Recording::open(&disk.join(name)).ok().filter(Recording::is_closed);
    eventually("the disk is full", || closed("run.mcap"));
    let full = fleet.tick();
    fleet.let_ticks_pass(50);
    std::fs::remove_file(disk.join("filler")).expect("removed");
    eventually("it goes on", || disk.join("run-0002.mcap").exists().then_some(()));
    fleet.let_ticks_pass(100);
    let output = recorder.interrupt();
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        report.contains("until there is room again") && report.contains("there is room again"),
        "{report}"
    );
    assert!(!output.status.success() && report.contains("could not be written"), "{report}");
    let mut ticks = Vec::new();
    let read = closed("run-0002.mcap").expect("a recording").frames(|_, frame| {
        ticks.push(frame.tick());
        Ok::<_, ReadingError>(())
    });
    read.expect("readable");
    assert!(ticks.first().is_some_and(|first| *first > full), "{ticks:?}");
}

#[test]
fn the_file_of_a_killed_recorder_is_readable_and_can_be_repaired() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    costs_no_late_tick("record-kill", |fleet| {
        let recorder = recorder(&fleet.name, &path, &["--force"]);
        // The file is longer than its header as soon as it has a chunk.
        eventually("a chunk is written", || {
            (std::fs::metadata(&path).ok()?.len() > 1000).then_some(())
        });
        fleet.let_ticks_pass(120);
        recorder.signal(Signal::KILL);
    });
    let recording = Recording::open(&path).expect("readable without a repair");
    let frames = recording.count(&Topic::Frames);
    assert!(!recording.is_closed() && frames > 0);
    let repaired =
        regatta().args(["record", "--repair"]).arg(&path).output().expect("regatta starts");
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
        assert!(
            output.status.success() && report.contains("that the recorder was too slow for"),
            "{report}"
        );
    });
}

/// The recorder runs with a limit on the size of files, so that a write fails as it does on a full
/// disk.
#[cfg(unix)]
#[test]
fn a_full_disk_ends_the_recording_but_not_the_file() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    let fleet = Fleet::start("record-full", "warehouse-1000.yaml", &["--robots", "5000"]);
    let mut command = Command::new("sh");
    let script = "ulimit -f 12000; exec \"$@\"";
    command.args(["-c", script, "sh", env!("CARGO_BIN_EXE_regatta"), "record", "-o"]).arg(&path);
    let recorder =
        Process::start(command.args(["--compression", "none", "--fleet", &fleet.name.to_string()]));
    // Well over 12 MB: a block of the limit has 512 or 1024 bytes.
    fleet.let_ticks_pass(200);
    let output = recorder.interrupt();
    let report = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{report}");
    assert!(
        report.contains("nothing is recorded from now on")
            && report.contains("could not be written"),
        "{report}"
    );
    let recording = Recording::open(&path).expect("a recording");
    assert!(recording.is_closed() && recording.count(&Topic::Frames) > 0, "{report}");
    digest(&path);
    assert!(fleet.engine.interrupt().status.success());
}

/// Ctrl-C arrives twice if a parent process forwards a signal that the terminal has sent to the
/// whole process group.
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
    assert!(
        !output.status.success() && message.contains("--force") && message.lines().count() == 1,
        "{message}"
    );
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
    let text =
        text.replace("graph: porto.yaml", &format!("graph: {}", graphs("porto.yaml").display()));
    let plugin =
        format!("plugins:\n  - name: record\n    args: [\"-o\", \"{}\"]\n", path.display());
    std::fs::write(&scenario, text + &plugin).expect("written");
    let mut command = regatta();
    command.arg("run").arg(&scenario).args([
        "--trust",
        "--for",
        "3s",
        "--fleet",
        &unique("record-run").to_string(),
    ]);
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
        let output = regatta()
            .arg(command)
            .arg(file(&folder))
            .args(args)
            .current_dir(folder.path())
            .output();
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
    run("export", &["-o", "events.csv", "--topics", "events"]);
    let events = std::fs::read_to_string(in_folder("events.csv")).expect("a table");
    assert!(events.starts_with("time_s,run,tick,robot,kind,"), "{events}");
    run("plot", &["--robot", "7", "-o", "robot7.svg"]);
    let picture = std::fs::read_to_string(in_folder("robot7.svg")).expect("a picture");
    assert!(
        picture.starts_with("<svg") && picture.contains("Robot 7") && picture.ends_with("</svg>\n")
    );
    run("plot", &["--robot", "7", "-o", "robot7.png"]);
    assert!(std::fs::read(in_folder("robot7.png")).expect("a picture").starts_with(b"\x89PNG"));
}

#[test]
fn a_recording_is_described() {
    let folder = TempDir::new().expect("a folder");
    record("record-info", "thirty.yaml", 200, &file(&folder), &[]);
    let info = |args: &[&str]| {
        let output =
            regatta().arg("info").arg(file(&folder)).args(args).output().expect("regatta starts");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let json: serde_json::Value = serde_json::from_str(&info(&["--json"])).expect("JSON");
    assert_eq!((&json["ticks"], &json["robots"]), (&serde_json::json!([0, 200]), &30.into()));
    assert!(json["fleet"].as_str().is_some_and(|fleet| fleet.contains("record-info")), "{json}");
    assert_eq!(
        (json["runs"].as_array().map(Vec::len), &json["is_closed"]),
        (Some(1), &true.into())
    );
    let text = info(&[]);
    assert!(text.contains("complete   yes") && text.contains("/columns/type"), "{text}");
}

/// A signal ends an export; what it had written is removed.
#[test]
fn nothing_is_left_of_an_interrupted_export() {
    let folder = TempDir::new().expect("a folder");
    let path = file(&folder);
    record("record-interrupt", "warehouse-1000.yaml", 2_000, &path, &["--poses-rate", "0"]);
    for signal in [Signal::INT, Signal::TERM] {
        let mut command = regatta();
        let tables = folder.path().join("tables");
        let export =
            Process::start(command.arg("export").arg(&path).arg("-o").arg(&tables).arg("--long"));
        let started = || std::fs::read_dir(&tables).ok()?.next().map(drop);
        eventually("it writes", started);
        export.signal(signal);
        let output = export.finish();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains("interrupted"), "{message}");
        assert!(!tables.exists(), "{signal:?}");
    }
}
