//! `regatta run --in-process`: the engine and the scenario's plugins call each other in this
//! process, as fast as possible. A table of results ends the run.

use std::process::ExitCode;

use regatta_meter::Figures;
use regatta_meter::meter::Effort;
use regatta_plugin::Termination;
use regatta_run::{Run, RunError, Summary};
use regatta_scenario::{PluginCommand, Scenario};
use regatta_study::statistics::{median, percentile};
use regatta_validator::Report;
use serde_json::json;

use super::{FLEET_MANAGER, LoadFile, RunArgs};
use crate::failure::Failure;
use crate::plugin;
use crate::scenario::tell_warnings;
use crate::study::observers::{Observed, Observers};

/// The name of the plugin that publishes the traffic, which is among the results.
const TRAFFIC: &str = "traffic";
/// The exit code of a run with findings.
const FOUND: u8 = 1;

/// Runs a scenario in this process, and prints its results.
pub fn run(
    scenario: Scenario,
    args: &RunArgs,
    termination: &Termination,
) -> Result<ExitCode, Failure> {
    tell_warnings(&scenario);
    let ticks = args.ticks(&scenario).unwrap_or_default();
    let load = LoadFile::of(args, &scenario)?;
    let mut observers = Observers::new(true);
    if scenario.plugins.iter().any(|plugin| plugin.name == TRAFFIC) {
        observers = observers.unpublished();
    }
    let outcome = {
        let mut plugins = Vec::new();
        for command in &scenario.plugins {
            plugins.push((command.name.clone(), command.after.clone(), make(command, &load)?));
        }
        let names: Vec<String> = plugins.iter().map(|(name, ..)| name.clone()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut run = Run::new(scenario).digested().stopped_by(|| termination.requested());
        if let Some(robots) = args.options.robots {
            run = run.robots(robots.0);
        }
        if args.publish {
            run = run.published(args.options.fleet.clone());
        }
        for (name, after, plugin) in plugins {
            let after: Vec<&str> = after.iter().map(String::as_str).collect();
            run = run.with_named(&name, &after, plugin);
        }
        run.with_named("observers", &names, &mut observers).for_ticks(ticks)
    };
    let mut has_failed = false;
    let (summary, is_whole) = match outcome {
        Ok(summary) => (summary, true),
        Err(RunError::AtEnd { summary, name, error }) => {
            regatta_plugin::tell!("regatta: {name}: {error}");
            has_failed = true;
            (summary, true)
        }
        Err(RunError::Stopped(summary)) => (summary, false),
        Err(error) => return Err(error.into()),
    };
    let results = Results::new(&summary, observers.observed());
    println!("{}", if args.json { results.json() } else { results.table() });
    has_failed |= results.findings.found().next().is_some();
    Ok(match (is_whole, has_failed) {
        (true, false) => ExitCode::SUCCESS,
        (true, true) => ExitCode::from(FOUND),
        (false, _) => ExitCode::FAILURE,
    })
}

/// Makes a plugin of the scenario.
fn make(
    command: &PluginCommand,
    load: &Option<LoadFile<'_>>,
) -> Result<Box<dyn regatta_plugin::Plugin>, Failure> {
    let PluginCommand { name, command: program, args, .. } = command;
    if !program.is_empty() {
        return Err(format!(
            "plugin '{name}' is a program of its own, and can't run in this process; run without \
             --in-process"
        )
        .into());
    }
    let mut args = args.clone();
    let has_load = args.iter().any(|arg| arg == "--load" || arg.starts_with("--load="));
    if let Some(load) = load
        && name == FLEET_MANAGER
        && !has_load
    {
        args.extend(["--load".to_owned(), load.path().to_string_lossy().into_owned()]);
    }
    plugin::make(name, &args)
}

/// The results of a run.
struct Results<'a> {
    summary: &'a Summary,
    figures: Figures,
    findings: Report,
}

