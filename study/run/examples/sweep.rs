//! Prints the orders that 2, 4, 8 … robots carry in half an hour. Each run takes place in this
//! process.
//!
//! ```console
//! $ cargo run --release -p regatta-run --example sweep -- graphs/warehouse-charging.yaml
//! ```

use std::path::PathBuf;
use std::time::Duration;

use clap::Parser;
use regatta_meter::Metering;
use regatta_plugin::{Error, Result};
use regatta_run::Run;
use regatta_scenario::{Overrides, Scenario};
use regatta_validator::{Settings, Validator};

const HALF_AN_HOUR: Duration = Duration::from_secs(1800);

fn main() -> Result {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(Error::new(
            "give a scenario with a load, such as graphs/warehouse-charging.yaml",
        ));
    };
    println!("robots  orders  findings  times real time");
    for robots in [2, 4, 8, 16, 32] {
        let scenario = Scenario::read(&path, &Overrides::default())?;
        let words = ["fleet-manager".as_ref(), "--load".as_ref(), path.as_os_str()];
        let manager = regatta_fleet_manager::Cli::try_parse_from(words)?;
        let (mut meter, mut validator) = (Metering::default(), Validator::new(Settings::default()));
        let summary = Run::new(scenario)
            .robots(robots)
            .with_named("fleet-manager", &[], regatta_fleet_manager::plugin(manager)?)
            .with_named("meter", &["fleet-manager"], &mut meter)
            .with_named("validator", &["fleet-manager"], &mut validator)
            .for_simulated(HALF_AN_HOUR)?;
        let orders = meter.figures().finished.len();
        let findings: u64 = validator.take_report().found().map(|found| found.count).sum();
        let factor = summary.sim_time.as_secs_f64() / summary.wall_time.as_secs_f64();
        println!("{robots:>6}  {orders:>6}  {findings:>8}  {factor:>15.0}");
    }
    Ok(())
}
