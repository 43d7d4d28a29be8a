//! The arguments of the command line.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::LazyLock;

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use regatta_plugin::producer::Speed;
use regatta_plugin::usage_line;
use regatta_scenario::RobotCount;

use crate::arguments::Time;
use crate::control::Target;
use crate::failure::Failure;
use crate::output::{Force, write_file};
use crate::{
    command, doctor, engine, graph, orders, plugin, recording, report, run, study, vda5050, version,
};

static SHORT_VERSION: LazyLock<String> = LazyLock::new(version::short);
static LONG_VERSION: LazyLock<String> = LazyLock::new(version::long);

/// Simulate, watch and steer a large fleet of mobile robots.
#[derive(Parser)]
#[command(name = "regatta", version = SHORT_VERSION.as_str())]
#[command(long_version = LONG_VERSION.as_str())]
#[command(arg_required_else_help = false, max_term_width = 100)]
pub struct Cli {
    /// Print more messages: -v for progress and the causes of errors, -vv for details as well.
    #[arg(short, long, global = true, action = clap::ArgAction::Count, display_order = 900)]
    pub verbose: u8,
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Subcommand)]
pub enum Command {
    /// Run a scenario: the engine, its plugins and the viewer (without a scenario, a built-in
    /// demo).
    Run(Box<run::RunArgs>),
    /// Steer the VDA 5050 vehicles of an MQTT broker with the fleet manager.
    Master(Box<run::master::MasterArgs>),
    /// Run only the engine, in this process.
    Engine(engine::EngineArgs),
    /// Run one of the built-in plugins, in this process.
    #[command(disable_help_flag = true)]
    Plugin(plugin::PluginArgs),
    /// Show a fleet in 3D, in a window or (with --headless) in pictures.
    #[cfg(feature = "viewer")]
    Viewer(Box<regatta_viewer::Options>),
    /// Check, describe, generate, draw, convert and compare layouts of any format.
    #[command(arg_required_else_help = false)]
    Graph {
        #[command(subcommand)]
        command: graph::GraphCommand,
    },
    /// Create a folder with a scenario and a README for a layout of any format.
    New(crate::new::NewArgs),
    /// Pause the clock of a running fleet.
    Pause(Target),
    /// Resume the clock of a paused fleet.
    Resume(Target),
    /// Pause a fleet, then advance it by a number of ticks.
    Step {
        /// Number of ticks.
        #[arg(default_value_t = 1)]
        ticks: u64,
        #[command(flatten)]
        target: Target,
    },
    /// Change the speed: simulated seconds per wall second.
    Speed {
        /// Factor from 0.001 to 1000, or max.
        speed: Speed,
        #[command(flatten)]
        target: Target,
    },
    /// Jump to a simulated time of a replay.
    Seek {
        /// Time on the recording's clock, as in `--from` and in exported tables: 4 (seconds),
        /// 12.5s, 3min … (A recording that began late in a run starts at that time, not at 0.)
        #[arg(allow_negative_numbers = true)]
        time: Time,
        #[command(flatten)]
        target: Target,
    },
    /// Change the number of robots of a running fleet, or break or repair one.
    #[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
    Robots {
        /// New number of robots: 500, 10k, 1M …
        #[arg(required = true)]
        robots: Option<RobotCount>,
        #[command(flatten)]
        target: Target,
        #[command(subcommand)]
        command: Option<command::RobotsCommand>,
    },
    /// Send a command to a robot of a running fleet, close an edge, or request a door or a lift,
    /// and wait for the answer.
    #[command(name = "command")]
    Send {
        #[command(subcommand)]
        command: command::RobotCommand,
    },
    /// Print the status of a running fleet.
    Status {
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        target: Target,
    },
    /// List the fleets that run on this machine.
    List {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// End the run of a fleet, as Ctrl-C in its terminal does.
    Stop(Target),
    /// Record a fleet to an MCAP file, or repair such a recording.
    Record(regatta_record::RecordArgs),
    /// Publish a recording as a fleet, which every reader can read.
    Replay(regatta_record::ReplayArgs),
    /// Describe a recording: its fleet, time, ticks, robots, runs, topics with their sizes, and
    /// whether it is complete.
    Info(recording::InfoArgs),
    /// Write a recording as CSV or Parquet.
    Export(regatta_record::ExportArgs),
    /// Plot one robot of a recording: its path over the graph, and its x, y, heading and speed over
    /// time.
    Plot(regatta_record::PlotArgs),
    /// Validate a recording: contacts, motion, orders; fail if there are findings.
    Validate(recording::ValidateArgs),
    /// Check the VDA 5050 messages of masters and vehicles, or show vehicles as a fleet.
    #[command(arg_required_else_help = false)]
    Vda5050 {
        #[command(subcommand)]
        command: vda5050::Vda5050Command,
    },
    /// Show a fleet on another host: send one of this host, or receive one from another host.
    #[cfg(feature = "zenoh")]
    #[command(arg_required_else_help = false)]
    Mirror {
        #[command(subcommand)]
        command: regatta_mirror::MirrorCommand,
    },
    /// Watch and steer a running fleet live in this terminal.
    Top(Target),
    /// List, show, cancel and import the transport orders of a running fleet manager.
    #[command(arg_required_else_help = false)]
    Orders {
        #[command(subcommand)]
        command: orders::OrdersCommand,
    },
    /// Measure Regatta's accuracy and speed.
    #[command(arg_required_else_help = false)]
    Report {
        #[command(subcommand)]
        command: report::ReportCommand,
    },
    /// Find how many robots a plant holds by simulating many runs, here or on a cluster, and write
    /// a page of results.
    Study(Box<study::StudyArgs>),
    /// Execute one job of a study; the workers of a study run this command.
    #[command(hide = true)]
    StudyRun(study::StudyRunArgs),
    /// Measure and validate a run of a study.
    #[command(hide = true)]
    StudyObserve(study::ObserverArgs),
    /// Check that this machine can run fleets, and clean up after crashed ones.
    Doctor(doctor::DoctorArgs),
    /// Print a completion script for a shell.
    Completions {
        /// Shell that runs the script.
        shell: Shell,
    },
    /// Write the man pages to a folder.
    #[command(hide = true)]
    Man {
        /// Folder that exists.
        folder: PathBuf,
        #[command(flatten)]
        force: Force,
    },
}

impl Default for Command {
    fn default() -> Self {
        Self::Run(Box::default())
    }
}

impl Command {
    /// The name before the messages of a command.
    pub fn speaker(&self) -> &str {
        match self {
            Self::Plugin(args) => args.name_and_args.first().map_or("regatta", String::as_str),
            Self::Engine(_) => "engine",
            #[cfg(feature = "viewer")]
            Self::Viewer(_) => "viewer",
            _ => "regatta",
        }
    }
}

/// Prints the requested help or version, or the error of the arguments in one line.
pub fn print_usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // Printing fails if the reader of a pipe is gone, which isn't an error here.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    regatta_plugin::tell!("regatta: {}; --help lists all commands and options", usage_line(error));
    ExitCode::from(2)
}

/// Returns all commands, for completions and man pages.
fn commands() -> clap::Command {
    Cli::command().mut_subcommand("plugin", plugin::with_subcommands)
}

/// Writes a completion script to standard output.
pub fn print_completions(shell: Shell) {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut commands(), "regatta", &mut script);
    print!("{}", String::from_utf8_lossy(&script));
}

/// Writes a man page per command, `regatta-run.1` for example, to a folder.
pub fn write_man_pages(folder: &Path, force: Force) -> Result<(), Failure> {
    let mut command = commands().disable_help_subcommand(true);
    command.build();
    write_man_page(&command, folder, force)
}

fn write_man_page(command: &clap::Command, folder: &Path, force: Force) -> Result<(), Failure> {
    let man = clap_mangen::Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    write_file(&folder.join(man.get_filename()), &page, force)?;
    for command in command.get_subcommands().filter(|command| !command.is_hide_set()) {
        write_man_page(command, folder, force)?;
    }
    Ok(())
}
