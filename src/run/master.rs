//! `regatta master`: the fleet manager steers vehicles of VDA 5050 that others have on a broker.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use regatta_plugin::FleetName;
use regatta_scenario::{PluginCommand, Scenario};
use regatta_vda5050::master::{MasterOptions, VehiclesOptions};

use super::{FLEET_MANAGER, RunArgs, VDA5050};
use crate::arguments::{LayoutArgs, Time};
use crate::day::DayArgs;
use crate::engine::EngineOptions;
use crate::failure::Failure;
use crate::trust::TrustArgs;

/// The time in seconds from a vehicle's position until an order that answers it takes effect: its
/// position may be a fifth of a second old, and the manager's cycle and the way there and back take
/// about as long.
const LATENCY_SECS: f32 = 0.5;

#[derive(Args)]
pub struct MasterArgs {
    /// Scenario or layout file of the plant.
    #[arg(value_hint = clap::ValueHint::FilePath)]
    plant: PathBuf,
    /// Options of the fleet manager (see regatta plugin fleet-manager --help).
    #[arg(last = true, value_name = "OPTIONS")]
    manager: Vec<String>,
    #[command(flatten)]
    vehicles: VehiclesOptions,
    /// Carry the made-up orders that a layout gets without a scenario.
    #[arg(long)]
    made_up_load: bool,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    trust: TrustArgs,
    #[command(flatten)]
    day: DayArgs,
    /// Stop after this time: 10 (seconds), 5min, 1h …
    #[arg(long = "for", value_name = "TIME", help_heading = "End of the run")]
    time_limit: Option<Time>,
    /// Print JSON: a line about the fleet, then its status once per second.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// The vehicles of a run, in the place of an engine.
#[derive(Debug)]
pub(super) struct Vehicles {
    options: VehiclesOptions,
    manager: Vec<String>,
    is_load_made_up: bool,
}

/// Runs `regatta master`.
pub fn run(args: MasterArgs) -> Result<ExitCode, Failure> {
    let fleet = args.vehicles.fleet.clone();
    super::run(RunArgs {
        scenario: Some(args.plant),
        options: EngineOptions { fleet, layout: args.layout, ..EngineOptions::default() },
        trust: args.trust,
        day: args.day,
        time_limit: args.time_limit,
        json: args.json,
        vehicles: Some(Vehicles {
            options: args.vehicles,
            manager: args.manager,
            is_load_made_up: args.made_up_load,
        }),
        ..RunArgs::default()
    })
}

impl Vehicles {
    /// Prepares a scenario: its fleet manager, which is added if there is none, steers vehicles. A
    /// layout without a scenario has no load, unless that was asked for.
    pub(super) fn prepare(&self, scenario: &mut Scenario) {
        scenario.plugins.retain(|plugin| plugin.name != VDA5050);
        if scenario.plugins.iter().all(|plugin| plugin.name != FLEET_MANAGER) {
            let name = FLEET_MANAGER.to_owned();
            scenario.plugins.push(PluginCommand { name, ..PluginCommand::default() });
        }
        for plugin in scenario.plugins.iter_mut().filter(|plugin| plugin.name == FLEET_MANAGER) {
            plugin.args.push("--whole-edges".to_owned());
            let is_told = |arg: &String| arg.starts_with("--latency");
            if !plugin.args.iter().chain(&self.manager).any(is_told) {
                plugin.args.push(format!("--latency={LATENCY_SECS}"));
            }
            plugin.args.extend(self.manager.iter().cloned());
        }
    }

    /// Whether the load of a scenario is carried.
    pub(super) fn carries_load(&self, scenario: &Scenario) -> bool {
        self.is_load_made_up || !scenario.is_default
    }

    /// The arguments of the process that publishes the vehicles, after the plant.
    pub(super) fn to_args(&self, fleet: &FleetName, layout: &LayoutArgs) -> Vec<String> {
        let mut args = vec![format!("--fleet={fleet}"), format!("--rate={}", self.options.rate)];
        args.extend(self.options.master.to_args());
        args.extend(layout.to_args());
        args
    }

    /// The vehicles, in words.
    pub(super) fn in_words(&self) -> String {
        let MasterOptions { broker, vehicles, .. } = &self.options.master;
        let broker = broker.as_ref().map_or_else(String::new, ToString::to_string);
        format!("{} on {broker}", vehicles.join(", "))
    }
}
