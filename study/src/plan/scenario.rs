//! The scenario of a run: the keys that a study sets are typed, the others are passed on to the
//! engine and the fleet manager as they are.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Number, Value};

/// The key of a load with the name of a file of orders.
const ORDERS: &str = "orders";
/// The key of a load with the names of the robot types that its orders are for.
const ROBOT_TYPES: &str = "robot_types";
/// The key of a load with the text of a file of orders.
const TIMETABLE: &str = "timetable";
/// The keys of a load that a day's orders don't replace.
const KEPT: [&str; 3] = ["groups", "stations", "storages"];
/// The keys of a file of orders in a load that hold for the orders of any file.
const KEPT_OF_FILE: [&str; 2] = ["deadline", "robot_types"];

/// The scenario of a job, as its file holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunScenario {
    /// The path of the layout. In a job it is the name of a file of the study.
    pub graph: String,
    /// Ticks per simulated second.
    pub rate: u32,
    /// The seed of the routes and disturbances.
    pub seed: u64,
    /// The robots.
    pub robots: Vec<RobotGroup>,
    /// The rest, which is the same for all runs of a variant but for the load's seed.
    #[serde(flatten)]
    pub setup: Setup,
}

/// Robots of one type that wait for orders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotGroup {
    /// The number of robots.
    pub count: u32,
    /// The routes that they drive before the manager has one for them.
    pub routes: Routes,
    /// The name of their type; the first type of the scenario by default.
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub robot_type: Option<String>,
}

/// The routes of robots that a manager steers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Routes {
    /// None: they stand until they get an order.
    None,
}

/// The part of a scenario that is the same for all runs of a variant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// The robot types; the engine's default type if there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot_types: Option<Vec<RobotType>>,
    /// The disturbances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disturbances: Option<Disturbances>,
    /// The transport orders.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<Load>,
}

/// A robot type. Lengths are in metres, times in seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotType {
    /// The name.
    pub name: String,
    /// The width of its footprint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<Number>,
    /// The largest speed; no limit by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<Number>,
    /// The largest acceleration; no limit by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_acceleration: Option<Number>,
    /// The engine's other keys.
    #[serde(flatten)]
    pub rest: Map<String, Value>,
}

impl RobotType {
    /// Returns the length and the width of its footprint; of a circle, its diameter twice.
    pub fn size(&self) -> [f64; 2] {
        let length = self.number("length").unwrap_or_default();
        let width = self.width.as_ref().and_then(Number::as_f64);
        [length, width.unwrap_or(length)]
    }

    /// Whether its footprint is a circle.
    pub fn is_round(&self) -> bool {
        self.rest.get("shape").is_some_and(|shape| shape == "circle")
    }

    /// Returns its largest speed in metres per second; `None` without a limit.
    pub fn max_speed(&self) -> Option<f64> {
        self.max_speed.as_ref().and_then(Number::as_f64)
    }

    /// Whether it turns on the spot.
    pub fn turns(&self) -> bool {
        self.number("max_rotation_speed").is_some_and(|speed| speed > 0.0)
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.rest.get(key)?.as_f64()
    }
}

/// The disturbances of robots.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Disturbances {
    /// Robots that break down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub breakdowns: Option<Breakdowns>,
    /// The engine's other keys.
    #[serde(flatten)]
    pub rest: Map<String, Value>,
}

/// Robots that break down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Breakdowns {
    /// Breakdowns of a robot per hour.
    pub per_hour: Number,
    /// Seconds until a robot is repaired.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repair_secs: Option<Number>,
}

/// A load of transport orders, or a generator of one, which the fleet manager reads.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// The seed of its orders.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The dwell time at stops: seconds, or `{min, max}`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dwell: Option<Value>,
    /// Several generators of orders instead of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generators: Option<Vec<Self>>,
    /// The fleet manager's other keys.
    #[serde(flatten)]
    pub rest: Map<String, Value>,
}

