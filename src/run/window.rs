//! The viewer of a run: it opens when the warm-up is over.

use std::process::Command;
use std::time::Instant;

use regatta_plugin::FleetName;
use regatta_plugin::control::ControlResponse;
use regatta_scenario::{Scenario, Viewer};

use super::{HAS_VIEWER, RunArgs, VIEWER, this_program};
use crate::control;
use crate::failure::Failure;
use crate::scenario;
use crate::supervisor::Supervisor;

/// The part of a run before its window opens.
pub(super) struct Opening {
    viewer: Option<Command>,
    /// The time at which the warm-up ended.
    warm_since: Option<Instant>,
}

impl Opening {
    /// Prepares the viewer that the scenario asks for, if there can be one. Tells the user about
    /// the warm-up, and if there is no viewer.
    pub(super) fn new(scenario: &Scenario, args: &RunArgs) -> Result<Self, Failure> {
        let warm_up = args.warm_up(scenario);
        if !warm_up.is_zero() && !args.json {
            println!(
                "warm-up: the first {:.0} s of simulated time are driven as fast as possible",
                warm_up.as_secs_f64()
            );
        }
        let viewer = match scenario.viewer {
            Viewer::Off => None,
            Viewer::Auto if !HAS_VIEWER => {
                regatta_plugin::tell!(
                    "regatta: built without the feature 'viewer'; the run continues without a \
                     viewer"
                );
                None
            }
            Viewer::Auto if !has_display() => {
                regatta_plugin::tell!("regatta: no display; the run continues without a viewer");
                None
            }
            Viewer::Auto | Viewer::On => Some(viewer_command(&args.options.fleet, scenario)?),
        };
        let warm_since = warm_up.is_zero().then(Instant::now);
        Ok(Self { viewer, warm_since })
    }

    /// The time at which the warm-up ended, or the run began without one; `None` while it goes on.
    pub(super) fn warm_since(&self) -> Option<Instant> {
        self.warm_since
    }

    /// Opens the window of a run that has no warm-up.
    pub(super) fn open_at_once(&mut self, supervisor: &mut Supervisor) -> Result<(), Failure> {
        if self.warm_since.is_some() { self.open(supervisor) } else { Ok(()) }
    }

    /// Opens the window if a status of the engine shows that the warm-up has ended.
    pub(super) fn open_if_warm(
        &mut self,
        status: &ControlResponse,
        supervisor: &mut Supervisor,
    ) -> Result<(), Failure> {
        if self.warm_since.is_some() {
            return Ok(());
        }
        if control::is_warming_up(status) {
            return Ok(());
        }
        self.warm_since = Some(Instant::now());
        self.open(supervisor)
    }

    fn open(&mut self, supervisor: &mut Supervisor) -> Result<(), Failure> {
        let Some(mut viewer) = self.viewer.take() else { return Ok(()) };
        supervisor.start(VIEWER, &mut viewer).map(drop)
    }
}

/// Whether a window can be opened.
fn has_display() -> bool {
    cfg!(any(target_os = "macos", windows))
        || ["DISPLAY", "WAYLAND_DISPLAY"]
            .into_iter()
            .any(|variable| std::env::var_os(variable).is_some_and(|value| !value.is_empty()))
}

/// The command that opens the viewer of a scenario's fleet.
pub(super) fn viewer_command(fleet: &FleetName, scenario: &Scenario) -> Result<Command, Failure> {
    let mut command = this_program()?;
    command.args(["viewer", "--fleet", &fleet.to_string()]);
    command.args(scenario::viewer_args(scenario)?);
    Ok(command)
}
