//! `regatta-bench plants`: the fleet manager on many plants, with each of several planners. Each
//! plant is a study of its own, by the program `regatta`.

mod generated;
pub mod manifest;
mod measure;
mod summary;
mod tables;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::temporary_folder;
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::progress::Progress;

use self::manifest::Source;
use self::measure::Answer;
use self::summary::{Plant, Summary};

#[derive(Args)]
pub struct PlantsArgs {
    #[command(flatten)]
    output: Output,
    /// Folders whose layouts are measured, too, with those of their subfolders
    #[arg(long, value_name = "FOLDER", num_args = 1.., value_hint = clap::ValueHint::DirPath)]
    layouts: Vec<PathBuf>,
    /// Measure only plants whose names contain one of these texts; separated by commas
    #[arg(long, value_name = "TEXT", value_delimiter = ',')]
    only: Vec<String>,
    /// Numbers of robots, separated by commas; if not given, 1, 2, 4, … up to half of a plant's
    /// nodes
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    robots: Vec<u32>,
    /// Planners of the fleet manager, separated by commas; the first is compared with the others
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    #[arg(default_values_t = ["auto", "lanes", "pibt"].map(str::to_owned))]
    planners: Vec<String>,
    /// Runs of each number of robots with each planner; run N has the seed N
    #[arg(long, value_name = "N", default_value_t = 3)]
    #[arg(value_parser = clap::value_parser!(u64).range(2..=1000))]
    seeds: u64,
    /// Simulated minutes of a run
    #[arg(long, value_name = "N", default_value_t = 60)]
    #[arg(value_parser = clap::value_parser!(u64).range(2..=7 * 24 * 60))]
    minutes: u64,
    /// Run a short version: 2 runs of 20 minutes each, with 16 robots at most
    #[arg(long, conflicts_with_all = ["robots", "seeds", "minutes"])]
    quick: bool,
    /// Runs side by side; if not given, the number of cores
    #[arg(short, long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
}

/// The measurements of each plant.
struct Plan {
    /// In ascending order.
    robots: Vec<u32>,
    limit: Limit,
    /// The first is compared with the others.
    planners: Vec<String>,
    seeds: u64,
    minutes: u64,
    jobs: Option<NonZeroUsize>,
}

/// The largest number of robots on a plant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Limit {
    /// As many as it holds.
    Room,
    /// Half of the nodes of its main part, at least one.
    HalfOfNodes,
}

/// The numbers of robots unless some are given: each plant has those up to half of its nodes.
const ROBOTS: [u32; 10] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512];
/// The same for a look.
const QUICK_ROBOTS: &[u32] = &[1, 2, 4, 8, 16];
const QUICK_SEEDS: u64 = 2;
const QUICK_MINUTES: u64 = 20;

/// A layout that the program doesn't take.
struct Refused {
    name: String,
    reason: String,
}

/// The plants of a report.
#[derive(Default)]
struct Results {
    plants: Vec<Plant>,
    refused: Vec<Refused>,
}

pub fn run(program: &Program, args: &PlantsArgs) -> Result<ExitCode, Failure> {
    args.output.check("plants")?;
    let plan = Plan::new(args)?;
    let folder = temporary_folder()?;
    let mut shipped = manifest::write_shipped(folder.path())?;
    shipped.extend(generated::write_generated(folder.path())?);
    let sources = sources(args, shipped)?;
    measure::check(program, &plan, folder.path())?;
    let results = measure_all(program, &plan, &sources)?;
    let summary = Summary::new(&plan, &results.plants);
    let (line, machine) = environment(program);
    let report = Report {
        name: "plants",
        markdown: tables::markdown(&plan, &results, &summary, &line),
        json: tables::json(&plan, &results, &summary, machine),
        plot: None,
    };
    args.output.write(&report)?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the plants to measure: the shipped ones, then those of the folders.
fn sources(args: &PlantsArgs, shipped: Vec<Source>) -> Result<Vec<Source>, Failure> {
    let mut sources = shipped;
    for folder in &args.layouts {
        sources.extend(manifest::find(folder)?);
    }
    if args.only.is_empty() {
        return Ok(sources);
    }
    sources.retain(|source| args.only.iter().any(|text| source.name.contains(text)));
    if sources.is_empty() {
        let texts = args.only.join(", ");
        return Err(format!(
            "--only {texts}: no plant has such a name; give a part of one, such as square.yaml"
        )
        .into());
    }
    Ok(sources)
}

fn measure_all(program: &Program, plan: &Plan, sources: &[Source]) -> Result<Results, Failure> {
    let progress = Progress::start("starting", sources.len() as u64);
    let mut results = Results::default();
    for source in sources {
        progress.set_current(format!("studying {}", source.name));
        let name = source.name.clone();
        match measure::measure(program, plan, source)? {
            Answer::Measured(study) => {
                let measure::Study { runs, failures } = study;
                results.plants.push(Plant { name, kind: source.kind, runs, failures });
            }
            Answer::Refused(reason) => results.refused.push(Refused { name, reason }),
        }
        progress.step("finishing");
    }
    Ok(results)
}

impl Plan {
    fn new(args: &PlantsArgs) -> Result<Self, Failure> {
        let (mut robots, limit) = match (args.quick, args.robots.is_empty()) {
            (true, _) => (QUICK_ROBOTS.to_vec(), Limit::HalfOfNodes),
            (false, true) => (ROBOTS.to_vec(), Limit::HalfOfNodes),
            (false, false) => (args.robots.clone(), Limit::Room),
        };
        let (seeds, minutes) = match args.quick {
            true => (QUICK_SEEDS, QUICK_MINUTES),
            false => (args.seeds, args.minutes),
        };
        robots.sort_unstable();
        robots.dedup();
        for (index, planner) in args.planners.iter().enumerate() {
            if args.planners[..index].contains(planner) {
                return Err(format!("--planners: '{planner}' is there twice; give it once").into());
            }
        }
        Ok(Self { robots, limit, planners: args.planners.clone(), seeds, minutes, jobs: args.jobs })
    }
}
