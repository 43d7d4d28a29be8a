//! `regatta run`: a scenario as a set of processes.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use clap::Args;
use regatta_engine::scenario::{LightEntry, PluginCommand, Scenario, Viewer};
use regatta_plugin::{Control, FleetName, Termination};

use crate::engine::Tuning;
use crate::supervisor::{Ended, Supervisor};
use crate::{Failure, control, demo, plugin};

/// How long the engine may take to answer for the first time: a large graph is compiled first.
const START_PATIENCE: Duration = Duration::from_secs(60);
const POLL: Duration = Duration::from_millis(20);
/// The engine and the viewer among the children.
const ENGINE: &str = "engine";
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
    let engine = supervisor.start(ENGINE, &mut engine_command(args.scenario.as_deref(), &args.tuning)?)?;
    for (plugin, mut command) in scenario.plugins.iter().zip(plugins) {
        supervisor.start(&plugin.name, &mut command)?;
    }
    announce(&scenario, &args.tuning.fleet);
    match scenario.viewer {
        Viewer::Off => {}
        Viewer::Auto if !has_display() => eprintln!("regatta: no display, so no viewer; the run goes on without it"),
        Viewer::Auto | Viewer::On => {
            supervisor.start(VIEWER, &mut viewer_command(&args.tuning.fleet, &scenario.lights)?)?;
        }
    }

    let needed = Needed { engine, viewer: scenario.viewer == Viewer::On };
    let mut all_well = watch(&mut supervisor, &needed, &args.tuning.fleet, args.for_.map(Into::into), &termination)?;
    for failure in supervisor.stop() {
        eprintln!("regatta: {failure}");
        all_well = false;
    }
    Ok(if all_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
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
    /// Whether a child that failed takes the run with it: neither the engine nor another plugin notices if a plugin does.
    fn ends_with(&self, ended: &Ended) -> bool {
        ended.name == ENGINE || ended.name == VIEWER && self.viewer
    }
}

/// Tells of the children that have ended. Whether the run ends with them, and whether all is well.
fn tell(ended: &[Ended], needed: &Needed) -> (bool, bool) {
    let (mut over, mut all_well) = (false, true);
    for ended in ended {
        let ends = needed.ends_with(ended);
        over |= ended.name == ENGINE;
        let Some(failure) = ended.failure() else { continue };
        over |= ends;
        // The viewer has said itself what is wrong, and is no part of what was asked for.
        all_well &= ended.name == VIEWER && !ends;
        eprintln!("regatta: {failure}{}", if ends { "" } else { "; the run goes on without it" });
    }
    (over, all_well)
}

/// Whether a window can be shown.
fn has_display() -> bool {
    let named = |variable| std::env::var_os(variable).is_some_and(|value| !value.is_empty());
    cfg!(any(target_os = "macos", windows)) || named("DISPLAY") || named("WAYLAND_DISPLAY")
}

/// Prints a status line a second until it is time to stop; returns whether all went well.
fn watch(
    supervisor: &mut Supervisor,
    needed: &Needed,
    fleet: &FleetName,
    limit: Option<Duration>,
    termination: &Termination,
) -> Result<bool, Failure> {
    let started = Instant::now();
    let mut control = Control::open(fleet)?;
    let mut answered = false;
    let mut next_line = started;
    let mut all_well = true;
    while !termination.requested() && limit.is_none_or(|limit| started.elapsed() < limit) {
        let (over, well) = tell(&supervisor.ended(), needed);
        all_well &= well;
        if over {
            return Ok(all_well);
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
            eprintln!("regatta: the engine gave no answer within {} s", START_PATIENCE.as_secs());
            return Ok(false);
        }
        std::thread::sleep(POLL);
    }
    Ok(all_well)
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

fn viewer_command(fleet: &FleetName, lights: &[LightEntry]) -> Result<Command, Failure> {
    let mut command = this_program()?;
    command.args(["viewer", "--fleet", &fleet.to_string()]);
    for LightEntry { x, y, z, colour: [red, green, blue] } in lights {
        command.args(["--light", &format!("{x},{y},{z},{red},{green},{blue}")]);
    }
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

#[cfg(test)]
mod tests {
    use clap::{Args, FromArgMatches};
    use regatta_engine::scenario::Overrides;

    use super::*;

    #[test]
    fn the_viewer_gets_the_scenarios_lights() {
        let lights = "[{x: -1.5, y: 2, z: 3}, {x: 4, y: 5e2, z: 6, colour: [1, 0.5, 0.25]}]";
        let text = format!("graph: none.yaml\nlights: {lights}\nrobots: [{{node: 1}}]\n");
        let graph = include_str!("../graphs/square.yaml");
        let scenario = Scenario::from_texts(&text, graph, Path::new("test"), &Overrides::default()).expect("sound");
        let command = viewer_command(&"lit".parse().expect("a name"), &scenario.lights).expect("a command");
        let arguments: Vec<_> = command.get_args().map(|argument| argument.to_string_lossy().into_owned()).collect();
        let wanted = ["viewer", "--fleet", "lit", "--light", "-1.5,2,3,1,1,1", "--light", "4,500,6,1,0.5,0.25"];
        assert_eq!(arguments, wanted);

        let parser = regatta_viewer::Options::augment_args(clap::Command::new("viewer"));
        let matches = parser.try_get_matches_from(&arguments).expect("the viewer takes them");
        let options = regatta_viewer::Options::from_arg_matches(&matches).expect("the viewer takes them");
        let hung: Vec<_> = options.look.scene().lights.iter().map(|light| light.position.to_array()).collect();
        assert_eq!(hung, [[-1.5, 2.0, 3.0], [4.0, 500.0, 6.0]]);
    }
}
