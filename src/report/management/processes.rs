//! The processes of a measurement.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use regatta_plugin::{Control, ControlError, FleetName, Orders};
use serde_json::Value;

use super::super::experiment::{check_interrupt, temporary_folder, wait};
use super::measurement::{Measured, Setup};
use crate::failure::Failure;
use crate::supervisor::{EndedChild, Supervisor};

const ENGINE: &str = "engine";
const MANAGER: &str = "fleet-manager";
const VALIDATOR: &str = "validator";
/// The time between two checks of the processes.
const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// The longest time that the engine waits for a tick of the others: the first ones of a large fleet take seconds.
const LOCKSTEP_TIMEOUT_SECS: &str = "120";
/// Robots break down while steps are made: so many simulated seconds at a time, so that Ctrl-C is noticed.
const STEP_SECS: u64 = 20;

/// A running measurement.
pub struct Run<'a> {
    setup: &'a Setup,
    rate_hz: u32,
    fleet: FleetName,
    supervisor: Supervisor,
    manager_pid: u32,
    /// For what the processes write.
    folder: tempfile::TempDir,
    /// The sender of breakdowns: until the end, as what it has sent is lost with it.
    orders: Option<Orders>,
}

impl<'a> Run<'a> {
    /// Starts the processes.
    pub fn start(setup: &'a Setup, scenario: &Path, rate_hz: u32) -> Result<Self, Failure> {
        let fleet = format!("report-management-{}", std::process::id()).parse()?;
        let (supervisor, folder) = (Supervisor::default(), temporary_folder()?);
        let mut run = Self { setup, rate_hz, fleet, supervisor, manager_pid: 0, folder, orders: None };
        run.start_engine(scenario)?;
        let mut manager = run.command(MANAGER, &["plugin", MANAGER, "--in-turn", "--no-cache"])?;
        let settings: &[&str] = if setup.conflicts { &[] } else { &["--no-conflicts"] };
        manager.arg("--load").arg(scenario).arg("--json").arg(run.json_file(MANAGER)).args(settings);
        run.manager_pid = run.supervisor.start(MANAGER, &mut manager)?;
        if setup.conflicts {
            let mut validator = run.command(VALIDATOR, &["plugin", VALIDATOR, "--after", MANAGER])?;
            validator.arg("--json").arg(run.json_file(VALIDATOR));
            run.supervisor.start(VALIDATOR, &mut validator)?;
        }
        Ok(run)
    }

    fn ticks(&self) -> u64 {
        self.setup.secs * u64::from(self.rate_hz)
    }

    fn start_engine(&mut self, scenario: &Path) -> Result<(), Failure> {
        let ticks = self.ticks();
        let mut engine = self.command(ENGINE, &[ENGINE])?;
        engine.arg(scenario).args(["--speed", "max", "--ticks", &ticks.to_string()]);
        engine.args(["--lockstep-timeout", LOCKSTEP_TIMEOUT_SECS, "--lockstep", MANAGER]);
        engine.args(self.setup.conflicts.then_some(VALIDATOR));
        self.supervisor.start(ENGINE, &mut engine)?;
        Ok(())
    }

    /// Returns the command of a process that writes its messages to `NAME.log`.
    fn command(&self, name: &str, args: &[&str]) -> Result<Command, Failure> {
        let log = File::create(self.folder.path().join(format!("{name}.log")))?;
        let mut command = Command::new(std::env::current_exe()?);
        command.args(args).args(["--fleet", self.fleet.as_str()]);
        command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
        Ok(command)
    }

    fn json_file(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(format!("{name}.json"))
    }

    /// Waits for the end, and returns the figures.
    pub fn finish(mut self) -> Result<Measured, Failure> {
        if self.setup.broken > 0 {
            self.break_down()?;
        }
        while !self.engine_has_ended()? {
            wait(POLL_INTERVAL)?;
        }
        let manager_secs = processor_secs(self.manager_pid);
        let failures = self.supervisor.stop();
        // A validator that has found something fails; what it has found is in its figures.
        if let Some(failure) = failures.iter().find(|failure| !failure.starts_with(VALIDATOR)) {
            return Err(self.failure(failure, MANAGER));
        }
        let manager = self.json(MANAGER)?;
        let validator = if self.setup.conflicts { Some(self.json(VALIDATOR)?) } else { None };
        self.measured(&manager, validator.as_ref(), manager_secs)
    }

    /// Whether the engine has made all ticks.
    ///
    /// # Errors
    /// If a process has ended too early.
    fn engine_has_ended(&mut self) -> Result<bool, Failure> {
        let ended = self.supervisor.take_ended();
        let is_fault = |child: &&EndedChild| child.name != ENGINE || !child.status.success();
        // If the manager has failed, that is why the engine has.
        let fault = ended.iter().filter(is_fault).max_by_key(|child| child.name != ENGINE);
        match fault {
            Some(child) => {
                let failure = child.failure().unwrap_or_else(|| format!("{} ended early", child.name));
                Err(self.failure(&failure, &child.name))
            }
            None => Ok(!ended.is_empty()),
        }
    }

    /// A failure of a process with the last line that it wrote.
    fn failure(&self, failure: &str, name: &str) -> Failure {
        let log = self.log(name);
        let line = log.lines().last().unwrap_or_default();
        format!("{failure} {}", line.trim_start_matches("regatta: ")).into()
    }

