//! Memory and processor time of the processes of a fleet.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Weak};
use std::thread;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use regatta_plugin::FleetName;
use regatta_plugin::health::{self, HealthError, Occupant};
use sysinfo::{Pid, ProcessRefreshKind, ProcessStatus, ProcessesToUpdate, System};

use crate::snapshot::Process;

/// Time between two samples.
const PERIOD: Duration = Duration::from_secs(1);

/// The processes of a fleet, or the reason why they can't be listed.
type ProcessList = Result<Vec<Process>, String>;

/// A monitor that samples the processes of a fleet once a second, on a thread of its own: listing
/// them may take long on a machine with many.
#[derive(Clone, Debug)]
pub struct ProcessMonitor {
    newest: Arc<Mutex<ProcessList>>,
}

impl ProcessMonitor {
    /// Starts the monitor. It ends when the last clone is dropped.
    ///
    /// # Errors
    /// Fails if no thread can be started.
    pub fn start(fleet: &FleetName) -> io::Result<Self> {
        let newest = Arc::new(Mutex::new(Ok(Vec::new())));
        let (fleet, weak) = (fleet.clone(), Arc::downgrade(&newest));
        thread::Builder::new()
            .name("processes".to_owned())
            .spawn(move || sample_repeatedly(&fleet, &weak))?;
        Ok(Self { newest })
    }

    /// Returns the newest sample; empty before the first.
    ///
    /// # Errors
    /// Returns the reason why the processes can't be listed, in one line.
    pub fn newest(&self) -> ProcessList {
        self.newest.lock().clone()
    }
}

/// Returns the live processes of a fleet, sorted by name, without their load.
///
/// # Errors
/// Returns the reason why they can't be listed, in one line.
pub fn list(fleet: &FleetName) -> ProcessList {
    Sampler::default().sample(fleet)
}

fn sample_repeatedly(fleet: &FleetName, newest: &Weak<Mutex<ProcessList>>) {
    let mut sampler = Sampler::default();
    while let Some(newest) = newest.upgrade() {
        let processes = sampler.sample(fleet);
        *newest.lock() = processes;
        drop(newest);
        thread::sleep(PERIOD);
    }
}

/// A sampler that keeps the processor times of the previous sample, to compute the load.
#[derive(Default)]
struct Sampler {
    system: Option<System>,
    /// The time of the sample and the processor time of each process, by its id.
    before: BTreeMap<u32, (Instant, f64)>,
    /// The processor time of all processes of a name, with those that have ended.
    totals: BTreeMap<String, f64>,
}

impl Sampler {
    fn sample(&mut self, fleet: &FleetName) -> ProcessList {
        let occupants = health::occupants().map_err(|error: HealthError| error.to_string())?;
        let mut processes = members(&occupants, fleet);
        let pids: Vec<_> = processes.iter().map(|process| Pid::from_u32(process.pid)).collect();
        let system = match &mut self.system {
            Some(system) => system,
            None => self
                .system
                .insert(System::new().map_err(|error| format!("can't list processes ({error})"))?),
        };
        let refresh = ProcessRefreshKind::nothing().with_memory().with_cpu().without_tasks();
        system.refresh_processes_specifics(ProcessesToUpdate::Some(&pids), true, refresh);
        let now = Instant::now();
        // A process that has ended since it was listed has no figures any more.
        processes.retain_mut(|process| measure(process, system, &self.before, now));
        self.add_up(&mut processes, now);
        Ok(processes)
    }

    /// Replaces the processor time of each process by that of all with its name.
    fn add_up(&mut self, processes: &mut [Process], now: Instant) {
        let mut totals = BTreeMap::new();
        for process in &*processes {
            let before = self.before.get(&process.pid).map_or(0.0, |(_, seconds)| *seconds);
            let known = self.totals.get(&process.name).copied().unwrap_or_default();
            *totals.entry(process.name.clone()).or_insert(known) +=
                (process.cpu_seconds - before).max(0.0);
        }
        self.totals = totals;
        self.before =
            processes.iter().map(|process| (process.pid, (now, process.cpu_seconds))).collect();
        for process in processes {
            process.cpu_seconds = self.totals.get(&process.name).copied().unwrap_or_default();
        }
    }
}

/// Whether a name is that of a port, by which a process joins a fleet that has a name of its own.
fn is_of_port(name: &str) -> bool {
    matches!(name, "control" | "manager-requests" | "reader") || name.starts_with("commands-")
}

