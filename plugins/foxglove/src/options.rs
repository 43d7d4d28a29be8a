//! The options of the plugin.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::PathBuf;

use clap::Parser;

/// The address by default: the one that Foxglove and Lichtblick propose.
const ADDRESS: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8765);
const RATE_HELP: &str = "Frames per second to send, or 'all' [default: 20]";

/// Show the fleet live in Foxglove or Lichtblick
#[derive(Parser, Clone, Debug)]
#[command(name = "foxglove", max_term_width = 100)]
#[command(mut_arg("rate", |rate| rate.help(RATE_HELP)))]
pub struct Cli {
    /// Address to listen on; port 0 is any free one
    #[arg(long, value_name = "IP:PORT", default_value_t = ADDRESS, value_parser = address)]
    pub listen: SocketAddr,
    /// Site whose pages may connect, such as `https://app.foxglove.dev`; may be repeated
    #[arg(long, value_name = "ORIGIN")]
    pub allow_origin: Vec<String>,
    /// Accept only clients that have the token of this file in their address:
    /// ws://IP:PORT/?token=TOKEN
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub token_file: Option<PathBuf>,
    /// Offer no services and change no parameters, so that nobody can steer the fleet
    #[arg(long)]
    pub read_only: bool,
    /// Write a layout for Foxglove and Lichtblick to this file, and exit
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub layout: Option<PathBuf>,
    /// The options of every plugin.
    #[command(flatten)]
    pub options: regatta_plugin::Options,
}

fn address(text: &str) -> Result<SocketAddr, &'static str> {
    let addresses = text.to_socket_addrs().map_err(|_| "give IP:PORT, for example 127.0.0.1:8765");
    addresses?.next().ok_or("this host name has no address")
}
