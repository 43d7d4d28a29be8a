//! A variant: a plant, its robots, its load and its manager, for any number of robots and any seed.

mod load;
mod settings;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use regatta_layout::{Format, ReadOptions, RouteGraph, write};
use regatta_scenario::{Overrides, Scenario, document, made_up_scenario};
use serde_json::{Map, Value, json};

use super::PlanError;
use crate::job::{Job, Manager};

/// The name of Regatta's manager as a value of [`Setting::Manager`](super::Setting::Manager).
const FLEET_MANAGER: &str = "fleet-manager";
/// Arguments of the fleet manager that a scenario's plugin may have and a study keeps, with their
/// values.
const KEPT_ARGUMENTS: [&str; 2] = [PLANNER, "--seed"];
const PLANNER: &str = "--planner";
/// Gives orders in turn: else robots pick the nearest of an endless load, and far ones are never
/// served.
const IN_TURN: &str = "--in-turn";

/// A variant of a study.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What tells it from the others; empty if there are none.
    pub name: String,
    /// The file that it was made of, for messages.
    pub file: PathBuf,
    /// The layout.
    pub graph: Arc<RouteGraph>,
    /// The scenario without what a job adds: the layout, the robots and the seeds.
    pub scenario: Value,
    /// Robot types by name, with the parts of the fleet that are of them.
    types: Vec<(Option<String>, f64)>,
    /// Who steers the robots.
    pub manager: Manager,
    /// Where orders go, in words.
    pub load: String,
    /// Whether the load was made for the layout, and not given.
    is_load_made_up: bool,
}

impl Variant {
    /// Reads a plant or a scenario.
    ///
    /// # Errors
    /// [`PlanError`] if it can't be read or is invalid, or if its stations aren't connected.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self, PlanError> {
        let overrides = Overrides { layout: options.clone(), ..Overrides::default() };
        let read = Scenario::read(path, &overrides)?;
        let text = match read.is_made_up {
            true => made_up_scenario(&read.graph, "layout", options),
            false => {
                let unreadable = |reason| PlanError::Read { path: path.to_owned(), reason };
                std::fs::read_to_string(path).map_err(unreadable)?
            }
        };
        let mut scenario: Map<String, Value> = document(&text, path)?;
        let manager = Manager::BuiltIn(kept_arguments(&scenario));
        let types = types(&scenario);
        for key in [
            "graph",
            "layout",
            "nodes",
            "robots",
            "rate",
            "publish_rate",
            "seed",
            "plugins",
            "viewer",
            "lights",
            "cameras",
        ] {
            scenario.remove(key);
        }
        let mut variant = Self {
            name: String::new(),
            file: path.to_owned(),
            graph: Arc::clone(&read.graph),
            scenario: scenario.into(),
            types,
            manager,
            load: "that of the scenario".to_owned(),
            is_load_made_up: false,
        };
        if variant.scenario["load"].is_null() {
            variant.make_load_up()?;
        }
        Ok(variant)
    }

    /// Checks the variant as the engine will, with one robot.
    ///
    /// # Errors
    /// [`PlanError::Variant`] if the engine would refuse it.
    pub fn check(&self, rate_hz: u32) -> Result<(), PlanError> {
        let job = self.job("layout.yaml", 1, 1, (1, rate_hz), "");
        let checked = Scenario::from_texts(
            &job.scenario.to_string(),
            &self.layout_text(),
            Path::new("the scenario"),
            &Overrides::default(),
        );
        let name =
            if self.name.is_empty() { self.file.display().to_string() } else { self.name.clone() };
        checked.map(drop).map_err(|error| PlanError::Variant { name, error })
    }

    /// Returns the largest speed of the robots, in metres per second, and their largest width in
    /// metres.
    pub fn robot_limits(&self) -> (f64, f64) {
        let types: Vec<&Value> =
            self.scenario["robot_types"].as_array().into_iter().flatten().collect();
        let largest =
            |key: &str| types.iter().filter_map(|kind| kind[key].as_f64()).fold(0.0, f64::max);
        let speed = if types.iter().all(|kind| kind["max_speed"].is_number()) {
            largest("max_speed")
        } else {
            f64::INFINITY
        };
        (if types.is_empty() { f64::INFINITY } else { speed }, largest("width").max(0.5))
    }

    /// Returns the layout as a text of Regatta's own format.
    pub fn layout_text(&self) -> String {
        write(&self.graph, Format::Regatta).map(|written| written.text).unwrap_or_default()
    }

    /// Returns the job of a run. `layout` is the name of the layout's file.
    pub fn job(
        &self,
        layout: &str,
        robots: u32,
        seed: u64,
        (secs, rate_hz): (u64, u32),
        program: &str,
    ) -> Job {
        let mut scenario = self.scenario.clone();
        scenario["graph"] = layout.into();
        scenario["rate"] = rate_hz.into();
        scenario["seed"] = seed.into();
        scenario["load"]["seed"] = seed.into();
        scenario["robots"] = self.groups(robots);
        Job { program: program.to_owned(), scenario, secs, rate_hz, manager: self.manager.clone() }
    }

    /// Shares robots out among the types, by the largest remainders.
    fn groups(&self, robots: u32) -> Value {
        let total: f64 = self.types.iter().map(|(_, weight)| weight).sum();
        let exact: Vec<f64> =
            self.types.iter().map(|(_, weight)| f64::from(robots) * weight / total).collect();
        let mut counts: Vec<u32> = exact.iter().map(|count| count.floor() as u32).collect();
        let mut order: Vec<usize> = (0..exact.len()).collect();
        order.sort_by(|a, b| exact[*b].fract().total_cmp(&exact[*a].fract()));
        let missing = robots - counts.iter().sum::<u32>();
        order.iter().cycle().take(missing as usize).for_each(|index| counts[*index] += 1);
        let group = |((name, _), count): (&(Option<String>, f64), &u32)| match name {
            Some(name) => json!({"count": count, "routes": "none", "type": name}),
            None => json!({"count": count, "routes": "none"}),
        };
        self.types.iter().zip(&counts).filter(|(_, count)| **count > 0).map(group).collect()
    }
}