impl Load {
    /// Returns an endless load with some of the fleet manager's keys: as many orders are open as
    /// there are robots.
    pub fn endless<const N: usize>(keys: [(&str, Value); N]) -> Self {
        let keys = keys.into_iter().map(|(key, value)| (key.to_owned(), value));
        let endless = ("endless".to_owned(), "robots".into());
        Self { rest: keys.chain([endless]).collect(), ..Self::default() }
    }

    /// Whether it always keeps an order open for each robot.
    pub fn is_endless(&self) -> bool {
        self.rest.get("endless").is_some_and(|orders| orders == "robots")
    }

    /// Whether orders of it or of one of its generators may be for some robot types only.
    pub fn may_name_robot_types(&self) -> bool {
        let mut generators = self.generators.iter().flatten();
        let mut keys = [ROBOT_TYPES, TIMETABLE].into_iter();
        keys.any(|key| self.rest.contains_key(key)) || generators.any(Self::may_name_robot_types)
    }

    /// Returns what is left of a load if the orders of a day take the place of its own: its seed,
    /// its groups, stations and storages, and what it says about orders that lack times at stops,
    /// deadlines or robot types.
    #[must_use]
    pub fn without_orders(&self) -> Self {
        let part = self.part_with_file();
        let of_file = part.map(|part| kept(&part.rest, &KEPT_OF_FILE));
        let rest = kept(&self.rest, &KEPT).chain(of_file.into_iter().flatten()).collect();
        let dwell = part.and_then(|part| part.dwell.clone()).or_else(|| self.dwell.clone());
        Self { seed: self.seed, dwell, generators: None, rest }
    }

    /// Returns the groups, stations and storages of a load, without any orders.
    #[must_use]
    pub fn without_generators(&self) -> Self {
        let rest = kept(&self.rest, &KEPT).collect();
        Self { generators: Some(Vec::new()), rest, ..Self::default() }
    }

    /// Returns the part that reads a file of orders if there is no other source of orders.
    pub fn only_file(&self) -> Option<&Self> {
        match self.generators.as_deref() {
            None | Some([_]) => self.part_with_file(),
            Some(_) => None,
        }
    }

    /// The file of orders that this part reads.
    pub fn file_of_orders(&self) -> Option<String> {
        self.rest.get(ORDERS).map(plain)
    }

    /// Puts the text of the file of orders in the place of its name.
    pub fn set_timetable(&mut self, text: String) {
        self.rest.remove(ORDERS);
        self.rest.insert(TIMETABLE.to_owned(), text.into());
    }

    /// Whether it or one of its generators reads a file of orders.
    pub fn names_a_file(&self) -> bool {
        self.part_with_file().is_some()
    }

    /// Returns the part that reads a file of orders: it, or one of its generators.
    pub(super) fn part_with_file(&self) -> Option<&Self> {
        if self.rest.contains_key(ORDERS) {
            return Some(self);
        }
        self.generators.iter().flatten().find_map(Self::part_with_file)
    }

    /// Returns the option that gives the file of orders that the load names, which lies in a
    /// folder, with those for its other keys; `None` if it names none.
    pub(super) fn orders_option(&self, folder: &Path) -> Option<String> {
        let part = self.part_with_file()?;
        let path = folder.join(plain(part.rest.get(ORDERS)?));
        let mut option = path.display().to_string();
        for key in ["scale", "shift", "resample"] {
            if let Some(value) = part.rest.get(key) {
                let unit = if key == "scale" { "" } else { "s" };
                option += &format!(" --{key} {}{unit}", plain(value));
            }
        }
        Some(option)
    }

    /// Sets the dwell time of all generators.
    pub fn set_dwell(&mut self, dwell: &Value) {
        match &mut self.generators {
            Some(generators) => {
                for generator in generators {
                    generator.set_dwell(dwell);
                }
            }
            None => self.dwell = Some(dwell.clone()),
        }
    }
}

/// Returns the entries of a mapping with some keys.
fn kept<'a>(
    rest: &'a Map<String, Value>,
    keys: &'a [&str],
) -> impl Iterator<Item = (String, Value)> + 'a {
    let entries = keys.iter().filter_map(|key| rest.get_key_value(*key));
    entries.map(|(key, value)| (key.clone(), value.clone()))
}

/// Returns a value as a text, without the quotation marks of JSON.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
