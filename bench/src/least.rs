//! `regatta-bench least`: the least fleet that studies find for a day's orders on small plants,
//! against runs of all numbers of robots with many seeds.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{ExitCode, Stdio};

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{check_interrupt, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta_base::random::Random;
use regatta_layout::ReadOptions;
use regatta_layout::traffic::MainPart;
use serde_json::{Value, json};

use crate::plants::manifest::{Source, write_shipped};

/// The plants: small route graphs of the repository, and layouts of other people.
const PLANTS: [&str; 10] = [
    "graphs/small/blocks3.yaml",
    "graphs/small/comb.yaml",
    "graphs/small/door.yaml",
    "graphs/small/hash4.yaml",
    "graphs/small/loop4.yaml",
    "graphs/small/roundabout.yaml",
    "graphs/imported/dxf/depot.dxf",
    "graphs/imported/nav2/aws_graph.geojson",
    "graphs/imported/lif/ex_10_7.lif.json",
    "graphs/imported/opentcs/Demo-01.xml",
];
/// The bar that the project has set itself: plants whose answer is at most one robot off.
const BAR: usize = 9;
/// The largest number of robots that a study may try.
const MOST_ROBOTS: u64 = 12;
/// Numbers above the answer that are run, too.
const BEYOND: u64 = 2;
/// The orders of the day of the probe, far enough apart that one robot carries each alone.
const PROBES: usize = 12;
const PROBE_GAP_SECS: f64 = 900.0;
/// The length of the day in seconds, and the robots that its orders would keep busy all the time.
const DAY_SECS: f64 = 1200.0;
const BUSY_ROBOTS: f64 = 3.0;
/// The limits of the targets, as multiples of the mean service of an order alone.
const MEAN_LIMIT: f64 = 1.6;
const P90_LIMIT: f64 = 2.8;

#[derive(Args)]
pub struct LeastArgs {
    #[command(flatten)]
    output: Output,
    /// Runs for each number of robots, which the answers are compared with
    #[arg(long, value_name = "N", default_value_t = 200)]
    #[arg(value_parser = clap::value_parser!(u32).range(2..=1000))]
    seeds: u32,
    /// Measure only plants whose names contain one of these texts; separated by commas
    #[arg(long, value_name = "TEXT", value_delimiter = ',')]
    only: Vec<String>,
}

/// A plant, its day and its targets.
struct Case<'a> {
    program: &'a Program,
    source: &'a Source,
    folder: &'a Path,
    targets: [String; 2],
}

/// The answer of a study, and the least number by runs of all numbers.
struct Compared {
    plant: String,
    targets: [String; 2],
    answer: Option<u64>,
    truth: Option<u64>,
}

impl Compared {
    /// Whether the answer is at most one robot off. That no fleet is enough is an answer, too.
    fn is_right(&self) -> bool {
        match (self.answer, self.truth) {
            (Some(answer), Some(truth)) => answer.abs_diff(truth) <= 1,
            (answer, truth) => answer == truth,
        }
    }
}

pub fn run(program: &Program, args: &LeastArgs) -> Result<ExitCode, Failure> {
    args.output.check("least")?;
    let folder = temporary_folder()?;
    let sources = write_shipped(folder.path())?;
    let mut compared = Vec::new();
    for (index, name) in PLANTS.iter().enumerate() {
        let is_wanted = args.only.is_empty() || args.only.iter().any(|text| name.contains(text));
        let source = sources.iter().find(|source| source.name == *name).filter(|_| is_wanted);
        if let Some(source) = source {
            let folder = folder.path().join(format!("plant-{index}"));
            fs::create_dir_all(&folder)?;
            compared.push(compare(program, source, &folder, args.seeds)?);
        }
    }
    let right = compared.iter().filter(|one| one.is_right()).count();
    let (line, machine) = environment(program);
    let count = compared.len();
    let bar = if count == PLANTS.len() && right >= BAR { "met" } else { "**missed**" };
    let markdown = format!(
        "# The least fleet\n\n{line}\n\nA day of 20 minutes on each plant. The answer is that of \
         `regatta study --target`, by its own rule for the number of seeds; the truth is the \
         least number of robots whose means over {} seeds are within the limits.\n\n{}\n\
         At most one robot off: {right} of {count}; the bar is {BAR} of {}: {bar}.\n",
        args.seeds,
        table(&compared)?,
        PLANTS.len(),
    );
    let rows = compared.iter().map(|one| {
        json!({
            "plant": one.plant, "targets": one.targets, "answer": one.answer,
            "truth": one.truth, "right": one.is_right(),
        })
    });
    let json = json!({
        "machine": machine, "seeds": args.seeds, "plants": rows.collect::<Vec<_>>(),
    });
    args.output.write(&Report { name: "least", markdown, json, plot: None })?;
    Ok(ExitCode::SUCCESS)
}

