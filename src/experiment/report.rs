//! The files of a report, and the description of the program and the machine in it.

use std::fs;
use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::output::{Force, check_file, write_file};
use crate::program::Program;

/// The destination of a report.
#[derive(Args, Debug)]
pub struct Output {
    /// Folder for the Markdown file and the plot; created if it doesn't exist
    #[arg(
        short = 'o',
        long = "output",
        alias = "out",
        value_name = "FOLDER",
        default_value = "out"
    )]
    out: PathBuf,
    /// File for the figures as JSON; `NAME.json` in the folder if not given
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// A finished report.
#[derive(Debug)]
pub struct Report<'a> {
    /// The name of its files, without the extension.
    pub name: &'a str,
    /// Its text.
    pub markdown: String,
    /// Its figures.
    pub json: serde_json::Value,
    /// The plot as SVG, if there is one.
    pub plot: Option<String>,
}

impl Output {
    /// Returns an error if a file of the report exists and may not be replaced. Reports call it
    /// before they measure.
    pub fn check(&self, name: &str) -> Result<(), Failure> {
        let paths = [self.path(name, "md"), self.path(name, "svg"), self.json_path(name)];
        paths.iter().try_for_each(|path| check_file(path, self.force).map(|_| ()))
    }

    fn path(&self, name: &str, extension: &str) -> PathBuf {
        self.out.join(format!("{name}.{extension}"))
    }

    fn json_path(&self, name: &str) -> PathBuf {
        self.json.clone().unwrap_or_else(|| self.path(name, "json"))
    }

    /// Writes all files of a report, and prints its Markdown.
    pub fn write(&self, report: &Report<'_>) -> Result<(), Failure> {
        fs::create_dir_all(&self.out)
            .map_err(|error| format!("can't create folder {}: {error}", self.out.display()))?;
        let name = report.name;
        if let Some(plot) = &report.plot {
            write_file(&self.path(name, "svg"), plot.as_bytes(), self.force)?;
        }
        write_file(&self.json_path(name), format!("{:#}\n", report.json).as_bytes(), self.force)?;
        write_file(&self.path(name, "md"), report.markdown.as_bytes(), self.force)?;
        println!("{}", report.markdown);
        Ok(())
    }
}

/// Returns the version of the measured program, the date and the machine, which every report names:
/// as one line and as JSON.
pub fn environment(program: &Program) -> (String, serde_json::Value) {
    let cpu_info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        cpu_info.lines().find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1));
    let cpu = model.unwrap_or(std::env::consts::ARCH).trim().to_owned();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let isa = regatta_motion::Isa::detect();
    let now = humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string();
    let date = &now[..10];
    let version = program.version();
    let os = std::env::consts::OS;
    let line =
        format!("Regatta {version}, {date}, {cpu}, {cores} cores, {os}, motion kernel {isa}");
    let json = serde_json::json!({
        "version": version, "date": date, "cpu": cpu, "cores": cores, "os": os,
        "isa": isa.to_string(),
    });
    (line, json)
}
