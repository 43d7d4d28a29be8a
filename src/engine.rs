//! `regatta engine`: runs the engine in this process.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use regatta_engine::engine::{Engine, Options, WarmUp};
use regatta_motion::Isa;
use regatta_plugin::producer::{LockstepOptions, Speed};
use regatta_plugin::{FleetName, SchedulingOptions, Termination};
use regatta_scenario::{Overrides, RobotCount, Scenario};

use crate::arguments::{LayoutArgs, Time, one_of};
use crate::failure::{Failure, plugin_failure};
use crate::progress::Progress;
use crate::scenario::{self, Demo};

#[derive(Args)]
pub struct EngineArgs {
    /// Scenario or layout file, - for standard input; the built-in demo if not given.
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub scenario: Option<PathBuf>,
    #[command(flatten)]
    pub options: EngineOptions,
    /// Run the demo whose robots wait for commands of a fleet manager, if no scenario is given.
    #[arg(long, hide = true)]
    pub managed_demo: bool,
    /// The plugins that take part in the warm-up; without this option there is none.
    #[arg(long, hide = true, value_delimiter = ',', num_args = 0..)]
    pub warm_up_with: Option<Vec<String>>,
    /// Stop after this number of ticks.
    #[arg(long, help_heading = "End of the run")]
    pub ticks: Option<u64>,
    /// Print a digest of every frame's columns at the end.
    #[arg(long, help_heading = "Output")]
    pub digest: bool,
}

/// Options of the engine that both `regatta run` and `regatta engine` have.
#[derive(Args, Clone, Default)]
pub struct EngineOptions {
    /// Name of the fleet.
    #[arg(long, default_value_t)]
    pub fleet: FleetName,
    /// Simulated seconds per wall second: a factor from 0.001 to 1000, or max.
    #[arg(long, default_value = "1", help_heading = "Speed and size")]
    pub speed: Option<Speed>,
    /// Number of robots instead of the scenario's (500, 10k, 1M …); the scenario's groups are
    /// repeated.
    #[arg(long, help_heading = "Speed and size")]
    pub robots: Option<RobotCount>,
    /// Ticks per simulated second instead of the scenario's.
    #[arg(long, value_name = "HZ", help_heading = "Speed and size")]
    pub rate: Option<f64>,
    /// Frames per simulated second; one per tick if not given.
    #[arg(long, value_name = "HZ", help_heading = "Speed and size")]
    pub publish_rate: Option<f64>,
    /// Seed of the random routes instead of the scenario's.
    #[arg(long, help_heading = "Speed and size")]
    pub seed: Option<u64>,
    /// Simulated time that `regatta run` runs through as fast as possible before the window opens,
    /// instead of the scenario's; 0 for none.
    #[arg(long, value_name = "TIME", help_heading = "Speed and size")]
    pub warm_up: Option<Time>,
    /// Number of threads that move robots.
    #[arg(long, default_value = "1", value_parser = parse_threads)]
    #[arg(help_heading = "Processor")]
    pub threads: Option<usize>,
    /// Instruction set of the motion kernel; the best available if not given.
    #[arg(long, value_parser = one_of::<Isa>(Isa::ALL.map(Isa::name)))]
    #[arg(help_heading = "Processor")]
    pub isa: Option<Isa>,
    #[command(flatten)]
    pub layout: LayoutArgs,
    #[command(flatten)]
    pub scheduling: SchedulingOptions,
    #[command(flatten)]
    pub lockstep: LockstepOptions,
}

/// The largest allowed number of threads per core: more threads only slow each other down.
const THREADS_PER_CORE: usize = 4;

pub fn parse_threads(text: &str) -> Result<usize, String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = THREADS_PER_CORE * cores;
    match text.parse() {
        Ok(threads) if (1..=most).contains(&threads) => Ok(threads),
        _ => Err(format!("give 1 to {most}, as this machine has {cores} cores")),
    }
}

impl EngineOptions {
    pub fn overrides(&self) -> Overrides {
        let (rate, publish_rate, seed) = (self.rate, self.publish_rate, self.seed);
        Overrides { layout: self.layout.options(), rate, publish_rate, seed }
    }

    /// The simulated time of the warm-up of a scenario.
    pub fn warm_up(&self, scenario: &Scenario) -> Duration {
        self.warm_up.map_or(scenario.warm_up, |Time(time)| time)
    }

    /// Converts the options to command-line arguments for a child process.
    pub fn to_args(&self) -> Vec<String> {
        let mut args = vec![format!("--fleet={}", self.fleet)];
        args.extend(self.speed.map(|speed| format!("--speed={speed}")));
        args.extend(self.robots.map(|robots| format!("--robots={robots}")));
        args.extend(self.rate.map(|rate| format!("--rate={rate}")));
        args.extend(self.publish_rate.map(|rate| format!("--publish-rate={rate}")));
        args.extend(self.seed.map(|seed| format!("--seed={seed}")));
        args.extend(self.warm_up.map(|Time(time)| format!("--warm-up={}", time.as_secs_f64())));
        args.extend(self.threads.map(|threads| format!("--threads={threads}")));
        args.extend(self.isa.map(|isa| format!("--isa={isa}")));
        args.extend(self.layout.to_args());
        args.extend(self.scheduling.priority.map(|priority| format!("--priority={priority}")));
        args.extend(self.scheduling.pin.iter().map(|core| format!("--pin={core}")));
        args.push(format!("--lockstep-timeout={}", self.lockstep.timeout.as_secs_f64()));
        args.extend(self.lockstep.names.iter().map(|name| format!("--lockstep={name}")));
        args
    }
}

/// Runs `regatta engine`.
pub fn run(args: EngineArgs) -> Result<(), Failure> {
    let termination = Termination::watch().map_err(plugin_failure)?;
    let demo = if args.managed_demo { Demo::Managed } else { Demo::Unmanaged };
    let scenario = scenario::load(args.scenario.as_deref(), demo, &args.options.overrides())?;
    // The engine of `regatta run` prints this, too.
    if scenario.is_default {
        regatta_plugin::tell!(
            "regatta: this is a layout without a scenario: one is made up; `regatta new` writes it \
             to a file"
        );
    }
    scenario::tell_warnings(&scenario);
    let warm_up = args.warm_up_with.map_or_else(WarmUp::default, |plugins| WarmUp {
        duration: args.options.warm_up(&scenario),
        plugins,
    });
    let shared = args.options;
    shared.scheduling.apply()?;
    let options = Options {
        fleet: shared.fleet,
        robots: shared.robots.map(|count| count.0),
        speed: shared.speed.unwrap_or(Speed::Factor(1.0)),
        threads: shared.threads.unwrap_or(1),
        isa: shared.isa,
        ticks: args.ticks,
        digest: args.digest,
        lockstep: shared.lockstep,
        warm_up,
    };
    let progress = Progress::start("setting the fleet up", 0);
    let mut engine = Engine::new(scenario, options)?;
    drop(progress);
    let summary = engine.run(&termination)?;
    if let Some(digest) = summary.digest {
        println!("{digest:032x}");
    }
    regatta_plugin::tell!(
        "engine: {} ticks, {:.2} s simulated in {:.2} s, {} late",
        summary.ticks,
        summary.sim_time.as_secs_f64(),
        summary.wall_time.as_secs_f64(),
        summary.late_ticks
    );
    Ok(())
}
