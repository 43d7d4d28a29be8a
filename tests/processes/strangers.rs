//! Strangers on the same machine: other users, and containers that see another `/dev/shm`.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use regatta_plugin::{RUNTIME_DIR_VARIABLE, health};
use tempfile::TempDir;

use crate::fleet::{Process, eventually, graphs, regatta, root, unique};

/// Ids that no account has.
const OWNER: u32 = 61_234;
const STRANGER: u32 = 61_235;

/// A folder that both users can enter, with a copy of the program.
struct Place {
    folder: TempDir,
}

impl Place {
    /// Returns `None` where this user can't be others.
    fn new() -> Option<Self> {
        if !rustix::process::getuid().is_root() {
            println!("skipped: only root can start processes of two users");
            return None;
        }
        let folder = TempDir::new().expect("a folder");
        let place = Self { folder };
        fs::set_permissions(place.folder.path(), fs::Permissions::from_mode(0o755)).expect("set");
        // By another process: a child that another test starts meanwhile would keep a file that this
        // one writes open, and the program couldn't be started.
        let mut copy = Command::new("cp");
        copy.arg(env!("CARGO_BIN_EXE_regatta")).arg(place.program());
        assert!(copy.status().expect("it starts").success());
        // iceoryx2 sets the umask of the process, which other tests share, while it makes a socket.
        let for_all = fs::Permissions::from_mode(0o755);
        fs::set_permissions(place.program(), for_all.clone()).expect("set");
        for user in [OWNER, STRANGER] {
            let own = place.own(user);
            fs::create_dir(&own).expect("created");
            fs::set_permissions(&own, for_all.clone()).expect("set");
            chown(&own, Some(user), Some(user)).expect("given");
        }
        Some(place)
    }

    fn program(&self) -> PathBuf {
        self.folder.path().join("regatta")
    }

    /// The directory of a user's shared memory.
    fn own(&self, user: u32) -> PathBuf {
        self.folder.path().join(user.to_string())
    }

    /// Returns a command of a user, in the directory of `of`.
    fn regatta(&self, user: u32, of: u32, args: &[&str]) -> Command {
        let mut command = Command::new(self.program());
        command.args(args).env_remove("DISPLAY").env(RUNTIME_DIR_VARIABLE, self.own(of));
        command.uid(user).gid(user).current_dir(root());
        command
    }

    /// Runs a command of the owner.
    fn owner(&self, args: &[&str]) -> Output {
        Process::start(&mut self.regatta(OWNER, OWNER, args)).finish()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        for user in [OWNER, STRANGER] {
            segments(&self.own(user)).iter().for_each(|segment| remove(segment));
        }
    }
}

