//! The processes of a measurement.

use std::fs;
use std::path::Path;

use regatta::experiment::{check_interrupt, wait};
use regatta::failure::Failure;
use regatta::lockstep_run::{ENGINE, LockstepRun, POLL_INTERVAL, findings};
use regatta::program::Program;
use regatta_plugin::ports::error::RequestError;
use regatta_plugin::{Commands, Control, ControlError};
use serde_json::Value;

use super::measurement::{Measured, Setup};

const MANAGER: &str = "fleet-manager";
const VALIDATOR: &str = "validator";
/// Robots break down while steps are made: so many simulated seconds at a time, so that Ctrl-C is
/// noticed.
const STEP_SECS: u64 = 20;

/// A running measurement.
pub struct Run<'a> {
    setup: &'a Setup,
    rate_hz: u32,
    run: LockstepRun,
    manager_pid: u32,
    /// The sender of breakdowns. It is kept until the end, because its messages are lost with it.
    commands: Option<Commands>,
}

impl<'a> Run<'a> {
    /// Starts the processes.
    pub fn start(
        program: &Program,
        setup: &'a Setup,
        scenario: &Path,
        rate_hz: u32,
    ) -> Result<Self, Failure> {
        let mut run = Self {
            setup,
            rate_hz,
            run: LockstepRun::new("report-management", program.clone())?,
            manager_pid: 0,
            commands: None,
        };
        let members = std::iter::once(MANAGER).chain(setup.conflicts.then_some(VALIDATOR));
        let ticks = run.ticks();
        run.run.start_engine(scenario, ticks, &members.collect::<Vec<_>>(), &[])?;
        let mut manager =
            run.run.command(MANAGER, &["plugin", MANAGER, "--in-turn", "--no-cache"])?;
        let settings: &[&str] = if setup.conflicts { &[] } else { &["--no-conflicts"] };
        manager
            .arg("--load")
            .arg(scenario)
            .arg("--json")
            .arg(run.run.json_file(MANAGER))
            .args(settings);
        run.manager_pid = run.run.start(MANAGER, &mut manager)?;
        if setup.conflicts {
            let mut validator =
                run.run.command(VALIDATOR, &["plugin", VALIDATOR, "--after", MANAGER])?;
            validator.arg("--json").arg(run.run.json_file(VALIDATOR));
            run.run.start(VALIDATOR, &mut validator)?;
        }
        Ok(run)
    }

    fn ticks(&self) -> u64 {
        self.setup.secs * u64::from(self.rate_hz)
    }

    /// Waits for the end, and returns the figures.
    pub fn finish(mut self) -> Result<Measured, Failure> {
        if self.setup.broken > 0 {
            self.break_down()?;
        }
        while !self.run.engine_has_ended()? {
            wait(POLL_INTERVAL)?;
        }
        let manager_secs = processor_secs(self.manager_pid);
        let failures = self.run.stop();
        // A validator with findings fails. Its figures contain the findings.
        if let Some(failure) = failures.iter().find(|failure| !failure.starts_with(VALIDATOR)) {
            return Err(self.run.failure(failure, MANAGER));
        }
        let manager = self.run.json(MANAGER, MANAGER)?;
        let validator =
            if self.setup.conflicts { Some(self.run.json(VALIDATOR, VALIDATOR)?) } else { None };
        self.measured(&manager, validator.as_ref(), manager_secs)
    }

    /// Steps to the end of the warm-up, and lets the first robots break down, which are anywhere.
    fn break_down(&mut self) -> Result<(), Failure> {
        let (mut control, rate) = (Control::open(self.run.fleet())?, u64::from(self.rate_hz));
        let mut tick = loop {
            if self.run.engine_has_ended()? {
                return Err("the run was over before robots broke down".into());
            }
            match control.pause() {
                Ok(status) => break status.tick,
                Err(
                    ControlError::NoEngine { .. }
                    | ControlError::Request(RequestError::Timeout { .. }),
                ) => wait(POLL_INTERVAL)?,
                Err(error) => return Err(error.into()),
            }
        };
        let due = self.setup.warm_up_secs() * rate;
        while tick < due {
            tick = control.step((due - tick).min(STEP_SECS * rate))?.tick;
            check_interrupt()?;
        }
        let mut commands = Commands::open(self.run.fleet())?;
        for robot in 0..self.setup.broken {
            commands.break_down(robot);
        }
        commands.send()?;
        self.commands = Some(commands);
        control.resume()?;
        Ok(())
    }

