//! `regatta report`: the experiments that Regatta is measured by, on the real engine process with a reader
//! attached. Each writes Markdown, JSON and an SVG plot.

mod accuracy;
mod experiment;
mod plot;
mod published;
mod scaling;
mod udp;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};

use crate::Failure;

#[derive(Subcommand)]
pub enum ReportCommand {
    /// Drive the routes of the dissertation's tables 5.1 and 5.3 and compare the end poses.
    Accuracy(Output),
    /// Repeat its tables 5.5 to 5.7, and go on to a million robots.
    Scaling(scaling::ScalingArgs),
    /// Send fleets over UDP into a second fleet: lines a second, losses, processor time.
    Udp(udp::UdpArgs),
}

/// Where a report goes.
#[derive(Args)]
pub struct Output {
    /// Folder for Markdown and plot; made if it isn't there.
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// File for the figures as JSON; `NAME.json` in the folder if left out.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

pub fn run(command: ReportCommand) -> Result<ExitCode, Failure> {
    match command {
        ReportCommand::Accuracy(output) => accuracy::run(&output),
        ReportCommand::Scaling(args) => scaling::run(&args),
        ReportCommand::Udp(args) => udp::run(&args),
    }
}

impl Output {
    /// The file of that name in the folder.
    fn file(&self, name: &str) -> Result<PathBuf, Failure> {
        fs::create_dir_all(&self.out).map_err(|error| format!("can't make folder {}: {error}", self.out.display()))?;
        Ok(self.out.join(name))
    }

    /// Writes `NAME.md` and the JSON, and prints the Markdown.
    fn write(&self, name: &str, markdown: &str, json: &serde_json::Value) -> Result<(), Failure> {
        let json_path = self.json.clone().map_or_else(|| self.file(&format!("{name}.json")), Ok)?;
        write(&self.file(&format!("{name}.md"))?, markdown)?;
        write(&json_path, &format!("{json:#}\n"))?;
        println!("{markdown}");
        Ok(())
    }
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(|error| format!("can't write {}: {error}", path.display()).into())
}

/// The machine, the version and the day, as every report names them.
fn circumstances() -> (String, serde_json::Value) {
    let cpu_info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu_info.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    let cpu = model.unwrap_or(std::env::consts::ARCH).trim().to_owned();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let isa = regatta_engine::motion::Isa::detect();
    let now = humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string();
    let day = &now[..10];
    let version = env!("CARGO_PKG_VERSION");
    let os = std::env::consts::OS;
    let line = format!("Regatta {version}, {day}, {cpu}, {cores} cores, {os}, motion kernel {isa}");
    let json = serde_json::json!({
        "version": version, "date": day, "cpu": cpu, "cores": cores, "os": os, "isa": isa.to_string(),
    });
    (line, json)
}