fn remove(path: &Path) {
    let is_folder = path.symlink_metadata().is_ok_and(|metadata| metadata.is_dir());
    let removed = if is_folder { fs::remove_dir(path) } else { fs::remove_file(path) };
    removed.expect("removed");
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Sends a request over TCP, and returns the status of the answer.
fn status(address: &str, header: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("connected");
    write!(stream, "GET /v1/status HTTP/1.0\r\n{header}\r\n").expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer.split(' ').nth(1).expect("a status").to_owned()
}

#[test]
fn another_user_neither_reads_nor_sends_orders() {
    let Some(place) = Place::new() else { return };
    let folder = place.folder.path();
    fs::copy(graphs("warehouse.yaml"), folder.join("warehouse.yaml")).expect("copied");
    let scenario = folder.join("scenario.yaml");
    fs::write(&scenario, "graph: warehouse.yaml\nrobots:\n- {count: 5, routes: none}\n")
        .expect("written");
    let (fleet, store) = (unique("two-users"), place.own(OWNER).join("orders.sqlite"));
    let [scenario, store] = [&scenario, &store].map(|path| path.to_str().expect("a path"));
    let fleet = fleet.as_str();
    let engine =
        Process::start(&mut place.regatta(OWNER, OWNER, &["engine", scenario, "--fleet", fleet]));
    let manager = Process::start(&mut place.regatta(
        OWNER,
        OWNER,
        &[
            "plugin",
            "fleet-manager",
            "--fleet",
            fleet,
            "--store",
            store,
            "--http",
            "127.0.0.1:55933",
        ],
    ));
    let list = ["orders", "list", "--fleet", fleet];
    eventually("the manager answers", || place.owner(&list).status.success().then_some(()));

    let own = place.own(OWNER);
    let private = own.join("private");
    for (path, mode) in [
        (private.clone(), 0o700),
        (private.join(format!("{fleet}.orders")), 0o600),
        (private.join("token"), 0o600),
        (PathBuf::from(store), 0o600),
    ] {
        let metadata = path.metadata().expect("it is there");
        assert_eq!((metadata.uid(), metadata.mode() & 0o777), (OWNER, mode), "{}", path.display());
    }
    let url = ["orders", "list", "--url", "http://127.0.0.1:55933"];
    assert!(place.owner(&url).status.success(), "the owner's token is found");
    for args in [&url[..], &list] {
        let mut theirs = place.regatta(STRANGER, STRANGER, args);
        let output = Process::start(&mut theirs).finish();
        assert!(!output.status.success(), "{args:?}: {}", text(&output.stdout));
    }
    let mut intruder = place.regatta(STRANGER, OWNER, &list);
    let message = text(&Process::start(&mut intruder).finish().stderr);
    assert!(message.contains(&format!("belongs to user {OWNER}")), "{message}");
    for header in ["", "Authorization: Bearer 0123456789abcdef\r\n"] {
        assert_eq!(status("127.0.0.1:55933", header), "401");
    }
    assert!(UnixStream::connect(private.join(format!("{fleet}.orders"))).is_ok(), "root may");
    manager.interrupt();
    engine.interrupt();
}

/// Something in the place of a segment.
enum Obstacle {
    File(&'static str),
    Folder,
    Link,
    Pipe,
}

impl Obstacle {
    /// Puts it there, as another user would.
    fn plant(&self, path: &Path) {
        match self {
            Self::File(content) => fs::write(path, content).expect("written"),
            Self::Folder => fs::create_dir(path).expect("created"),
            Self::Link => symlink("/etc/passwd", path).expect("linked"),
            Self::Pipe => {
                assert!(Command::new("mkfifo").arg(path).status().expect("it starts").success());
            }
        }
        std::os::unix::fs::lchown(path, Some(STRANGER), Some(STRANGER)).expect("given");
    }
}

#[test]
fn what_another_user_puts_in_the_way_is_told_with_the_remedy() {
    let Some(place) = Place::new() else { return };
    assert!(place.owner(&["doctor"]).status.success());
    let management = management_segment(&place.own(OWNER));
    let other = management.with_extension("dynamic");
    segments(&place.own(OWNER)).iter().for_each(|segment| remove(segment));
    let obstacles = [
        Obstacle::File(""),
        Obstacle::File("0123456789abcdef"),
        Obstacle::File("rubbish, and more of it than a segment has"),
        Obstacle::Folder,
        Obstacle::Link,
        Obstacle::Pipe,
    ];
    for (path, obstacle) in [&management, &other]
        .into_iter()
        .flat_map(|path| obstacles.iter().map(move |it| (path, it)))
    {
        obstacle.plant(path);
        for args in [&["status"][..], &["engine", "graphs/thirty.yaml"]] {
            let output = place.owner(args);
            let message = text(&output.stderr);
            assert!(!output.status.success() && message.lines().count() == 1, "{message}");
            assert!(message.contains(&format!("belongs to user {STRANGER}")), "{message}");
            assert!(message.contains(RUNTIME_DIR_VARIABLE), "{message}");
        }
        let output = place.owner(&["doctor", "--clean"]);
        let printed = text(&output.stdout);
        assert!(!output.status.success() && printed.contains("belongs to user"), "{printed}");
        assert!(printed.starts_with("warn  cleaned up"), "{printed}");
        let elsewhere = place.own(OWNER).join("elsewhere");
        let mut command = place.regatta(OWNER, OWNER, &["doctor"]);
        let output = Process::start(command.env(RUNTIME_DIR_VARIABLE, &elsewhere)).finish();
        assert!(output.status.success(), "the remedy works: {}", text(&output.stdout));
        segments(&elsewhere).iter().for_each(|segment| remove(segment));
        remove(path);
    }
    assert!(place.owner(&["doctor"]).status.success());
}

/// Runs the program in a container that shares a directory, but not `/dev/shm`.
fn in_container(directory: &Path, args: &[&str]) -> Output {
    let script = "mount -t tmpfs tmpfs /dev/shm && exec \"$0\" \"$@\"";
    let mut command = Command::new("unshare");
    command.args(["--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_regatta")]).args(args);
    Process::start(command.current_dir(root()).env(RUNTIME_DIR_VARIABLE, directory)).finish()
}

#[test]
fn a_container_that_sees_other_shared_memory_is_refused_and_harms_no_fleet() {
    let directory = TempDir::new().expect("a folder");
    if !in_container(TempDir::new().expect("a folder").path(), &["--version"]).status.success() {
        println!("skipped: this user may not mount a /dev/shm of its own");
        return;
    }
    let here = |args: &[&str]| {
        let mut command = regatta();
        command.current_dir(root()).args(args).env(RUNTIME_DIR_VARIABLE, directory.path());
        Process::start(&mut command)
    };
    let engine = here(&["engine", "graphs/thirty.yaml", "--fleet", "contained"]);
    let answers = || here(&["status", "--fleet", "contained"]).finish().status.success();
    eventually("the engine answers", || answers().then_some(()));
    for args in [
        &["status", "--fleet", "contained"][..],
        &["plugin", "hello", "--fleet", "contained"],
        &["engine", "graphs/thirty.yaml", "--fleet", "other"],
        &["doctor", "--clean"],
    ] {
        let output = in_container(directory.path(), args);
        let message = text(&[output.stdout, output.stderr].concat());
        assert!(!output.status.success(), "{args:?}: {message}");
        assert!(message.contains("processes that see another /dev/shm"), "{args:?}: {message}");
        assert!(answers(), "the owner steers its fleet after {args:?}");
    }
    assert!(here(&["pause", "--fleet", "contained"]).finish().status.success());
    assert!(engine.interrupt().status.success());
    let output = in_container(directory.path(), &["doctor"]);
    assert!(output.status.success(), "nobody else is there: {}", text(&output.stdout));
    segments(directory.path()).iter().for_each(|segment| remove(segment));
}

/// Returns the segments of a directory.
fn segments(directory: &Path) -> Vec<PathBuf> {
    let Ok(metadata) = directory.metadata() else { return Vec::new() };
    let prefix = format!("regatta_{:x}-{:x}_", metadata.dev(), metadata.ino());
    let entries = fs::read_dir(health::SHARED_MEMORY).expect("listed").flatten();
    let named = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    named.map(|entry| entry.path()).collect()
}

fn management_segment(directory: &Path) -> PathBuf {
    let mut all = segments(directory).into_iter();
    all.find(|path| path.extension().is_some_and(|it| it == "global_mgmt")).expect("a segment")
}