    fn measured(
        &self,
        manager: &Value,
        validator: Option<&Value>,
        secs: Option<f64>,
    ) -> Result<Measured, Failure> {
        let run = &manager["run"];
        let simulated_secs = self.setup.secs as f64;
        let wall_secs =
            wall_secs(&self.run.log(ENGINE), self.ticks()).ok_or("the engine ended early")?;
        let findings =
            validator.map(|figures| findings(figures).collect::<Vec<_>>()).unwrap_or_default();
        let (contacts, other_findings): (Vec<_>, Vec<_>) =
            findings.into_iter().partition(|(kind, _)| kind == "contact");
        Ok(Measured {
            goals_per_sec: goals_per_sec(run, self.setup),
            longest_without_finish_secs: number(run, "longest_without_finish_secs")?,
            start_ms: number(run, "start_ms")?,
            mean_cycle_ms: number(run, "mean_cycle_ms")?,
            longest_cycle_ms: number(run, "longest_cycle_ms")?,
            manager_cores: secs.map(|secs| secs / simulated_secs),
            real_time_factor: simulated_secs / wall_secs,
            contacts: contacts.iter().map(|(_, count)| count).sum(),
            other_findings,
        })
    }
}

fn number(run: &Value, key: &str) -> Result<f64, String> {
    run[key].as_f64().ok_or_else(|| format!("the manager's figures lack {key}"))
}

/// The stops that were finished a second between the warm-up and the end.
fn goals_per_sec(run: &Value, setup: &Setup) -> f64 {
    let period_secs = run["period_secs"].as_f64().map_or(1, |secs| secs as u64).max(1);
    let stops = run["stops_by_period"].as_array().into_iter().flatten().filter_map(Value::as_u64);
    let (first, end) = (setup.warm_up_secs() / period_secs, setup.secs / period_secs);
    let counted: u64 = stops.take(end as usize).skip(first as usize).sum();
    counted as f64 / ((end - first).max(1) * period_secs) as f64
}

/// The wall time of an engine that has made all its ticks: `engine: 600 ticks, 60.00 s simulated
/// in 1.23 s, 0 late`.
fn wall_secs(log: &str, ticks: u64) -> Option<f64> {
    let start = format!("engine: {ticks} ticks, ");
    let (_, rest) =
        log.lines().rfind(|line| line.starts_with(&start))?.split_once(" s simulated in ")?;
    rest.split_whitespace().next()?.parse().ok().filter(|secs| *secs > 0.0)
}

/// The processor time that a process has used, in seconds; `None` on systems without `/proc`.
fn processor_secs(pid: u32) -> Option<f64> {
    /// Linux counts it in these units wherever it is published.
    const TICKS_PER_SEC: f64 = 100.0;
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in brackets, may contain spaces. The 14th and 15th field are user
    // and system time.
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
        let log = "a warning\nengine: 600 ticks, 60.00 s simulated in 1.25 s, 0 late\n";
        assert_eq!(
            (wall_secs(log, 600), wall_secs(log, 700)),
            (Some(1.25), None),
            "only if it has made all ticks"
        );
        assert_eq!(wall_secs("the engine failed", 600), None);
    }

    #[test]
    fn stops_of_the_warm_up_do_not_count() {
        let run = json!({"period_secs": 10.0, "stops_by_period": [9, 4, 5, 6, 100]});
        let setup = Setup { secs: 40, ..Setup::of(1) };
        assert_eq!(goals_per_sec(&run, &setup), 0.5, "(4 + 5 + 6) / 30 s");
        assert_eq!(
            goals_per_sec(&json!({"period_secs": 10.0, "stops_by_period": [1]}), &setup),
            0.0
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_has_used_processor_time() {
        while processor_secs(std::process::id()).expect("a process") == 0.0 {}
    }
}
