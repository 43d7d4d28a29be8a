//! `regatta report`: measures accuracy and speed on a real engine process with a reader attached. Every report writes
//! Markdown and JSON; most also draw an SVG plot.

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

/// A subcommand of `regatta report`.
#[derive(Subcommand)]
pub enum ReportCommand {
    /// Drive the routes of the dissertation's tables 5.1 and 5.3, and compare the end poses.
    Accuracy(Output),
    /// Repeat the dissertation's tables 5.5 to 5.7, and continue to a million robots.
    Scaling(scaling::ScalingArgs),
    /// Send fleets over UDP into a second fleet: lines per second, losses, processor time.
    Udp(udp::UdpArgs),
}

/// The destination of a report.
#[derive(Args)]
pub struct Output {
    /// Folder for the Markdown file and the plot; created if it doesn't exist.
    #[arg(long, default_value = "out")]
    out: PathBuf,
    /// File for the figures as JSON; `NAME.json` in the folder if not given.
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
    /// Returns the path of a file in the output folder, and creates the folder.
    fn file(&self, name: &str) -> Result<PathBuf, Failure> {
        fs::create_dir_all(&self.out)
            .map_err(|error| format!("can't create folder {}: {error}", self.out.display()))?;
        Ok(self.out.join(name))
    }

    /// Writes `NAME.md` and the JSON file, and prints the Markdown.
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

/// Returns Regatta's version, the date and the machine, which every report names: as one line and as JSON.
fn environment() -> (String, serde_json::Value) {
    let cpu_info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu_info.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    let cpu = model.unwrap_or(std::env::consts::ARCH).trim().to_owned();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let isa = regatta_engine::motion::Isa::detect();
    let now = humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string();
    let date = &now[..10];
    let version = env!("CARGO_PKG_VERSION");
    let os = std::env::consts::OS;
    let line = format!("Regatta {version}, {date}, {cpu}, {cores} cores, {os}, motion kernel {isa}");
    let json = serde_json::json!({
        "version": version, "date": date, "cpu": cpu, "cores": cores, "os": os, "isa": isa.to_string(),
    });
    (line, json)
}
