//! The processes of a test, and what it waits for.

use std::net::TcpListener;
use std::process::{Child, Command};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_mirror::MirrorCommand;
use regatta_plugin::{FleetName, Result, Subscriber};
use rustix::process::{Pid, Signal, kill_process};

use crate::engine::{Engine, value};

/// Longest wait for anything: machines may be busy.
const PATIENCE: Duration = Duration::from_secs(60);
/// Separates the arguments of a child.
const SEPARATOR: char = '\n';
const ARGUMENTS: &str = "REGATTA_TEST_ARGUMENTS";

#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: MirrorCommand,
}

/// Not a test but what the children run.
#[test]
fn child() {
    let Ok(arguments) = std::env::var(ARGUMENTS) else { return };
    let arguments: Vec<_> = arguments.split(SEPARATOR).collect();
    let outcome: Result = match arguments[0] {
        "engine" => regatta_plugin::produce_from(Engine::default(), arguments),
        _ => regatta_mirror::run(&Cli::parse_from(arguments).command),
    };
    outcome.expect("the child's work");
}

/// A process; killed when dropped.
pub struct Process(Child);

impl Process {
    /// Starts this program as `arguments`, the first of which is `engine` or `mirror`; after
    /// `prefix`, for example `ip netns exec NAME`.
    pub fn start_in(prefix: &[&str], arguments: &[&str]) -> Self {
        let program = std::env::current_exe().expect("this program");
        let program = program.to_str().expect("UTF-8");
        let mut line = prefix.to_vec();
        line.extend([program, "--exact", "process::child", "--nocapture", "--test-threads=1"]);
        let separator = SEPARATOR.to_string();
        let mut command = Command::new(line[0]);
        let command = command.args(&line[1..]).env(ARGUMENTS, arguments.join(&separator));
        Self(command.spawn().expect("a process"))
    }

    pub fn start(arguments: &[&str]) -> Self {
        Self::start_in(&[], arguments)
    }

    pub fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(self.0.id() as i32).expect("a process");
        kill_process(pid, signal).expect("it lives");
    }

    pub fn is_running(&mut self) -> bool {
        self.0.try_wait().expect("a child").is_none()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A fleet of an engine, the name of its copy, and the address between their hosts.
pub struct Hosts {
    pub fleet: FleetName,
    pub copy: FleetName,
    pub address: String,
}

impl Hosts {
    pub fn new(test: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("mirror-{test}-{}-{number}", std::process::id());
        let port = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("it");
        Self {
            fleet: name.parse().expect("a name"),
            copy: format!("{name}-copy").parse().expect("a name"),
            address: format!("tcp/{port}"),
        }
    }

    pub fn engine(&self) -> Process {
        Process::start(&["engine", "--fleet", self.fleet.as_str(), "--rate", "50"])
    }

    pub fn send(&self) -> Process {
        self.send_with(&[])
    }

    pub fn send_with(&self, more: &[&str]) -> Process {
        let fleet = self.fleet.as_str();
        let mut line = vec!["mirror", "send", "--fleet", fleet, "--listen", &self.address];
        line.extend(more);
        Process::start(&line)
    }

    pub fn receive(&self) -> Process {
        self.receive_with(&[])
    }

    pub fn receive_with(&self, more: &[&str]) -> Process {
        let mut line = vec!["mirror", "receive", "--from", self.fleet.as_str()];
        line.extend(["--fleet", self.copy.as_str(), "--connect", &self.address]);
        line.extend(more);
        Process::start(&line)
    }

    /// Waits until the copy shows frames after the newest one, each bit for bit the engine's.
    /// Returns the run.
    pub fn wait_for_frames(&self) -> u64 {
        let mut frames = Subscriber::open(&self.copy).expect("a subscriber");
        let mut seen = 0;
        wait_for("frames", || {
            let frame = frames.wait(Duration::from_millis(100)).expect("a frame or none")?;
            assert_eq!(frame.len(), Engine::ROBOTS);
            for (row, x) in frame.x().iter().enumerate() {
                assert_eq!(x.to_bits(), value(frame.tick(), row).to_bits());
                assert_eq!((frame.edge()[row], frame.state()[row]), (0, 1));
            }
            seen += 1;
            // The first may be one of a process that was killed.
            (seen > 3).then(|| frame.run_id())
        })
    }
}

/// Waits until `check` returns something.
pub fn wait_for<T>(what: &str, mut check: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(found) = check() {
            return found;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("waited {PATIENCE:?} for {what}");
}
