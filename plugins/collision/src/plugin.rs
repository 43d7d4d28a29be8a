//! The plugin: every frame goes through the detector; what it finds is published, logged and summed up.

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_plugin::contact::ContactHeader;
use regatta_plugin::frame::ClockState;
use regatta_plugin::{
    ColumnPublisher, ColumnReader, ContactPublisher, Error, Frame, Options, Participant, Plugin, Rate, Result, World,
};

use crate::detector::{Detector, Scene};
use crate::log::{Change, Log};
use crate::settings::Settings;
use crate::skips::Skips;
use crate::summary;

/// The column that it publishes: 0 clear, 1 possible, 2 touching.
pub const COLUMN: &str = "collision";

/// How long to wait for the robots' types at the start of a run. A producer that has none to tell is read without.
const TYPES_WAIT: Duration = Duration::from_millis(500);

/// The command line of `regatta plugin collision`.
#[derive(Clone, Debug, Parser)]
#[command(about = "Marks robots that collide, now or soon, as the column 'collision'")]
pub struct Cli {
    /// Robots nearer than this may collide, in metres
    #[arg(long, value_name = "METRES", default_value_t = 0.2, allow_negative_numbers = true)]
    pub margin: f32,
    /// So may those that will touch within this time if both go on as they do, in seconds; 0 looks at the present alone
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, allow_negative_numbers = true)]
    pub horizon: f32,
    /// Add a line for each begin and end of a contact or a warning to this file
    #[arg(long, value_name = "FILE.csv")]
    pub log: Option<PathBuf>,
    /// At the end of a run, print totals, and the ten worst pairs, robots and edges
    #[arg(long)]
    pub summary: bool,
    /// What every plugin takes.
    #[command(flatten)]
    pub options: Options,
}

/// Runs the plugin with a command line, whose first argument is the program.
///
/// # Errors
/// If an option is wrong, the log can't be written, or as [`regatta_plugin::run`]; among them that the fleet has such
/// a plugin already.
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    match Cli::try_parse_from(args) {
        Ok(cli) => cli.options.run(Watch::new(&cli)?, "collision"),
        Err(error) if !error.use_stderr() => Ok(error.print()?),
        Err(error) => Err(first_line(&error)),
    }
}

/// What is wrong; the usage that clap adds fits no single line.
fn first_line(error: &clap::Error) -> Error {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
    Error::new(format_args!("{first}; --help lists the options"))
}

/// A line to standard error. Nobody reads it: no reason to end.
fn tell(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "collision: {line}");
}

/// Ports into the fleet, from its start on.
struct Ports {
    types: ColumnReader,
    column: ColumnPublisher,
    contacts: ContactPublisher,
}

/// The plugin.
struct Watch {
    detector: Detector,
    ports: Option<Ports>,
    log: Option<Log>,
    summary: bool,
    skips: Skips,
    /// Ids of the world's edges, by index.
    edges: Vec<u32>,
    /// How many robot types the world has.
    kinds: usize,
    /// The last frame's run, and its simulated time in nanoseconds.
    last: Option<(u64, u64)>,
    told: Told,
}

/// What was told already in this run.
#[derive(Default)]
struct Told {
    capped: bool,
    unplaced: bool,
    summary: bool,
}

impl Watch {
    fn new(cli: &Cli) -> Result<Self> {
        let every_frame = cli.options.rate.is_none_or(|rate| rate == Rate::EveryFrame);
        Ok(Self {
            detector: Detector::new(Settings::new(cli.margin, cli.horizon)?),
            ports: None,
            log: cli.log.as_deref().map(Log::open).transpose()?,
            summary: cli.summary,
            skips: Skips::new(every_frame),
            edges: Vec::new(),
            kinds: 0,
            last: None,
            told: Told::default(),
        })
    }

