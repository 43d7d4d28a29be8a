//! `regatta graph`: checks, describes, generates and draws route graphs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use regatta_engine::graph::generate::{Grid, Warehouse};
use regatta_engine::graph::info::Info;
use regatta_engine::graph::{self, Findings, GraphError, Handles, ReadOptions, RouteGraph, draw};

use crate::failure::Failure;

/// A subcommand of `regatta graph`.
#[derive(Debug, Subcommand)]
pub enum GraphCommand {
    /// List all problems of a route graph; exit code 0 if it can be driven
    Check(FileArgs),
    /// Print counts, length, bounding box, speeds and components
    Info {
        #[command(flatten)]
        file: FileArgs,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Generate a route graph of any size
    Generate {
        #[command(subcommand)]
        generator: Generator,
    },
    /// Draw a map as SVG
    Draw {
        #[command(flatten)]
        file: FileArgs,
        /// File to write
        #[arg(short, long, value_name = "SVG")]
        output: PathBuf,
    },
}

/// A route graph file and how to read it.
#[derive(Debug, Args)]
pub struct FileArgs {
    /// Route graph file (YAML)
    file: PathBuf,
    /// Handle length at an edge's origin instead of the file's setting: b_at_origin or f_at_origin
    #[arg(long)]
    handles: Option<Handles>,
}

/// A generator of route graphs, with its parameters.
#[derive(Debug, Subcommand)]
pub enum Generator {
    /// A warehouse: pick aisles between racks, cross aisles and a ring road
    Warehouse {
        /// Number of pick aisles side by side
        #[arg(long, default_value_t = 12)]
        aisles: u32,
        /// Number of rows of racks, with a cross aisle between adjacent rows
        #[arg(long, default_value_t = 3)]
        rows: u32,
        /// Number of stops along an aisle in each row
        #[arg(long, default_value_t = 6)]
        bays: u32,
        #[command(flatten)]
        output: Output,
    },
    /// A grid of streets that all cross each other
    Grid {
        /// Number of streets to the north
        #[arg(long, default_value_t = 5)]
        columns: u32,
        /// Number of streets to the east
        #[arg(long, default_value_t = 5)]
        rows: u32,
        /// Distance between streets in metres
        #[arg(long, default_value_t = 20)]
        spacing: u32,
        /// Make the streets inside the two-way ring one-way
        #[arg(long)]
        one_way: bool,
        #[command(flatten)]
        output: Output,
    },
}

/// The destination of a generated graph.
#[derive(Debug, Args)]
pub struct Output {
    /// File to write; standard output if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs `regatta graph`.
///
/// # Errors
/// Returns an error if a file can't be read or written, if a route graph is invalid, or if an argument is out of range.
pub fn run(command: GraphCommand) -> Result<ExitCode, Failure> {
    match command {
        GraphCommand::Check(file) => check(&file),
        GraphCommand::Info { file, json } => info(&file, json),
        GraphCommand::Generate { generator } => generate(&generator),
        GraphCommand::Draw { file, output } => {
            let graph = read(&file)?;
            write_file(&output, &draw::svg(&graph))
        }
    }
}

fn check(file: &FileArgs) -> Result<ExitCode, Failure> {
    let (findings, summary) = match graph::read(&file.file, &file.options()) {
        Ok((graph, warnings)) => {
            let (edges, nodes) = (graph.edges().len(), graph.nodes().len());
            (warnings, format!("can be driven: {edges} edges, {nodes} nodes"))
        }
        Err(GraphError::Invalid(findings)) => (findings, "can't be driven".to_owned()),
        Err(error) => return Err(error.into()),
    };
    print(&report(&file.file, &findings, &summary))?;
    Ok(if findings.errors() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Formats every finding and a summary line.
fn report(file: &Path, findings: &Findings, summary: &str) -> String {
    let mut text: String = findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect();
    let (errors, warnings) = (findings.errors(), findings.warnings());
    let unlisted = errors + warnings - findings.as_slice().len();
    if unlisted > 0 {
        text.push_str(&format!("({unlisted} more findings are not listed)\n"));
    }
    let (errors, warnings) = (with_plural(errors, "error"), with_plural(warnings, "warning"));
    text + &format!("{}: {summary}; {errors}, {warnings}\n", file.display())
}

fn with_plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn info(file: &FileArgs, json: bool) -> Result<ExitCode, Failure> {
    let info = Info::of(&read(file)?);
    let text = if json { serde_json::to_string_pretty(&info)? + "\n" } else { info.to_string() };
    print(&text)
}

fn generate(generator: &Generator) -> Result<ExitCode, Failure> {
    let (text, output) = match *generator {
        Generator::Warehouse { aisles, rows, bays, ref output } => {
            (Warehouse { aisles, rows, bays }.generate()?, output)
        }
        Generator::Grid { columns, rows, spacing, one_way, ref output } => {
            (Grid { columns, rows, spacing, one_way }.generate()?, output)
        }
    };
    match &output.output {
        Some(file) => write_file(file, &text),
        None => print(&text),
    }
}

impl FileArgs {
    fn options(&self) -> ReadOptions {
        ReadOptions { handles: self.handles }
    }
}

fn read(file: &FileArgs) -> Result<RouteGraph, GraphError> {
    graph::read(&file.file, &file.options()).map(|(graph, _)| graph)
}

fn write_file(file: &Path, text: &str) -> Result<ExitCode, Failure> {
    std::fs::write(file, text).map_err(|error| format!("{}: can't write: {error}", file.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn print(text: &str) -> Result<ExitCode, Failure> {
    print!("{text}");
    Ok(ExitCode::SUCCESS)
}
