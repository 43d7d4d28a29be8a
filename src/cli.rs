//! The arguments of the command line, and log output.

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use regatta_plugin::producer::Speed;

use crate::control::Target;
use crate::{doctor, engine, graph, plugin, recording, report, run};

/// Simulate, watch and steer a large fleet of mobile robots.
#[derive(Parser)]
#[command(name = "regatta", version, arg_required_else_help = false, max_term_width = 100)]
pub struct Cli {
    /// Print more: -v shows progress and the causes of errors, -vv also details.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Subcommand)]
pub enum Command {
    /// Run a scenario: the engine, its plugins and the viewer (without a scenario, a built-in demo).
    Run(run::RunArgs),
    /// Run only the engine, in this process.
    Engine(engine::EngineArgs),
    /// Run one of the built-in plugins, in this process.
    #[command(disable_help_flag = true)]
    Plugin(plugin::PluginArgs),
    /// Show a fleet in 3D, in a window or (with --headless) in pictures.
    Viewer(Box<regatta_viewer::Options>),
    /// Check, describe, generate and draw route graphs.
    Graph {
        #[command(subcommand)]
        command: graph::GraphCommand,
    },
    /// Pause the clock of a running fleet.
    Pause(Target),
    /// Resume the clock of a paused fleet.
    Resume(Target),
    /// Pause, and advance by a number of ticks at the fleet's speed (immediately after `regatta speed max`).
    Step {
        /// Number of ticks.
        #[arg(default_value_t = 1)]
        ticks: u64,
        #[command(flatten)]
        target: Target,
    },
    /// Change the speed: simulated seconds per wall second.
    Speed {
        /// A factor from 0.001 to 1000, or max.
        speed: Speed,
        #[command(flatten)]
        target: Target,
    },
    /// Jump to a simulated time of a replay.
    Seek {
        /// Time on the recording's clock, as in `--from` and in exported tables: 12.5s, 3min … (A recording that began
        /// late in a run starts at that time, not at 0.)
        #[arg(allow_negative_numbers = true)]
        time: humantime::Duration,
        #[command(flatten)]
        target: Target,
    },
    /// Change the number of robots while the fleet runs.
    Robots {
        /// New number of robots.
        robots: u32,
        #[command(flatten)]
        target: Target,
    },
    /// Print the status of a running fleet.
    Status {
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        target: Target,
    },
    /// Record a fleet to an MCAP file, or repair such a recording.
    Record(regatta_record::RecordArgs),
    /// Publish a recording as if its fleet were running, so that every reader works with it.
    Replay(regatta_record::ReplayArgs),
    /// Describe a recording: its fleet, time, ticks, robots, runs, topics with their sizes, and whether it is complete.
    Info(recording::InfoArgs),
    /// Write a recording as CSV or Parquet.
    Export(regatta_record::ExportArgs),
    /// Plot one robot of a recording: its path over the graph, and its x, y, heading and speed over time.
    Plot(regatta_record::PlotArgs),
    /// Watch and steer a running fleet live in this terminal.
    Top(Target),
    /// Repeat the experiments that Regatta's accuracy and speed are measured with.
    Report {
        #[command(subcommand)]
        command: report::ReportCommand,
    },
    /// Check that this machine can run fleets, and clean up after crashed ones.
    Doctor(doctor::DoctorArgs),
    /// Print a completion script for a shell.
    Completions {
        /// Shell that runs the script.
        shell: Shell,
    },
}

impl Default for Command {
    fn default() -> Self {
        Self::Run(run::RunArgs::default())
    }
}

/// Writes log messages to standard error: warnings, and one more level for each `-v`.
pub fn start_logging(verbose: u8) {
    let level = match verbose {
        0 => tracing::Level::WARN,
        1 => tracing::Level::INFO,
        _ => tracing::Level::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_target(false)
        .without_time()
        .with_writer(std::io::stderr)
        .init();
}

/// Prints the requested help or version, or one line that says what is wrong with the arguments.
pub fn print_usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // Printing fails if the reader of a pipe is gone, which is no error here.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.to_string();
    // Clap's first paragraph says what is wrong, in several lines if arguments are missing. The usage follows it.
    let paragraph: Vec<_> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let message = paragraph.join(" ");
    eprintln!("regatta: {}; --help lists all commands and options", message.trim_start_matches("error: "));
    ExitCode::from(2)
}

/// Writes a completion script to standard output.
pub fn print_completions(shell: Shell) {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "regatta", &mut script);
    print!("{}", String::from_utf8_lossy(&script));
}
