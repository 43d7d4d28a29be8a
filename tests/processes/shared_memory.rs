//! Shared memory that is full, damaged, or crowded: nobody's behaviour ends an engine.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use regatta_plugin::column::COLLISION;
use regatta_plugin::{
    ColumnReader, Commands, Control, OpenError, Participant, RUNTIME_DIR_VARIABLE, RouteClient,
    Subscriber, health, services,
};
use rustix::fs::{AtFlags, CWD, Timespec, Timestamps, utimensat};
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, graphs, messages, regatta, unique};

/// The environment variable by which a test starts itself with a `/dev/shm` of its own.
const ROLE: &str = "REGATTA_TEST_SMALL_MEMORY";

/// Runs a test of this program with another `/dev/shm`, of this size, and a directory of its own.
/// Returns `None` where this user may not mount.
fn with_small_memory(test: &str, size: &str) -> Option<Output> {
    let directory = TempDir::new().expect("a folder");
    let script = format!(
        "mount -t tmpfs -o size={size} tmpfs /dev/shm && exec \"$0\" --exact {test} --nocapture"
    );
    let allowed = Command::new("unshare")
        .args(["--mount", "mount", "-t", "tmpfs", "tmpfs", "/dev/shm"])
        .output();
    if !allowed.is_ok_and(|output| output.status.success()) {
        println!("skipped: this user may not mount a /dev/shm of its own");
        return None;
    }
    let mut command = Command::new("unshare");
    command
        .args(["--mount", "sh", "-c", &script])
        .arg(std::env::current_exe().expect("this program"));
    Some(
        command
            .env(ROLE, size)
            .env(RUNTIME_DIR_VARIABLE, directory.path())
            .output()
            .expect("unshare starts"),
    )
}

fn assert_passed(output: Option<Output>) {
    let Some(output) = output else { return };
    let [printed, messages] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success() && printed.contains("1 passed"), "{printed}\n{messages}");
}

/// Fills what is left of `/dev/shm`.
fn fill() -> PathBuf {
    let path = Path::new("/dev/shm/filler").to_owned();
    let mut file = fs::File::create(&path).expect("created");
    while file.write_all(&[1; 4096]).is_ok() {}
    assert_eq!(health::space().expect("known").available, 0);
    path
}

#[test]
fn full_memory_leaves_frames_out_and_the_engine_goes_on() {
    if std::env::var(ROLE).is_err() {
        return assert_passed(with_small_memory(
            "shared_memory::full_memory_leaves_frames_out_and_the_engine_goes_on",
            "64m",
        ));
    }
    // Frames of 1.5 MB.
    let fleet =
        Fleet::start("full-memory", "warehouse-1000.yaml", &["--robots", "60000", "--rate", "50"]);
    let mut readers: Vec<_> = (0..4).map(|_| fleet.subscriber()).collect();
    eventually("a frame", || readers[0].latest().expect("readable").map(drop));
    // Opened before: there will be no memory for another process.
    let mut control = Control::open(&fleet.name).expect("opened");
    let mut let_ticks_pass = |ticks: u64| {
        let from = control.status().expect("answered").tick;
        eventually("more ticks", || {
            (control.status().expect("answered").tick >= from + ticks).then_some(())
        });
    };
    let_ticks_pass(1);
    let filler = fill();
    // Each reader holds a frame of its own from here on: the engine needs chunks that it hasn't
    // used yet.
    for reader in &mut readers[1..] {
        let_ticks_pass(3);
        let _ = reader.latest().expect("readable");
    }
    let_ticks_pass(20);
    let stuck = readers[0].latest().expect("readable").map(|frame| frame.tick());
    let_ticks_pass(20);
    drop(readers);
    fs::remove_file(filler).expect("removed");
    let mut reader = fleet.subscriber();
    let tick =
        eventually("frames again", || reader.latest().expect("readable").map(|frame| frame.tick()));
    assert!(stuck.is_none_or(|stuck| tick > stuck + 15), "{stuck:?}, {tick}");
    let output = fleet.engine.interrupt();
    let messages = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{messages}");
    assert!(messages.contains("shared memory is full: make /dev/shm larger"), "{messages}");
    assert!(messages.contains("shared memory has room for frames again"), "{messages}");
}

