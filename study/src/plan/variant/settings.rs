//! Variants with other settings.

use std::path::Path;
use std::sync::Arc;

use regatta_layout::{EdgeChange, ReadOptions};
use regatta_scenario::{Overrides, Scenario};
use serde_json::{Value, json};

use super::{FLEET_MANAGER, IN_TURN, PLANNER, Variant};
use crate::job::Manager;
use crate::plan::{PlanError, Setting};

/// The time to repair if the scenario says none, in seconds.
const REPAIR_SECS: f64 = 300.0;

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
        let number = || match value.as_f64() {
            Some(number) if number >= 0.0 && number.is_finite() => Ok(number),
            _ => Err(PlanError::setting(
                setting,
                format!("invalid number {value}: give one of at least 0"),
            )),
        };
        let positive = || match number()? {
            0.0 => Err(PlanError::setting(
                setting,
                "robots that stand still carry nothing: give a number above 0",
            )),
            number => Ok(number),
        };
        let text = || {
            value.as_str().ok_or_else(|| {
                PlanError::setting(setting, format!("invalid value {value}: give a text"))
            })
        };
        match setting {
            Setting::Layout => self.take_layout(Path::new(text()?), options)?,
            Setting::Type => self.types = vec![(Some(self.known_type(text()?)?), 1.0)],
            Setting::MaxSpeed => self.limit_types("max_speed", positive()?)?,
            Setting::MaxAcceleration => self.limit_types("max_acceleration", positive()?)?,
            Setting::SpeedFactor => {
                let factor = positive()?;
                let ids: Vec<u32> = self.graph.edges().iter().map(|edge| edge.id).collect();
                self.change(&ids, EdgeChange::Speed(factor))?;
            }
            Setting::Load => self.take_load(value)?,
            Setting::Dwell => self.dwell(value)?,
            Setting::Closed => {
                let ids: Vec<u32> = serde_json::from_value(value.clone()).map_err(|_| {
                    PlanError::setting(
                        setting,
                        format!("invalid edges {value}: give a list of ids, such as [3,4]"),
                    )
                })?;
                self.change(&ids, EdgeChange::Close)?;
            }
            Setting::BreakdownsPerHour => self.break_down(number()?),
            Setting::Planner => match &mut self.manager {
                Manager::BuiltIn(args) | Manager::Bound(args) => {
                    // The scenario's own gives way.
                    if let Some(index) = args.iter().position(|arg| arg == PLANNER) {
                        args.drain(index..(index + 2).min(args.len()));
                    }
                    args.extend([PLANNER.to_owned(), text()?.to_owned()]);
                }
                Manager::Command(_) => {
                    return Err(PlanError::setting(setting, "only the fleet manager has planners"));
                }
            },
            Setting::Manager => self.manage(text()?)?,
        }
        Ok(self)
    }

    fn take_layout(&mut self, path: &Path, options: &ReadOptions) -> Result<(), PlanError> {
        let overrides = Overrides { layout: options.clone(), ..Overrides::default() };
        (self.graph, self.file) = (Scenario::read(path, &overrides)?.graph, path.to_owned());
        // Its stations are other ones.
        if self.is_load_made_up { self.make_load_up() } else { Ok(()) }
    }

    fn known_type(&self, name: &str) -> Result<String, PlanError> {
        let types = self.scenario["robot_types"].as_array().into_iter().flatten();
        let names: Vec<&str> = types.filter_map(|kind| kind["name"].as_str()).collect();
        match names.contains(&name) {
            true => Ok(name.to_owned()),
            false => Err(PlanError::setting(
                Setting::Type,
                format!("unknown type '{name}': there are {}", names.join(", ")),
            )),
        }
    }

    fn limit_types(&mut self, key: &str, value: f64) -> Result<(), PlanError> {
        let Some(types) = self.scenario["robot_types"].as_array_mut() else {
            return Err(PlanError::setting(
                key,
                "the scenario has no robot_types to change: add one",
            ));
        };
        types.iter_mut().for_each(|kind| kind[key] = value.into());
        Ok(())
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
            return Err(PlanError::setting(
                Setting::Manager,
                "the command is empty: give a program and its arguments",
            ));
        }
        self.manager = Manager::Command(words);
        Ok(())
    }

    /// Returns the variant in which robots drive through each other, whoever steers them: the
    /// bound.
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
        self.graph = Arc::new(
            changed.map_err(|error| PlanError::Change { file: self.file.clone(), error })?,
        );
        Ok(())
    }
}
