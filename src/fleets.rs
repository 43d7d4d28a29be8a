//! `regatta list` and `regatta stop`: the fleets that run on this machine.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::health::{self, Occupant};
use regatta_plugin::{Control, FleetName};
use serde_json::{Value, json};

use crate::control::{Target, is_paused};
use crate::failure::Failure;

/// The longest time that a producer may take to answer before it is listed as silent.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(1);
/// The longest time that a producer may take to end.
const END_TIMEOUT: Duration = Duration::from_secs(10);

/// A fleet with at least one process.
struct RunningFleet {
    name: FleetName,
    /// The status, or the reason why there is none.
    status: Result<ControlResponse, String>,
    /// The name of the producer in the fleet, for example `engine`; empty if it is unknown.
    producer: String,
}

/// Runs `regatta list`.
pub fn list(json: bool) -> Result<(), Failure> {
    let fleets: Vec<_> = fleets()?
        .into_iter()
        .map(|(name, processes)| RunningFleet::ask(name, &processes))
        .collect();
    if json {
        println!("{:#}", Value::from_iter(fleets.iter().map(RunningFleet::json)));
    } else if fleets.is_empty() {
        println!("no fleet runs here; `regatta run` starts one");
    } else {
        print!("{}", table(&fleets));
    }
    Ok(())
}

/// Returns the live processes of each fleet.
fn fleets() -> Result<BTreeMap<FleetName, Vec<Occupant>>, Failure> {
    let mut fleets: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for occupant in health::occupants()?.into_iter().filter(|occupant| occupant.alive) {
        let fleet = fleet_and_name(&occupant).and_then(|(fleet, _)| fleet.parse().ok());
        if let Some(fleet) = fleet {
            fleets.entry(fleet).or_default().push(occupant);
        }
    }
    Ok(fleets)
}

/// Splits the name of a process in shared memory, `regatta/FLEET/NAME`.
fn fleet_and_name(occupant: &Occupant) -> Option<(&str, &str)> {
    occupant.name.strip_prefix("regatta/")?.split_once('/')
}

impl RunningFleet {
    fn ask(name: FleetName, processes: &[Occupant]) -> Self {
        let status = ask_status(&name).map_err(|failure| failure.to_string());
        let producer = status.as_ref().ok().and_then(|status| producer(processes, status.pid));
        let producer =
            producer.and_then(fleet_and_name).map(|(_, name)| name.to_owned()).unwrap_or_default();
        Self { name, status, producer }
    }

    fn state(&self) -> &str {
        match &self.status {
            Ok(status) if is_paused(status) => "paused",
            Ok(_) => "running",
            Err(reason) => reason,
        }
    }

    /// Returns the ticks per simulated second; `None` before the first tick.
    fn rate_hz(&self) -> Option<f64> {
        let status = self.status.as_ref().ok()?;
        if status.tick == 0 || status.sim_time_nanos == 0 {
            return None;
        }
        let rate_hz = status.tick as f64 / (status.sim_time_nanos as f64 * 1e-9);
        Some((rate_hz * 1000.0).round() / 1000.0)
    }

    fn json(&self) -> Value {
        let status = self.status.as_ref().ok();
        json!({
            "fleet": self.name.as_str(),
            "producer": status.map(|_| &self.producer),
            "pid": status.map(|status| status.pid),
            "robots": status.map(|status| status.robots),
            "rate_hz": self.rate_hz(),
            "state": self.state(),
        })
    }
}

/// Requests the status of a fleet.
fn ask_status(fleet: &FleetName) -> Result<ControlResponse, Failure> {
    let mut control = Control::open(fleet)?;
    if !control.has_engine() {
        return Err("no producer".into());
    }
    let answer = control.request(ControlRequest::new(ControlKind::Status), ANSWER_TIMEOUT);
    answer.map_err(|_| "no answer".into())
}

/// Returns the process of a producer with this id.
fn producer(processes: &[Occupant], pid: u32) -> Option<&Occupant> {
    processes.iter().find(|occupant| occupant.pid == pid)
}

/// Formats a line per fleet below a line of titles.
fn table(fleets: &[RunningFleet]) -> String {
    let mut rows = vec![["FLEET", "PRODUCER", "PID", "ROBOTS", "RATE", "STATE"].map(str::to_owned)];
    for fleet in fleets {
        let (mut pid, mut robots) = Default::default();
        if let Ok(status) = &fleet.status {
            (pid, robots) = (status.pid.to_string(), status.robots.to_string());
        }
        let rate = fleet.rate_hz().map(|rate| format!("{rate} Hz")).unwrap_or_default();
        let (name, producer) = (fleet.name.to_string(), fleet.producer.clone());
        rows.push([name, producer, pid, robots, rate, fleet.state().to_owned()]);
    }
    let mut widths = [0; 6];
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = cell.chars().count().max(*width);
        }
    }
    let mut table = String::new();
    for row in &rows {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}  "));
        table += cells.collect::<String>().trim_end();
        table.push('\n');
    }
    table
}

/// Runs `regatta stop`.
pub fn stop(target: &Target) -> Result<(), Failure> {
    let fleet = &target.fleet;
    let mut control = Control::open(fleet)?;
    let pid = control.status()?.pid;
    let processes = fleets()?.remove(fleet).unwrap_or_default();
    let verified = producer(&processes, pid).filter(|occupant| is_same_program(occupant));
    let Some(occupant) = verified else {
        // Another container, for example, has other process ids.
        return Err(format!(
            "process {pid} here isn't the producer of fleet '{fleet}'; stop it where it was started"
        )
        .into());
    };
    interrupt(occupant)?;
    let deadline = Instant::now() + END_TIMEOUT;
    while control.has_engine() {
        if Instant::now() > deadline {
            let secs = END_TIMEOUT.as_secs();
            return Err(format!(
                "the producer of fleet '{fleet}' (process {pid}) has not ended within {secs} s"
            )
            .into());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    println!("fleet '{fleet}' has ended");
    Ok(())
}

/// Whether the process with the id of an occupant runs the occupant's program.
#[cfg(target_os = "linux")]
fn is_same_program(occupant: &Occupant) -> bool {
    let program = std::fs::read_link(format!("/proc/{}/exe", occupant.pid));
    program.is_ok_and(|path| {
        // The kernel appends ` (deleted)` if the program was rebuilt meanwhile.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.trim_end_matches(" (deleted)") == occupant.executable
    })
}

/// Other systems have no namespaces of process ids: that of a live occupant is its own.
#[cfg(not(target_os = "linux"))]
fn is_same_program(_occupant: &Occupant) -> bool {
    true
}

/// Sends the signal of Ctrl-C.
#[cfg(unix)]
fn interrupt(occupant: &Occupant) -> Result<(), Failure> {
    use rustix::process::{Pid, Signal, kill_process};
    let pid = Pid::from_raw(occupant.pid as i32).ok_or("the producer has no process id")?;
    kill_process(pid, Signal::INT).map_err(|error| {
        format!("can't stop {} (process {}): {error}", occupant.executable, occupant.pid).into()
    })
}

#[cfg(not(unix))]
fn interrupt(occupant: &Occupant) -> Result<(), Failure> {
    Err(format!(
        "press Ctrl-C where {} (process {}) runs: this system has no signals",
        occupant.executable, occupant.pid
    )
    .into())
}