#[test]
fn answers_and_growing_columns_in_full_memory_do_not_end_an_engine() {
    if std::env::var(ROLE).is_err() {
        let test = "shared_memory::answers_and_growing_columns_in_full_memory_do_not_end_an_engine";
        return assert_passed(with_small_memory(test, "64m"));
    }
    let fleet = Fleet::start("full-answers", "warehouse-1000.yaml", &["--rate", "50"]);
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut control = Control::open(&fleet.name).expect("opened");
    let mut routes = RouteClient::open_on(&participant).expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    let from = control.status().expect("answered").tick;
    assert!(routes.route(1).expect("answered").is_found());
    // The command's chunk has memory from here on.
    for _ in 0..200 {
        commands.spawn_at_node(0, u32::MAX);
    }
    commands.send().expect("sent");

    let filler = fill();
    // Answers need chunks that haven't been used yet, and the engine's column `type` one for more
    // robots.
    for _ in 0..4 {
        let _ = routes.routes(&(0..30).collect::<Vec<_>>(), Duration::from_millis(200));
    }
    for _ in 0..200 {
        commands.spawn_at_node(0, 1);
    }
    let _ = commands.send();
    eventually("more ticks", || {
        (control.status().expect("answered").tick >= from + 100).then_some(())
    });
    fs::remove_file(filler).expect("removed");

    // All works again.
    let robots: Vec<_> = (0..30).collect();
    assert_eq!(routes.routes(&robots, Duration::from_secs(5)).expect("answered").len(), 30);
    let output = fleet.engine.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn plugins_go_on_when_memory_was_full_for_a_while() {
    if std::env::var(ROLE).is_err() {
        let test = "shared_memory::plugins_go_on_when_memory_was_full_for_a_while";
        return assert_passed(with_small_memory(test, "64m"));
    }
    let args = ["--robots", "20000", "--rate", "50"];
    let fleet = Fleet::start("full-plugins", "warehouse-1000.yaml", &args);
    let plugins = ["collision", "traffic"].map(|name| fleet.plugin(name));
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let column = COLLISION.name();
    let mut readers: Vec<_> =
        (0..12).map(|_| ColumnReader::open_on(&participant, column).expect("opened")).collect();
    let mut newest = readers.pop().expect("a reader");
    let mut next =
        || eventually("a column", || newest.latest().expect("readable").map(|it| it.header.tick));
    next();
    let filler = fill();
    // Each reader holds a sample of its own from here on: the plugin needs chunks that it hasn't
    // used yet.
    for reader in &mut readers {
        std::thread::sleep(Duration::from_millis(200));
        let _ = reader.latest().expect("readable");
    }
    std::thread::sleep(Duration::from_secs(1));
    let before = eventually("a sample", || readers[10].current().expect("readable"));
    let before = before.header.tick;
    fs::remove_file(filler).expect("removed");
    drop(readers);
    while next() <= before + 50 {}
    for (plugin, is_told) in plugins.into_iter().zip([true, false]) {
        let output = plugin.interrupt();
        let messages = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{messages}");
        let told = messages.matches("samples are left out until there is room").count();
        assert!(!is_told || told == 1, "{messages}");
    }
}

#[test]
fn too_few_open_files_are_told_with_the_limit() {
    for limit in [16, 24, 32] {
        let script = format!("ulimit -n {limit} && exec \"$0\" \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_regatta"), "engine"]);
        command.arg(graphs("thirty.yaml")).args(["--fleet", unique("few-files").as_str()]);
        let output = Process::start(&mut command).finish();
        let message = messages(&output.stderr);
        assert!(!output.status.success() && message.lines().count() == 1, "{limit}: {message}");
        assert!(message.contains(&format!("only {limit} open files")), "{limit}: {message}");
        assert!(message.contains("ulimit -n"), "{limit}: {message}");
    }
}