/// Returns the live processes of a fleet, each once, by the first of its names that isn't a port's,
/// sorted by name.
fn members(occupants: &[Occupant], fleet: &FleetName) -> Vec<Process> {
    let prefix = format!("regatta/{fleet}/");
    let mut members = BTreeMap::<u32, Process>::new();
    for occupant in occupants.iter().filter(|occupant| occupant.alive && occupant.pid != 0) {
        let Some(name) = occupant.name.strip_prefix(&prefix) else { continue };
        // Occupants are sorted by name.
        let member = members.entry(occupant.pid).or_insert_with(|| Process {
            name: name.to_owned(),
            pid: occupant.pid,
            stopped: false,
            shared_bytes: 0,
            resident_bytes: 0,
            cpu_seconds: 0.0,
            cpu_cores: 0.0,
        });
        if is_of_port(&member.name) && !is_of_port(name) {
            name.clone_into(&mut member.name);
        }
        member.shared_bytes += occupant.bytes;
    }
    let mut members: Vec<_> = members.into_values().collect();
    members.sort_by(|a, b| (&a.name, a.pid).cmp(&(&b.name, b.pid)));
    members
}

/// Fills in the operating system's figures of a process. Returns `false` if there are none.
fn measure(
    process: &mut Process,
    system: &System,
    before: &BTreeMap<u32, (Instant, f64)>,
    now: Instant,
) -> bool {
    let Some(sampled) = system.process(Pid::from_u32(process.pid)) else { return false };
    if sampled.status() == ProcessStatus::Zombie {
        return false;
    }
    process.stopped = sampled.status() == ProcessStatus::Stop;
    process.resident_bytes = sampled.memory();
    process.cpu_seconds = sampled.accumulated_cpu_time() as f64 * 1e-3;
    process.cpu_cores = before.get(&process.pid).map_or(0.0, |(then, seconds)| {
        let passed = now.saturating_duration_since(*then).as_secs_f64();
        if passed > 0.0 { (process.cpu_seconds - seconds).max(0.0) / passed } else { 0.0 }
    });
    true
}

#[cfg(test)]
mod tests {
    use regatta_plugin::Participant;

    use super::*;

    fn occupant(name: &str, pid: u32, alive: bool, bytes: u64) -> Occupant {
        Occupant { name: name.to_owned(), executable: "regatta".to_owned(), pid, alive, bytes }
    }

    #[test]
    fn each_live_process_of_the_fleet_is_listed_once() {
        let fleet: FleetName = "f".parse().expect("a name");
        let occupants = [
            occupant("regatta/f/control", 12, true, 1),
            occupant("regatta/f/dead", 13, false, 8),
            occupant("regatta/f/producer", 12, true, 2),
            occupant("regatta/f/zebra", 11, true, 4),
            occupant("regatta/ff/producer", 14, true, 8),
            occupant("other", 15, true, 8),
        ];
        let members: Vec<_> = members(&occupants, &fleet)
            .into_iter()
            .map(|p| (p.name, p.pid, p.shared_bytes))
            .collect();
        assert_eq!(members, [("producer".to_owned(), 12, 3), ("zebra".to_owned(), 11, 4)]);
    }

    #[test]
    fn the_processor_time_of_a_name_never_decreases_while_one_process_has_it() {
        let fleet: FleetName = "f".parse().expect("a name");
        let mut sampler = Sampler::default();
        let mut sample = |running: &[(u32, f64)]| {
            let occupants: Vec<_> = running
                .iter()
                .map(|(pid, _)| occupant("regatta/f/viewer", *pid, true, 0))
                .collect();
            let mut processes = members(&occupants, &fleet);
            processes
                .iter_mut()
                .zip(running)
                .for_each(|(process, (_, seconds))| process.cpu_seconds = *seconds);
            sampler.add_up(&mut processes, Instant::now());
            processes.first().map(|process| process.cpu_seconds)
        };
        assert_eq!(sample(&[(1, 5.0)]), Some(5.0));
        assert_eq!(sample(&[(1, 6.0), (2, 0.5)]), Some(6.5));
        assert_eq!(sample(&[(2, 1.0)]), Some(7.0), "the first has ended");
        assert_eq!(sample(&[(3, 0.25)]), Some(7.25), "another has replaced the second");
        assert_eq!(sample(&[]), None);
        assert_eq!(sample(&[(4, 2.0)]), Some(2.0), "a new series");
    }

    #[test]
    fn this_process_is_listed_with_its_memory_and_processor_time() {
        let fleet: FleetName =
            format!("unit-metrics-watch-{}", std::process::id()).parse().expect("a name");
        let _participant = Participant::join(&fleet, "me").expect("joined");
        let mut sampler = Sampler::default();
        let busy = Instant::now();
        sampler.sample(&fleet).expect("listable");
        // The operating system counts processor time in hundredths of a second.
        while busy.elapsed() < Duration::from_millis(100) {
            std::hint::spin_loop();
        }
        let processes = sampler.sample(&fleet).expect("listable");
        let [me] = &processes[..] else { panic!("{processes:?}") };
        assert_eq!((me.name.as_str(), me.pid, me.stopped), ("me", std::process::id(), false));
        assert!(
            me.resident_bytes > 1 << 20 && me.cpu_seconds > 0.0 && me.cpu_cores > 0.0,
            "{me:?}"
        );
    }
}
