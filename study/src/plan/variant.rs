//! A variant: a plant, its robots, its load and its manager, for any number of robots and any seed.

mod prune;
mod roads;
mod settings;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use regatta_layout::traffic::{self, Turning};
use regatta_layout::{Format, ReadOptions, Role, RouteGraph, write};
use regatta_scenario::yaml::{PluginEntry, RobotGroupEntry};
use regatta_scenario::{LEFT_OUT_OF_ORDERS, MadeUpLoad, Overrides, Scenario, Warnings};
use serde::{Deserialize, Serialize};

use super::scenario::{Breakdowns, Load, RobotGroup, RobotType, Routes, RunScenario, Setup};
use super::{Day, PlanError};
use crate::job::{IN_TURN, Job, Manager, OPTIONS};

/// The name of Regatta's manager as a value of [`Setting::Manager`](super::Setting::Manager).
pub const FLEET_MANAGER: &str = "fleet-manager";
/// The options of a fleet manager with files of orders.
const UNREAD: [&str; 2] = ["--load", "--orders"];
/// The width in metres of robots whose types have no larger one.
const LEAST_WIDTH: f64 = 0.5;

/// A variant of a study.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The name that tells it from the others; empty if there are none.
    pub name: String,
    /// The file that it was made of, for messages.
    pub file: PathBuf,
    /// The roads: the main part of the layout.
    pub graph: Arc<RouteGraph>,
    /// The stations and nodes that are cut off from them, in words: they take no part.
    pub left_out: Vec<String>,
    /// The ids of those of these nodes where orders could have stops.
    pub left_out_stops: BTreeSet<u32>,
    /// The reason why made-up orders have other stops than the layout's stations suggest.
    pub other_stops: Option<String>,
    /// The assumptions of reading the layout, in words.
    pub assumptions: Vec<String>,
    /// The warnings about the layout and its scenario.
    pub warnings: Warnings,
    /// The whole layout.
    whole: Arc<RouteGraph>,
    /// The parts of the scenario that a study doesn't use, in words.
    unread: Vec<String>,
    /// The program that steers the robots.
    pub manager: Manager,
    /// The stops of the orders, in words.
    pub load: String,
    /// The scenario without what a job adds: the layout, the robots and the seeds.
    pub(super) setup: Setup,
    /// The robot types of the fleet.
    types: Vec<TypeShare>,
    /// Whether the load was made for the layout, and not given.
    pub(super) is_load_made_up: bool,
    /// The day whose orders are the load.
    pub(super) day: Option<Arc<Day>>,
}

/// A robot type and its share of the fleet.
#[derive(Clone, Debug, PartialEq)]
struct TypeShare {
    /// The name; `None` for the scenario's first type.
    name: Option<String>,
    /// The share, in proportion to those of the other types.
    weight: f64,
}

/// A robot type of a fleet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FleetType {
    /// The name; `None` of a scenario without types.
    pub name: Option<String>,
    /// The outline of its robots.
    #[serde(rename = "shape")]
    pub outline: traffic::Outline,
    /// The length and the width of its robots, in metres; of circles, the diameter twice.
    pub size: [f64; 2],
    /// Their largest speed in metres per second; `None` without a limit of their own.
    pub max_speed: Option<f64>,
    /// The number of its robots at the answer; `None` without an answer.
    pub robots: Option<u32>,
}

/// The time of a run, and its resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunTime {
    /// Simulated seconds.
    pub secs: u64,
    /// Ticks and frames per simulated second.
    pub rate_hz: u32,
}

/// The keys of a scenario that a study uses. The scenario was checked before.
#[derive(Deserialize)]
struct PlantScenario {
    robots: Vec<RobotGroupEntry>,
    #[serde(default)]
    plugins: Vec<PluginEntry>,
    #[serde(flatten)]
    setup: Setup,
}

