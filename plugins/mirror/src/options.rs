//! The command line.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use regatta_plugin::FleetName;

use crate::wire::Encoding;

/// A subcommand of `regatta mirror`.
#[derive(Clone, Debug, Subcommand)]
pub enum MirrorCommand {
    /// Offer a fleet of this host to other hosts, which can see and steer it
    Send(SendArgs),
    /// Write a fleet of another host into this host's shared memory
    Receive(ReceiveArgs),
}

/// The connections of either side.
#[derive(Args, Clone, Debug, Default)]
pub struct LinkArgs {
    /// Connect to this address: tcp/HOST:PORT, or tls/HOST:PORT with --config
    #[arg(long, value_name = "ADDRESS")]
    pub connect: Vec<String>,
    /// Listen on this address: tcp/HOST:PORT; tcp/0.0.0.0:7447 opens it to the network
    #[arg(long, value_name = "ADDRESS")]
    pub listen: Vec<String>,
    /// Configuration of zenoh, in JSON5: certificates, passwords, access control
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
}

/// Options of `regatta mirror send`.
#[derive(Args, Clone, Debug)]
pub struct SendArgs {
    /// Fleet to offer
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    #[command(flatten)]
    /// Connections
    pub link: LinkArgs,
    /// Accept neither commands nor control requests from other hosts
    #[arg(long)]
    pub read_only: bool,
    /// Frames per second at most [default: all]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub rate: Option<f64>,
}

/// Options of `regatta mirror receive`.
#[derive(Args, Clone, Debug)]
pub struct ReceiveArgs {
    /// Fleet of the other host
    #[arg(long, value_name = "NAME", default_value_t)]
    pub from: FleetName,
    /// Fleet to write on this host [default: the same name]
    #[arg(long, value_name = "NAME")]
    pub fleet: Option<FleetName>,
    #[command(flatten)]
    /// Connections
    pub link: LinkArgs,
    /// Encoding of frames
    #[arg(long, value_enum, default_value_t)]
    pub encoding: Encoding,
    /// Print the final statistics on standard output as JSON, too
    #[arg(long)]
    pub json: bool,
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.01..=10_000.0).contains(rate));
    rate.ok_or_else(|| "give a number of frames per second from 0.01 to 10000".to_owned())
}
