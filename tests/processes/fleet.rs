//! A running engine process under a fleet name of its own.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use regatta_plugin::{FleetName, Subscriber};
use rustix::process::{Pid, Signal, kill_process};

/// Longest wait for anything: these machines may be busy.
pub const PATIENCE: Duration = Duration::from_secs(60);

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn graphs(file: &str) -> PathBuf {
    root().join("graphs").join(file)
}

/// The program, without a display: no test opens a window by the way.
pub fn regatta() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_regatta"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

/// A name that no other test and no other run of the tests uses.
pub fn unique(test: &str) -> FleetName {
    format!("test-{test}-{}", std::process::id()).parse().expect("a fleet name")
}

/// Tries until there is a value.
pub fn eventually<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(value) = attempt() {
            return value;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("{what}: not within {} s", PATIENCE.as_secs());
}

/// A child process that is killed when the test ends, however it ends.
pub struct Process(pub Child);

impl Process {
    pub fn start(command: &mut Command) -> Self {
        let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Self(command.spawn().expect("the program starts"))
    }

    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_raw(self.0.id() as i32).expect("a pid"), signal).expect("the process is there");
    }

    /// Waits for the end and gives what it printed.
    pub fn finish(mut self) -> Output {
        let status = eventually("the process ends", || self.0.try_wait().expect("a status"));
        let read = |pipe: &mut dyn Read| {
            let mut bytes = Vec::new();
            pipe.read_to_end(&mut bytes).expect("its output");
            bytes
        };
        let stdout = self.0.stdout.take().map(|mut pipe| read(&mut pipe)).unwrap_or_default();
        let stderr = self.0.stderr.take().map(|mut pipe| read(&mut pipe)).unwrap_or_default();
        Output { status, stdout, stderr }
    }

    /// Ctrl-C, and what it printed.
    pub fn interrupt(self) -> Output {
        self.signal(Signal::INT);
        self.finish()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let status = self.0.wait();
        // Of a test that failed, this may be the reason.
        if std::thread::panicking() {
            let mut said = String::new();
            let _ = self.0.stderr.take().map(|mut pipe| pipe.read_to_string(&mut said));
            eprintln!("process {}: {status:?} {said}", self.0.id());
        }
    }
}

/// An engine process and its fleet's name.
pub struct Fleet {
    pub name: FleetName,
    pub engine: Process,
}

impl Fleet {
    /// Starts an engine with a shipped scenario and waits for its first frame.
    pub fn start(test: &str, scenario: &str, args: &[&str]) -> Self {
        Self::restart(unique(test), scenario, args)
    }

    /// The same under a name that was used before.
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

    /// A plugin process on this fleet.
    pub fn plugin(&self, name: &str) -> Process {
        Process::start(regatta().args(["plugin", name, "--fleet", &self.name.to_string()]))
    }

    /// Runs a control command, which must succeed.
    pub fn tell(&self, args: &[&str]) {
        let output = regatta().args(args).args(["--fleet", &self.name.to_string()]).output().expect("regatta starts");
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// The status as JSON, as soon as the engine answers.
    pub fn status(&self) -> serde_json::Value {
        eventually("the engine answers", || {
            let output = regatta().args(["status", "--json", "--fleet", &self.name.to_string()]).output().ok()?;
            serde_json::from_slice(&output.stdout).ok()
        })
    }

    pub fn late_ticks(&self) -> u64 {
        self.status()["late_ticks"].as_u64().expect("a count")
    }

    /// Ticks of the run so far.
    pub fn tick(&self) -> u64 {
        self.status()["tick"].as_u64().expect("a count")
    }

    /// Waits until the engine has made so many more ticks.
    pub fn let_ticks_pass(&self, ticks: u64) {
        let from = self.tick();
        eventually("the engine goes on", || (self.tick() >= from + ticks).then_some(()));
    }
}