#[test]
fn an_engine_that_memory_is_too_small_for_says_how_much_it_needs() {
    if std::env::var(ROLE).is_err() {
        let test = "shared_memory::an_engine_that_memory_is_too_small_for_says_how_much_it_needs";
        return assert_passed(with_small_memory(test, "16m"));
    }
    let mut command = regatta();
    command
        .arg("engine")
        .arg(graphs("warehouse-1000.yaml"))
        .args(["--robots", "1000000", "--fleet", "small"]);
    let output = Process::start(&mut command).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    // A busy machine takes so long that progress is told.
    let errors = message.lines().filter(|line| !line.starts_with("regatta: setting the fleet up"));
    assert!(!output.status.success() && errors.count() == 1, "{message}");
    assert!(message.contains("75.0 MB are needed") && message.contains("--shm-size"), "{message}");
}

#[test]
fn joining_with_full_memory_is_an_error_in_one_line() {
    if std::env::var(ROLE).is_err() {
        let test = "shared_memory::joining_with_full_memory_is_an_error_in_one_line";
        return assert_passed(with_small_memory(test, "4m"));
    }
    let filler = fill();
    for arguments in [&["engine", "graphs/thirty.yaml"][..], &["plugin", "hello"], &["status"]] {
        let output =
            Process::start(regatta().current_dir(crate::fleet::root()).args(arguments)).finish();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            output.status.code().is_some_and(|code| code != 0),
            "{arguments:?}: {:?} {message}",
            output.status
        );
        assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    }
    fs::remove_file(filler).expect("removed");
}

#[test]
fn a_damaged_management_segment_is_reported_and_repaired() {
    let directory = TempDir::new().expect("a folder");
    let doctor = |arguments: &[&str]| {
        let mut command = regatta();
        command.arg("doctor").args(arguments).env(RUNTIME_DIR_VARIABLE, directory.path());
        let output = Process::start(&mut command).finish();
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    assert!(doctor(&[]).0);
    // Anybody could write to it until it was closed.
    let segment = management_segment(directory.path());
    fs::write(&segment, "rubbish").expect("written");
    let (healthy, printed) = doctor(&[]);
    assert!(
        !healthy && printed.contains(&format!("{} is damaged", segment.display())),
        "{printed}"
    );
    let mut status = regatta();
    let output =
        Process::start(status.arg("status").env(RUNTIME_DIR_VARIABLE, directory.path())).finish();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("is damaged; `regatta doctor --clean` repairs it"), "{message}");
    let (healthy, printed) = doctor(&["--clean"]);
    assert!(healthy && printed.contains("removed the damaged management segment"), "{printed}");
    let (healthy, printed) = doctor(&["--json"]);
    let mut results =
        printed.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON"));
    assert!(
        healthy && results.any(|result| result["result"] == "ok" && result["message"].is_string()),
        "{printed}"
    );
    remove_segments(directory.path());
}

/// Returns the segments of a directory.
fn segments(directory: &Path) -> Vec<PathBuf> {
    use std::os::unix::fs::MetadataExt;
    let metadata = directory.metadata().expect("a folder");
    let prefix = format!("regatta_{:x}-{:x}_", metadata.dev(), metadata.ino());
    let entries = fs::read_dir(health::SHARED_MEMORY).expect("listed").flatten();
    entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix))
        .map(|entry| entry.path())
        .collect()
}

fn remove_segments(directory: &Path) {
    segments(directory).iter().for_each(|segment| fs::remove_file(segment).expect("removed"));
}

/// Returns the management segment of a directory, which only this user may use.
fn management_segment(directory: &Path) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let is_it =
        |path: &PathBuf| path.extension().is_some_and(|extension| extension == "global_mgmt");
    let segment = segments(directory).into_iter().find(is_it).expect("the management segment");
    assert_eq!(segment.metadata().expect("it exists").permissions().mode() & 0o777, 0o600);
    segment
}

