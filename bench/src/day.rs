//! `regatta-bench day`: a day of 20,000 orders in one run, and the parts of the time of each order
//! of many such days, which have to add up to it, to the tick.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{ExitCode, Stdio};
use std::time::Instant;

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{check_interrupt, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta_base::random::Random;
use serde_json::{Value, json};

use crate::reading::processor_secs;

/// The orders and the robots of a day.
const ORDERS: u64 = 20_000;
const ROBOTS: &str = "200";
/// The bar that the project has set itself for its run, in seconds.
const BAR_SECS: f64 = 90.0;
/// The nodes of the warehouse.
const NODES: usize = 1668;
/// The shares of the hours of the day in its orders: two shifts and a quiet night.
const HOURS: [usize; 24] =
    [2, 2, 2, 2, 3, 4, 6, 8, 9, 9, 8, 6, 7, 9, 10, 9, 8, 6, 5, 4, 3, 3, 2, 2];
const PLANT: &str = "graph: warehouse.yaml\nrate: 10\nrobot_types:\n  \
    - {name: amr, length: 0.9, width: 0.6, max_speed: 1.5, max_acceleration: 0.8}\n\
    robots: [{count: 200, routes: none}]\nload: {dwell: {min: 4, max: 12}}\n\
    plugins: [fleet-manager]\n";

#[derive(Args)]
pub struct DayArgs {
    #[command(flatten)]
    output: Output,
    /// Days to simulate, each with another seed; 50 days have a million orders
    #[arg(long, value_name = "N", default_value_t = 50)]
    #[arg(value_parser = clap::value_parser!(u32).range(2..=1000))]
    days: u32,
}

/// A run of a day.
struct Day {
    /// Processor time, which other programs on the machine don't lengthen.
    secs: f64,
    orders: usize,
    /// Orders whose parts don't add up to their time.
    inexact: usize,
    is_over: bool,
}

pub fn run(program: &Program, args: &DayArgs) -> Result<ExitCode, Failure> {
    args.output.check("day")?;
    let folder = temporary_folder()?;
    let jobs = export(program, folder.path(), args.days)?;
    let mut days = Vec::new();
    for id in fs::read_to_string(jobs.join("jobs.txt"))?.lines() {
        days.push(day(program, &jobs, id)?);
    }
    let mut secs: Vec<f64> = days.iter().map(|day| day.secs).collect();
    secs.sort_by(f64::total_cmp);
    let median = secs[secs.len() / 2];
    let orders: usize = days.iter().map(|day| day.orders).sum();
    let inexact: usize = days.iter().map(|day| day.inexact).sum();
    let over = days.iter().filter(|day| day.is_over).count();
    let (line, machine) = environment(program);
    let count = days.len();
    let mut table = String::from("| | measured | bar | |\n|---|---|---|---|\n");
    writeln!(
        table,
        "| a day of {ORDERS} orders, 24 h, {ROBOTS} robots, processor time of a run: median of \
         {count} | {median:.0} s | {BAR_SECS:.0} s | {} |\n\
         | days that were over within an hour of their last order | {over} of {count} | all \
         | {} |\n\
         | orders whose parts of the time don't add up to it, to the tick, of {orders} \
         | {inexact} | 0 | {} |",
        verdict(median <= BAR_SECS),
        verdict(over == count),
        verdict(inexact == 0),
    )?;
    let markdown = format!("# A day of orders\n\n{line}\n\n{table}");
    let json = json!({
        "machine": machine, "days": count, "secs": secs, "orders": orders, "inexact": inexact,
        "days_over": over,
    });
    args.output.write(&Report { name: "day", markdown, json, plot: None })?;
    Ok(ExitCode::SUCCESS)
}

fn verdict(is_met: bool) -> &'static str {
    if is_met { "met" } else { "**missed**" }
}

/// Writes the plant, the day and the jobs of a study: a run for each day.
fn export(program: &Program, folder: &Path, days: u32) -> Result<PathBuf, Failure> {
    write(&folder.join("warehouse.yaml"), include_str!("../../graphs/warehouse.yaml"))?;
    let (plant, day, jobs) =
        (folder.join("plant.yaml"), folder.join("day.csv"), folder.join("jobs"));
    write(&plant, PLANT)?;
    write(&day, &orders())?;
    let mut command = program.command();
    command.arg("study").arg(&plant).arg("--orders").arg(&day);
    command.args(["--robots", ROBOTS, "--seeds", &format!("{days}..{days}")]);
    let status = command.arg("--export-jobs").arg(&jobs).stdout(Stdio::null()).status()?;
    match status.success() {
        true => Ok(jobs),
        false => Err("the jobs can't be written; the messages are above".into()),
    }
}

/// Returns the orders of a day, between any two nodes.
fn orders() -> String {
    let random = Random::new(1);
    let shares = HOURS.iter().sum();
    let mut orders: Vec<(usize, usize, usize)> = Vec::new();
    for index in 0..ORDERS {
        let draws = random.part(index);
        let (mut share, mut hour) = (draws.below(0, shares), 0);
        while share >= HOURS[hour] {
            share -= HOURS[hour];
            hour += 1;
        }
        let from = draws.below(1, NODES);
        let to = (from + 1 + draws.below(2, NODES - 1)) % NODES;
        orders.push((hour * 3600 + draws.below(3, 3600), from + 1, to + 1));
    }
    orders.sort_unstable();
    let rows = orders.iter().map(|(time, from, to)| format!("{time},{from},{to}\n"));
    std::iter::once("time,from,to\n".to_owned()).chain(rows).collect()
}

/// Runs a day, and adds up the parts of the time of its orders.
fn day(program: &Program, jobs: &Path, id: &str) -> Result<Day, Failure> {
    check_interrupt()?;
    let (started, before) = (Instant::now(), processor_secs());
    let mut command = program.command();
    command.arg("study-run").arg(jobs.join(format!("jobs/{id}.json")));
    let status = command.stdout(Stdio::null()).status()?;
    let wall_secs = started.elapsed().as_secs_f64();
    let secs = processor_secs().zip(before).map_or(wall_secs, |(after, before)| after - before);
    check_interrupt()?;
    if !status.success() {
        return Err(format!("a run has failed ({status})").into());
    }
    let result = jobs.join(format!("results/{id}.json"));
    let text = fs::read_to_string(&result)?;
    fs::remove_file(&result)?;
    // A seal may follow the JSON.
    let mut values = serde_json::Deserializer::from_str(&text).into_iter::<Value>();
    let outcome = values.next().ok_or("a run has no result")??;
    let figures = &outcome["figures"];
    let tick_secs = figures["tick_secs"].as_f64().unwrap_or(f64::NAN);
    let finished = figures["finished"].as_array().map_or(&[][..], |orders| &orders[..]);
    let inexact = finished.iter().filter(|order| !is_exact(order, tick_secs)).count();
    let is_over = figures["open"] == 0 && figures["failed"] == 0;
    Ok(Day { secs, orders: finished.len(), inexact, is_over })
}

/// Whether the parts of an order's time are its ticks from creation to end. Times are rounded to
/// milliseconds, which are less than half a tick.
fn is_exact(order: &Value, tick_secs: f64) -> bool {
    let parts = order["parts"].as_array();
    let ticks: u64 = parts.into_iter().flatten().filter_map(Value::as_u64).sum();
    let secs = order["service_secs"].as_f64().unwrap_or(f64::NAN);
    (secs / tick_secs).round() == ticks as f64 && parts.is_some_and(|parts| parts.len() == 7)
}