    /// Another run: what is known of the last one is told, and forgotten.
    fn begin_run(&mut self, frame: &Frame<'_>) -> Result {
        self.end_run();
        self.told = Told::default();
        if self.kinds <= 1 {
            // There is nothing to choose from: a UDP source, say, whose robots are yet to come.
            return Ok(());
        }
        let start = Instant::now();
        let Some(ports) = &mut self.ports else { return Ok(()) };
        while ports.types.latest()?.is_none()
            && ports.types.current()?.is_none_or(|old| old.header.run_id != frame.run_id())
        {
            if start.elapsed() > TYPES_WAIT {
                tell("nobody publishes the column 'type': all robots count as the first robot type");
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }

    fn end_run(&mut self) {
        let Some((_, nanos)) = self.last else { return };
        if self.summary && !std::mem::replace(&mut self.told.summary, true) {
            print!("{}", summary::of(&self.detector, &self.edges, nanos));
        }
    }

    fn publish(&mut self, frame: &Frame<'_>) -> Result {
        let Self { detector, ports, log, edges, skips, .. } = self;
        let Some(ports) = ports else { return Ok(()) };
        let (all, pairs) = (detector.tally().all(), detector.contacts());
        ports.column.publish(frame, detector.levels())?;
        if !detector.events().is_empty() {
            ports.contacts.publish_events(frame.run_id(), frame.tick(), detector.events())?;
        }
        let header = ContactHeader {
            run_id: frame.run_id(),
            tick: frame.tick(),
            sim_time_nanos: frame.header().sim_time_nanos,
            touching_ever: all.contacts,
            possible_ever: all.warnings,
            frames_skipped: skips.count(),
            touching: detector.touching() as u32,
            possible: (pairs.len() - detector.touching()) as u32,
            capped: u32::from(detector.is_capped()),
            ..ContactHeader::default()
        };
        ports.contacts.publish(&header, pairs)?;
        match log.as_mut().and_then(|log| log.add(frame.run_id(), detector.events(), edges)) {
            Some(Change::Failed(error)) => tell(format_args!("{error}; events are lost until it can be written")),
            Some(Change::Recovered(lost)) => tell(format_args!("the log can be written again; {lost} events are lost")),
            None => {}
        }
        Ok(())
    }

    /// Says once per run what a person should know about how well it goes.
    fn tell_limits(&mut self) {
        if self.detector.is_capped() && !std::mem::replace(&mut self.told.capped, true) {
            tell("so many robots are so close that not all pairs are looked at");
        }
        let unplaced = self.detector.unplaced();
        if unplaced > 0 && !std::mem::replace(&mut self.told.unplaced, true) {
            tell(format_args!("{unplaced} robots have no pose or footprint that can be checked"));
        }
    }
}

impl Plugin for Watch {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        let column = ColumnPublisher::open_on(fleet, COLUMN)?;
        let contacts = ContactPublisher::open_on(fleet)?;
        self.ports = Some(Ports { types: ColumnReader::open_on(fleet, "type")?, column, contacts });
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.detector.set_world(world.edges(), world.robot_types());
        self.edges = world.edges().iter().map(|edge| edge.id).collect();
        self.kinds = world.robot_types().len();
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if self.last.is_none_or(|(run, _)| run != frame.run_id()) {
            self.begin_run(frame)?;
        }
        if let Some(line) = self.skips.see(frame.run_id(), frame.tick()) {
            tell(line);
        }
        let Some(ports) = &mut self.ports else { return Ok(()) };
        ports.types.latest()?;
        let types = ports.types.current()?.map_or(&[][..], |types| types.values);
        let (run_id, tick, sim_time_nanos) = (frame.run_id(), frame.tick(), frame.header().sim_time_nanos);
        self.detector.look(&Scene { run_id, tick, sim_time_nanos, columns: frame.columns(), types });
        self.publish(frame)?;
        self.tell_limits();
        self.last = Some((run_id, sim_time_nanos));
        if frame.header().clock == ClockState::Stopped as u32 {
            self.end_run();
        }
        Ok(())
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        if let Some(ports) = &self.ports {
            ports.column.update();
            ports.contacts.update();
        }
        Ok(())
    }

    fn on_stop(&mut self) -> Result {
        self.end_run();
        if self.skips.count() > 0 {
            tell(format_args!(
                "{} frames of the last run were not seen: too slow for them, or they were never published",
                self.skips.count()
            ));
        }
        if let Some(log) = self.log.as_ref().filter(|log| log.lost() > 0) {
            tell(format_args!("{} events are missing in {}", log.lost(), log.path().display()));
        }
        Ok(())
    }
}
