//! The command line of `regatta plugin vda5050`.

use core::str::FromStr;
use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Parser;
use regatta_plugin::{Error, Options, Result, tell};

use crate::broker::{self, Broker, BrokerUrl};
use crate::disturb::{Disturbance, Disturbances};
use crate::message::{Topic, Version};
use crate::server::{Access, Login, Server};
use crate::vehicle::Catalogue;

/// The part of a pattern that stands for the number of a robot.
const NUMBER: &str = "{}";

/// The command line of `regatta plugin vda5050`.
#[derive(Clone, Debug, Parser)]
#[command(max_term_width = 100)]
#[command(about = "Make the robots of a fleet vehicles of VDA 5050 on an MQTT broker")]
pub struct Cli {
    /// Broker to connect to; if not given, the plugin runs a broker on this machine
    #[arg(long, value_name = "mqtt://[USER@]HOST[:PORT]")]
    pub broker: Option<BrokerUrl>,
    /// File with the password of the broker's user [default: the environment variable
    /// REGATTA_MQTT_PASSWORD]
    #[arg(long, value_name = "FILE")]
    pub password_file: Option<PathBuf>,
    /// Address of the plugin's own broker; port 0 is any free one
    #[arg(long, value_name = "IP:PORT", default_value = "127.0.0.1:1883")]
    #[arg(conflicts_with_all = ["broker", "password_file"])]
    pub listen: SocketAddr,
    /// Accept clients of the plugin's own broker without user and password
    #[arg(long, conflicts_with = "broker")]
    pub anonymous: bool,
    /// Versions of the standard: 2.0, 2.1 or 3.0; several are assigned to the robots in turn
    #[arg(long, value_name = "VERSION", value_delimiter = ',', default_value = "2.0")]
    pub protocol: Vec<Version>,
    /// First level of topics [default: uagv for 2.x, vda5050 for 3.0]
    #[arg(long, value_name = "NAME", value_parser = level)]
    pub interface: Option<String>,
    /// Manufacturer of the vehicles
    #[arg(long, value_name = "NAME", default_value = "regatta", value_parser = level)]
    pub manufacturer: String,
    /// Serial numbers; {} stands for the id of a robot
    #[arg(long, value_name = "PATTERN", default_value = "{}", value_parser = pattern)]
    pub serial: String,
    /// Name of the map, for layouts without levels
    #[arg(long, value_name = "NAME", default_value = "map")]
    pub map_id: String,
    /// Seconds between two states if nothing happens; at most 30
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = state_interval)]
    pub state_every: f64,
    /// Seconds between two positions on the topic visualization; 0 for none
    #[arg(long, value_name = "SECONDS", default_value_t = 0.2, value_parser = seconds)]
    pub visualization_every: f64,
    /// Duration of an action in simulated seconds; a new name declares an action of your own
    #[arg(long, value_name = "NAME=SECONDS")]
    pub action: Vec<Duration>,
    /// Disturbances of the vehicles: failed-actions, refused-orders, lost-messages or
    /// doubled-messages (share, 2%), delay (mean, 0.5s), lost-connections, manual-mode,
    /// emergency-stops or lost-positions (so often an hour and vehicle, 1/h)
    #[arg(long, value_name = "KIND=VALUE", value_delimiter = ',')]
    pub disturb: Vec<Disturbance>,
    /// Seed of the disturbances
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub disturb_seed: u64,
    /// Number of robots above which all share one connection, without a last will
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub shared_above: usize,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

/// Returns a password that nobody guesses.
fn made_password() -> Result<String> {
    let mut random = [0; 12];
    getrandom::fill(&mut random).map_err(|error| Error::new(format_args!("{error}")))?;
    Ok(random.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The duration of an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Duration {
    name: String,
    seconds: f64,
}

impl FromStr for Duration {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, rest) = text.split_once('=').ok_or("give NAME=SECONDS, for example pick=8")?;
        if name.is_empty() {
            return Err("the name of the action is missing".to_owned());
        }
        Ok(Self { name: name.to_owned(), seconds: seconds(rest)? })
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    seconds.ok_or_else(|| "give seconds, from 0 to 1000000".to_owned())
}

fn state_interval(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.01..=30.0).contains(seconds));
    seconds.ok_or_else(|| "give seconds, from 0.01 to 30, as the standard has it".to_owned())
}

/// Checks a level of a topic.
fn level(text: &str) -> Result<String, String> {
    let is_level = !text.is_empty() && !text.contains(['/', '+', '#', '$']);
    is_level
        .then(|| text.to_owned())
        .ok_or_else(|| "a level of topics has no /, +, #, $".to_owned())
}

