//! The plugin: frames and the order log in, a file with figures out.

#[cfg(feature = "shared-memory")]
use std::ffi::OsString;
use std::path::PathBuf;

use clap::Parser;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::{
    ColumnReader, Error, Frame, Options, OrderReader, Participant, Plugin, ReadError, Result,
};

use crate::meter::{Figures, Meter};

/// The command line of `regatta plugin meter`.
#[derive(Clone, Debug, Parser)]
#[command(
    about = "Measure the throughput of the fleet: orders, their times, and the effort of robots"
)]
pub struct Cli {
    /// At the end, write the figures to this file as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: PathBuf,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// If an option is invalid, the file can't be written, or as [`regatta_plugin::run`] does.
#[cfg(feature = "shared-memory")]
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    regatta_kit::run_from(args, |cli: Cli| {
        let options = cli.options.clone();
        options.run(plugin(cli), "meter")
    })
}

/// Returns the plugin of a command line, to run it beside others in one process.
pub fn plugin(cli: Cli) -> impl Plugin {
    MeterProgram { cli, metering: Metering::default() }
}

/// The plugin that measures a fleet. Its figures are those of the run so far.
#[derive(Default)]
pub struct Metering {
    orders: Option<OrderReader>,
    activities: Option<ColumnReader>,
    meter: Meter,
}

impl Metering {
    /// Returns the figures of the run so far.
    pub fn figures(&self) -> Figures {
        self.meter.figures()
    }

    /// Takes a frame, with the newest activities.
    fn take_frame(&mut self, frame: &Frame<'_>) -> Result {
        let newest = match &mut self.activities {
            Some(column) => {
                column.latest()?;
                column.current()?
            }
            None => None,
        };
        let activities = newest.map_or(&[][..], |newest| newest.values);
        self.meter.take_frame(&frame.columns(), activities, frame.tick());
        Ok(())
    }

    /// Takes the new records of the order log.
    fn take_orders(&mut self) -> Result {
        let Some(orders) = &mut self.orders else { return Ok(()) };
        orders.take(|orders| {
            let header = orders.header;
            self.meter.take_orders(orders.records, header.sequence, orders.missed, header.tick);
            Ok::<_, ReadError>(())
        })?;
        Ok(())
    }
}

impl Plugin for Metering {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.orders = Some(OrderReader::open_on(fleet)?);
        self.activities = Some(ColumnReader::open_on(fleet, ACTIVITY.name())?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        let header = frame.header();
        self.meter.begin(header.run_id, header.tick_period_nanos as f64 * 1e-9);
        self.take_frame(frame)?;
        self.take_orders()
    }
}

/// The program: it writes the figures to a file at the end.
struct MeterProgram {
    cli: Cli,
    metering: Metering,
}

impl Plugin for MeterProgram {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.metering.on_start(fleet)
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.metering.on_frame(frame)
    }

    fn on_stop(&mut self) -> Result {
        let figures = serde_json::to_vec(&self.metering.figures())
            .map_err(|error| self.unwritable(&error))?;
        std::fs::write(&self.cli.json, figures).map_err(|error| self.unwritable(&error))
    }
}

impl MeterProgram {
    fn unwritable(&self, error: &dyn std::fmt::Display) -> Error {
        Error::new(format_args!(
            "can't write {} ({error}); choose another file",
            self.cli.json.display()
        ))
    }
}
