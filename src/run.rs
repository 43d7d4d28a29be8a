//! `regatta run`: a scenario as a set of processes.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use clap::Args;
use regatta_engine::scenario::{PluginCommand, Scenario, Viewer};
use regatta_plugin::{Control, FleetName, Termination};

use crate::engine::Tuning;
use crate::supervisor::{Ended, Supervisor};
use crate::{Failure, control, demo, plugin};

/// How long the engine may take to answer for the first time: a large graph is compiled first.
const START_PATIENCE: Duration = Duration::from_secs(60);
const POLL: Duration = Duration::from_millis(20);
/// The viewer among the children.
const VIEWER: &str = "viewer";

#[derive(Args, Default)]
pub struct RunArgs {
    /// Scenario file; the built-in demo if left out.
    scenario: Option<PathBuf>,
    #[command(flatten)]
    tuning: Tuning,
    /// Stop after this time: 10s, 5min, 1h …
    #[arg(long = "for", value_name = "TIME")]
    for_: Option<humantime::Duration>,
}

pub fn run(args: RunArgs) -> Result<ExitCode, Failure> {
    let termination = Termination::watch().map_err(crate::plugin_failure)?;
    // Read here too, so that a mistake in it is told once, by this process, before anything starts.
    let scenario = demo::scenario(args.scenario.as_deref(), &args.tuning.overrides())?;
    let plugins = scenario.plugins.iter().map(|plugin| plugin_command(plugin, &args.tuning.fleet));
    let plugins = plugins.collect::<Result<Vec<_>, _>>()?;

    let mut supervisor = Supervisor::default();
    let engine = supervisor.start("engine", &mut engine_command(args.scenario.as_deref(), &args.tuning)?)?;
    for (plugin, mut command) in scenario.plugins.iter().zip(plugins) {
        supervisor.start(&plugin.name, &mut command)?;
    }
    announce(&scenario, &args.tuning.fleet);
    match scenario.viewer {
        Viewer::Off => {}
        Viewer::Auto if !has_display() => eprintln!("regatta: no display, so no viewer; the run goes on without it"),
        Viewer::Auto | Viewer::On => {
            supervisor.start(VIEWER, &mut viewer_command(&args.tuning.fleet)?)?;
        }
    }

    let needed = Needed { engine, viewer: scenario.viewer == Viewer::On };
    let mut failures = watch(&mut supervisor, &needed, &args.tuning.fleet, args.for_.map(Into::into), &termination)?;
    failures.extend(supervisor.stop());
    for failure in &failures {
        eprintln!("regatta: {failure}");
    }
    Ok(if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn announce(scenario: &Scenario, fleet: &FleetName) {
    println!(
        "fleet '{fleet}': {} robots on {} edges, {} ticks a second; Ctrl-C stops",
        scenario.robots(),
        scenario.graph.edges().len(),
        (1.0 / scenario.tick_period.as_secs_f64()).round()
    );
}

/// What a run can't go on without.
struct Needed {
    /// The engine's process.
    engine: u32,
    /// Whether the scenario insists on the viewer.
    viewer: bool,
}

impl Needed {
    /// Whether a child that failed takes the run with it. The viewer has said itself what is wrong.
    fn is_missed(&self, ended: &Ended) -> bool {
        let spared = ended.name == VIEWER && !self.viewer;
        if spared && !ended.status.success() {
            eprintln!("regatta: the run goes on without the viewer");
        }
        !spared
    }
}

/// Whether a window can be shown.
fn has_display() -> bool {
    let named = |variable| std::env::var_os(variable).is_some_and(|value| !value.is_empty());
    cfg!(any(target_os = "macos", windows)) || named("DISPLAY") || named("WAYLAND_DISPLAY")
}

/// Prints a status line a second until it is time to stop; returns what failed.
fn watch(
    supervisor: &mut Supervisor,
    needed: &Needed,
    fleet: &FleetName,
    limit: Option<Duration>,
    termination: &Termination,
) -> Result<Vec<String>, Failure> {
    let started = Instant::now();
    let mut control = Control::open(fleet)?;
    let mut answered = false;
    let mut next_line = started;
    while !termination.requested() && limit.is_none_or(|limit| started.elapsed() < limit) {
        let ended = supervisor.ended();
        let failures: Vec<_> =
            ended.iter().filter(|ended| needed.is_missed(ended)).filter_map(|ended| ended.failure()).collect();
        if !failures.is_empty() || ended.iter().any(|ended| ended.name == "engine") {
            return Ok(failures);
        }
        if Instant::now() >= next_line && control.has_engine() {
            match control.status() {
                // Another engine of that name: ours is about to say so.
                Ok(status) if status.pid != needed.engine => {}
                Ok(status) => println!("{}", control::line(&status)),
                // Seen as an ended child, or there may be an answer next time.
                Err(error) => tracing::info!("{error}"),
            }
            answered = true;
            // Nothing to catch up with after a pause of this process or of the engine.
            next_line = (next_line + Duration::from_secs(1)).max(Instant::now());
        }
        if !answered && started.elapsed() > START_PATIENCE {
            return Ok(vec![format!("the engine gave no answer within {} s", START_PATIENCE.as_secs())]);
        }
        std::thread::sleep(POLL);
    }
    Ok(Vec::new())
}

fn this_program() -> Result<Command, Failure> {
    let path = std::env::current_exe().map_err(|error| format!("can't find this program's own file: {error}"))?;
    Ok(Command::new(path))
}

fn engine_command(scenario: Option<&Path>, tuning: &Tuning) -> Result<Command, Failure> {
    let mut command = this_program()?;
    command.arg("engine").args(scenario).args(tuning.to_args());
    Ok(command)
}

fn viewer_command(fleet: &FleetName) -> Result<Command, Failure> {
    let mut command = this_program()?;
    command.args(["viewer", "--fleet", &fleet.to_string()]);
    Ok(command)
}

fn plugin_command(plugin: &PluginCommand, fleet: &FleetName) -> Result<Command, Failure> {
    let mut command = match plugin.command.split_first() {
        Some((program, args)) => {
            let mut command = Command::new(program);
            command.args(args);
            command
        }
        None if plugin::exists(&plugin.name) => {
            let mut command = this_program()?;
            command.args(["plugin", &plugin.name]);
            command
        }
        None => return Err(plugin::unknown(&plugin.name).into()),
    };
    command.args(["--fleet", &fleet.to_string()]).args(&plugin.args);
    Ok(command)
}
