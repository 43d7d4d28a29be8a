//! The source's command line.

use std::time::Duration;

use clap::Parser;
use regatta_plugin::FleetName;
use regatta_plugin::world::{RobotTypeRecord, Shape};

use crate::options::{self, Form, Offset};
use crate::packer::MAX_DATAGRAM_BYTES;
use crate::socket::Listen;

/// Most robots that can be allowed.
const MOST_ROBOTS: i64 = 1 << 24;

/// Makes a fleet of the poses that arrive in UDP datagrams, as lines `id,x,y,theta`
#[derive(Parser, Debug)]
#[command(name = "udp-source", bin_name = "regatta plugin udp-source", max_term_width = 100)]
pub struct SourceOptions {
    /// Where to receive; a port alone is one of this machine's own
    #[arg(long, value_name = "[HOST:]PORT")]
    pub listen: Listen,
    /// The fleet to make
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Frames per second
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = rate)]
    pub rate: f64,
    /// Robots have ids below this
    #[arg(long, value_name = "N", default_value = "10000", value_parser = clap::value_parser!(u32).range(1..=MOST_ROBOTS))]
    pub max_robots: u32,
    /// Metres along the heading of a robot; without it, the robots have no type
    #[arg(long, value_name = "METRES", requires = "robot_width", value_parser = metres)]
    pub robot_length: Option<f32>,
    /// Metres across it
    #[arg(long, value_name = "METRES", requires = "robot_length", value_parser = metres)]
    pub robot_width: Option<f32>,
    /// What to add to all positions, in metres
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true)]
    pub offset: Offset,
    /// Where to answer each line to, as `id x y theta` with the offset added
    #[arg(long, value_name = "HOST:PORT")]
    pub echo_to: Option<String>,
    #[command(flatten)]
    pub form: Form,
    /// Ignore datagrams that are longer
    #[arg(long, value_name = "BYTES", default_value_t = MAX_DATAGRAM_BYTES, value_parser = options::datagram_limit)]
    pub max_datagram: usize,
    /// Seconds of silence after which a robot is gone [default: never]
    #[arg(long, value_name = "SECONDS", value_parser = options::seconds)]
    pub forget: Option<Duration>,
    /// Print the closing figures as JSON too, on standard output
    #[arg(long)]
    pub json: bool,
    /// The name to go by in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Tell the figures once a second, and warnings of shared memory (iceoryx2); twice for all of its log
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

impl SourceOptions {
    /// The robots' type, if they have one.
    pub fn robot_type(&self) -> Option<RobotTypeRecord> {
        Some(RobotTypeRecord {
            name: RobotTypeRecord::padded_name("udp"),
            shape: Shape::Rectangle as u32,
            length: self.robot_length?,
            width: self.robot_width?,
            max_speed: f32::INFINITY,
            max_acceleration: f32::INFINITY,
        })
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (0.1..=1000.0).contains(rate));
    rate.ok_or_else(|| "give frames per second, 0.1 to 1000".to_owned())
}

fn metres(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|metres| (0.001..=1000.0).contains(metres));
    metres.ok_or_else(|| "give metres, 0.001 to 1000".to_owned())
}
