//! A running engine process with its own fleet name, and helpers for processes.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use regatta_plugin::{FleetName, Subscriber};
use rustix::process::{Pid, Signal, kill_process};

/// The longest time that a test waits for anything; test machines may be busy.
pub const TIMEOUT: Duration = Duration::from_secs(60);

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn graphs(file: &str) -> PathBuf {
    root().join("graphs").join(file)
}

/// Returns a command of the program, without a display so that no test opens a window by accident,
/// and with a folder for settings that isn't the user's.
pub fn regatta() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_regatta"));
    command.env("XDG_CONFIG_HOME", env!("CARGO_TARGET_TMPDIR"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

/// Returns Python if it has the packages that a script needs, separated by commas. If they are
/// missing, the test is skipped, unless the variable `REGATTA_PYTHON_TESTS` requires them.
pub fn python_with(packages: &str) -> Option<Command> {
    let mut probe = Command::new("python3");
    let probe = probe.args(["-c", &format!("import {packages}")]);
    let found = probe.output().is_ok_and(|out| out.status.success());
    assert!(
        found || std::env::var_os("REGATTA_PYTHON_TESTS").is_none(),
        "python3 lacks packages that the tests need: {packages}"
    );
    found.then(|| Command::new("python3"))
}

/// Builds an example crate as its user would, and returns its program.
pub fn build_example(name: &str) -> PathBuf {
    // One folder for all examples: their dependencies are built once.
    let target = root().join("target/built-examples");
    let build = Command::new(env!("CARGO"))
        .args(["build", "--offline", "--manifest-path"])
        .arg(root().join("examples").join(name).join("Cargo.toml"))
        .arg("--target-dir")
        .arg(&target)
        // Its dependencies are built a second time: at least without debug information.
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .output()
        .expect("cargo starts");
    assert!(build.status.success(), "{}", String::from_utf8_lossy(&build.stderr));
    target.join("debug").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

/// Returns a fleet name that no other test and no other run of the tests uses.
pub fn unique(test: &str) -> FleetName {
    format!("test-{test}-{}", std::process::id()).parse().expect("a fleet name")
}

/// Returns the messages of an engine: its standard error without the line that a busy machine takes
/// a second to set the fleet up.
pub fn messages(stderr: &[u8]) -> String {
    let text = String::from_utf8_lossy(stderr);
    text.lines()
        .filter(|line| !line.starts_with("regatta: setting the fleet up"))
        .collect::<Vec<_>>()
        .join("\n")
}

/// Calls `attempt` until it returns a value, and panics after [`TIMEOUT`].
pub fn eventually<T>(expected: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < TIMEOUT {
        if let Some(value) = attempt() {
            return value;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("{expected}: not within {} s", TIMEOUT.as_secs());
}

/// A child process that is killed when the value is dropped, also if the test fails.
pub struct Process(pub Child);

impl Process {
    pub fn start(command: &mut Command) -> Self {
        let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().expect("the program starts"))
    }

    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_raw(self.0.id() as i32).expect("a pid"), signal)
            .expect("the process exists");
    }

    /// Waits for the end of the process and returns its output.
    pub fn finish(mut self) -> Output {
        let status = eventually("the process ends", || self.0.try_wait().expect("a status"));
        let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
        if let Some(pipe) = &mut self.0.stdout {
            pipe.read_to_end(&mut stdout).expect("its output");
        }
        if let Some(pipe) = &mut self.0.stderr {
            pipe.read_to_end(&mut stderr).expect("its messages");
        }
        Output { status, stdout, stderr }
    }

    /// Sends SIGINT as Ctrl-C does, waits for the end of the process and returns its output.
    pub fn interrupt(self) -> Output {
        self.signal(Signal::INT);
        self.finish()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // An error means that the process has ended already.
        let _ = self.0.kill();
        let status = self.0.wait();
        // The messages of the process may explain why the test failed.
        if std::thread::panicking() {
            let mut messages = String::new();
            let _ = self.0.stderr.take().map(|mut pipe| pipe.read_to_string(&mut messages));
            println!("process {}: {status:?} {messages}", self.0.id());
        }
    }
}

/// An engine process and the name of its fleet.
pub struct Fleet {
    pub name: FleetName,
    pub engine: Process,
}

impl Fleet {
    /// Starts an engine with a shipped scenario and waits for its first frame.
    pub fn start(test: &str, scenario: &str, args: &[&str]) -> Self {
        Self::restart(unique(test), scenario, args)
    }

    /// Starts an engine like [`Self::start`], with a given fleet name.
    pub fn restart(name: FleetName, scenario: &str, args: &[&str]) -> Self {
        let mut command = regatta();
        command.arg("engine").arg(graphs(scenario)).args(["--fleet", &name.to_string()]).args(args);
        let fleet = Self { name, engine: Process::start(&mut command) };
        fleet.status();
        fleet
    }

    pub fn subscriber(&self) -> Subscriber {
        eventually("the fleet can be read", || Subscriber::open(&self.name).ok())
    }

    /// Starts a built-in plugin on this fleet.
    pub fn plugin(&self, name: &str) -> Process {
        Process::start(regatta().args(["plugin", name, "--fleet", &self.name.to_string()]))
    }

    /// Runs a control command, for example `pause`, which must succeed.
    pub fn control(&self, args: &[&str]) {
        let output = regatta()
            .args(args)
            .args(["--fleet", &self.name.to_string()])
            .output()
            .expect("regatta starts");
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Waits until the engine answers, and returns its status as JSON.
    pub fn status(&self) -> serde_json::Value {
        eventually("the engine answers", || {
            let output = regatta()
                .args(["status", "--json", "--fleet", &self.name.to_string()])
                .output()
                .ok()?;
            serde_json::from_slice(&output.stdout).ok()
        })
    }

    pub fn late_ticks(&self) -> u64 {
        self.status()["late_ticks"].as_u64().expect("a count")
    }

    /// Returns the current tick.
    pub fn tick(&self) -> u64 {
        self.status()["tick"].as_u64().expect("a count")
    }

    /// Waits until the engine has made this many more ticks.
    pub fn let_ticks_pass(&self, ticks: u64) {
        let from = self.tick();
        eventually("more ticks", || (self.tick() >= from + ticks).then_some(()));
    }
}