fn pattern(text: &str) -> Result<String, String> {
    let rest = text.replace(NUMBER, "0");
    if !text.contains(NUMBER) {
        return Err("give {} where the id of the robot stands".to_owned());
    }
    let is_valid = rest.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_.:-".contains(&byte));
    is_valid
        .then(|| text.to_owned())
        .ok_or_else(|| "serial numbers have A to Z, a to z, 0 to 9, _ . : and - only".to_owned())
}

/// The name of the user of the plugin's own broker.
const USER: &str = "regatta";

impl Cli {
    /// Connects to the broker, or to one of the plugin's own, which it starts and tells.
    pub(crate) fn start_broker(&self) -> Result<(Broker, BrokerUrl)> {
        let (url, password) = self.find_broker()?;
        Ok((Broker::start(url.clone(), password)?.disturbed(&self.disturbances()), url))
    }

    /// The disturbances of the vehicles.
    pub(crate) fn disturbances(&self) -> Disturbances {
        Disturbances::new(&self.disturb, self.disturb_seed)
    }

    /// Returns the address of the broker and the password of its user. Without an address, it
    /// starts a broker of this process, and tells its address.
    ///
    /// # Errors
    /// If the password can't be read, or if the broker can't be started.
    pub fn find_broker(&self) -> Result<(BrokerUrl, Option<String>)> {
        match &self.broker {
            Some(url) => Ok((url.clone(), broker::password(self.password_file.as_deref())?)),
            None => self.serve(),
        }
    }

    /// Starts the plugin's own broker.
    fn serve(&self) -> Result<(BrokerUrl, Option<String>)> {
        let access = if self.anonymous {
            Access::Anonymous
        } else {
            Access::Login(Login { user: USER.to_owned(), password: made_password()? })
        };
        let server = Server::start(self.listen, access.clone()).map_err(|error| {
            let address = self.listen;
            Error::new(format_args!(
                "can't listen at {address} ({error}); name a broker by --broker, or another \
                 address by --listen"
            ))
        })?;
        let (host, port) = (server.address().ip().to_string(), server.address().port());
        let (user, password) = match access {
            Access::Anonymous => (None, None),
            Access::Login(login) => (Some(login.user), Some(login.password)),
        };
        let url = BrokerUrl { user, host, port };
        match (&url.user, &password) {
            (Some(user), Some(password)) => {
                tell!("vda5050: broker at {url} for the user {user} with the password {password}")
            }
            _ => tell!("vda5050: broker at {url} for anyone who reaches it"),
        }
        Ok((url, password))
    }

    /// The actions that vehicles can carry out.
    pub(crate) fn catalogue(&self) -> Catalogue {
        let mut catalogue = Catalogue::default();
        for Duration { name, seconds } in &self.action {
            catalogue.set(name, *seconds);
        }
        catalogue
    }

    /// The version that a robot speaks.
    pub(crate) fn version(&self, robot: usize) -> Version {
        let versions = self.protocol.len().max(1);
        self.protocol.get(robot % versions).copied().unwrap_or_default()
    }

    /// The serial number of a robot.
    pub(crate) fn serial_number(&self, robot: usize) -> String {
        self.serial.replace(NUMBER, &robot.to_string())
    }

    /// The first levels of the topics of a robot.
    pub fn vehicle(&self, robot: usize) -> String {
        format!("{}/{}", self.prefix(self.version(robot)), self.serial_number(robot))
    }

    /// The first levels of the topics of a version.
    pub(crate) fn prefix(&self, version: Version) -> String {
        let interface = self.interface.as_deref().unwrap_or(version.interface());
        format!("{interface}/{}/{}", version.level(), self.manufacturer)
    }

    /// The topics of all vehicles, for a connection that they share.
    pub(crate) fn shared_topics(&self) -> Vec<String> {
        self.topics(&[Topic::Order, Topic::InstantActions])
    }

    /// Some topics of all vehicles, with `+` in the place of serial numbers.
    pub fn topics(&self, topics: &[Topic]) -> Vec<String> {
        let prefixes = self.protocol.iter().map(|version| self.prefix(*version));
        let prefixes: BTreeSet<String> = prefixes.collect();
        let of_prefix = prefixes.iter().flat_map(|prefix| {
            topics.iter().map(move |topic| format!("{prefix}/+/{}", topic.name()))
        });
        of_prefix.collect()
    }
}