#[test]
fn all_places_can_be_taken_and_the_error_says_by_whom() {
    let fleet = Fleet::start("many-readers", "thirty.yaml", &["--rate", "50"]);
    let participant = Participant::join(&fleet.name, "crowd").expect("joined");
    let mut readers = Vec::new();
    let error = loop {
        match Subscriber::open_on(&participant) {
            Ok(reader) => readers.push(reader),
            Err(error) => break error,
        }
    };
    assert_eq!(readers.len(), services::MAX_READERS);
    let OpenError::Full { limit, .. } = error else { panic!("{error}") };
    assert_eq!(limit, services::MAX_READERS);
    let message = error.to_string();
    assert!(message.contains("crowd") && message.contains("engine"), "{message}");
    for reader in &mut readers {
        assert!(
            reader.wait(Duration::from_secs(10)).expect("readable").is_some(),
            "each of them has frames"
        );
    }
    let name = unique("other");
    assert!(Subscriber::open(&name).is_ok(), "another fleet has places of its own");
}

/// Runs `regatta doctor --clean` in a directory of iceoryx2's files.
fn doctor(directory: &Path) -> Output {
    let mut command = regatta();
    Process::start(command.args(["doctor", "--clean"]).env(RUNTIME_DIR_VARIABLE, directory))
        .finish()
}

/// Sets the time of a file's last change back by a minute: younger files may belong to processes
/// that are joining.
fn age(path: &Path) {
    let minute_ago = SystemTime::now() - Duration::from_secs(60);
    let since_epoch = minute_ago.duration_since(UNIX_EPOCH).expect("after 1970");
    let time = Timespec { tv_sec: since_epoch.as_secs() as i64, tv_nsec: 0 };
    let times = Timestamps { last_access: time, last_modification: time };
    utimensat(CWD, path, &times, AtFlags::empty()).expect("this user's file");
}

/// A process that was killed while it created a segment leaves it without a length. iceoryx2 waits
/// for its creator for ever.
#[test]
fn a_segment_that_was_never_finished_holds_nobody_up() {
    let directory = TempDir::new().expect("a folder");
    assert!(doctor(directory.path()).status.success());
    let unfinished = management_segment(directory.path());
    fs::File::create(&unfinished).expect("emptied");
    age(&unfinished);
    assert!(doctor(directory.path()).status.success());
    remove_segments(directory.path());
}

/// Processes that are killed while they join leave files that iceoryx2 doesn't clean up by itself.
#[test]
fn what_processes_killed_at_their_start_leave_is_cleaned_up() {
    let directory = TempDir::new().expect("a folder");
    let command = |arguments: &[&str]| {
        let mut command = regatta();
        command.args(arguments).env(RUNTIME_DIR_VARIABLE, directory.path());
        Process::start(&mut command)
    };
    let engine = command(&["engine", "graphs/thirty.yaml", "--fleet", "killed-readers"]);
    eventually("the engine answers", || {
        command(&["status", "--fleet", "killed-readers"]).finish().status.success().then_some(())
    });
    for round in 0..12 {
        let readers: Vec<_> =
            (0..5).map(|_| command(&["plugin", "hello", "--fleet", "killed-readers"])).collect();
        std::thread::sleep(Duration::from_millis(3 * round));
        drop(readers);
    }
    let files = fs::read_dir(directory.path().join("nodes")).expect("listed");
    for file in files.map(|file| file.expect("listed").path()).chain(segments(directory.path())) {
        age(&file);
    }
    let output = doctor(directory.path());
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && !printed.contains("can't clean up"), "{printed}");
    let nodes: Vec<_> = fs::read_dir(directory.path().join("nodes"))
        .expect("listed")
        .map(|entry| entry.expect("listed").file_name().to_string_lossy().into_owned())
        .collect();
    // A folder and three files of the engine. `doctor` has removed its own.
    assert!(nodes.len() <= 4, "{} of {nodes:?}", nodes.len());
    assert!(engine.interrupt().status.success());
    remove_segments(directory.path());
}

