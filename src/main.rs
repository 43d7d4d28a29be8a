//! Simulate, watch and steer a large fleet of mobile robots.

mod graph;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(name = "regatta", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Check, describe, generate and draw route graphs
    #[command(subcommand)]
    Graph(graph::GraphCommand),
}

fn main() -> ExitCode {
    let Command::Graph(command) = Cli::parse().command;
    graph::run(command).unwrap_or_else(|error| {
        eprintln!("regatta: {error}");
        ExitCode::FAILURE
    })
}
