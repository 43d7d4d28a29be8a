//! The files of a report, and the description of the machine in it.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::failure::Failure;

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

impl Output {
    /// Returns the path of a file in the output folder, and creates the folder.
    pub fn file(&self, name: &str) -> Result<PathBuf, Failure> {
        fs::create_dir_all(&self.out)
            .map_err(|error| format!("can't create folder {}: {error}", self.out.display()))?;
        Ok(self.out.join(name))
    }

    /// Writes `NAME.md` and the JSON file, and prints the Markdown.
    pub fn write(&self, name: &str, markdown: &str, json: &serde_json::Value) -> Result<(), Failure> {
        let json_path = self.json.clone().map_or_else(|| self.file(&format!("{name}.json")), Ok)?;
        write(&self.file(&format!("{name}.md"))?, markdown)?;
        write(&json_path, &format!("{json:#}\n"))?;
        println!("{markdown}");
        Ok(())
    }
}

/// Writes a text file.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(|error| format!("can't write {}: {error}", path.display()).into())
}

/// Returns Regatta's version, the date and the machine, which every report names: as one line and as JSON.
pub fn environment() -> (String, serde_json::Value) {
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
