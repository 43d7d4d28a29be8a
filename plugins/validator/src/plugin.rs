//! The plugin: reads a fleet and feeds the judge.

#[cfg(feature = "shared-memory")]
use std::ffi::OsString;
use std::io::Write as _;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_plugin::column::{ACTIVITY, TYPE};
use regatta_plugin::{
    ColumnReader, Events, Frame, Options, OrderReader, Participant, Plugin, ReadError, Result,
    World, visible,
};
#[cfg(feature = "shared-memory")]
use regatta_plugin::{Error, usage_line};

use crate::judge::{Judge, Settings};
use crate::options::JudgeOptions;
use crate::report::Report;

/// The longest wait for the column `type` at the start of a run.
const TYPES_WAIT: Duration = Duration::from_secs(2);

/// The command line of `regatta plugin validator`.
#[derive(Clone, Debug, Parser)]
#[command(max_term_width = 100)]
#[command(about = "Validate the fleet: contacts, motion, orders; fail if there are findings")]
pub struct Cli {
    /// Options of the judgement and its report.
    #[command(flatten)]
    pub judge: JudgeOptions,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// If an option is invalid, if the fleet can't be read, if the report can't be written, or if there
/// are findings.
#[cfg(feature = "shared-memory")]
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    match Cli::try_parse_from(args) {
        Ok(cli) => cli.options.clone().run(plugin(cli), "validator"),
        Err(error) if !error.use_stderr() => Ok(error.print()?),
        Err(error) => {
            Err(Error::new(format_args!("{}; --help lists the options", usage_line(&error))))
        }
    }
}

/// Returns the plugin of a command line, to run it beside others in one process.
pub fn plugin(cli: Cli) -> impl Plugin {
    let options = cli.judge;
    ValidatorProgram { validator: Validator::new(options.settings()), options }
}

/// The plugin that validates a fleet.
pub struct Validator {
    settings: Settings,
    judge: Judge,
    ports: Option<Ports>,
    run_id: u64,
    robot_types: usize,
}

/// The ports beside frames and events.
struct Ports {
    types: ColumnReader,
    activities: ColumnReader,
    orders: OrderReader,
}

impl Validator {
    /// Creates a validator that has seen nothing.
    pub fn new(settings: Settings) -> Self {
        Self { settings, judge: Judge::new(settings), ports: None, run_id: 0, robot_types: 0 }
    }

    /// The number of times so far in which robots with orders made no progress.
    pub fn stalls(&self) -> u64 {
        self.judge.stalls()
    }

    /// Ends the judgement, and returns its report.
    pub fn take_report(&mut self) -> Report {
        std::mem::replace(&mut self.judge, Judge::new(self.settings)).finish()
    }

    /// Gives the judge the robots' types. At the start of a run they may arrive shortly after the
    /// first frame.
    fn take_types(&mut self, frame: &Frame<'_>) -> Result {
        let Some(Ports { types, .. }) = &mut self.ports else { return Ok(()) };
        if std::mem::replace(&mut self.run_id, frame.run_id()) != frame.run_id()
            && self.robot_types > 1
        {
            let start = Instant::now();
            while types.latest()?.is_none()
                && types.current()?.is_none_or(|old| old.header.run_id != frame.run_id())
                && start.elapsed() < TYPES_WAIT
            {
                std::thread::sleep(Duration::from_millis(1));
            }
            if let Some(types) = types.current()? {
                self.judge.take_types(types.values);
            }
        }
        if let Some(types) = types.latest()? {
            self.judge.take_types(types.values);
        }
        Ok(())
    }

    fn take_activities(&mut self) -> Result {
        let Some(Ports { activities, .. }) = &mut self.ports else { return Ok(()) };
        if let Some(sample) = activities.latest()? {
            self.judge.take_activities(sample.values);
        }
        Ok(())
    }

    fn take_orders(&mut self) -> Result {
        let Some(Ports { orders, .. }) = &mut self.ports else { return Ok(()) };
        orders.take(|orders| {
            self.judge.take_orders(orders.header, orders.missed, orders.records);
            Ok::<_, ReadError>(())
        })?;
        Ok(())
    }
}

impl Plugin for Validator {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.ports = Some(Ports {
            types: ColumnReader::open_on(fleet, TYPE.name())?,
            activities: ColumnReader::open_on(fleet, ACTIVITY.name())?,
            orders: OrderReader::open_on(fleet)?,
        });
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.robot_types = world.robot_types().len();
        self.judge.take_world(world);
        Ok(())
    }

    fn wants_events(&self) -> bool {
        true
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        self.judge.take_events(events.header, events.records, events.missed > 0);
        self.take_orders()
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.take_types(frame)?;
        self.take_activities()?;
        self.judge.take_frame(frame);
        self.take_orders()
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        self.take_orders()
    }

    fn on_stop(&mut self) -> Result {
        self.take_orders()
    }
}

/// The program: it prints and writes the report at the end, and fails if there are findings.
struct ValidatorProgram {
    options: JudgeOptions,
    validator: Validator,
}

impl Plugin for ValidatorProgram {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.validator.on_start(fleet)
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.validator.on_world(world)
    }

    fn wants_events(&self) -> bool {
        self.validator.wants_events()
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        self.validator.on_events(events)
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.validator.on_frame(frame)
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        self.validator.on_idle(has_producer)
    }

    fn on_stop(&mut self) -> Result {
        self.validator.on_stop()?;
        let report = self.validator.take_report();
        // A closed standard output isn't a finding.
        let _ = write!(std::io::stdout(), "{}", visible(&report.to_string()));
        Ok(self.options.conclude(&report)?)
    }
}
