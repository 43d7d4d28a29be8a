//! The plan of a study: variants of a plant, numbers of robots, seeds.

mod day;
mod file;
mod prices;
mod robots;
mod scenario;
mod setting;
mod target;
mod variant;

use std::path::{Path, PathBuf};

pub use day::{Day, DayClock};
pub use file::{StudyFile, is_study};
pub use prices::Prices;
pub use robots::{ParseRobotsError, Robots, robots_in_words};
pub use scenario::{
    Breakdowns, Disturbances, Load, RobotGroup, RobotType, Routes, RunScenario, Setup,
};
pub use setting::{Axis, ParseAxisError, Setting};
pub use target::{ParseTargetError, Side, Statistic, Target, TargetFigure};
pub use variant::{FLEET_MANAGER, FleetType, RunTime, Variant};

use regatta_layout::traffic::CutOff;
use regatta_layout::{ChangeError, GraphError};
use regatta_scenario::ScenarioError;
use serde::Serialize;

/// The most stations that a message names.
const MOST_STOPS: usize = 8;

/// A study.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The name of the plant, for the page's title.
    pub title: String,
    /// The numbers of robots.
    pub robots: Robots,
    /// The question.
    pub question: Question,
    /// The precision of the answer.
    pub precision: Precision,
    /// The time of a run.
    pub time: RunTime,
    /// The number of changes that are tried for a relief.
    pub reliefs: usize,
    /// The files that it is made of.
    pub inputs: Vec<Input>,
    /// The prices, if the user gives any.
    pub prices: Option<Prices>,
    /// The version of the program.
    pub program: String,
    /// The variants; at least one. The others are compared with the first.
    pub variants: Vec<Variant>,
}

/// A file that a study was made of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Input {
    /// Its name, without folders.
    pub name: String,
    /// The hash of its content: XXH3 of 128 bits, in hexadecimal digits.
    pub hash: String,
}

/// The question of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Question {
    /// The number of robots that the plant holds: the knee of the curve.
    #[default]
    Knee,
    /// The least number of robots that meets all of some targets.
    Least(Vec<Target>),
}

impl Question {
    /// The targets; none if the question is another one.
    pub fn targets(&self) -> &[Target] {
        match self {
            Self::Knee => &[],
            Self::Least(targets) => targets,
        }
    }
}

/// The numbers of seeds, and the definition of the knee of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// The least number of seeds of each point; at least 2, as one run has no spread.
    pub least_seeds: u64,
    /// The largest number of seeds of a point.
    pub most_seeds: u64,
    /// Seeds are added at the knee until half of the 95 % interval of the throughput is at most
    /// this part of it.
    pub interval: f64,
    /// At the knee, one more robot brings less than this part of what one brings alone.
    pub knee: f64,
    /// The distance from the knee to its neighbours is at most this part of it.
    pub resolution: f64,
}

impl Default for Precision {
    fn default() -> Self {
        Self { least_seeds: 3, most_seeds: 10, interval: 0.02, knee: 0.01, resolution: 0.06 }
    }
}

/// The error of making a plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The plant or the scenario can't be used.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The layout can't be used.
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// An edge can't be changed.
    #[error("{file}: {error}", file = file.display())]
    Change {
        /// The layout.
        file: PathBuf,
        /// The reason.
        error: ChangeError,
    },
    /// The engine would refuse a variant.
    #[error("{name}: {error}")]
    Variant {
        /// Its name.
        name: String,
        /// The reason.
        error: ScenarioError,
    },
    /// With a setting's value, the plant or its load can't be used.
    #[error("with {name}: {error}")]
    With {
        /// The variant's name.
        name: String,
        /// The reason.
        error: Box<PlanError>,
    },
    /// Robots can't drive to any node that a part of the load names, and back.
    #[error(
        "{file}: load, {part}: robots can't drive to any of its nodes and back: connect them; \
         `regatta graph check --traffic` shows more",
        file = file.display()
    )]
    CutOff {
        /// The layout or the scenario.
        file: PathBuf,
        /// The part of the load.
        part: String,
    },
    /// Robots can't drive to any station of a role that the load names, and back.
    #[error(
        "{file}: load: no station to {role} is left that robots can drive to and back: connect \
         one; `regatta graph check --traffic` shows more",
        file = file.display()
    )]
    NoStation {
        /// The layout or the scenario.
        file: PathBuf,
        /// The role.
        role: &'static str,
    },
    /// Robots can't drive to stops of a day's orders, or not back.
    #[error(
        "{day}: robots can't serve {stops}: connect {them}, or take {their} orders out; \
         `regatta graph check --traffic` shows more",
        stops = stops_in_words(stops, file),
        them = if stops.len() == 1 { "it" } else { "them" },
        their = if stops.len() == 1 { "its" } else { "their" }
    )]
    CutOffStops {
        /// The file of orders.
        day: String,
        /// The stations with the ways that are missing; at least one.
        stops: Vec<(String, CutOff)>,
        /// The layout or the scenario.
        file: PathBuf,
    },
    /// The load names a file of orders.
    #[error(
        "{file}: load: a study gets a file of orders by an option: give --orders {orders}, which \
         replaces the whole load",
        file = file.display()
    )]
    FileOfOrders {
        /// The layout or the scenario.
        file: PathBuf,
        /// The path of the file, with the options for its other keys.
        orders: String,
    },
    /// A setting doesn't fit the scenario, or its value is invalid.
    #[error("{setting}: {message}")]
    Setting {
        /// The setting.
        setting: String,
        /// The reason, and the remedy.
        message: String,
    },
    /// No two nodes can be reached from each other.
    #[error(
        "{file}: no road leads back to where it began, so that robots could work there only once: \
         add edges, allow reverse gear, or raise speeds under 0.01 m/s, which are too slow to \
         count; `regatta graph check --traffic` shows more",
        file = file.display()
    )]
    NoWayBack {
        /// The layout.
        file: PathBuf,
    },
}

/// Returns stations of a layout with the ways that are missing, in words: the first ones by name.
fn stops_in_words(stops: &[(String, CutOff)], file: &Path) -> String {
    let file = file.display();
    if let [(stop, cut_off)] = stops {
        return format!("the station {stop} of {file}, as {}", cut_off.missing_way());
    }
    let named = stops.iter().take(MOST_STOPS);
    let named: Vec<String> =
        named.map(|(stop, cut_off)| format!("{stop}, as {}", cut_off.missing_way())).collect();
    let more = match stops.len().saturating_sub(MOST_STOPS) {
        0 => String::new(),
        more => format!("; and {more} more, which `regatta orders check` names"),
    };
    format!("these stations of {file} ({}{more})", named.join("; "))
}

impl PlanError {
    /// Adds the name of the variant that has the error, unless the error names the setting.
    #[must_use]
    pub fn with_name(self, name: &str) -> Self {
        match self {
            Self::Setting { .. } => self,
            error => Self::With { name: name.to_owned(), error: Box::new(error) },
        }
    }

    fn setting(setting: impl ToString, message: impl ToString) -> Self {
        Self::Setting { setting: setting.to_string(), message: message.to_string() }
    }
}
