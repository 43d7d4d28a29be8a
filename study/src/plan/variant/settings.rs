//! Variants with other settings.

use std::path::Path;

use regatta_layout::{EdgeChange, ReadOptions};
use regatta_scenario::yaml::Key;
use regatta_scenario::{Overrides, Scenario, find_edge};
use serde::Deserialize;
use serde_json::{Number, Value};

use super::{FLEET_MANAGER, TypeShare, Variant, without_left_out};
use crate::job::{IN_TURN, Manager, PLANNER};
use crate::plan::scenario::{Breakdowns, Load, RobotType};
use crate::plan::{PlanError, Setting};

/// The time to repair if the scenario says none, in seconds.
const REPAIR_SECS: f64 = 300.0;

/// The planner of a bound.
const LANES: &str = "lanes";
/// A dwell time in seconds.
#[derive(Deserialize)]
#[serde(untagged)]
enum Dwell {
    Secs(f64),
    Range { min: f64, max: f64 },
}

impl Dwell {
    fn is_valid(&self) -> bool {
        match *self {
            Self::Secs(secs) => secs >= 0.0,
            Self::Range { min, max } => 0.0 <= min && min <= max,
        }
    }
}

impl Variant {
    /// Returns the variant with a setting.
    ///
    /// # Errors
    /// [`PlanError::Setting`] if the value is invalid, or as [`read`](Self::read) for another
    /// layout.
    pub fn with(
        mut self,
        setting: Setting,
        value: &Value,
        options: &ReadOptions,
    ) -> Result<Self, PlanError> {
        match setting {
            Setting::Layout => self.set_layout(Path::new(text(setting, value)?), options)?,
            Setting::Type => self.set_type(text(setting, value)?)?,
            Setting::MaxSpeed => {
                let speed = positive(setting, value)?;
                self.change_types(setting, |kind| kind.max_speed = Number::from_f64(speed))?;
            }
            Setting::MaxAcceleration => {
                let limit = positive(setting, value)?;
                self.change_types(setting, |kind| kind.max_acceleration = Number::from_f64(limit))?;
            }
            Setting::SpeedFactor => {
                let factor = positive(setting, value)?;
                let ids: Vec<u32> = self.graph.edges().iter().map(|edge| edge.id).collect();
                self.change(&ids, EdgeChange::Speed(factor))?;
            }
            Setting::Load => self.set_load(value)?,
            Setting::Dwell => self.set_dwell(value)?,
            Setting::Closed => {
                let ids = self.edges(value)?;
                self.change(&ids, EdgeChange::Close)?;
            }
            Setting::BreakdownsPerHour => self.set_breakdowns(number(setting, value)?),
            Setting::Planner => self.set_planner(text(setting, value)?)?,
            Setting::Manager => self.set_manager(text(setting, value)?)?,
        }
        Ok(self)
    }

    /// Returns the ids of the edges of a list.
    fn edges(&self, value: &Value) -> Result<Vec<u32>, PlanError> {
        let edges: Vec<Key> = serde_json::from_value(value.clone()).map_err(|_| {
            let remedy = "give a list of edges by id, name or nodes, such as [3,\"A..B\"]";
            PlanError::setting(Setting::Closed, format!("invalid edges {value}: {remedy}"))
        })?;
        let mut ids = Vec::new();
        for edge in &edges {
            let found = find_edge(self.whole(), edge);
            let found = found.map_err(|reason| PlanError::setting(Setting::Closed, reason))?;
            ids.push(self.whole().edge(found).id);
        }
        Ok(ids)
    }

    fn set_layout(&mut self, path: &Path, options: &ReadOptions) -> Result<(), PlanError> {
        let overrides = Overrides { layout: options.clone(), ..Overrides::default() };
        let read = Scenario::read(path, &overrides)?;
        (self.whole, self.assumptions) = (read.graph, read.assumptions);
        self.warnings = without_left_out(read.warnings);
        self.file = path.to_owned();
        self.set_roads()?;
        // Its stations are other ones.
        if self.is_load_made_up {
            self.make_load_up();
        }
        Ok(())
    }

    fn set_type(&mut self, name: &str) -> Result<(), PlanError> {
        let types = self.setup.robot_types.iter().flatten();
        let names: Vec<&str> = types.map(|kind| &*kind.name).collect();
        if !names.contains(&name) {
            return Err(PlanError::setting(
                Setting::Type,
                format!("unknown type '{name}': there are {}", names.join(", ")),
            ));
        }
        self.types = vec![TypeShare { name: Some(name.to_owned()), weight: 1.0 }];
        Ok(())
    }

