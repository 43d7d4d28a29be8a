//! `regatta-bench management`: the throughput and the effort of the fleet manager, and contacts of
//! robots. Engine, manager and validator run in lockstep as separate processes.

mod measurement;
mod parts;
mod processes;
mod tables;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use regatta::arguments::Time;
use regatta::experiment::plot::{self, Chart, Scale, Series};
use regatta::experiment::report::{Output, Report, environment};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::progress::Progress;
use regatta_scenario::RobotCount;
use serde_json::{Value, json};

use self::measurement::{Measured, Setup, Site};
use self::parts::Part;

#[derive(Args)]
pub struct ManagementArgs {
    #[command(flatten)]
    output: Output,
    /// Measure only these parts; separated by commas
    #[arg(long, value_name = "PART", value_delimiter = ',', value_enum)]
    only: Vec<Part>,
    /// Seeds of the runs, separated by commas
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [1, 2, 3])]
    seeds: Vec<u64>,
    /// Simulated time of a run (of 'large': ten minutes at most)
    #[arg(long, value_name = "TIME", default_value = "1h", value_parser = parse_duration)]
    duration: Time,
    /// Numbers of robots, separated by commas, instead of each part's own
    #[arg(long, value_name = "N", value_delimiter = ',')]
    robots: Vec<RobotCount>,
    /// Layout, for all parts but 'large'; the generated warehouse with 32 aisles and 4 rows if not
    /// given
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    layout: Option<PathBuf>,
    /// Ticks and frames per simulated second; the manager works at 10 in any case
    #[arg(long, value_name = "HZ", default_value_t = 10)]
    #[arg(value_parser = clap::value_parser!(u32).range(10..=1000))]
    rate: u32,
    /// Run a short version: one seed, ten minutes, fewer fleet sizes
    #[arg(long, conflicts_with_all = ["seeds", "duration"])]
    quick: bool,
}

/// The shortest run: it has a period of ten seconds after the warm-up.
const SHORTEST: Duration = Duration::from_secs(40);
const LONGEST: Duration = Duration::from_secs(7 * 24 * 3600);

fn parse_duration(text: &str) -> Result<Time, String> {
    let time: Time = text.parse().map_err(|error| format!("{error}"))?;
    let is_possible = (SHORTEST..=LONGEST).contains(&time.0);
    if is_possible { Ok(time) } else { Err("give 40 s to 7 days".to_owned()) }
}

/// The plan of a report: its arguments, with all defaults filled in.
struct Plan {
    parts: Vec<Part>,
    seeds: Vec<u64>,
    secs: u64,
    /// Empty for each part's own.
    robots: Vec<u32>,
    quick: bool,
}

impl Plan {
    fn new(args: &ManagementArgs) -> Self {
        let parts =
            Part::ALL.into_iter().filter(|part| args.only.is_empty() || args.only.contains(part));
        let robots = args.robots.iter().map(|count| count.0).collect();
        let (seeds, secs) = if args.quick {
            (vec![1], 600)
        } else {
            (args.seeds.clone(), args.duration.0.as_secs())
        };
        Self { parts: parts.collect(), seeds, secs, robots, quick: args.quick }
    }

    /// All runs, each once, in the order of the parts.
    fn setups(&self) -> Vec<Setup> {
        let mut setups: Vec<Setup> = Vec::new();
        for setup in self.parts.iter().flat_map(|part| part.setups(self)) {
            if !setups.contains(&setup) {
                setups.push(setup);
            }
        }
        setups
    }
}

/// The results of all runs.
#[derive(Default)]
struct Results {
    measured: BTreeMap<Setup, Measured>,
    /// Runs that failed, with the reason.
    failed: Vec<(Setup, String)>,
}

impl Results {
    fn contacts(&self) -> u64 {
        self.measured.values().map(|measured| measured.contacts).sum()
    }
}

pub fn run(program: &Program, args: &ManagementArgs) -> Result<ExitCode, Failure> {
    args.output.check("management")?;
    let plan = Plan::new(args);
    let site = Site::new(args.layout.as_deref(), args.rate)?;
    let results = measure(program, &plan, &site)?;
    let (line, machine) = environment(program);
    let markdown = tables::markdown(&plan, &results, &site.description(), &line);
    let plot = plan.parts.contains(&Part::Throughput).then(|| draw(&plan, &results)).transpose()?;
    let json = json(&plan, &results, args.rate, machine);
    args.output.write(&Report { name: "management", markdown, json, plot })?;
    let (failed, contacts) = (results.failed.len(), results.contacts());
    if failed > 0 || contacts > 0 {
        regatta_plugin::tell!(
            "regatta-bench: {failed} runs failed, and robots touched {contacts} times; the report \
             lists them"
        );
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

fn measure(program: &Program, plan: &Plan, site: &Site) -> Result<Results, Failure> {
    let setups = plan.setups();
    let progress = Progress::start("starting", setups.len() as u64);
    let mut results = Results::default();
    for setup in setups {
        progress.set_current(setup.to_string());
        match site.measure(program, &setup)? {
            Ok(measured) => drop(results.measured.insert(setup, measured)),
            Err(reason) => {
                regatta_plugin::tell!("{setup} failed: {reason}");
                results.failed.push((setup, reason));
            }
        }
        progress.step("finishing");
    }
    Ok(results)
}

/// Draws the throughput over the number of robots on the left, and the duration of a cycle on the
/// right.
fn draw(plan: &Plan, results: &Results) -> Result<String, Failure> {
    let (x, scale) = ("robots", Scale::Linear);
    plot::side_by_side(
        &Chart {
            caption: "Throughput",
            x,
            y: "goals a second",
            scale,
            series: lines(plan, results, &[true, false], |run| run.goals_per_sec),
        },
        &Chart {
            caption: "A cycle of the manager",
            x,
            y: "milliseconds",
            scale,
            series: lines(plan, results, &[true], |run| run.mean_cycle_ms),
        },
    )
}

/// Returns a figure over the number of robots: lines with and without acceleration limits, each
/// with and without conflicts, or as `conflicts` says.
fn lines(
    plan: &Plan,
    results: &Results,
    conflicts: &[bool],
    select: fn(&Measured) -> f64,
) -> Vec<Series> {
    let mut lines = Vec::new();
    for limited in [false, true] {
        for &conflicts in conflicts {
            let name = if conflicts { "manager" } else { "bound" };
            let limit = if limited { ", 0.8 m/s²" } else { "" };
            let rows = parts::throughput_rows(plan, limited, conflicts);
            let points = rows.iter().filter_map(|row| {
                Some((f64::from(row[0].robots), tables::mean_of(results, row, select)?))
            });
            lines.push(Series { name: format!("{name}{limit}"), points: points.collect() });
        }
    }
    lines
}

fn json(plan: &Plan, results: &Results, rate: u32, machine: Value) -> Value {
    let runs: Vec<_> =
        results.measured.iter().map(|(setup, measured)| measured.json(setup)).collect();
    let failed: Vec<_> = results
        .failed
        .iter()
        .map(|(setup, reason)| json!({"setup": setup.json(), "reason": reason}))
        .collect();
    let parts: Vec<_> = plan.parts.iter().map(|part| part.name()).collect();
    json!({
        "machine": machine, "parts": parts, "seeds": plan.seeds, "secs": plan.secs,
        "rate_hz": rate, "runs": runs, "failed": failed,
    })
}