/// Returns the robot types of a scenario's groups, with the numbers of their robots.
fn types(scenario: &Map<String, Value>) -> Vec<(Option<String>, f64)> {
    let mut types: Vec<(Option<String>, f64)> = Vec::new();
    for group in scenario.get("robots").and_then(Value::as_array).into_iter().flatten() {
        let name = group["type"].as_str().map(str::to_owned);
        // Numbers such as 10k are texts; one is what a group has by default.
        let count = group["count"]
            .as_str()
            .and_then(|count| count.parse::<regatta_scenario::RobotCount>().ok());
        let count = count
            .map_or_else(|| group["count"].as_f64().unwrap_or(1.0), |count| f64::from(count.0));
        match types.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += count,
            None => types.push((name, count)),
        }
    }
    if types.is_empty() { vec![(None, 1.0)] } else { types }
}

/// Returns the arguments of the scenario's fleet manager that change what it does.
fn kept_arguments(scenario: &Map<String, Value>) -> Vec<String> {
    let plugins = scenario.get("plugins").and_then(Value::as_array).into_iter().flatten();
    let manager = plugins
        .filter(|plugin| plugin["name"] == FLEET_MANAGER)
        .find_map(|plugin| plugin["args"].as_array());
    let args: Vec<&str> = manager.into_iter().flatten().filter_map(Value::as_str).collect();
    let kept = args.windows(2).filter(|pair| KEPT_ARGUMENTS.contains(&pair[0])).flatten();
    kept.chain(args.iter().filter(|arg| **arg == IN_TURN)).map(|text| (*text).to_owned()).collect()
}

#[cfg(test)]
mod tests;
