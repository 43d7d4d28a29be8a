//! What the command line takes.

use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use regatta_plugin::FleetName;
use regatta_plugin::producer::Speed;

use crate::{doctor, engine, graph, plugin, report, run};

/// Simulate, watch and steer a large fleet of mobile robots.
#[derive(Parser)]
#[command(name = "regatta", version, arg_required_else_help = false, max_term_width = 100)]
pub struct Cli {
    /// Say more: -v shows causes and progress, -vv details.
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
    /// Run one of the plugins that come with Regatta, in this process.
    #[command(disable_help_flag = true)]
    Plugin(plugin::PluginArgs),
    /// See a fleet in 3D, in a window or with --headless in pictures.
    Viewer(Box<regatta_viewer::Options>),
    /// Check, describe, generate and draw route graphs.
    Graph {
        #[command(subcommand)]
        command: graph::GraphCommand,
    },
    /// Stop the clock of a running fleet.
    Pause(Target),
    /// Let the clock of a paused fleet go on.
    Resume(Target),
    /// Pause, and advance by so many ticks at the fleet's speed (at once after `regatta speed max`).
    Step {
        /// Number of ticks.
        #[arg(default_value_t = 1)]
        ticks: u64,
        #[command(flatten)]
        target: Target,
    },
    /// Change the simulated seconds per wall second.
    Speed {
        /// A factor from 0.001 to 1000, or max.
        speed: Speed,
        #[command(flatten)]
        target: Target,
    },
    /// Go to a simulated time of a replay.
    Seek {
        /// On the recording's clock, as `--from` and exported tables have it: 12.5s, 3min … (A recording that began late
        /// in a run begins at that time, not at 0.)
        #[arg(allow_negative_numbers = true)]
        time: humantime::Duration,
        #[command(flatten)]
        target: Target,
    },
    /// Change the number of robots while the fleet runs.
    Robots {
        /// The wanted number.
        robots: u32,
        #[command(flatten)]
        target: Target,
    },
    /// Say how a running fleet is.
    Status {
        /// As JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        target: Target,
    },
    /// Record a fleet to an MCAP file, or repair such a recording.
    Record(regatta_record::RecordArgs),
    /// Publish a recording as if its fleet were running: every reader works on it.
    Replay(regatta_record::ReplayArgs),
    /// Write a recording as CSV or Parquet.
    Export(regatta_record::ExportArgs),
    /// Draw one robot's way through a recording: its path over the graph, and x, y, heading and speed over time.
    Plot(regatta_record::PlotArgs),
    /// Watch and steer a running fleet, live in this terminal.
    Top(Target),
    /// Repeat the experiments that Regatta is measured by.
    Report {
        #[command(subcommand)]
        command: report::ReportCommand,
    },
    /// Check that this machine can run fleets, and clean up after crashed ones.
    Doctor(doctor::DoctorArgs),
    /// Print a completion script for a shell.
    Completions {
        /// The shell.
        shell: Shell,
    },
}

impl Default for Command {
    fn default() -> Self {
        Self::Run(run::RunArgs::default())
    }
}

/// Which fleet to talk to.
#[derive(Args)]
pub struct Target {
    /// Name of the fleet.
    #[arg(long, default_value_t)]
    pub fleet: FleetName,
}

/// Sends log lines to standard error: warnings, and more for each `-v`.
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

/// Help and version as asked for; one line for what is wrong with the arguments.
pub fn explain(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // With colours where the terminal has them; nobody may be reading it any more.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.to_string();
    // Clap's first paragraph says what is wrong, over several lines if arguments are missing; usage follows it.
    let paragraph: Vec<_> = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect();
    let message = paragraph.join(" ");
    eprintln!("regatta: {}; --help lists what there is", message.trim_start_matches("error: "));
    ExitCode::from(2)
}

/// One line for what failed; its causes below it if asked for.
pub fn print_failure(failure: &(dyn std::error::Error + 'static), verbose: bool) {
    eprintln!("regatta: {failure}");
    let causes = std::iter::successors(failure.source(), |cause| cause.source());
    for cause in causes.take_while(|_| verbose) {
        eprintln!("  because: {cause}");
    }
}

/// Writes a completion script to standard output.
pub fn print_completions(shell: Shell) {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "regatta", &mut script);
    print!("{}", String::from_utf8_lossy(&script));
}
