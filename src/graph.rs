//! `regatta graph`: check, describe, generate and draw route graphs.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::Failure;
use clap::{Args, Subcommand};
use regatta_engine::graph::generate::{Grid, Warehouse};
use regatta_engine::graph::info::Info;
use regatta_engine::graph::{self, Findings, GraphError, Handles, ReadOptions, RouteGraph, draw};

/// What to do with a route graph.
#[derive(Debug, Subcommand)]
pub enum GraphCommand {
    /// Say all that is wrong with a route graph; exit code 0 if it can be driven
    Check(FileArgs),
    /// Counts, length, bounding box, speeds and components
    Info {
        #[command(flatten)]
        file: FileArgs,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Write a route graph of any size
    Generate {
        #[command(subcommand)]
        kind: Generate,
    },
    /// Draw a map as SVG
    Draw {
        #[command(flatten)]
        file: FileArgs,
        /// Where to write the map
        #[arg(short, long, value_name = "SVG")]
        output: PathBuf,
    },
}

/// A route graph file and how to read it.
#[derive(Debug, Args)]
pub struct FileArgs {
    /// Route graph file (YAML)
    file: PathBuf,
    /// Which handle length is at an edge's origin, whatever the file says: b_at_origin or f_at_origin
    #[arg(long)]
    handles: Option<Handles>,
}

/// Kinds of graphs that can be generated.
#[derive(Debug, Subcommand)]
pub enum Generate {
    /// Pick aisles between racks, cross aisles and a ring road
    Warehouse {
        /// Pick aisles side by side
        #[arg(long, default_value_t = 12)]
        aisles: u32,
        /// Rows of racks, with a cross aisle between each two
        #[arg(long, default_value_t = 3)]
        rows: u32,
        /// Places to stop along an aisle in each row
        #[arg(long, default_value_t = 6)]
        bays: u32,
        #[command(flatten)]
        output: Output,
    },
    /// Streets that cross each other everywhere
    Grid {
        /// Streets to the north
        #[arg(long, default_value_t = 5)]
        columns: u32,
        /// Streets to the east
        #[arg(long, default_value_t = 5)]
        rows: u32,
        /// Metres between streets
        #[arg(long, default_value_t = 20)]
        spacing: u32,
        /// One-way streets inside the two-way ring
        #[arg(long)]
        one_way: bool,
        #[command(flatten)]
        output: Output,
    },
}

/// Where the generated graph goes.
#[derive(Debug, Args)]
pub struct Output {
    /// File to write; standard output if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs `regatta graph`.
///
/// # Errors
/// If a file can't be read or written, isn't a sound route graph, or an argument is out of range.
pub fn run(command: GraphCommand) -> Result<ExitCode, Failure> {
    match command {
        GraphCommand::Check(file) => check(&file),
        GraphCommand::Info { file, json } => info(&file, json),
        GraphCommand::Generate { kind } => generate(&kind),
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
        Err(other) => return Err(other.into()),
    };
    print(&report(&file.file, &findings, &summary))?;
    Ok(if findings.errors() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Every finding, and a line that sums up.
fn report(file: &Path, findings: &Findings, summary: &str) -> String {
    let mut text: String = findings.as_slice().iter().map(|finding| format!("{finding}\n")).collect();
    let (errors, warnings) = (findings.errors(), findings.warnings());
    let unlisted = errors + warnings - findings.as_slice().len();
    if unlisted > 0 {
        text.push_str(&format!("({unlisted} more findings aren't listed)\n"));
    }
    let (errors, warnings) = (counted(errors, "error"), counted(warnings, "warning"));
    text + &format!("{}: {summary}; {errors}, {warnings}\n", file.display())
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn info(file: &FileArgs, json: bool) -> Result<ExitCode, Failure> {
    let info = Info::of(&read(file)?);
    let text = if json { serde_json::to_string_pretty(&info)? + "\n" } else { info.to_string() };
    print(&text)
}

fn generate(kind: &Generate) -> Result<ExitCode, Failure> {
    let (text, output) = match *kind {
        Generate::Warehouse { aisles, rows, bays, ref output } => {
            (Warehouse { aisles, rows, bays }.generate()?, output)
        }
        Generate::Grid { columns, rows, spacing, one_way, ref output } => {
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
    std::fs::write(file, text).map_err(|error| format!("{}: can't be written: {error}", file.display()))?;
    Ok(ExitCode::SUCCESS)
}

fn print(text: &str) -> Result<ExitCode, Failure> {
    print!("{text}");
    Ok(ExitCode::SUCCESS)
}
