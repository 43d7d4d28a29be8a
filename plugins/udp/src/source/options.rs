//! Command line of `regatta plugin udp-source`.

use std::time::Duration;

use clap::Parser;
use regatta_plugin::FleetName;
use regatta_plugin::world::RobotTypeRecord;

use crate::options::{self, Form, Offset};
use crate::packer::MAX_DATAGRAM_BYTES;
use crate::socket::Listen;

/// The largest value of `--max-robots`.
const MAX_ROBOTS: i64 = 1 << 24;

/// Makes a fleet from poses that arrive in UDP datagrams as lines `id,x,y,theta`
#[derive(Parser, Debug)]
#[command(name = "udp-source", bin_name = "regatta plugin udp-source", max_term_width = 100)]
pub struct SourceOptions {
    /// Receive at this address; a port without a host is on the loopback interface
    #[arg(long, value_name = "[HOST:]PORT")]
    pub listen: Listen,
    /// Name of the fleet
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Frames per second
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = rate)]
    pub rate: f64,
    /// Ignore robots with ids from this number on
    #[arg(long, value_name = "N", default_value = "10000")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=MAX_ROBOTS))]
    pub max_robots: u32,
    /// Length of the robots along their heading, in metres; without it, the robots have no type
    #[arg(long, value_name = "METRES", requires = "robot_width", value_parser = metres)]
    pub robot_length: Option<f32>,
    /// Width of the robots across their heading, in metres
    #[arg(long, value_name = "METRES", requires = "robot_length", value_parser = metres)]
    pub robot_width: Option<f32>,
    /// Offset that is added to all positions, in metres
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true)]
    pub offset: Offset,
    /// Answer each line to this address, as `id x y theta` with the offset added
    #[arg(long, value_name = "HOST:PORT")]
    pub echo_to: Option<String>,
    #[command(flatten)]
    pub form: Form,
    /// Ignore datagrams that are longer than this number of bytes
    #[arg(long, value_name = "BYTES", default_value_t = MAX_DATAGRAM_BYTES)]
    #[arg(value_parser = options::datagram_limit)]
    pub max_datagram: usize,
    /// Remove a robot when no line about it arrives for this many seconds [default: never]
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds)]
    pub forget: Option<Duration>,
    /// Print the final statistics on standard output as JSON, too
    #[arg(long)]
    pub json: bool,
    /// Name in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Print statistics once a second, and warnings of the shared memory library (iceoryx2); -vv
    /// for its complete log
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

impl SourceOptions {
    /// Returns the robots' type, if a length and width are given.
    pub fn robot_type(&self) -> Option<RobotTypeRecord> {
        Some(RobotTypeRecord::new("udp", self.robot_length?, self.robot_width?))
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.1..=1000.0).contains(rate));
    rate.ok_or_else(|| "give a number of frames per second from 0.1 to 1000".to_owned())
}

fn metres(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|metres| (0.001..=1000.0).contains(metres));
    metres.ok_or_else(|| "give a number of metres from 0.001 to 1000".to_owned())
}
