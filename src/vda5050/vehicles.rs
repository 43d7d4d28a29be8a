//! `regatta vda5050 vehicles`: publishes the vehicles that others have on a broker as a fleet.

use std::path::PathBuf;

use clap::Args;
use regatta_engine::engine::scenario_world;
use regatta_scenario::Overrides;
use regatta_vda5050::master::{self, VehiclesOptions};

use crate::arguments::LayoutArgs;
use crate::failure::{Failure, plugin_failure};
use crate::scenario::{self, Demo};

/// Options of `regatta vda5050 vehicles`.
#[derive(Args, Debug)]
pub struct VehiclesArgs {
    /// Scenario or layout file of the plant, - for standard input
    #[arg(value_hint = clap::ValueHint::FilePath)]
    plant: PathBuf,
    #[command(flatten)]
    options: VehiclesOptions,
    #[command(flatten)]
    layout: LayoutArgs,
}

/// Runs `regatta vda5050 vehicles`.
pub fn run(args: &VehiclesArgs) -> Result<(), Failure> {
    let overrides = Overrides { layout: args.layout.options(), ..Overrides::default() };
    let scenario = scenario::load(Some(&args.plant), Demo::Unmanaged, &overrides)?;
    scenario::tell_warnings(&scenario);
    master::run(scenario_world(&scenario), &args.options).map_err(plugin_failure)
}
