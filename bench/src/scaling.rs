//! `regatta-bench scaling`: how the cost of a tick grows with robots, threads, edges and readers,
//! and how the time of a study grows with its runs.

mod engine;
mod studies;
mod tables;

use std::process::ExitCode;

use clap::{Args, ValueEnum};
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{seconds_parser, temporary_folder};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta_scenario::RobotCount;
use serde_json::json;

use self::engine::Bench;
use self::tables::Table;

/// The quantities that costs grow with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Quantity {
    Robots,
    Threads,
    Edges,
    Readers,
    Runs,
}

#[derive(Args)]
pub struct ScalingArgs {
    #[command(flatten)]
    output: Output,
    /// Quantities to vary
    #[arg(long, value_delimiter = ',', default_value = "robots,threads,edges,readers,runs")]
    only: Vec<Quantity>,
    /// Seconds for which each fleet is measured
    #[arg(long, default_value_t = 5, value_parser = seconds_parser())]
    secs: u64,
    /// Robots of the largest fleet
    #[arg(long, value_name = "N", default_value = "1M", value_parser = parse_robots)]
    max_robots: u32,
    /// Edges of the largest layout, roughly
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    max_edges: u64,
    /// Readers of the most watched fleet
    #[arg(long, value_name = "N", default_value_t = 60)]
    max_readers: u64,
    /// Runs of the largest study
    #[arg(long, value_name = "N", default_value_t = 1_000)]
    max_runs: u64,
    /// Cluster that also carries out the studies, as for `regatta study --on`
    #[arg(long, value_name = "ADDRESS")]
    on: Option<String>,
}

pub fn run(program: &Program, args: &ScalingArgs) -> Result<ExitCode, Failure> {
    args.output.check("scaling")?;
    check_once(&args.only)?;
    let folder = temporary_folder()?;
    let bench = Bench::new(program, folder.path(), args.secs)?;
    let mut tables = Vec::new();
    for quantity in &args.only {
        tables.push(table(program, &bench, *quantity, args)?);
    }
    let (line, machine) = environment(program);
    let figures: Vec<_> = tables.iter().map(Table::json).collect();
    args.output.write(&Report {
        name: "scaling",
        markdown: tables::markdown(&tables, &line),
        json: json!({"machine": machine, "tables": figures}),
        plot: Some(tables::plot(&tables)?),
    })?;
    Ok(ExitCode::SUCCESS)
}

fn check_once(quantities: &[Quantity]) -> Result<(), Failure> {
    for (number, quantity) in quantities.iter().enumerate() {
        if quantities[..number].contains(quantity) {
            return Err(format!("{quantity:?} is given twice; give it once").to_lowercase().into());
        }
    }
    Ok(())
}

/// Parses a number of robots that isn't 0.
fn parse_robots(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(RobotCount(robots @ 1..)) => Ok(robots),
        _ => Err("give at least 1 robot: 500, 10k, 1M".to_owned()),
    }
}

fn table(
    program: &Program,
    bench: &Bench<'_>,
    quantity: Quantity,
    args: &ScalingArgs,
) -> Result<Table, Failure> {
    match quantity {
        Quantity::Robots => engine::by_robots(bench, args.max_robots),
        Quantity::Threads => engine::by_threads(bench, args.max_robots),
        Quantity::Edges => engine::by_edges(bench, args.max_edges),
        Quantity::Readers => engine::by_readers(bench, args.max_readers),
        Quantity::Runs => studies::by_runs(program, args.max_runs, args.on.as_deref()),
    }
}
