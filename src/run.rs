//! `regatta run`: runs a scenario as a set of child processes, or in this one.

mod in_process;
pub mod master;
mod window;

use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use clap::Args;
use regatta_layout::MAX_FILE_BYTES;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::{AFTER_VARIABLE, Control, FleetName, LOAD_VARIABLE, Termination};
use regatta_scenario::{PluginCommand, Scenario, Viewer};
use regatta_vda5050::broker::BrokerUrl;
use serde_json::json;
use tempfile::NamedTempFile;

use crate::activities::Activities;
use crate::arguments::Time;
use crate::day::DayArgs;
use crate::engine::EngineOptions;
use crate::failure::{Failure, plugin_failure};
use crate::output::with_plural;
use crate::scenario::Demo;
use crate::supervisor::{EndedChild, Supervisor};
use crate::trust::{self, TrustArgs};
use crate::{control, plugin, scenario};
use window::Opening;

/// The longest time until the engine's first response: it compiles the route graph first, which may
/// be large.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// The time between two checks of the children.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// The time between two status lines.
const STATUS_INTERVAL: Duration = Duration::from_secs(1);
/// The time between two looks at a warm-up.
const WARM_UP_LOOK: Duration = Duration::from_millis(50);
/// The name of the engine's process in messages.
const ENGINE: &str = "engine";
/// The name of the viewer's process in messages.
const VIEWER: &str = "viewer";
/// The option of a fleet manager that prints figures at the end.
const SUMMARY: &str = "--summary";
/// The name of the plugin that publishes the activities of robots.
const FLEET_MANAGER: &str = "fleet-manager";
/// The name of the plugin that lets a master of VDA 5050 steer the robots.
const VDA5050: &str = "vda5050";
/// The word that stands for all plugins of the scenario among those in lockstep.
const ALL_PLUGINS: &str = "all";
/// The section of a scenario that the fleet manager reads.
pub const LOAD: &str = "load";
/// Whether this program has a viewer.
const HAS_VIEWER: bool = cfg!(feature = "viewer");

