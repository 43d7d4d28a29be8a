//! `regatta-bench reading`: the time to check files of every format by their size. It must grow in
//! proportion to the size, whatever is in the file: a small file that takes long would block those
//! who get it from somebody else.

mod shapes;

use std::fs;
use std::path::Path;
use std::process::{ExitCode, Stdio};
use std::time::Instant;

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{check_interrupt, temporary_folder};
use regatta::failure::Failure;
use regatta::program::Program;
use serde_json::{Value, json};

use self::shapes::{SHAPES, Shape};

/// The sizes in MiB, each four times the one before.
const SIZES: [usize; 4] = [1, 4, 16, 64];
/// The sizes of a quick measurement.
const QUICK_SIZES: usize = 2;
/// Four times the size may take that many times as long: caches and memory are slower then.
const MOST_GROWTH: f64 = 6.0;
/// Times below this one, in seconds, say nothing about growth.
const LEAST_SECS: f64 = 0.5;

#[derive(Args)]
pub struct ReadingArgs {
    #[command(flatten)]
    output: Output,
    /// Read only files of 1 and 4 MiB
    #[arg(long)]
    quick: bool,
}

/// The processor times of a shape, in seconds, by size.
struct Measured {
    shape: &'static Shape,
    secs: Vec<f64>,
}

impl Measured {
    /// The largest factor from one size to the next.
    fn growth(&self) -> f64 {
        let pairs = self.secs.windows(2).filter(|pair| pair[1] > LEAST_SECS);
        pairs.map(|pair| pair[1] / pair[0].max(LEAST_SECS / MOST_GROWTH)).fold(0.0, f64::max)
    }

    fn is_linear(&self) -> bool {
        self.growth() <= MOST_GROWTH
    }

    fn row(&self) -> String {
        let Shape { format, content, .. } = self.shape;
        let secs: Vec<String> = self.secs.iter().map(|secs| format!("{secs:.2}")).collect();
        let verdict = if self.is_linear() { "met" } else { "**missed**" };
        format!("| {format} | {content} | {} | {verdict} |\n", secs.join(" | "))
    }

    fn json(&self) -> Value {
        let Shape { format, content, .. } = self.shape;
        json!({"format": format, "content": content, "secs": self.secs, "linear": self.is_linear()})
    }
}

pub fn run(program: &Program, args: &ReadingArgs) -> Result<ExitCode, Failure> {
    args.output.check("reading")?;
    let folder = temporary_folder()?;
    let sizes = if args.quick { &SIZES[..QUICK_SIZES] } else { &SIZES[..] };
    let mut measured = Vec::new();
    for shape in &SHAPES {
        let mut secs = Vec::new();
        for size in sizes {
            secs.push(check(program, folder.path(), shape, size << 20)?);
        }
        measured.push(Measured { shape, secs });
    }
    let (line, machine) = environment(program);
    let columns: Vec<String> = sizes.iter().map(|size| format!("{size} MiB")).collect();
    let mut markdown = format!(
        "# Reading files of any size\n\n{line}\n\nProcessor seconds of `regatta graph check`. The \
         bar: four \
         times the size takes at most {MOST_GROWTH} times as long.\n\n| format | content | {} | \
         |\n|---|---|{}---|\n",
        columns.join(" | "),
        "---|".repeat(columns.len()),
    );
    markdown.extend(measured.iter().map(Measured::row));
    let rows: Vec<Value> = measured.iter().map(Measured::json).collect();
    let json = json!({"machine": machine, "sizes_mib": sizes, "shapes": rows});
    args.output.write(&Report { name: "reading", markdown, json, plot: None })?;
    let all_linear = measured.iter().all(Measured::is_linear);
    Ok(if all_linear { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The clock ticks of Linux in a second.
const CLOCK_HZ: f64 = 100.0;

/// Returns the processor time of a process, in seconds.
///
/// # Errors
/// If the system has no `/proc`, or the process has ended.
pub fn processor_secs_of(pid: u32) -> Result<f64, Failure> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat"))?;
    // The name of the program, in parentheses, may contain anything.
    let (_, fields) = stat.rsplit_once(')').ok_or("/proc has another format")?;
    let ticks = fields.split_whitespace().skip(11).take(2);
    Ok(ticks.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / CLOCK_HZ)
}

/// Returns the processor time in seconds of all child processes that have ended, which other
/// programs on the machine hardly change; `None` if the system doesn't tell it.
pub fn processor_secs() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in parentheses, may contain anything.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks: Vec<f64> =
        fields.split_whitespace().skip(13).take(2).filter_map(|field| field.parse().ok()).collect();
    (ticks.len() == 2).then(|| ticks.iter().sum::<f64>() / CLOCK_HZ)
}

/// Returns the time in seconds to check a file of a shape and a size.
fn check(program: &Program, folder: &Path, shape: &Shape, bytes: usize) -> Result<f64, Failure> {
    check_interrupt()?;
    let file = folder.join(format!("plant.{}", shape.ending));
    fs::write(&file, shape.text(bytes))?;
    let (started, before) = (Instant::now(), processor_secs());
    let mut command = program.command();
    command.args(["graph", "check"]).arg(&file).stdout(Stdio::null()).stderr(Stdio::null());
    let status = command.status()?;
    let wall_secs = started.elapsed().as_secs_f64();
    let secs = processor_secs().zip(before).map_or(wall_secs, |(after, before)| after - before);
    check_interrupt()?;
    // A file may be refused, but the program must end by itself.
    match status.code() {
        Some(_) => Ok(secs),
        None => Err(format!("{status}: {} with {}", shape.format, shape.content).into()),
    }
}
