//! The processes of a running fleet, which `regatta status` lists: its producer, plugins and other
//! readers.

use regatta_metrics::processes::list;
use regatta_metrics::snapshot::Process;
use regatta_plugin::FleetName;
use serde_json::{Value, json};

use crate::failure::Failure;

/// Returns the live processes of a fleet, sorted by name, without this one.
pub fn processes(fleet: &FleetName) -> Result<Vec<Process>, Failure> {
    let mut processes = list(fleet)?;
    processes.retain(|process| process.pid != std::process::id());
    Ok(processes)
}

/// Formats processes in a line each, with their names below each other.
pub fn lines(processes: &[Process]) -> String {
    let width = processes.iter().map(|process| process.name.chars().count()).max().unwrap_or(0);
    let mut lines = String::new();
    for process in processes {
        let Process { name, pid, .. } = process;
        let megabytes = process.resident_bytes as f64 * 1e-6;
        let state = state(process);
        lines += &format!("process  {name:width$}  {state}  pid {pid}  {megabytes:.0} MB\n");
    }
    lines
}

/// Returns a process as JSON.
pub fn to_json(process: &Process) -> Value {
    json!({
        "name": process.name,
        "pid": process.pid,
        "state": state(process),
        "resident_bytes": process.resident_bytes,
        "shared_bytes": process.shared_bytes,
        "cpu_secs": process.cpu_seconds,
    })
}

fn state(process: &Process) -> &'static str {
    if process.stopped { "stopped" } else { "running" }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn process(name: &str, pid: u32, stopped: bool) -> Process {
        Process {
            name: name.to_owned(),
            pid,
            stopped,
            shared_bytes: 5,
            resident_bytes: 34_000_000,
            cpu_seconds: 1.5,
            cpu_cores: 0.0,
        }
    }

    #[test]
    fn processes_are_listed_with_their_states() {
        let processes = [process("engine", 7, false), process("fleet-manager", 12, true)];
        assert_eq!(
            lines(&processes),
            "process  engine         running  pid 7  34 MB\n\
             process  fleet-manager  stopped  pid 12  34 MB\n"
        );
        assert_eq!(to_json(&processes[1])["state"], "stopped");
        assert_eq!(lines(&[]), "");
    }
}
