//! A variant: a plant, its robots, its load and its manager, for any number of robots and any seed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use regatta_engine::graph::components::Components;
use regatta_engine::graph::format::write;
use regatta_engine::graph::{self, EdgeChange, Format, NodeIndex, ReadOptions, Role, RouteGraph};
use regatta_engine::scenario::{Overrides, Scenario, document, made_up_scenario};
use serde_json::{Map, Value, json};

use super::{PlanError, Setting};
use crate::job::{Job, Manager};

/// The name of Regatta's manager as a value of [`Setting::Manager`].
const FLEET_MANAGER: &str = "fleet-manager";
/// The time to repair if the scenario says none, in seconds.
const REPAIR_SECS: f64 = 300.0;
/// Arguments of the fleet manager that a scenario's plugin may have and a study keeps, with their values.
const KEPT_ARGUMENTS: [&str; 2] = ["--planner", "--seed"];
/// Gives orders in turn: else robots pick the nearest of an endless load, and far ones are never served.
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
            load: "the scenario's load".to_owned(),
        };
        if variant.scenario["load"].is_null() {
            variant.make_load_up()?;
        }
        Ok(variant)
    }

    /// Gives every robot an order to the stations of the plant, as soon as it has finished one.
    fn make_load_up(&mut self) -> Result<(), PlanError> {
        let with_role = |role| -> Vec<NodeIndex> {
            let nodes = (0..).map(NodeIndex).zip(self.graph.nodes());
            nodes.filter(|(_, node)| node.role == role).map(|(index, _)| index).collect()
        };
        let (picks, drops) = (with_role(Role::Pick), with_role(Role::Drop));
        let stations: Vec<NodeIndex> =
            self.graph.stations().iter().flat_map(|station| station.nodes.iter().copied()).collect();
        let (load, words) = if !picks.is_empty() && !drops.is_empty() {
            self.check_connected(&[picks, drops].concat())?;
            (
                json!({"endless": "robots", "from": "pick", "to": "drop"}),
                "from stations to pick at to stations to drop at",
            )
        } else if stations.len() > 1 {
            self.check_connected(&stations)?;
            let ids: Vec<u32> = stations.iter().map(|node| self.graph.node(*node).id).collect();
            let load = json!({"groups": {"stations": ids}, "endless": "robots", "among": "stations"});
            (load, "from one station to the next")
        } else {
            (json!({"endless": "robots"}), "from one node to the next, since the layout names no stations")
        };
        self.scenario["load"] = load;
        self.load = format!("each robot has an order at any time, {words}");
        if let Manager::BuiltIn(args) = &mut self.manager {
            args.push(IN_TURN.to_owned());
        }
        Ok(())
    }

    /// Checks that all of some nodes can be reached from each other.
    fn check_connected(&self, nodes: &[NodeIndex]) -> Result<(), PlanError> {
        let components = Components::strong(&self.graph);
        let of = |node: &NodeIndex| components.of_node[node.0 as usize];
        let count = |component: u32| nodes.iter().filter(|node| of(node) == component).count();
        let most = nodes.iter().map(of).max_by_key(|component| count(*component)).unwrap_or(0);
        match nodes.iter().find(|node| of(node) != most) {
            None => Ok(()),
            Some(node) => {
                let node = self.graph.node(*node);
                let station = node.name().map_or_else(|| format!("node {}", node.id), |name| format!("station {name}"));
                Err(PlanError::Unreachable { file: self.file.clone(), station })
            }
        }
    }

    /// Returns the variant with a setting.
    ///
    /// # Errors
    /// [`PlanError::Setting`] if the value is invalid, or as [`read`](Self::read) for another layout.
    pub fn with(mut self, setting: Setting, value: &Value, options: &ReadOptions) -> Result<Self, PlanError> {
        let number = || match value.as_f64() {
            Some(number) if number >= 0.0 && number.is_finite() => Ok(number),
            _ => Err(PlanError::setting(setting, format!("invalid number {value}: give one of at least 0"))),
        };
        let text =
            || value.as_str().ok_or_else(|| PlanError::setting(setting, format!("invalid value {value}: give a text")));
        match setting {
            Setting::Layout => self.take_layout(Path::new(text()?), options)?,
            Setting::Type => self.types = vec![(Some(self.known_type(text()?)?), 1.0)],
            Setting::MaxSpeed => self.limit_types("max_speed", number()?)?,
            Setting::MaxAcceleration => self.limit_types("max_acceleration", number()?)?,
            Setting::SpeedFactor => {
                let factor = number()?;
                let ids: Vec<u32> = self.graph.edges().iter().map(|edge| edge.id).collect();
                self.change(&ids, EdgeChange::Speed(factor))?;
            }
            Setting::Load => self.scenario["load"] = value.clone(),
            Setting::Dwell => self.dwell(value),
            Setting::Closed => {
                let ids: Vec<u32> = serde_json::from_value(value.clone())
                    .map_err(|_| PlanError::setting(setting, format!("invalid edges {value}: give a list of ids")))?;
                self.change(&ids, EdgeChange::Close)?;
            }
            Setting::BreakdownsPerHour => self.break_down(number()?),
            Setting::Planner => match &mut self.manager {
                Manager::BuiltIn(args) | Manager::Bound(args) => {
                    args.extend(["--planner".to_owned(), text()?.to_owned()])
                }
                Manager::Command(_) => return Err(PlanError::setting(setting, "only the fleet manager has planners")),
            },
            Setting::Manager => self.manage(text()?)?,
        }
        Ok(self)
    }

    fn take_layout(&mut self, path: &Path, options: &ReadOptions) -> Result<(), PlanError> {
        let (graph, _) = graph::read(path, options)?;
        (self.graph, self.file) = (Arc::new(graph), path.to_owned());
        Ok(())
    }

    fn known_type(&self, name: &str) -> Result<String, PlanError> {
        let types = self.scenario["robot_types"].as_array().into_iter().flatten();
        let names: Vec<&str> = types.filter_map(|kind| kind["name"].as_str()).collect();
        match names.contains(&name) {
            true => Ok(name.to_owned()),
            false => {
                Err(PlanError::setting(Setting::Type, format!("unknown type '{name}': there are {}", names.join(", "))))
            }
        }
    }

    fn limit_types(&mut self, key: &str, value: f64) -> Result<(), PlanError> {
        let Some(types) = self.scenario["robot_types"].as_array_mut() else {
            return Err(PlanError::setting(key, "the scenario has no robot_types to change: add one"));
        };
        types.iter_mut().for_each(|kind| kind[key] = value.into());
        Ok(())
    }

    fn dwell(&mut self, value: &Value) {
        let load = &mut self.scenario["load"];
        match load["generators"].as_array_mut() {
            Some(generators) => generators.iter_mut().for_each(|generator| generator["dwell"] = value.clone()),
            None => load["dwell"] = value.clone(),
        }
    }

    fn break_down(&mut self, per_hour: f64) {
        let breakdowns = &mut self.scenario["disturbances"]["breakdowns"];
        let repair_secs = breakdowns["repair_secs"].as_f64().unwrap_or(REPAIR_SECS);
        *breakdowns = json!({"per_hour": per_hour, "repair_secs": repair_secs});
    }

    fn manage(&mut self, command: &str) -> Result<(), PlanError> {
        if command == FLEET_MANAGER {
            return Ok(());
        }
        let words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        if words.is_empty() {
            return Err(PlanError::setting(Setting::Manager, "the command is empty: give a program and its arguments"));
        }
        self.manager = Manager::Command(words);
        Ok(())
    }

    /// Returns the variant in which robots drive through each other, whoever steers them: the bound.
    #[must_use]
    pub fn bound(self) -> Self {
        let args = match self.manager {
            Manager::BuiltIn(args) | Manager::Bound(args) => args,
            Manager::Command(_) => vec![IN_TURN.to_owned()],
        };
        Self { manager: Manager::Bound(args), ..self }
    }

    /// Changes edges of the layout, by their ids.
    ///
    /// # Errors
    /// [`PlanError::Change`].
    pub fn change(&mut self, ids: &[u32], change: EdgeChange) -> Result<(), PlanError> {
        let changes: Vec<_> = ids.iter().map(|id| (*id, change)).collect();
        let changed = self.graph.with_changes(&changes);
        self.graph = Arc::new(changed.map_err(|error| PlanError::Change { file: self.file.clone(), error })?);
        Ok(())
    }

    /// Returns the largest speed of the robots, in metres per second, and their largest width in metres.
    pub fn robot_limits(&self) -> (f64, f64) {
        let types: Vec<&Value> = self.scenario["robot_types"].as_array().into_iter().flatten().collect();
        let largest = |key: &str| types.iter().filter_map(|kind| kind[key].as_f64()).fold(0.0, f64::max);
        let speed =
            if types.iter().all(|kind| kind["max_speed"].is_number()) { largest("max_speed") } else { f64::INFINITY };
        (if types.is_empty() { f64::INFINITY } else { speed }, largest("width").max(0.5))
    }

    /// Returns the layout as a text of Regatta's own format.
    pub fn layout_text(&self) -> String {
        write(&self.graph, Format::Regatta).map(|written| written.text).unwrap_or_default()
    }

    /// Returns the job of a run. `layout` is the name of the layout's file.
    pub fn job(&self, layout: &str, robots: u32, seed: u64, (secs, rate_hz): (u64, u32), program: &str) -> Job {
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
        let exact: Vec<f64> = self.types.iter().map(|(_, weight)| f64::from(robots) * weight / total).collect();
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
        let count =
            group["count"].as_str().and_then(|count| count.parse::<regatta_engine::scenario::RobotCount>().ok());
        let count = count.map_or_else(|| group["count"].as_f64().unwrap_or(1.0), |count| f64::from(count.0));
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
    let manager = plugins.filter(|plugin| plugin["name"] == FLEET_MANAGER).find_map(|plugin| plugin["args"].as_array());
    let args: Vec<&str> = manager.into_iter().flatten().filter_map(Value::as_str).collect();
    let kept = args.windows(2).filter(|pair| KEPT_ARGUMENTS.contains(&pair[0])).flatten();
    kept.chain(args.iter().filter(|arg| **arg == IN_TURN)).map(|text| (*text).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variant(text: &str) -> Result<Variant, PlanError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plant.csv");
        std::fs::write(&path, text).expect("written");
        Variant::read(&path, &ReadOptions::default())
    }

    const RING: &str = "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,10,10,drop\n\nfrom,to\nA,B\nB,C\nC,A\n";

    #[test]
    fn a_layout_with_stations_gets_a_load_between_them() {
        let variant = variant(RING).expect("a variant");
        let job = variant.job("x.yaml", 5, 7, (600, 10), "0.1.0");
        assert_eq!(job.scenario["load"], json!({"endless": "robots", "from": "pick", "to": "drop", "seed": 7}));
        assert_eq!((&job.scenario["seed"], &job.scenario["graph"]), (&json!(7), &json!("x.yaml")));
        assert_eq!(job.scenario["robots"][0]["count"], 5);
        assert_eq!(job.manager, Manager::BuiltIn(vec![IN_TURN.to_owned()]));
        assert!(job.scenario.get("plugins").is_none());
    }

    #[test]
    fn a_station_that_nobody_reaches_is_named() {
        let error = variant("id,x,y,role\nA,0,0,pick\nB,9,0,\nC,9,9,drop\nD,0,9,drop\n\nfrom,to\nA,B\nB,C\nC,A\nD,A\n");
        let error = error.map(drop).expect_err("D can't be reached").to_string();
        assert!(error.contains("station D") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn settings_change_what_they_name() {
        let with =
            |setting, value: Value| variant(RING).expect("a variant").with(setting, &value, &ReadOptions::default());
        let fast = with(Setting::MaxSpeed, json!(2.5)).expect("faster");
        assert_eq!(fast.scenario["robot_types"][0]["max_speed"], 2.5);
        assert_eq!(fast.robot_limits(), (2.5, 0.6));
        let slow = with(Setting::SpeedFactor, json!(0.5)).expect("slower");
        assert_eq!(slow.graph.edges()[0].velocity_forward, 0.5);
        let closed = with(Setting::Closed, json!([1])).expect("closed");
        assert_eq!(closed.graph.edges().len(), 2);
        assert_eq!(with(Setting::Dwell, json!(4)).expect("dwell").scenario["load"]["dwell"], 4);
        let broken = with(Setting::BreakdownsPerHour, json!(0.5)).expect("breakdowns");
        assert_eq!(broken.scenario["disturbances"]["breakdowns"]["repair_secs"], 300.0);
        let own = with(Setting::Manager, json!("python own.py")).expect("a manager");
        assert_eq!(own.manager, Manager::Command(vec!["python".to_owned(), "own.py".to_owned()]));
        for (setting, value) in [
            (Setting::MaxSpeed, json!("fast")),
            (Setting::Closed, json!([99])),
            (Setting::Type, json!("tugger")),
            (Setting::Manager, json!(" ")),
        ] {
            let error = with(setting, value).map(drop).expect_err("invalid").to_string();
            assert!(!error.contains('\n') && error.contains(": "), "{error}");
        }
    }

    #[test]
    fn robots_are_shared_out_among_the_types() {
        let variant = Variant {
            types: vec![(Some("a".to_owned()), 10.0), (Some("b".to_owned()), 5.0), (None, 0.1)],
            ..variant(RING).expect("a variant")
        };
        let counts = |robots| -> Vec<u64> {
            let groups = variant.groups(robots);
            groups.as_array().expect("groups").iter().map(|group| group["count"].as_u64().expect("a count")).collect()
        };
        assert_eq!((counts(1), counts(3), counts(15)), (vec![1], vec![2, 1], vec![10, 5]));
        assert_eq!(counts(1510), [1000, 500, 10]);
    }
}