impl<'a> Results<'a> {
    fn new(summary: &'a Summary, observed: Observed) -> Self {
        let findings = observed.findings.unwrap_or_default();
        Self { summary, figures: observed.meter, findings }
    }

    /// Simulated seconds over wall seconds.
    fn real_time_factor(&self) -> f64 {
        self.summary.sim_time.as_secs_f64() / self.summary.wall_time.as_secs_f64().max(1e-9)
    }

    fn service_secs(&self, percent: usize) -> Option<f64> {
        let secs: Vec<f64> = self.figures.finished.iter().map(|order| order.service_secs).collect();
        percentile(&secs, percent)
    }

    fn median_secs(&self) -> Option<f64> {
        let secs = self.figures.finished.iter().map(|order| order.service_secs);
        median(&secs.collect::<Vec<_>>())
    }

    /// The part of the robots' time that `secs` takes from an effort, from 0 to 1.
    fn part(&self, secs: impl Fn(&Effort) -> f64) -> f64 {
        let sum: f64 = self.figures.effort.iter().map(&secs).sum();
        let robot_secs: f64 = self.figures.effort.iter().map(|effort| effort.robot_secs).sum();
        if robot_secs > 0.0 { sum / robot_secs } else { 0.0 }
    }

    fn digest(&self) -> String {
        self.summary.digest.map(|digest| format!("{digest:032x}")).unwrap_or_default()
    }

    fn orders_per_hour(&self) -> f64 {
        self.figures.finished.len() as f64 * 3600.0 / self.figures.secs.max(1e-9)
    }

    fn json(&self) -> String {
        let findings: serde_json::Map<_, _> = self
            .findings
            .found()
            .map(|found| (found.kind.to_string(), json!(found.count)))
            .collect();
        json!({
            "ticks": self.summary.ticks,
            "sim_time_secs": self.summary.sim_time.as_secs_f64(),
            "wall_time_secs": self.summary.wall_time.as_secs_f64(),
            "robots": self.figures.robots,
            "orders_finished": self.figures.finished.len(),
            "orders_open": self.figures.open,
            "orders_failed": self.figures.failed,
            "orders_per_hour": self.orders_per_hour(),
            "service_p50_secs": self.service_secs(50),
            "service_p99_secs": self.service_secs(99),
            "utilisation": self.part(|effort| effort.ordered_secs),
            "waiting": self.part(|effort| effort.waiting_secs),
            "findings": findings,
            "digest": self.digest(),
        })
        .to_string()
    }

    fn table(&self) -> String {
        let service = match (self.median_secs(), self.service_secs(99)) {
            (Some(median), Some(p99)) => {
                format!("median {median:.1} s, 99th percentile {p99:.1} s")
            }
            _ => "no order was finished".to_owned(),
        };
        let found: Vec<_> =
            self.findings.found().map(|found| format!("{} {}", found.count, found.kind)).collect();
        let Figures { robots, finished, open, failed, .. } = &self.figures;
        let (sim_secs, wall_secs) =
            (self.summary.sim_time.as_secs_f64(), self.summary.wall_time.as_secs_f64());
        let rows = [
            ("robots", robots.to_string()),
            (
                "time",
                format!(
                    "{sim_secs:.0} s simulated in {wall_secs:.1} s, {:.0} times real time",
                    self.real_time_factor()
                ),
            ),
            (
                "orders",
                format!(
                    "{} finished ({:.0} an hour), {open} open, {failed} failed",
                    finished.len(),
                    self.orders_per_hour()
                ),
            ),
            ("service time", service),
            (
                "robots' time",
                format!(
                    "{:.1} % with an order, {:.1} % waiting for room, a route, a door or a lift",
                    100.0 * self.part(|effort| effort.ordered_secs),
                    100.0 * self.part(|effort| effort.waiting_secs)
                ),
            ),
            ("findings", if found.is_empty() { "none".to_owned() } else { found.join(", ") }),
            ("digest", self.digest()),
        ];
        let lines = rows.map(|(name, value)| format!("{name:<13} {value}"));
        lines.join("\n")
    }
}
