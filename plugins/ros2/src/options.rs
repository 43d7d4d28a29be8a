//! The options of the plugin.

use std::net::Ipv4Addr;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Parser;

/// The variable with the domain that ROS 2 itself reads.
const DOMAIN_VARIABLE: &str = "ROS_DOMAIN_ID";
/// The highest domain: higher ones have no UDP ports.
const MAX_DOMAIN: u16 = 232;

const RATE_HELP: &str = "Frames per second to publish, or 'all' [default: 10]";

/// Make the fleet part of ROS 2
#[derive(Parser, Clone, Debug)]
#[command(name = "ros2", max_term_width = 100)]
#[command(mut_arg("rate", |rate| rate.help(RATE_HELP)))]
pub struct Cli {
    /// Domain of ROS 2, 0 to 232 [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_parser = clap::value_parser!(u16).range(..=i64::from(MAX_DOMAIN)))]
    pub domain: Option<u16>,
    /// Prefix of the names of topics, services and frames
    #[arg(long, value_name = "NAME", default_value = "regatta")]
    pub namespace: Namespace,
    /// Robots with topics and actions of their own: the first, and the one after the last
    #[arg(long, value_name = "A..B", default_value = "0..10")]
    pub robots: RobotRange,
    /// Robots with a frame in /tf: the first, and the one after the last
    #[arg(long, value_name = "A..B", default_value = "0..1000")]
    pub frames: RobotRange,
    /// Interfaces to use, by their IPv4 addresses, or 'all'
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", value_delimiter = ',')]
    pub network: Vec<Network>,
    /// Publish this map of the ROS map server (YAML) as an occupancy grid
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub map: Option<PathBuf>,
    /// Accept no goals and offer no services, so that nobody can steer the fleet
    #[arg(long)]
    pub read_only: bool,
    /// Publish the fleet, doors and lifts as messages of Open-RMF, and accept its requests
    #[arg(long)]
    pub open_rmf: bool,
    /// The options of every plugin.
    #[command(flatten)]
    pub options: regatta_plugin::Options,
}

impl Cli {
    /// The domain.
    pub(crate) fn domain(&self) -> regatta_plugin::Result<u16> {
        if let Some(domain) = self.domain {
            return Ok(domain);
        }
        let Ok(text) = std::env::var(DOMAIN_VARIABLE) else { return Ok(0) };
        match text.trim().parse() {
            _ if text.trim().is_empty() => Ok(0),
            Ok(domain) if domain <= MAX_DOMAIN => Ok(domain),
            _ => Err(regatta_plugin::Error::new(format_args!(
                "{DOMAIN_VARIABLE} is '{text}'; give a number from 0 to {MAX_DOMAIN}"
            ))),
        }
    }

    /// The addresses of the interfaces; empty for all.
    pub(crate) fn networks(&self) -> Vec<Ipv4Addr> {
        let mut addresses = Vec::new();
        for network in &self.network {
            match network {
                Network::All => return Vec::new(),
                Network::Address(address) => addresses.push(*address),
            }
        }
        addresses
    }
}

/// An interface of this machine, or all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Network {
    /// All interfaces.
    All,
    /// The one with this address.
    Address(Ipv4Addr),
}

impl FromStr for Network {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "all" {
            return Ok(Self::All);
        }
        let address = text.parse().map(Self::Address);
        address.map_err(|_| "give the IPv4 address of an interface, or 'all'")
    }
}

/// The first part of names: tokens of ROS with slashes between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Namespace(String);

impl FromStr for Namespace {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_valid = text.trim_start_matches('/').split('/').all(|token| {
            let starts_well = token.starts_with(|c: char| c.is_ascii_alphabetic());
            let is_word = token.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
            starts_well && is_word && !token.contains("__")
        });
        is_valid
            .then(|| Self(text.trim_start_matches('/').to_owned()))
            .ok_or("give words of A to Z, a to z, 0 to 9 and _ that begin with a letter")
    }
}

impl Namespace {
    /// With a slash before it, as the names of nodes have it.
    pub(crate) fn absolute(&self) -> String {
        format!("/{}", self.0)
    }

    /// The absolute name of a topic or a service below it; a name with a slash before it stands as
    /// it is.
    pub(crate) fn resolve(&self, name: &str) -> String {
        if name.starts_with('/') { name.to_owned() } else { format!("/{}/{name}", self.0) }
    }

    /// The frame of a robot.
    pub(crate) fn frame_of(&self, robot: u32) -> String {
        format!("{}/{}", self.0, robot_name(robot))
    }
}

/// The name of a robot: a word, as ROS wants it.
pub(crate) fn robot_name(robot: u32) -> String {
    format!("robot_{robot}")
}

/// The robot with a name.
pub(crate) fn robot_number(name: &str) -> Option<u32> {
    let digits = name.strip_prefix("robot_")?;
    let robot = digits.parse().ok()?;
    (robot_name(robot) == name).then_some(robot)
}

/// A range of robots' ids: `A..B` is A to B - 1. Either end may be omitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotRange(pub Range<u32>);

impl FromStr for RobotRange {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let ends = text.split_once("..").and_then(|(from, to)| {
            let from = if from.is_empty() { 0 } else { from.parse().ok()? };
            let to = if to.is_empty() { u32::MAX } else { to.parse().ok()? };
            (from <= to).then_some(Self(from..to))
        });
        ends.ok_or("give A..B, the first robot and the one after the last, for example 0..100")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces_are_words_of_ros() {
        for (text, name) in [("regatta", "/regatta/x"), ("/site_1/north", "/site_1/north/x")] {
            assert_eq!(text.parse::<Namespace>().expect("valid").resolve("x"), name);
        }
        for text in ["", "/", "a//b", "1a", "a b", "a__b", "ä", "a/"] {
            assert!(text.parse::<Namespace>().is_err(), "{text}");
        }
        let namespace: Namespace = "a".parse().expect("valid");
        assert_eq!(
            (namespace.resolve("/tf"), namespace.frame_of(7)),
            ("/tf".into(), "a/robot_7".into())
        );
    }

    #[test]
    fn robots_have_names() {
        assert_eq!(robot_number("robot_70"), Some(70));
        for name in ["robot_", "robot_07", "robot_-1", "robot_4294967296", "amr_1", ""] {
            assert_eq!(robot_number(name), None, "{name}");
        }
    }

    #[test]
    fn ranges_and_networks_are_parsed() {
        assert_eq!("3..9".parse(), Ok(RobotRange(3..9)));
        assert_eq!("..".parse(), Ok(RobotRange(0..u32::MAX)));
        assert_eq!("0..0".parse(), Ok(RobotRange(0..0)));
        assert!("9..3".parse::<RobotRange>().is_err() && "3".parse::<RobotRange>().is_err());
        let cli = Cli::try_parse_from(["ros2", "--network", "10.0.0.1,127.0.0.1"]).expect("valid");
        assert_eq!(cli.networks(), [Ipv4Addr::new(10, 0, 0, 1), Ipv4Addr::LOCALHOST]);
        let cli = Cli::try_parse_from(["ros2", "--network", "all"]).expect("valid");
        assert!(cli.networks().is_empty());
        assert!(Cli::try_parse_from(["ros2", "--domain", "233"]).is_err());
    }
}