impl Variant {
    /// Reads a plant or a scenario.
    ///
    /// # Errors
    /// [`PlanError`] if it can't be read or is invalid, or if robots can't come back anywhere.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self, PlanError> {
        let overrides = Overrides { layout: options.clone(), ..Overrides::default() };
        let read = Scenario::read(path, &overrides)?;
        let PlantScenario { robots, plugins, setup } = read.source.sections()?;
        // The load of a default scenario is made for a look at the layout.
        let load = setup.load.filter(|_| !read.is_default);
        let setup = Setup { load, ..setup };
        let mut variant = Self {
            name: String::new(),
            file: path.to_owned(),
            graph: Arc::clone(&read.graph),
            left_out: Vec::new(),
            left_out_stops: BTreeSet::new(),
            other_stops: None,
            assumptions: read.assumptions,
            warnings: without_left_out(read.warnings),
            whole: read.graph,
            unread: unread(&plugins, &robots),
            manager: Manager::BuiltIn(kept_arguments(&plugins)),
            load: "that of the scenario".to_owned(),
            setup,
            types: types(robots),
            is_load_made_up: false,
            day: None,
        };
        variant.set_roads()?;
        if variant.setup.load.is_none() {
            variant.make_load_up();
        }
        Ok(variant)
    }

    /// Checks the variant as the engine will, with one robot.
    ///
    /// # Errors
    /// [`PlanError::FileOfOrders`] if its load names a file, which jobs don't have, and
    /// [`PlanError::Variant`] if the engine would refuse it.
    pub fn check(&self, rate_hz: u32) -> Result<(), PlanError> {
        let folder = self.file.parent().unwrap_or(Path::new(""));
        if let Some(orders) = self.setup.load.as_ref().and_then(|load| load.orders_option(folder)) {
            return Err(PlanError::FileOfOrders { file: self.file.clone(), orders });
        }
        let job = self.job("layout.yaml", 1, 1, RunTime { secs: 1, rate_hz }, "");
        let checked = Scenario::from_texts(
            &job.scenario_text(),
            &self.layout_text(),
            Path::new("the scenario"),
            &Overrides::default(),
        );
        let name =
            if self.name.is_empty() { self.file.display().to_string() } else { self.name.clone() };
        checked.map(drop).map_err(|error| PlanError::Variant { name, error })
    }

    /// Whether the load was made for the layout, and not given.
    pub fn is_load_made_up(&self) -> bool {
        self.is_load_made_up
    }

    /// Whether its load is the orders of a day.
    pub fn is_day(&self) -> bool {
        self.day.is_some()
    }

    /// The load.
    pub fn load_entry(&self) -> Option<&Load> {
        self.setup.load.as_ref()
    }

    /// The load, to be changed.
    pub fn load_entry_mut(&mut self) -> Option<&mut Load> {
        self.setup.load.as_mut()
    }

    /// The robot types, to be changed; `None` of a scenario without any.
    pub fn robot_types_mut(&mut self) -> Option<&mut Vec<RobotType>> {
        self.setup.robot_types.as_mut()
    }

    /// The breakdowns of robots, to be changed; `None` if there are none.
    pub fn breakdowns_mut(&mut self) -> Option<&mut Breakdowns> {
        self.setup.disturbances.as_mut()?.breakdowns.as_mut()
    }

    /// Whether a generator of the load always keeps an order open for each robot, so that the load
    /// is never the limit.
    pub fn is_load_endless(&self) -> bool {
        let Some(load) = &self.setup.load else { return false };
        match &load.generators {
            Some(generators) => generators.iter().any(Load::is_endless),
            None => load.is_endless(),
        }
    }

    /// Returns the load in words, with the time at stops if neither a made-up load nor a day has
    /// one.
    pub fn load_in_words(&self) -> String {
        let has_dwell = match &self.day {
            Some(day) => day.has_dwell,
            None => !self.is_load_made_up,
        };
        if has_dwell || self.setup.load.as_ref().is_some_and(|load| load.dwell.is_some()) {
            return self.load.clone();
        }
        let in_a_run = match self.is_load_made_up {
            true => ", where `regatta run` and `regatta new` assume 5 to 15 s",
            false => "",
        };
        format!(
            "{}; robots spend no time at stops{in_a_run} (`--vary dwell=SECONDS` gives one)",
            self.load
        )
    }

    /// Returns the largest speed of the robot types, in metres per second; infinite if a type has
    /// no limit.
    pub fn max_speed(&self) -> f64 {
        let types = self.setup.robot_types.iter().flatten();
        let speeds = types.map(RobotType::max_speed);
        let largest = speeds.map(|speed| speed.unwrap_or(f64::INFINITY)).reduce(f64::max);
        largest.unwrap_or(f64::INFINITY)
    }

    /// Returns the robot types in use, as certificates of traffic describe them, with their names,
    /// the largest footprint first; the default one, which never turns on the spot, of a scenario
    /// without types.
    pub fn robots(&self) -> Vec<(String, traffic::RobotType)> {
        let mut robots: Vec<(String, traffic::RobotType)> = Vec::new();
        for share in &self.types {
            let name = self.type_of(share.name.as_deref()).map(|kind| kind.name.clone());
            robots.push((name.unwrap_or_default(), self.robot_of(share.name.as_deref())));
        }
        robots.sort_by(|(_, a), (_, b)| b.area().total_cmp(&a.area()));
        robots
    }

    /// Returns the length of the longest robot type in use, in metres.
    pub fn max_length(&self) -> f64 {
        self.robots().iter().map(|(_, robot)| robot.length()).fold(0.0, f64::max)
    }

    /// Returns the largest diameter of the circle around a robot type in use, in metres.
    pub fn max_diameter(&self) -> f64 {
        self.robots().iter().map(|(_, robot)| robot.diameter()).fold(0.0, f64::max)
    }

    /// Returns the robot types in use, with their numbers in a fleet.
    pub fn types_of(&self, robots: Option<u32>) -> Vec<FleetType> {
        let groups = robots.map(|robots| self.groups(robots));
        let first = self.setup.robot_types.iter().flatten().next();
        let mut types = Vec::new();
        for share in &self.types {
            let robot = self.robot_of(share.name.as_deref());
            let name = share.name.clone().or_else(|| first.map(|first| first.name.clone()));
            let count = groups.iter().flatten().find(|group| group.robot_type == share.name);
            types.push(FleetType {
                name,
                outline: robot.outline(),
                size: [robot.length(), robot.width()],
                max_speed: self.type_of(share.name.as_deref()).and_then(RobotType::max_speed),
                robots: robots.map(|_| count.map_or(0, |group| group.count)),
            });
        }
        types
    }

    /// Returns the type of the scenario with a name, the first one by default; `None` if it has no
    /// types.
    fn type_of(&self, name: Option<&str>) -> Option<&RobotType> {
        let mut types = self.setup.robot_types.iter().flatten();
        types.find(|kind| name.is_none_or(|name| kind.name == name))
    }

    /// The number of its chargers.
    pub fn chargers(&self) -> usize {
        self.graph.purposes().iter().filter(|role| **role == Role::Charge).count()
    }

    /// Returns a robot type, the first one by default.
    fn robot_of(&self, name: Option<&str>) -> traffic::RobotType {
        let kind = self.type_of(name);
        let default = traffic::RobotType::default();
        let [length, width] = kind.map_or([default.length(), default.width()], RobotType::size);
        let turning = match kind.is_some_and(RobotType::turns) {
            true => Turning::OnTheSpot,
            false => Turning::Never,
        };
        let robot = match kind.is_some_and(RobotType::is_round) {
            true => traffic::RobotType::round(length, turning),
            false => traffic::RobotType::new(length, width, turning),
        };
        // The scenario was checked: its types have sizes within the range.
        robot.unwrap_or(default)
    }

    /// Returns the largest width of the robot types, in metres.
    pub fn max_width(&self) -> f64 {
        let types = self.setup.robot_types.iter().flatten();
        types.map(|kind| kind.size()[1]).fold(LEAST_WIDTH, f64::max)
    }

    /// Returns the layout as a text of Regatta's own format.
    pub fn layout_text(&self) -> String {
        write(&self.graph, Format::Regatta).map(|written| written.text).unwrap_or_default()
    }

    /// Returns the job of a run. `layout` is the name of the layout's file.
    pub fn job(&self, layout: &str, robots: u32, seed: u64, time: RunTime, program: &str) -> Job {
        let (mut setup, groups) = (self.setup.clone(), self.groups(robots));
        setup.load.get_or_insert_default().seed = Some(seed);
        let load = setup.load.as_ref();
        let names_types = load.is_some_and(Load::may_name_robot_types);
        if let Some(types) = setup.robot_types.as_mut().filter(|_| !names_types) {
            // A manager keeps room for the largest type that it knows.
            let first = types.first().map(|kind| kind.name.clone());
            types.retain(|kind| {
                let mut used = groups.iter().map(|group| group.robot_type.as_ref());
                used.any(|name| name.or(first.as_ref()) == Some(&kind.name))
            });
        }
        let (graph, rate) = (layout.to_owned(), time.rate_hz);
        let scenario = RunScenario { graph, rate, seed, robots: groups, setup };
        Job {
            program: program.to_owned(),
            scenario,
            secs: time.secs,
            rate_hz: time.rate_hz,
            ending: self.ending(),
            manager: self.manager.clone(),
        }
    }

    /// Shares robots out among the types, by the largest remainders.
    fn groups(&self, robots: u32) -> Vec<RobotGroup> {
        let total: f64 = self.types.iter().map(|share| share.weight).sum();
        let exact: Vec<f64> =
            self.types.iter().map(|share| f64::from(robots) * share.weight / total).collect();
        let mut counts: Vec<u32> = exact.iter().map(|count| count.floor() as u32).collect();
        let mut order: Vec<usize> = (0..exact.len()).collect();
        order.sort_by(|a, b| exact[*b].fract().total_cmp(&exact[*a].fract()));
        let missing = robots - counts.iter().sum::<u32>();
        for index in order.iter().cycle().take(missing as usize) {
            counts[*index] += 1;
        }
        let mut groups = Vec::new();
        for (share, count) in self.types.iter().zip(counts) {
            if count > 0 {
                let robot_type = share.name.clone();
                groups.push(RobotGroup { count, routes: Routes::None, robot_type });
            }
        }
        groups
    }

    /// Gives every robot an order to the stations of the plant, as soon as it has finished one.
    fn make_load_up(&mut self) {
        let load = MadeUpLoad::new(&self.graph);
        self.load = format!("each robot has an order at any time, {}", load.words());
        self.other_stops = load.other_stops(&self.whole);
        self.is_load_made_up = true;
        let dwell = self.setup.load.take().and_then(|load| load.dwell);
        let made_up = match load {
            MadeUpLoad::Transports { .. } => {
                Load::endless([("from", "pick".into()), ("to", "drop".into())])
            }
            MadeUpLoad::Stations(ids) | MadeUpLoad::Nodes(ids) => {
                let groups = serde_json::json!({ "stops": ids });
                Load::endless([
                    ("groups", groups),
                    ("from", "stops".into()),
                    ("to", "stops".into()),
                ])
            }
        };
        self.setup.load = Some(Load { dwell, ..made_up });
        if let Manager::BuiltIn(args) = &mut self.manager
            && !args.iter().any(|arg| arg == IN_TURN)
        {
            args.push(IN_TURN.to_owned());
        }
    }
}

