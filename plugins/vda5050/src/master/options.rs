//! The command line of a master's producer.

use core::fmt;
use core::str::FromStr;
use std::path::PathBuf;

use clap::Args;
use regatta_plugin::FleetName;

use super::vehicle::Limits;
use crate::broker::BrokerUrl;
use crate::message::{ActionParameter, Topic};

/// The topics that a master listens to.
const HEARD: [Topic; 4] = [Topic::Connection, Topic::State, Topic::Visualization, Topic::Factsheet];

/// The groups of options in the help.
const BROKER: &str = "Broker and vehicles";
const ORDERS: &str = "Orders of VDA 5050";

/// The vehicles of a master, and how it watches them.
#[derive(Args, Clone, Debug)]
pub struct MasterOptions {
    /// Broker of the vehicles
    #[arg(long = "vda5050", value_name = "mqtt://[USER@]HOST[:PORT]", required = true)]
    #[arg(help_heading = BROKER)]
    pub broker: Option<BrokerUrl>,
    /// File with the password of the broker's user [default: the environment variable
    /// REGATTA_MQTT_PASSWORD]
    #[arg(long, value_name = "FILE", help_heading = BROKER)]
    pub password_file: Option<PathBuf>,
    /// First levels of the topics of the vehicles: INTERFACE/VERSION/MANUFACTURER/SERIAL, with + for
    /// any
    #[arg(long, value_name = "FILTER", value_delimiter = ',', value_parser = filter)]
    #[arg(default_value = "+/+/+/+", help_heading = BROKER)]
    pub vehicles: Vec<String>,
    /// Name of the map, for layouts without levels
    #[arg(long, value_name = "NAME", default_value = "map", help_heading = ORDERS)]
    pub map_id: String,
    /// Parameter of an action, such as pick.loadType=EPAL; may be repeated
    #[arg(long = "action-parameter", value_name = "ACTION.KEY=VALUE", help_heading = ORDERS)]
    pub parameters: Vec<Parameter>,
    /// Distance in metres from its path beyond which a vehicle counts as astray, and others keep
    /// away from it
    #[arg(long, value_name = "METRES", default_value_t = 0.5, value_parser = positive)]
    #[arg(help_heading = ORDERS)]
    pub tolerance: f64,
    /// Seconds without a message after which a vehicle counts as offline
    #[arg(long, value_name = "SECONDS", default_value_t = 35.0, value_parser = positive)]
    #[arg(help_heading = BROKER)]
    pub silence: f64,
    /// Largest number of vehicles; further ones are ignored
    #[arg(long, value_name = "N", default_value_t = 10_000, help_heading = BROKER)]
    pub most_vehicles: usize,
}

/// The fleet in which the vehicles are published.
#[derive(Args, Clone, Debug)]
pub struct VehiclesOptions {
    /// The vehicles.
    #[command(flatten)]
    pub master: MasterOptions,
    /// Name of the fleet
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Frames per second
    #[arg(long, value_name = "HZ", default_value_t = 50.0, value_parser = rate)]
    pub rate: f64,
}

/// A parameter of all actions of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    kind: String,
    parameter: ActionParameter,
}

impl FromStr for Parameter {
    type Err = String;

    /// Reads `ACTION.KEY=VALUE`. A value that is JSON is taken as such, and others as texts.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(name, value)| {
            let (kind, key) = name.split_once('.')?;
            (!kind.is_empty() && !key.is_empty()).then_some((kind, key, value))
        });
        let (kind, key, value) =
            parts.ok_or("give ACTION.KEY=VALUE, such as pick.loadType=EPAL")?;
        let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
        let parameter = ActionParameter { key: key.to_owned(), value };
        Ok(Self { kind: kind.to_owned(), parameter })
    }
}

impl Parameter {
    /// The parameter, if it is one of a kind of action.
    pub(super) fn of(&self, kind: &str) -> Option<ActionParameter> {
        (self.kind == kind).then(|| self.parameter.clone())
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ActionParameter { key, value } = &self.parameter;
        write!(f, "{}.{key}={value}", self.kind)
    }
}

fn filter(text: &str) -> Result<String, String> {
    let levels: Vec<&str> = text.split('/').collect();
    let is_filter = levels.len() == 4
        && levels
            .iter()
            .all(|level| !level.is_empty() && (*level == "+" || !level.contains(['+', '#', '$'])));
    is_filter.then(|| text.to_owned()).ok_or_else(|| {
        "give four levels of topics, for example uagv/v2/+/+ or uagv/v2/KIT/0001".to_owned()
    })
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| *number > 0.0 && *number <= 1e6);
    number.ok_or_else(|| "give a number above 0, up to 1000000".to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (1.0..=1000.0).contains(rate));
    rate.ok_or_else(|| "give frames per second, from 1 to 1000".to_owned())
}

impl MasterOptions {
    /// The limits by which vehicles are watched.
    pub(super) fn limits(&self) -> Limits {
        Limits { tolerance: self.tolerance, silence: self.silence }
    }

    /// The parameters of actions of a kind.
    pub(super) fn parameters_of(&self, kind: &str) -> Vec<ActionParameter> {
        self.parameters.iter().filter_map(|parameter| parameter.of(kind)).collect()
    }

    /// The topics to listen to.
    pub(super) fn topics(&self) -> Vec<String> {
        let filters = self.vehicles.iter();
        filters.flat_map(|filter| HEARD.map(|topic| format!("{filter}/{}", topic.name()))).collect()
    }

    /// Converts the options to command-line arguments for a child process.
    pub fn to_args(&self) -> Vec<String> {
        let broker = self.broker.as_ref().map(|url| format!("--vda5050={}", url.to_text()));
        let mut args: Vec<String> = broker.into_iter().collect();
        if let Some(file) = &self.password_file {
            args.push(format!("--password-file={}", file.display()));
        }
        args.push(format!("--vehicles={}", self.vehicles.join(",")));
        args.push(format!("--map-id={}", self.map_id));
        args.extend(self.parameters.iter().map(|it| format!("--action-parameter={it}")));
        args.push(format!("--tolerance={}", self.tolerance));
        args.push(format!("--silence={}", self.silence));
        args.push(format!("--most-vehicles={}", self.most_vehicles));
        args
    }
}