fn table(compared: &[Compared]) -> Result<String, Failure> {
    let mut table = String::from(
        "| plant | targets | answer | truth | at most one off |\n|---|---|---|---|---|\n",
    );
    for one in compared {
        let [answer, truth] =
            [one.answer, one.truth].map(|n| n.map_or("none".to_owned(), |n| n.to_string()));
        let verdict = if one.is_right() { "yes" } else { "**no**" };
        let targets = one.targets.join("; ");
        writeln!(table, "| {} | {targets} | {answer} | {truth} | {verdict} |", one.plant)?;
    }
    Ok(table)
}

/// Compares the answer of a study with runs of all numbers up to some robots beyond it.
fn compare(
    program: &Program,
    source: &Source,
    folder: &Path,
    seeds: u32,
) -> Result<Compared, Failure> {
    let mut case = Case { program, source, folder, targets: [String::new(), String::new()] };
    let alone_secs = case.service_alone()?;
    case.targets = [
        format!("mean service < {:.0}s", MEAN_LIMIT * alone_secs),
        format!("p90 service < {:.0}s", P90_LIMIT * alone_secs),
    ];
    let orders = (BUSY_ROBOTS * DAY_SECS / alone_secs) as usize;
    case.write_day(orders.max(2), DAY_SECS / orders.max(2) as f64)?;
    let search = case.study("search", &format!("1..{MOST_ROBOTS}"), None)?;
    let answer = search["least"]["robots"].as_u64();
    let most = answer.map_or(MOST_ROBOTS, |robots| (robots + BEYOND).min(MOST_ROBOTS));
    let all: Vec<_> = (1..=most).map(|robots| robots.to_string()).collect();
    let all = case.study("all", &all.join(","), Some(seeds))?;
    let points = all["points"].as_array().map_or(&[][..], |points| &points[..]);
    let truth = points.iter().filter(|point| is_within(point));
    let truth = truth.filter_map(|point| point["robots"].as_u64()).min();
    Ok(Compared { plant: source.name.clone(), targets: case.targets, answer, truth })
}

/// Whether the means of a number of robots are within all limits, and its robots never stood.
fn is_within(point: &Value) -> bool {
    let targets = point["targets"].as_array().map_or(&[][..], |targets| &targets[..]);
    !targets.is_empty() && targets.iter().all(is_met)
}

/// Whether the mean over the runs is within the limit of a target.
fn is_met(target: &Value) -> bool {
    target["standing"] != "missed" && target["margin"].as_f64().is_some_and(|it| it > 0.0)
}

impl Case<'_> {
    /// Returns the mean service in seconds of orders that one robot carries, each alone.
    fn service_alone(&mut self) -> Result<f64, Failure> {
        self.write_day(PROBES, PROBE_GAP_SECS)?;
        self.targets = ["mean service < 1h".to_owned(), "p90 service < 1h".to_owned()];
        let probe = self.study("probe", "1", Some(2))?;
        let secs = probe["points"][0]["targets"][0]["value"]["mean"].as_f64();
        secs.ok_or_else(|| format!("{}: one robot carries no orders", self.source.name).into())
    }

    /// Writes a day of orders between any two nodes of the plant's main part.
    fn write_day(&self, orders: usize, gap_secs: f64) -> Result<(), Failure> {
        let (graph, _) = regatta_layout::read(&self.source.path, &ReadOptions::default())?;
        let main = MainPart::of(&graph).ok_or("the plant has no main part")?;
        let ids: Vec<u32> = main.graph.nodes().iter().map(|node| node.id).collect();
        let random = Random::new(1);
        let mut rows = String::from("time,from,to\n");
        for order in 0..orders {
            let draws = random.part(order as u64);
            let from = draws.below(0, ids.len());
            let to = (from + 1 + draws.below(1, ids.len() - 1)) % ids.len();
            let secs = (order as f64 + draws.below(2, 1000) as f64 / 1000.0) * gap_secs;
            writeln!(rows, "{secs:.1},{},{}", ids[from], ids[to])?;
        }
        write(&self.folder.join("day.csv"), &rows)
    }

    /// Studies the day with some numbers of robots; returns the answer about its only variant.
    fn study(&self, name: &str, robots: &str, seeds: Option<u32>) -> Result<Value, Failure> {
        check_interrupt()?;
        let output = self.folder.join(name);
        let mut command = self.program.command();
        command.arg("study").arg(&self.source.path).args(["--robots", robots, "--reliefs", "0"]);
        command.arg("--orders").arg(self.folder.join("day.csv")).arg("--output").arg(&output);
        for target in &self.targets {
            command.args(["--target", target]);
        }
        if let Some(seeds) = seeds {
            command.args(["--seeds", &format!("{seeds}..{seeds}")]);
        }
        let messages = command.stdout(Stdio::null()).output()?;
        check_interrupt()?;
        let Ok(text) = fs::read(output.join("study.json")) else {
            let messages = String::from_utf8_lossy(&messages.stderr).into_owned();
            return Err(format!("{}: no answer: {messages}", self.source.name).into());
        };
        let mut answer: Value = serde_json::from_slice(&text)?;
        Ok(answer["variants"][0].take())
    }
}