/// Returns warnings without those about stations that a default scenario leaves out: a study tells
/// itself what it leaves out.
fn without_left_out(mut warnings: Warnings) -> Warnings {
    warnings.of_scenario.retain(|line| !line.contains(LEFT_OUT_OF_ORDERS));
    warnings
}

/// Returns the robot types of a scenario's groups, with the numbers of their robots.
fn types(groups: Vec<RobotGroupEntry>) -> Vec<TypeShare> {
    let mut types: Vec<TypeShare> = Vec::new();
    for group in groups {
        let count = f64::from(group.count.0);
        match types.iter_mut().find(|share| share.name == group.robot_type) {
            Some(share) => share.weight += count,
            None => types.push(TypeShare { name: group.robot_type, weight: count }),
        }
    }
    if types.is_empty() { vec![TypeShare { name: None, weight: 1.0 }] } else { types }
}

/// Returns the arguments of the scenario's fleet manager that change its decisions.
fn kept_arguments(plugins: &[PluginEntry]) -> Vec<String> {
    let mut kept = Vec::new();
    for plugin in plugins {
        let PluginEntry::Detailed(plugin) = plugin else { continue };
        if plugin.name != FLEET_MANAGER || plugin.args.is_empty() {
            continue;
        }
        for pair in plugin.args.windows(2) {
            if OPTIONS.contains(&&*pair[0]) {
                kept.extend_from_slice(pair);
            }
        }
        kept.extend(plugin.args.iter().filter(|arg| *arg == IN_TURN).cloned());
        break;
    }
    kept
}

/// Returns the parts of a scenario that a study doesn't use, in words: files of its fleet manager,
/// and the places where robots start.
fn unread(plugins: &[PluginEntry], robots: &[RobotGroupEntry]) -> Vec<String> {
    let mut unread = Vec::new();
    if robots.iter().any(|group| group.node.is_some()) {
        let places = "the places where the scenario's robots start, as each run of a study draws \
                      them by its seed";
        unread.push(places.to_owned());
    }
    for plugin in plugins {
        let PluginEntry::Detailed(plugin) = plugin else { continue };
        if plugin.name != FLEET_MANAGER {
            continue;
        }
        for pair in plugin.args.windows(2).filter(|pair| UNREAD.contains(&&*pair[0])) {
            unread.push(format!(
                "the fleet manager's `{} {}`, as a study reads the scenario's `load` only",
                pair[0], pair[1]
            ));
        }
    }
    unread
}

#[cfg(test)]
mod tests;
