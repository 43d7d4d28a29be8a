//! `regatta graph`: check, describe, generate and draw route graphs.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};
use regatta_engine::graph::generate::{Grid, Warehouse};
use regatta_engine::graph::{self, Handles, ReadOptions, RouteGraph};

use crate::Failure;

#[derive(Subcommand)]
pub enum GraphCommand {
    /// Say everything that is wrong with a route graph; exit code 0 if it can be driven.
    Check(Source),
    /// Write a route graph.
    Generate {
        #[command(subcommand)]
        layout: Layout,
    },
}

/// A route graph file and how to read it.
#[derive(Args)]
pub struct Source {
    /// Route graph file.
    file: PathBuf,
    /// Which handle of a spline is whose: b_at_origin or f_at_origin, whatever the file says.
    #[arg(long)]
    handles: Option<Handles>,
}

#[derive(Subcommand)]
pub enum Layout {
    /// Pick aisles, cross aisles and a ring road.
    Warehouse {
        /// Pick aisles side by side.
        #[arg(long, default_value_t = 12)]
        aisles: u32,
        /// Rows of racks, with a cross aisle between each two.
        #[arg(long, default_value_t = 4)]
        rows: u32,
        /// Places to stop along an aisle in each row.
        #[arg(long, default_value_t = 6)]
        bays: u32,
        #[command(flatten)]
        target: Target,
    },
    /// Streets that cross each other everywhere.
    Grid {
        /// Streets that run north.
        #[arg(long, default_value_t = 6)]
        columns: u32,
        /// Streets that run east.
        #[arg(long, default_value_t = 6)]
        rows: u32,
        /// Metres between streets.
        #[arg(long, default_value_t = 30)]
        spacing: u32,
        /// Streets inside the ring are one-way, in turn.
        #[arg(long)]
        one_way: bool,
        #[command(flatten)]
        target: Target,
    },
}

/// Where a generated file goes.
#[derive(Args)]
pub struct Target {
    /// File to write; standard output if left out.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

pub fn run(command: GraphCommand) -> Result<ExitCode, Failure> {
    match command {
        GraphCommand::Check(source) => check(&source),
        GraphCommand::Generate { layout } => generate(layout),
    }
}

/// The graph that the scaling report drives on: 4,096 edges and more.
pub fn large_warehouse() -> String {
    Warehouse { aisles: 60, rows: 12, bays: 4 }.generate().expect("within the generator's limits")
}

fn check(source: &Source) -> Result<ExitCode, Failure> {
    let (graph, findings) = read(source)?;
    for finding in findings.as_slice() {
        println!("{finding}");
    }
    println!("{}: {} nodes, {} edges", source.file.display(), graph.nodes().len(), graph.edges().len());
    Ok(ExitCode::SUCCESS)
}

fn read(source: &Source) -> Result<(RouteGraph, graph::Findings), Failure> {
    Ok(graph::read(&source.file, &ReadOptions { handles: source.handles })?)
}

fn generate(layout: Layout) -> Result<ExitCode, Failure> {
    let (text, target) = match layout {
        Layout::Warehouse { aisles, rows, bays, target } => (Warehouse { aisles, rows, bays }.generate()?, target),
        Layout::Grid { columns, rows, spacing, one_way, target } => {
            (Grid { columns, rows, spacing, one_way }.generate()?, target)
        }
    };
    match target.output {
        Some(path) => {
            std::fs::write(&path, text).map_err(|error| format!("can't write {}: {error}", path.display()))?;
        }
        None => print!("{text}"),
    }
    Ok(ExitCode::SUCCESS)
}