    fn change_types(
        &mut self,
        setting: Setting,
        change: impl Fn(&mut RobotType),
    ) -> Result<(), PlanError> {
        let Some(types) = &mut self.setup.robot_types else {
            return Err(PlanError::setting(
                setting,
                "the scenario has no robot_types to change: add one",
            ));
        };
        types.iter_mut().for_each(change);
        Ok(())
    }

    fn set_load(&mut self, value: &Value) -> Result<(), PlanError> {
        self.setup.load = Some(Load::deserialize(value).map_err(|_| {
            PlanError::setting(
                Setting::Load,
                format!(
                    "invalid load {value}: give a mapping as under `load` in a scenario, such as \
                     {{\"per_hour\": 100}}"
                ),
            )
        })?);
        self.day = None;
        (self.is_load_made_up, self.load) = (false, "that of the setting `load`".to_owned());
        self.other_stops = None;
        self.set_roads()
    }

    fn set_dwell(&mut self, value: &Value) -> Result<(), PlanError> {
        if !Dwell::deserialize(value).is_ok_and(|dwell| dwell.is_valid()) {
            return Err(PlanError::setting(
                Setting::Dwell,
                format!(
                    "invalid time {value}: give seconds, or a range such as \
                     {{\"min\": 5, \"max\": 15}}"
                ),
            ));
        }
        self.setup.load.get_or_insert_default().set_dwell(value);
        Ok(())
    }

    fn set_breakdowns(&mut self, per_hour: f64) {
        let breakdowns = &mut self.setup.disturbances.get_or_insert_default().breakdowns;
        let repair_secs =
            breakdowns.as_ref().and_then(|before| before.repair_secs.as_ref()?.as_f64());
        // None at all is what others are compared with.
        *breakdowns =
            Number::from_f64(per_hour).filter(|_| per_hour != 0.0).map(|per_hour| Breakdowns {
                per_hour,
                repair_secs: Number::from_f64(repair_secs.unwrap_or(REPAIR_SECS)),
            });
    }

    fn set_planner(&mut self, name: &str) -> Result<(), PlanError> {
        let (Manager::BuiltIn(args) | Manager::Bound(args)) = &mut self.manager else {
            return Err(PlanError::setting(
                Setting::Planner,
                "only the fleet manager has planners",
            ));
        };
        replace_planner(args, name);
        Ok(())
    }

    fn set_manager(&mut self, command: &str) -> Result<(), PlanError> {
        if command == FLEET_MANAGER {
            return Ok(());
        }
        let words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        if words.is_empty() {
            return Err(PlanError::setting(
                Setting::Manager,
                "the command is empty: give a program and its arguments",
            ));
        }
        self.manager = Manager::Command(words);
        Ok(())
    }

    /// Returns the bound: the variant in which robots drive through each other on the fastest ways,
    /// with the fleet manager as their manager. Other planners than `lanes` keep robots apart by
    /// rules of their own, so that robots would wait.
    #[must_use]
    pub fn bound(self) -> Self {
        let mut args = match self.manager {
            Manager::BuiltIn(args) | Manager::Bound(args) => args,
            Manager::Command(_) => vec![IN_TURN.to_owned()],
        };
        replace_planner(&mut args, LANES);
        Self { manager: Manager::Bound(args), ..self }
    }
}

fn number(setting: Setting, value: &Value) -> Result<f64, PlanError> {
    match value.as_f64() {
        Some(number) if number >= 0.0 && number.is_finite() => Ok(number),
        _ => Err(PlanError::setting(
            setting,
            format!("invalid number {value}: give one of at least 0"),
        )),
    }
}

fn positive(setting: Setting, value: &Value) -> Result<f64, PlanError> {
    match number(setting, value)? {
        0.0 => Err(PlanError::setting(
            setting,
            "robots that stand still carry nothing: give a number above 0",
        )),
        number => Ok(number),
    }
}

fn text(setting: Setting, value: &Value) -> Result<&str, PlanError> {
    value
        .as_str()
        .ok_or_else(|| PlanError::setting(setting, format!("invalid value {value}: give a text")))
}

/// Gives a fleet manager a planner instead of the one that it has.
fn replace_planner(args: &mut Vec<String>, name: &str) {
    if let Some(index) = args.iter().position(|arg| arg == PLANNER) {
        args.drain(index..(index + 2).min(args.len()));
    }
    args.extend([PLANNER.to_owned(), name.to_owned()]);
}
