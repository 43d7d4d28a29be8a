//! The time of a study by its runs: what the study adds to the time of its runs.

use std::process::Stdio;
use std::time::Instant;

use regatta::experiment::{check_interrupt, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;

use super::tables::{Line, Table};

/// Runs are short here, so that the study's own time is seen: two minutes of four robots.
const OPTIONS: [&str; 6] = ["--robots", "4", "--duration", "2min", "--reliefs", "0"];

/// Measures studies of 10 runs and more, each ten times the one before, on this machine and on a
/// cluster if there is one.
pub fn by_runs(program: &Program, most: u64, cluster: Option<&str>) -> Result<Table, Failure> {
    let note = "Two minutes of four robots in `warehouse.yaml` for each run.";
    let mut table = Table::of_studies(note);
    for (number, cluster) in [None, cluster].into_iter().enumerate() {
        if number > 0 && cluster.is_none() {
            break;
        }
        table.name(number, cluster.map_or("this machine", |_| "the cluster").to_owned());
        let numbers = (1..).map(|power| 10_u64.saturating_pow(power));
        for runs in numbers.take_while(|runs| *runs <= most) {
            table.add(number, Line::of_study(runs, secs(program, runs, cluster)?));
        }
    }
    Ok(table)
}

/// Returns the wall time of a study in seconds.
fn secs(program: &Program, runs: u64, cluster: Option<&str>) -> Result<f64, Failure> {
    check_interrupt()?;
    let folder = temporary_folder()?;
    let plant = folder.path().join("warehouse.yaml");
    write(&plant, include_str!("../../../graphs/warehouse.yaml"))?;
    let mut command = program.command();
    command.arg("study").arg(&plant).args(OPTIONS).args(["--seeds", &format!("{runs}..{runs}")]);
    let output = folder.path().join("study");
    command.arg("--output").arg(&output);
    if let Some(cluster) = cluster {
        command.args(["--on", cluster]);
    }
    let started = Instant::now();
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    check_interrupt()?;
    // Short runs have too few orders for an answer, so that a study may end with a failure.
    match output.join("study.json").exists() {
        true => Ok(started.elapsed().as_secs_f64()),
        false => Err(format!("a study of {runs} runs failed ({status})").into()),
    }
}
