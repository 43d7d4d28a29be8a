//! `regatta study-observe`: the readers of a study's run in one process. In lockstep each
//! additional process costs some wake-ups a tick, which with small fleets would cost more than the
//! work of the readers.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser};
use regatta_plugin::{Events, Frame, Options, Participant, Plugin, Rate, Result, World};
use regatta_validator::Kind;

use crate::failure::{Failure, plugin_failure};

#[derive(Args)]
pub struct ObserverArgs {
    /// File for the traffic on edges, as JSON
    #[arg(long, value_name = "FILE")]
    traffic: PathBuf,
    /// File for the places that robots wait for, as JSON
    #[arg(long, value_name = "FILE")]
    queues: PathBuf,
    /// File for the figures of the orders, as JSON
    #[arg(long, value_name = "FILE")]
    meter: PathBuf,
    /// File for the findings of the validator, as JSON; without it, nothing is judged
    #[arg(long, value_name = "FILE")]
    validator: Option<PathBuf>,
    /// File that is made when all are ready to read
    #[arg(long, value_name = "FILE")]
    ready: PathBuf,
    #[command(flatten)]
    options: Options,
}

/// Runs `regatta study-observe`.
pub fn run(args: &ObserverArgs) -> Result<ExitCode, Failure> {
    let mut readers: Vec<Box<dyn Plugin>> = Vec::new();
    let traffic = regatta_traffic::Cli::try_parse_from(with_json("traffic", &args.traffic))?;
    readers.push(Box::new(regatta_traffic::plugin(traffic)));
    readers.push(Box::new(regatta_traffic::queue_observer(args.queues.clone())));
    let meter = regatta_meter::Cli::try_parse_from(with_json("meter", &args.meter))?;
    readers.push(Box::new(regatta_meter::plugin(meter)));
    if let Some(file) = &args.validator {
        // Findings are figures here, and no failure.
        let kinds: Vec<_> = Kind::all().map(|kind| kind.to_string()).collect();
        let words = with_json("validator", file)
            .into_iter()
            .chain(["--allow".into(), kinds.join(",").into()]);
        readers.push(Box::new(regatta_validator::plugin(regatta_validator::Cli::try_parse_from(
            words,
        )?)));
    }
    let observers = Observers { readers, ready: args.ready.clone() };
    args.options.run(observers, "observers").map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}

fn with_json(name: &str, file: &Path) -> [OsString; 3] {
    [name.into(), "--json".into(), file.into()]
}

/// Plugins that are called one after the other.
struct Observers {
    readers: Vec<Box<dyn Plugin>>,
    /// The file whose existence means that all are ready.
    ready: PathBuf,
}

impl Plugin for Observers {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.readers.iter_mut().try_for_each(|reader| reader.on_start(fleet))?;
        // From now on, nothing that a manager writes is lost.
        Ok(std::fs::write(&self.ready, "")?)
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.readers.iter_mut().try_for_each(|reader| reader.on_world(world))
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.readers.iter_mut().try_for_each(|reader| reader.on_frame(frame))
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        self.readers.iter_mut().try_for_each(|reader| reader.on_idle(has_producer))
    }

    fn wants_events(&self) -> bool {
        self.readers.iter().any(|reader| reader.wants_events())
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        let mut wanting = self.readers.iter_mut().filter(|reader| reader.wants_events());
        wanting.try_for_each(|reader| reader.on_events(events))
    }

    fn rate(&self) -> Rate {
        Rate::EveryFrame
    }

    fn on_stop(&mut self) -> Result {
        // Each writes its figures, even if others fail.
        let ends: Vec<Result> = self.readers.iter_mut().map(|reader| reader.on_stop()).collect();
        ends.into_iter().collect()
    }
}