/// A process that was killed while it created a service leaves a file that others may not read yet.
/// iceoryx2 waits for its creator, and then gives up: no later process could use the service.
#[test]
fn a_service_that_was_never_finished_holds_nobody_up() {
    use std::os::unix::fs::PermissionsExt;
    let directory = TempDir::new().expect("a folder");
    let start = || engine_that_answers(directory.path(), "unfinished");
    let engine = start();
    let services = fs::read_dir(directory.path().join("services")).expect("listed");
    let services: Vec<_> = services.map(|entry| entry.expect("listed").path()).collect();
    assert!(engine.interrupt().status.success() && services.len() > 5, "{services:?}");
    for service in services {
        fs::write(&service, "the half of").expect("written");
        fs::set_permissions(&service, fs::Permissions::from_mode(0o600)).expect("set");
    }
    assert!(start().interrupt().status.success());
    remove_segments(directory.path());
}

/// The last process that used a service may be killed while it removes it: a file stays behind that
/// no process has open, without the segment that belongs to it. iceoryx2 would wait for that segment
/// for ever.
#[test]
fn a_service_that_its_last_process_removed_by_half_holds_nobody_up() {
    let directory = TempDir::new().expect("a folder");
    let start = || engine_that_answers(directory.path(), "removed-by-half");
    let engine = start();
    let copies: Vec<_> = fs::read_dir(directory.path().join("services"))
        .expect("listed")
        .map(|entry| entry.expect("listed").path())
        .map(|path| (fs::read(&path).expect("read"), path))
        .collect();
    assert!(engine.interrupt().status.success() && copies.len() > 5);
    for (text, path) in &copies {
        write_finished(path, text);
        age(path);
    }
    assert!(start().interrupt().status.success());
    remove_segments(directory.path());
}

/// Other processes open the services of a fleet at the moment when it starts, and some of them are
/// killed while they do so.
#[test]
fn a_fleet_starts_while_others_look_at_it() {
    let directory = TempDir::new().expect("a folder");
    let command = |arguments: &[&str]| {
        let mut command = regatta();
        command.args(arguments).env(RUNTIME_DIR_VARIABLE, directory.path());
        Process::start(&mut command)
    };
    for _ in 0..3 {
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            for patience in [0, 7, 29] {
                let (command, is_over) = (&command, &is_over);
                scope.spawn(move || {
                    while !is_over.load(Ordering::Relaxed) {
                        let status = command(&["status", "--fleet", "looked-at"]);
                        if patience == 0 {
                            status.finish();
                        } else {
                            std::thread::sleep(Duration::from_millis(patience));
                        }
                    }
                });
            }
            // Also if the engine doesn't answer: the test then fails, and doesn't wait for ever.
            let over = Over(&is_over);
            let engine = engine_that_answers(directory.path(), "looked-at");
            drop(over);
            let output = engine.interrupt();
            assert!(output.status.success(), "{}", messages(&output.stderr));
        });
    }
    remove_segments(directory.path());
}

/// Sets a flag when it is dropped.
struct Over<'a>(&'a AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Starts an engine with this directory of iceoryx2's files, and waits until it answers.
fn engine_that_answers(directory: &Path, fleet: &str) -> Process {
    let command = |arguments: &[&str]| {
        let mut command = regatta();
        command.args(arguments).env(RUNTIME_DIR_VARIABLE, directory);
        Process::start(&mut command)
    };
    let engine = command(&["engine", "graphs/thirty.yaml", "--fleet", fleet]);
    eventually("the engine answers", || {
        command(&["status", "--fleet", fleet]).finish().status.success().then_some(())
    });
    engine
}

/// Writes the file of a service as its creator leaves it: nobody may write to it.
fn write_finished(path: &Path, text: &[u8]) {
    use std::os::unix::fs::PermissionsExt;
    fs::write(path, text).expect("written");
    fs::set_permissions(path, fs::Permissions::from_mode(0o400)).expect("set");
}