    fn log(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(format!("{name}.log"))).unwrap_or_default()
    }

    fn json(&self, name: &str) -> Result<Value, Failure> {
        let text = fs::read_to_string(self.json_file(name)).unwrap_or_default();
        serde_json::from_str(&text).map_err(|_| self.failure(&format!("{name} wrote no figures:"), name))
    }

    /// Steps to the end of the warm-up, and lets the first robots break down, which are anywhere.
    fn break_down(&mut self) -> Result<(), Failure> {
        let (mut control, rate) = (Control::open(&self.fleet)?, u64::from(self.rate_hz));
        let mut tick = loop {
            if self.engine_has_ended()? {
                return Err("the run was over before robots broke down".into());
            }
            match control.pause() {
                Ok(status) => break status.tick,
                Err(ControlError::NoEngine { .. } | ControlError::Timeout { .. }) => wait(POLL_INTERVAL)?,
                Err(error) => return Err(error.into()),
            }
        };
        let due = self.setup.warm_up_secs() * rate;
        while tick < due {
            tick = control.step((due - tick).min(STEP_SECS * rate))?.tick;
            check_interrupt()?;
        }
        let mut orders = Orders::open(&self.fleet)?;
        for robot in 0..self.setup.broken {
            orders.break_down(robot);
        }
        orders.send()?;
        self.orders = Some(orders);
        control.resume()?;
        Ok(())
    }

    fn measured(&self, manager: &Value, validator: Option<&Value>, secs: Option<f64>) -> Result<Measured, Failure> {
        let run = &manager["run"];
        let number = |key: &str| run[key].as_f64().ok_or_else(|| format!("the manager's figures lack {key}"));
        let simulated_secs = self.setup.secs as f64;
        let wall_secs = wall_secs(&self.log(ENGINE), self.ticks()).ok_or("the engine ended early")?;
        let findings = validator.map(findings).unwrap_or_default();
        let is_contact = |(kind, _): &(String, u64)| kind == "contact";
        Ok(Measured {
            goals_per_sec: goals_per_sec(run, self.setup),
            longest_without_finish_secs: number("longest_without_finish_secs")?,
            start_ms: number("start_ms")?,
            mean_cycle_ms: number("mean_cycle_ms")?,
            longest_cycle_ms: number("longest_cycle_ms")?,
            manager_cores: secs.map(|secs| secs / simulated_secs),
            real_time_factor: simulated_secs / wall_secs,
            contacts: findings.iter().filter(|finding| is_contact(finding)).map(|(_, count)| count).sum(),
            other_findings: findings.into_iter().filter(|finding| !is_contact(finding)).collect(),
        })
    }
}

/// The stops that were finished a second between the warm-up and the end.
fn goals_per_sec(run: &Value, setup: &Setup) -> f64 {
    let period_secs = run["period_secs"].as_f64().map_or(1, |secs| secs as u64).max(1);
    let stops = run["stops_by_period"].as_array().into_iter().flatten().filter_map(Value::as_u64);
    let (first, end) = (setup.warm_up_secs() / period_secs, setup.secs / period_secs);
    let counted: u64 = stops.take(end as usize).skip(first as usize).sum();
    counted as f64 / ((end - first).max(1) * period_secs) as f64
}

/// The kinds of findings that there are, with their counts.
fn findings(validator: &Value) -> Vec<(String, u64)> {
    let kinds = validator["kinds"].as_array().into_iter().flatten();
    let kinds = kinds.filter_map(|kind| Some((kind["kind"].as_str()?.to_owned(), kind["count"].as_u64()?)));
    kinds.filter(|(_, count)| *count > 0).collect()
}

/// The wall time of an engine that has made all its ticks: `600 ticks, 60.00 s simulated in 1.23 s, 0 late`.
fn wall_secs(log: &str, ticks: u64) -> Option<f64> {
    let start = format!("{ticks} ticks, ");
    let (_, rest) = log.lines().rfind(|line| line.starts_with(&start))?.split_once(" s simulated in ")?;
    rest.split_whitespace().next()?.parse().ok().filter(|secs| *secs > 0.0)
}

/// The processor time that a process has used, in seconds; `None` on systems without `/proc`.
fn processor_secs(pid: u32) -> Option<f64> {
    /// Linux counts it in these units wherever it is published.
    const TICKS_PER_SEC: f64 = 100.0;
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in brackets, may contain spaces. The 14th and 15th field are user and system time.
    let (_, fields) = stat.rsplit_once(") ")?;
    let ticks = fields.split(' ').skip(11).take(2).map(str::parse::<f64>);
    Some(ticks.sum::<Result<f64, _>>().ok()? / TICKS_PER_SEC)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn an_engine_tells_how_long_it_took() {
        let log = "a warning\n600 ticks, 60.00 s simulated in 1.25 s, 0 late\n";
        assert_eq!((wall_secs(log, 600), wall_secs(log, 700)), (Some(1.25), None), "only if it has made all ticks");
        assert_eq!(wall_secs("the engine failed", 600), None);
    }

    #[test]
    fn stops_of_the_warm_up_do_not_count() {
        let run = json!({"period_secs": 10.0, "stops_by_period": [9, 4, 5, 6, 100]});
        let setup = Setup { secs: 40, ..Setup::of(1) };
        assert_eq!(goals_per_sec(&run, &setup), 0.5, "(4 + 5 + 6) / 30 s");
        assert_eq!(goals_per_sec(&json!({"period_secs": 10.0, "stops_by_period": [1]}), &setup), 0.0);
    }

    #[test]
    fn only_kinds_that_were_found_are_findings() {
        let report = json!({"kinds": [{"kind": "contact", "count": 0}, {"kind": "idle", "count": 2}]});
        assert_eq!(findings(&report), [("idle".to_owned(), 2)]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_has_used_processor_time() {
        while processor_secs(std::process::id()).expect("a process") == 0.0 {}
    }
}