#[derive(Args, Default)]
pub struct RunArgs {
    /// Scenario or layout file, - for standard input; the built-in demo if not given.
    #[arg(value_hint = clap::ValueHint::FilePath)]
    scenario: Option<PathBuf>,
    /// Run the built-in demo without the fleet manager: robots drive at random, and may collide.
    #[arg(long, conflicts_with = "scenario")]
    unmanaged: bool,
    #[command(flatten)]
    options: EngineOptions,
    /// Make the robots VDA 5050 vehicles, which a master steers instead of the fleet manager, on
    /// this MQTT broker or, without an address, on one that is started here.
    #[arg(long, value_name = "mqtt://[USER@]HOST[:PORT]", num_args = 0..=1)]
    #[arg(require_equals = true, conflicts_with_all = ["in_process", "unmanaged"])]
    vda5050: Option<Option<BrokerUrl>>,
    /// The vehicles that are steered, in the place of an engine's robots.
    #[arg(skip)]
    vehicles: Option<master::Vehicles>,
    #[command(flatten)]
    trust: TrustArgs,
    #[command(flatten)]
    day: DayArgs,
    /// Stop after this wall time, whatever the speed: 10 (seconds), 5min, 1h …
    #[arg(long = "for", value_name = "TIME", help_heading = "End of the run")]
    time_limit: Option<Time>,
    /// Stop after this simulated time.
    #[arg(long, value_name = "TIME", help_heading = "End of the run")]
    simulated: Option<Time>,
    /// Run engine and plugins in this process, as fast as possible, and print a table of results.
    #[arg(long, requires = "simulated", conflicts_with = "time_limit")]
    #[arg(help_heading = "Processes")]
    in_process: bool,
    /// Publish a run in one process to shared memory, for a viewer or other readers.
    #[arg(long, requires = "in_process", help_heading = "Processes")]
    publish: bool,
    /// Print JSON: a line about the fleet, then its status once per second.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs `regatta run`.
pub fn run(mut args: RunArgs) -> Result<ExitCode, Failure> {
    let (mut scenario, input) = read_scenario(&args)?;
    require_trust(&scenario, &args)?;
    if let Some(vehicles) = &args.vehicles {
        vehicles.prepare(&mut scenario);
    }
    if let Some(broker) = &args.vda5050 {
        let broker = broker.as_ref().map(BrokerUrl::to_text);
        steer_by_vda5050(&mut scenario, broker)?;
    }
    name_all(&mut args.options.lockstep.names, &scenario);
    // Until now, a signal ends this program at once, whatever it waits for.
    let termination = Termination::watch().map_err(plugin_failure)?;
    if args.vda5050.is_none()
        && let Some(warning) = unread_load(&scenario)
    {
        regatta_plugin::tell!("regatta: {warning}");
    }
    if args.in_process {
        return in_process::run(scenario, &args, &termination);
    }
    if scenario.viewer == Viewer::On && !HAS_VIEWER {
        return Err("the scenario requires a viewer, and this program was built without the \
                    feature 'viewer'"
            .into());
    }
    let fleet = &args.options.fleet;
    let mut plugins = Vec::new();
    for plugin in &scenario.plugins {
        plugins.push((&plugin.name, plugin_command(plugin, fleet)?));
    }

    let mut supervisor = Supervisor::default();
    let load = LoadFile::of(&args, &scenario)?;
    let mut engine = engine_command(&args)?;
    engine.args(args.ticks(&scenario).map(|ticks| format!("--ticks={ticks}")));
    if !args.warm_up(&scenario).is_zero() {
        let names: Vec<&str> = scenario.plugins.iter().map(|plugin| plugin.name.as_str()).collect();
        engine.arg(format!("--warm-up-with={}", names.join(",")));
    }
    if let Some(input) = input {
        engine.stdin(input);
    }
    let engine = supervisor.start(ENGINE, &mut engine)?;
    for (name, mut command) in plugins {
        command.envs(load.as_ref().map(|load| (LOAD_VARIABLE, load.path())));
        supervisor.start(name, &mut command)?;
    }
    print_summary(&scenario, &args);
    let mut opening = Opening::new(&scenario, &args)?;
    opening.open_at_once(&mut supervisor)?;
    let required = Required { engine_pid: engine, viewer: scenario.viewer == Viewer::On };
    let mut success = watch(&mut supervisor, &required, &mut opening, &args, &termination)?;
    for failure in supervisor.stop() {
        regatta_plugin::tell!("regatta: {failure}");
        success = false;
    }
    Ok(if success { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Replaces the word for all plugins by their names.
fn name_all(lockstep: &mut Vec<String>, scenario: &Scenario) {
    if !lockstep.iter().any(|name| name == ALL_PLUGINS) {
        return;
    }
    lockstep.retain(|name| name != ALL_PLUGINS);
    let names = scenario.plugins.iter().map(|plugin| plugin.name.clone());
    let others: Vec<String> = names.filter(|name| !lockstep.contains(name)).collect();
    lockstep.extend(others);
}

/// Gives the robots of a scenario to a master of VDA 5050. In a made-up scenario it takes the place
/// of the fleet manager.
fn steer_by_vda5050(scenario: &mut Scenario, broker: Option<String>) -> Result<(), Failure> {
    if scenario.is_default {
        scenario.plugins.retain(|plugin| plugin.name != FLEET_MANAGER);
    } else if let Some(other) =
        scenario.plugins.iter().find(|plugin| [FLEET_MANAGER, VDA5050].contains(&&*plugin.name))
    {
        return Err(format!(
            "--vda5050: the scenario has the plugin {}, which moves the robots; take it out",
            other.name
        )
        .into());
    }
    let args = broker.map(|broker| vec!["--broker".to_owned(), broker]).unwrap_or_default();
    let plugin = PluginCommand { name: VDA5050.to_owned(), args, ..PluginCommand::default() };
    scenario.plugins.push(plugin);
    Ok(())
}

/// Returns a warning if a scenario has orders and no plugin that could read them: a fleet manager,
/// or a program of the user's.
fn unread_load(scenario: &Scenario) -> Option<String> {
    let mut plugins = scenario.plugins.iter();
    let reads = plugins.any(|plugin| plugin.name == FLEET_MANAGER || !plugin.command.is_empty());
    (scenario.source.has(LOAD) && !reads).then(|| {
        format!(
            "the scenario has a load, and no plugin carries it: add {FLEET_MANAGER} to its plugins"
        )
    })
}

/// Reads the scenario. The engine reads it too; reading it here first reports an error once, before
/// any process starts. Also returns the text of standard input, if the scenario came from there,
/// for the engine to read again.
fn read_scenario(args: &RunArgs) -> Result<(Scenario, Option<File>), Failure> {
    let (path, overrides) = (args.scenario.as_deref(), args.options.overrides());
    if !scenario::is_standard_input(path) {
        return Ok((scenario::load(path, args.demo(), &overrides)?, None));
    }
    let mut file = tempfile::tempfile()?;
    io::copy(&mut io::stdin().lock().take(MAX_FILE_BYTES + 1), &mut file)?;
    file.rewind()?;
    let scenario = Scenario::read_from(&file, Path::new(scenario::STANDARD_INPUT), &overrides)?;
    scenario::viewer_args(&scenario)?;
    file.rewind()?;
    Ok((scenario, Some(file)))
}

/// Checks that the user trusts the scenario with its plugins: programs, and files and addresses
/// of built-in plugins.
fn require_trust(scenario: &Scenario, args: &RunArgs) -> Result<(), Failure> {
    let Some(path) = &args.scenario else { return Ok(()) };
    let reaching =
        scenario.plugins.iter().filter(|PluginCommand { name, command, args, .. }| {
            !command.is_empty() || plugin::reaches_out(name, args)
        });
    let wishes: Vec<String> = reaching.map(|plugin| plugin.in_words()).collect();
    let is_standard_input = scenario::is_standard_input(Some(path));
    let folder = path.parent().filter(|_| !is_standard_input);
    trust::require(&path.display().to_string(), folder, &wishes, args.trust)
}

/// Checks that a scenario has the plugin that carries out the orders of a day.
fn require_manager(scenario: &Scenario) -> Result<(), Failure> {
    if scenario.plugins.iter().any(|plugin| plugin.name == FLEET_MANAGER) {
        return Ok(());
    }
    Err(format!("--orders: no plugin carries them: add {FLEET_MANAGER} to the plugins").into())
}

fn copy_of(text: &str) -> io::Result<NamedTempFile> {
    let mut copy = NamedTempFile::with_suffix(".yaml")?;
    copy.write_all(text.as_bytes())?;
    Ok(copy)
}

/// The file in which plugins find the orders of a day, or the scenario's load.
enum LoadFile<'a> {
    Scenario(&'a Path),
    /// A copy of a scenario that is in no file.
    Copy(NamedTempFile),
}

impl<'a> LoadFile<'a> {
    /// Returns the file with the orders of a day, or with the load of a scenario, if there is one.
    fn of(args: &'a RunArgs, scenario: &Scenario) -> Result<Option<Self>, Failure> {
        if let Some(load) = args.day.load(scenario)? {
            require_manager(scenario)?;
            return Ok(Some(Self::Copy(copy_of(&load)?)));
        }
        let is_carried = args.vehicles.as_ref().is_none_or(|it| it.carries_load(scenario));
        let has_load = is_carried && scenario.source.has(LOAD);
        let load = has_load.then(|| Self::new(args, scenario));
        Ok(load.transpose()?)
    }

    fn new(args: &'a RunArgs, scenario: &Scenario) -> io::Result<Self> {
        let path = args.scenario.as_deref();
        if let Some(path) = path.filter(|path| !scenario::is_standard_input(Some(path)))
            && !scenario.is_default
        {
            return Ok(Self::Scenario(path));
        }
        copy_of(scenario.source.text()).map(Self::Copy)
    }

    fn path(&self) -> &Path {
        match self {
            Self::Scenario(path) => path,
            Self::Copy(file) => file.path(),
        }
    }
}

impl RunArgs {
    /// The simulated time of the warm-up. A master of VDA 5050 can't take part in one.
    fn warm_up(&self, scenario: &Scenario) -> Duration {
        if self.vda5050.is_some() || self.vehicles.is_some() {
            return Duration::ZERO;
        }
        self.options.warm_up(scenario)
    }

    fn demo(&self) -> Demo {
        if self.unmanaged { Demo::Unmanaged } else { Demo::Managed }
    }

    /// The number of ticks after which the run ends, if its simulated time is limited.
    fn ticks(&self, scenario: &Scenario) -> Option<u64> {
        let period_nanos = scenario.tick_period.as_nanos().max(1);
        let ticks = self.simulated?.0.as_nanos().div_ceil(period_nanos);
        Some(u64::try_from(ticks).unwrap_or(u64::MAX))
    }
}

fn print_summary(scenario: &Scenario, args: &RunArgs) {
    let fleet = &args.options.fleet;
    let robots = args.options.robots.map_or_else(|| scenario.robots(), |count| count.0);
    let edges = scenario.graph.edges().len();
    let rate_hz = (1.0 / scenario.tick_period.as_secs_f64()).round();
    if args.json {
        let fleet = fleet.as_str();
        let summary = json!({"fleet": fleet, "robots": robots, "edges": edges, "rate_hz": rate_hz});
        println!("{summary}");
    } else if let Some(vehicles) = &args.vehicles {
        println!(
            "fleet '{fleet}': vehicles {} on {}; Ctrl-C stops",
            vehicles.in_words(),
            with_plural(edges, "edge")
        );
    } else {
        println!(
            "fleet '{fleet}': {} on {}, {rate_hz} ticks a second; Ctrl-C stops",
            with_plural(robots as usize, "robot"),
            with_plural(edges, "edge")
        );
    }
}

/// The child processes that a run can't continue without. Plugins aren't among them: neither the
/// engine nor another plugin depends on a plugin.
struct Required {
    /// The process id of the engine.
    engine_pid: u32,
    /// Whether the scenario requires the viewer.
    viewer: bool,
}

impl Required {
    fn contains(&self, child: &EndedChild) -> bool {
        child.name == ENGINE || child.name == VIEWER && self.viewer
    }
}

/// Prints the failures of children that have ended. Returns whether the run is over and whether it
/// is still a success.
fn report_ended(children: &[EndedChild], required: &Required) -> (bool, bool) {
    let (mut over, mut success) = (false, true);
    for child in children {
        let is_required = required.contains(child);
        over |= child.name == ENGINE;
        let Some(failure) = child.failure() else { continue };
        over |= is_required;
        // An optional viewer that fails doesn't make the run a failure; it has printed its error
        // itself.
        success &= child.name == VIEWER && !is_required;
        let consequence = if is_required { "" } else { "; the run continues without it" };
        regatta_plugin::tell!("regatta: {failure}{consequence}");
    }
    (over, success)
}

/// Whether the time of a run is over. That of its warm-up doesn't count.
fn is_over(opening: &Opening, limit: Option<Duration>) -> bool {
    limit.zip(opening.warm_since()).is_some_and(|(limit, since)| since.elapsed() >= limit)
}

/// Formats the line of a status.
fn line(
    status: &ControlResponse,
    activities: &mut Activities,
    args: &RunArgs,
) -> Result<String, Failure> {
    let robots = activities.of_run(status.run_id)?;
    Ok(match args.json {
        true => control::status_json(status, robots).to_string(),
        false => control::run_line(status, robots),
    })
}

/// Prints a status line per second until the run is over; returns whether it is a success.
fn watch(
    supervisor: &mut Supervisor,
    required: &Required,
    opening: &mut Opening,
    args: &RunArgs,
    termination: &Termination,
) -> Result<bool, Failure> {
    let started = Instant::now();
    let limit = args.time_limit.map(|Time(limit)| limit);
    let mut control = Control::open(&args.options.fleet)?;
    let mut activities = Activities::join_as(&args.options.fleet, "run")?;
    let mut answered = false;
    let mut next_line = started;
    let mut success = true;
    while !termination.requested() && !is_over(opening, limit) {
        let (over, no_failure) = report_ended(&supervisor.take_ended(), required);
        success &= no_failure;
        if over {
            return Ok(success);
        }
        let interval = if opening.warm_since().is_some() { STATUS_INTERVAL } else { WARM_UP_LOOK };
        if Instant::now() >= next_line && control.has_engine() {
            match control.status() {
                // Another engine has this fleet name, which this run's engine is about to report.
                Ok(status) if status.pid != required.engine_pid => {}
                Ok(status) => {
                    opening.open_if_warm(&status, supervisor)?;
                    if opening.warm_since().is_some() {
                        println!("{}", line(&status, &mut activities, args)?);
                    }
                }
                // Either the engine has ended, which the next iteration reports, or the next
                // request succeeds.
                Err(error) => tracing::info!("{error}"),
            }
            answered = true;
            // Lines that are missing after a pause of this process or of the engine are not printed
            // later.
            next_line = (next_line + interval).max(Instant::now());
        }
        if !answered && started.elapsed() > START_TIMEOUT {
            regatta_plugin::tell!(
                "regatta: the engine did not respond within {} s",
                START_TIMEOUT.as_secs()
            );
            return Ok(false);
        }
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(success)
}

/// Returns a command that starts this executable.
fn this_program() -> Result<Command, Failure> {
    let path = std::env::current_exe()
        .map_err(|error| format!("can't find the path of this program: {error}"))?;
    Ok(Command::new(path))
}

fn engine_command(args: &RunArgs) -> Result<Command, Failure> {
    let mut command = this_program()?;
    // The engine tells the warnings about the scenario.
    if scenario::is_verbose() {
        command.arg("-v");
    }
    if let Some(vehicles) = &args.vehicles {
        let (fleet, layout) = (&args.options.fleet, &args.options.layout);
        command.args(["vda5050", "vehicles"]).args(&args.scenario);
        command.args(vehicles.to_args(fleet, layout));
        return Ok(command);
    }
    command.arg("engine").args(&args.scenario).args(args.options.to_args());
    if args.scenario.is_none() && args.demo() == Demo::Managed {
        command.arg("--managed-demo");
    }
    Ok(command)
}

fn plugin_command(plugin: &PluginCommand, fleet: &FleetName) -> Result<Command, Failure> {
    let mut command = if let Some((program, args)) = plugin.command.split_first() {
        let mut command = Command::new(program);
        command.args(args);
        command
    } else if plugin::is_built_in(&plugin.name) {
        let mut command = this_program()?;
        command.args(["plugin", &plugin.name]);
        if plugin.name == FLEET_MANAGER && !plugin.args.iter().any(|arg| arg == SUMMARY) {
            command.arg(SUMMARY);
        }
        command
    } else {
        return Err(plugin::unknown(&plugin.name).into());
    };
    command.args(["--fleet", &fleet.to_string()]).args(&plugin.args);
    if !plugin.after.is_empty() {
        command.env(AFTER_VARIABLE, plugin.after.join(","));
    }
    Ok(command)
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use clap::{Args, FromArgMatches};
    use regatta_scenario::Overrides;
    use regatta_viewer::options::CameraOption;

    use super::*;

    #[test]
    fn the_viewer_receives_the_lights_and_cameras_of_the_scenario() {
        let lights = "[{x: -1.5, y: 2, z: 3}, {x: 4, y: 5e2, z: 6, colour: [1, 0.5, 0.25]}]";
        let cameras = "[{name: dock, x: 4, y: -3, z: 12, yaw: 1.5, pitch: 0.9}, \
            {name: west hall, x: 2.5, y: 1, height: 40}]";
        let text = format!(
            "graph: none.yaml\nlights: {lights}\ncameras: {cameras}\nrobots: [{{node: 1}}]\n"
        );
        let graph = include_str!("../graphs/square.yaml");
        let scenario = Scenario::from_texts(&text, graph, Path::new("test"), &Overrides::default())
            .expect("a valid scenario");
        let command =
            window::viewer_command(&"lit".parse().expect("a name"), &scenario).expect("a command");
        let arguments: Vec<_> =
            command.get_args().map(|argument| argument.to_string_lossy().into_owned()).collect();
        let lights = [
            "viewer",
            "--fleet",
            "lit",
            "--light",
            "-1.5,2,3,1,1,1",
            "--light",
            "4,500,6,1,0.5,0.25",
        ];
        let cameras = ["--bookmark", "dock=4,-3,12,1.5,0.9", "--bookmark", "west hall=2.5,1,40"];
        assert_eq!(arguments, [&lights[..], &cameras].concat());

        let parser = regatta_viewer::Options::augment_args(clap::Command::new("viewer"));
        let matches = parser.try_get_matches_from(&arguments).expect("valid options of the viewer");
        let options = regatta_viewer::Options::from_arg_matches(&matches)
            .expect("valid options of the viewer");
        let positions: Vec<_> =
            options.look.scene().lights.iter().map(|light| light.position.to_array()).collect();
        assert_eq!(positions, [[-1.5, 2.0, 3.0], [4.0, 500.0, 6.0]]);
        let names: Vec<_> =
            options.bookmark.iter().map(|bookmark| bookmark.name.as_str()).collect();
        assert_eq!(names, ["dock", "west hall"]);
        let hall = &options.bookmark[1].view;
        assert!(matches!(hall, CameraOption::Eye(camera) if camera.is_plan()), "{hall:?}");
    }
}
