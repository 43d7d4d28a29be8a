//! `regatta-bench runs`: the cost of single runs of a study, in one process and as processes in
//! lockstep, interleaved.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{check_interrupt, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use serde_json::{Value, json};

/// A bar that the project has set itself: half an hour of the warehouse with some robots takes at
/// most some seconds.
struct Bar {
    robots: u32,
    secs: f64,
}

const BARS: [Bar; 3] = [
    Bar { robots: 8, secs: 0.25 },
    Bar { robots: 300, secs: 4.0 },
    Bar { robots: 1000, secs: 22.0 },
];
/// The memory of a run with [`SMALL`] robots, in megabytes.
const MEGABYTES: f64 = 60.0;
/// The robots of the runs side by side.
const SMALL: u32 = 300;
/// The speed of two runs side by side, as a multiple of that of one.
const SIDE_BY_SIDE: f64 = 1.8;
/// The time between two looks at a running process.
const POLL: Duration = Duration::from_millis(2);

#[derive(Args)]
pub struct RunsArgs {
    #[command(flatten)]
    output: Output,
    /// Pairs of runs, the first in one process and the second as processes
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pairs: u32,
}

/// The jobs of a study with one number of robots.
struct Jobs {
    folder: PathBuf,
    ids: Vec<String>,
}

/// A run that has ended.
struct Ended {
    secs: f64,
    /// The largest resident memory, in megabytes.
    megabytes: f64,
    digest: String,
}

pub fn run(program: &Program, args: &RunsArgs) -> Result<ExitCode, Failure> {
    args.output.check("runs")?;
    let folder = temporary_folder()?;
    let plant = folder.path().join("warehouse.yaml");
    write(&plant, include_str!("../../graphs/warehouse.yaml"))?;
    let mut rows = Vec::new();
    let mut table = String::new();
    for Bar { robots, secs: bar } in BARS {
        let jobs = Jobs::export(program, &plant, &folder.path().join(robots.to_string()), robots)?;
        let (mut one, mut many) = (Vec::new(), Vec::new());
        for _ in 0..args.pairs {
            one.push(jobs.run(program, 0, &[])?);
            many.push(jobs.run(program, 0, &["--processes"])?);
        }
        let repeats = one.iter().chain(&many).all(|run| run.digest == one[0].digest);
        let (secs, processes_secs) = (median(&one, |run| run.secs), median(&many, |run| run.secs));
        let megabytes = median(&one, |run| run.megabytes);
        table += &format!(
            "| {robots} | {secs:.2} s | {bar} s | {} | {processes_secs:.2} s | {:.1} | \
             {megabytes:.0} MB | {} |\n",
            verdict(secs <= bar),
            processes_secs / secs,
            if repeats { "yes" } else { "**no**" },
        );
        rows.push(json!({
            "robots": robots, "secs": secs, "processes_secs": processes_secs,
            "megabytes": megabytes, "same_digest": repeats,
        }));
    }
    let jobs = Jobs::export(program, &plant, &folder.path().join("two"), SMALL)?;
    let speed = jobs.side_by_side(program, args.pairs)?;
    let (line, machine) = environment(program);
    let markdown = format!(
        "# Runs of studies\n\n{line}\n\nHalf an hour of `warehouse.yaml`, medians of {} runs.\n\n\
         | robots | in one process | bar | | processes | times | memory | same digest |\n\
         |---|---|---|---|---|---|---|---|\n{table}\n\
         Memory of a run with {SMALL} robots: at most {MEGABYTES:.0} MB. Two runs of {SMALL} robots \
         side by side are {speed:.2} times as fast as one after the other; the bar is \
         {SIDE_BY_SIDE}: {}.\n",
        args.pairs,
        verdict(speed >= SIDE_BY_SIDE),
    );
    let json = json!({"machine": machine, "runs": rows, "side_by_side": speed});
    args.output.write(&Report { name: "runs", markdown, json, plot: None })?;
    Ok(ExitCode::SUCCESS)
}

fn verdict(is_met: bool) -> &'static str {
    if is_met { "met" } else { "**missed**" }
}

fn median(runs: &[Ended], figure: impl Fn(&Ended) -> f64) -> f64 {
    let mut figures: Vec<f64> = runs.iter().map(figure).collect();
    figures.sort_by(f64::total_cmp);
    figures.get(figures.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Jobs {
    /// Writes the jobs of a study, two seeds of one number of robots.
    fn export(
        program: &Program,
        plant: &Path,
        folder: &Path,
        robots: u32,
    ) -> Result<Self, Failure> {
        let mut command = program.command();
        command.arg("study").arg(plant).args(["--robots", &robots.to_string(), "--seeds", "2..2"]);
        let status = command.arg("--export-jobs").arg(folder).stdout(Stdio::null()).status()?;
        if !status.success() {
            return Err("the jobs can't be written; the messages are above".into());
        }
        let text = fs::read_to_string(folder.join("jobs.txt"))?;
        let ids = text.lines().map(str::to_owned).collect();
        Ok(Self { folder: folder.to_owned(), ids })
    }

    fn start(&self, program: &Program, index: usize, args: &[&str]) -> Result<Child, Failure> {
        let id = self.ids.get(index).ok_or("the study has too few jobs")?;
        let mut command = program.command();
        command.arg("study-run").arg(self.folder.join(format!("jobs/{id}.json"))).args(args);
        Ok(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn()?)
    }

    /// Does a job, and returns its cost.
    fn run(&self, program: &Program, index: usize, args: &[&str]) -> Result<Ended, Failure> {
        check_interrupt()?;
        let started = Instant::now();
        let mut child = self.start(program, index, args)?;
        let mut megabytes = 0.0;
        let status = loop {
            megabytes = f64::max(megabytes, peak_megabytes(child.id()));
            if let Some(status) = child.try_wait()? {
                break status;
            }
            std::thread::sleep(POLL);
        };
        let secs = started.elapsed().as_secs_f64();
        check_interrupt()?;
        if !status.success() {
            return Err(format!("a run has failed ({status})").into());
        }
        let result = self.folder.join(format!("results/{}.json", self.ids[index]));
        let outcome: Value = serde_json::from_slice(&fs::read(result)?)?;
        let digest = outcome["digest"].as_str().unwrap_or_default().to_owned();
        Ok(Ended { secs, megabytes, digest })
    }

    /// Returns the speed of two runs side by side, as a multiple of that of one after the other.
    fn side_by_side(&self, program: &Program, pairs: u32) -> Result<f64, Failure> {
        let mut speeds = Vec::new();
        for _ in 0..pairs {
            let alone = self.run(program, 0, &[])?.secs + self.run(program, 1, &[])?.secs;
            let started = Instant::now();
            let mut children = [self.start(program, 0, &[])?, self.start(program, 1, &[])?];
            for child in &mut children {
                child.wait()?;
            }
            speeds.push(alone / started.elapsed().as_secs_f64());
        }
        speeds.sort_by(f64::total_cmp);
        Ok(speeds[speeds.len() / 2])
    }
}

/// Returns the largest resident memory of a process so far, in megabytes; 0 if it is unknown.
fn peak_megabytes(pid: u32) -> f64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kibibytes.unwrap_or(0.0) * 1024e-6
}
