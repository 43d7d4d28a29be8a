//! `regatta-bench study`: the speed of studies, their cost beyond the runs, and their
//! repeatability.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{ExitCode, Stdio};
use std::time::Instant;

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{check_interrupt, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use serde_json::{Value, json};

/// The bars that the project has set itself.
const HUNDRED_SECS: f64 = 600.0;
const OVERHEAD: f64 = 0.05;
const KNEE_SECS: f64 = 300.0;
const INTERVAL: f64 = 0.02;
/// Simulated time of the runs of the knee: with hundreds of robots, thousands of orders.
const KNEE_DURATION: &str = "15min";

#[derive(Args)]
pub struct StudyArgs {
    #[command(flatten)]
    output: Output,
    /// Robots of the hundred runs of an hour
    #[arg(long, value_name = "N", default_value_t = 200)]
    robots: u32,
    /// Run a short version: ten runs instead of a hundred, and 1 to 100 robots instead of 1 to 1000
    #[arg(long)]
    quick: bool,
}

/// A study that was measured.
struct Measured {
    /// Wall time of the study, in seconds.
    secs: f64,
    runs: usize,
    /// The wall times of all runs, added up, in seconds.
    run_secs: f64,
    answer: Value,
    bytes: Vec<u8>,
}

pub fn run(program: &Program, args: &StudyArgs) -> Result<ExitCode, Failure> {
    args.output.check("study")?;
    let folder = temporary_folder()?;
    let plant = folder.path().join("warehouse.yaml");
    write(&plant, include_str!("../../graphs/warehouse.yaml"))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (count, most) = if args.quick { (10, "1..100") } else { (100, "1..1000") };
    let measure =
        |name: &str, options: &[&str]| measure(program, &plant, &folder.path().join(name), options);

    let (seeds, robots) = (format!("{count}..{count}"), args.robots.to_string());
    let hundred = measure(
        "hundred",
        &["--robots", &robots, "--seeds", &seeds, "--duration", "1h", "--reliefs", "0"],
    )?;
    let knee = measure("knee", &["--robots", most, "--reliefs", "0", "--duration", KNEE_DURATION])?;
    let small = ["--robots", "1..40", "--duration", "5min", "--seeds", "2..4", "--reliefs", "1"];
    let twice = [measure("first", &small)?, measure("second", &small)?];

    // Fewer runs have less time.
    let hundred_secs = HUNDRED_SECS * f64::from(count) / 100.0;
    let overhead = (hundred.secs * cores as f64 / hundred.run_secs - 1.0).max(0.0);
    let at_knee = &knee.answer["variants"][0]["knee"];
    let [half_width, mean] = ["half_width", "mean"]
        .map(|key| at_knee["orders_per_hour"][key].as_f64().unwrap_or(f64::NAN));
    let interval = half_width / mean;
    let repeats = twice[0].bytes == twice[1].bytes;
    let (line, machine) = environment(program);
    let knee_robots = at_knee["robots"].as_u64().unwrap_or(0);
    let markdown = format!(
        "# Studies\n\n{line}\n\n| | measured | bar | |\n|---|---|---|---|\n\
         | {} runs of {robots} robots × 1 simulated hour, {cores} at a time | {:.0} s | \
         {hundred_secs:.0} s | {} |\n\
         | the study over its runs | {:.1} % | {:.0} % | {} |\n\
         | `warehouse.yaml`, {most} robots, runs of {KNEE_DURATION}: the knee ({knee_robots} \
         robots, {} runs) | {:.0} s | {KNEE_SECS:.0} s | {} |\n\
         | half of the 95 % interval there | {:.1} % | {:.0} % | {} |\n\
         | the same study twice gives the same bytes | {} | yes | {} |\n",
        hundred.runs,
        hundred.secs,
        verdict(hundred.secs <= hundred_secs),
        overhead * 100.0,
        OVERHEAD * 100.0,
        verdict(overhead <= OVERHEAD),
        knee.runs,
        knee.secs,
        verdict(knee.secs <= KNEE_SECS),
        interval * 100.0,
        INTERVAL * 100.0,
        verdict(interval <= INTERVAL),
        if repeats { "yes" } else { "no" },
        verdict(repeats),
    );
    let json = json!({
        "machine": machine, "runs": hundred.runs, "robots": args.robots, "runs_secs": hundred.secs,
        "runs_secs_added_up": hundred.run_secs, "overhead": overhead, "knee_secs": knee.secs,
        "knee_robots": knee_robots,
        "knee_runs": knee.runs, "knee_interval": interval, "repeats": repeats,
    });
    args.output.write(&Report { name: "study", markdown, json, plot: None })?;
    Ok(ExitCode::SUCCESS)
}

fn verdict(is_met: bool) -> &'static str {
    if is_met { "met" } else { "**missed**" }
}

/// Runs a study in a new folder.
fn measure(
    program: &Program,
    plant: &Path,
    folder: &PathBuf,
    options: &[&str],
) -> Result<Measured, Failure> {
    check_interrupt()?;
    let started = Instant::now();
    let mut command = program.command();
    command.arg("study").arg(plant).args(options).arg("--output").arg(folder).stdout(Stdio::null());
    let status = command.status()?;
    check_interrupt()?;
    if !status.success() {
        return Err("the study failed; its messages are above".into());
    }
    let secs = started.elapsed().as_secs_f64();
    let bytes = fs::read(folder.join("study.json"))?;
    let times = regatta_study::store::times(folder);
    Ok(Measured {
        secs,
        runs: times.len(),
        run_secs: times.values().sum(),
        answer: serde_json::from_slice(&bytes)?,
        bytes,
    })
}
