//! The life of a plugin's process.

use std::ffi::OsString;
use std::path::Path;
use std::time::{Duration, Instant};

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser};

use crate::error::{Error, Result};
use crate::event_reader::EventReader;
use crate::fleet_name::FleetName;
use crate::frame::Frame;
use crate::lockstep::Reporter;
use crate::participant::{Participant, set_verbosity};
use crate::plugin::{Plugin, Rate};
use crate::subscribe::{Subscriber, WorldReader};
use crate::termination::Termination;

/// The command line that every plugin has. A plugin with options of its own flattens these into them
/// (`#[command(flatten)]`) and calls [`run`](Self::run).
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// The fleet to read
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Frames per second to look at, or 'all' [default: as the plugin wants]
    #[arg(long, value_name = "N")]
    pub rate: Option<Rate>,
    /// The name to go by, in lockstep and in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Show warnings of shared memory (iceoryx2); twice for all of its log
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

/// Runs a plugin until Ctrl-C or `SIGTERM`, with the options on this process's command line.
///
/// Waits for an engine that isn't there yet, and goes on when the engine is replaced.
///
/// # Errors
/// If an option is wrong, shared memory can't be used, the fleet speaks another version of the contract, or
/// one of the plugin's functions returns an error.
pub fn run(plugin: impl Plugin) -> Result {
    run_from(plugin, std::env::args_os())
}

/// The same with a command line from elsewhere. Its first argument is the program (`regatta plugin hello`, say),
/// whose last word is the plugin's name unless `--name` gives one.
///
/// # Errors
/// As [`run`].
pub fn run_from<A: Into<OsString> + Clone>(plugin: impl Plugin, args: impl IntoIterator<Item = A>) -> Result {
    let args: Vec<OsString> = args.into_iter().map(Into::into).collect();
    let program = args.first().and_then(|path| Path::new(path).file_stem()?.to_str()).unwrap_or("plugin").to_owned();
    let command = Cli::command().bin_name(&program).about("A Regatta plugin: reads the frames of a fleet");
    let parsed = command.try_get_matches_from(args).and_then(|matches| Cli::from_arg_matches(&matches));
    match parsed {
        Ok(cli) => cli.options.run(plugin, program.rsplit(' ').next().unwrap_or(&program)),
        Err(error) if error.kind() == ErrorKind::DisplayHelp => Ok(error.print()?),
        Err(error) => Err(one_line(&error)),
    }
}

/// Clap's first line; the rest (usage, and a pointer to `--help`) fits no single line.
fn one_line(error: &clap::Error) -> Error {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
    Error::new(format_args!("{first}; --help lists the options"))
}

impl Options {
    /// Runs a plugin with these options. `program` is its name, unless `--name` gives one.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&self, mut plugin: impl Plugin, program: &str) -> Result {
        set_verbosity(self.verbose);
        let termination = Termination::watch()?;
        let given = std::env::var(NAME_VARIABLE).ok();
        let name = self.name.as_deref().or(given.as_deref()).unwrap_or(program);
        let participant = Participant::join(&self.fleet, name)?;
        let rate = self.rate.unwrap_or_else(|| plugin.rate());
        let result = Runner::open(&participant, &plugin, rate).and_then(|mut runner| {
            plugin.on_start(&participant)?;
            while !termination.requested() {
                runner.turn(&mut plugin)?;
            }
            Ok(())
        });
        result.and(plugin.on_stop())
    }
}

/// Environment variable with the name that a plugin goes by unless `--name` says otherwise: `regatta run` sets it to
/// the name in the scenario.
pub const NAME_VARIABLE: &str = "REGATTA_PLUGIN_NAME";

/// Longest sleep between two looks at the termination flag.
const SLICE: Duration = Duration::from_millis(100);
/// Without frames for so long, look whether there is an engine at all.
const SILENCE: Duration = Duration::from_secs(1);
/// How long to wait for the world that a frame names.
const WORLD_WAIT: Duration = Duration::from_millis(500);

struct Runner {
    worlds: WorldReader,
    frames: Subscriber,
    events: Option<EventReader>,
    reporter: Option<Reporter>,
    pace: Pace,
    silence: Silence,
    /// Run and tick of the last frame.
    last: (u64, u64),
}

impl Runner {
    fn open(participant: &Participant, plugin: &impl Plugin, rate: Rate) -> Result<Self> {
        Ok(Self {
            worlds: WorldReader::open_on(participant)?,
            frames: Subscriber::open_on(participant)?,
            events: plugin.wants_events().then(|| EventReader::open_on(participant)).transpose()?,
            reporter: None,
            pace: Pace::new(rate),
            silence: Silence { since: Instant::now(), said: false },
            last: (0, u64::MAX),
        })
    }

    /// Waits for a frame, for a [`SLICE`] at most, and hands it to the plugin.
    fn turn(&mut self, plugin: &mut impl Plugin) -> Result {
        if !self.pace.sleep() {
            return Ok(());
        }
        if self.frames.wait(SLICE)?.is_none() {
            self.silence.look(&self.frames);
            return plugin.on_idle(self.frames.has_producer());
        }
        self.silence.end();
        let Some(frame) = self.frames.current()? else { return Ok(()) };
        hand_over_world(&mut self.worlds, &frame, plugin)?;
        if let Some(events) = &mut self.events {
            events.take(|events| plugin.on_events(events))?;
        }
        let this = (frame.run_id(), frame.tick());
        // In lockstep once per tick: whether a frame that was published again is seen would depend on who is faster.
        let again = frame.header().lockstep != 0 && self.last == this;
        self.last = this;
        if !again && self.pace.is_due(&frame) {
            plugin.on_frame(&frame)?;
        }
        if frame.header().lockstep != 0 {
            report(&mut self.reporter, &self.frames, &frame)?;
        }
        self.frames.release();
        Ok(())
    }
}

fn report(reporter: &mut Option<Reporter>, frames: &Subscriber, frame: &Frame<'_>) -> Result {
    let reporter = match reporter {
        Some(reporter) => reporter,
        None => reporter.insert(Reporter::open_on(frames.participant())?),
    };
    Ok(reporter.done(frame.run_id(), frame.tick())?)
}

/// Hands over a new world, if there is one. A process that joins just now can have its first frame some
/// moments before the world that it names.
fn hand_over_world(worlds: &mut WorldReader, frame: &Frame<'_>, plugin: &mut impl Plugin) -> Result {
    let wanted = (frame.run_id(), frame.header().world_revision);
    let start = Instant::now();
    loop {
        if let Some(world) = worlds.latest()? {
            plugin.on_world(&world)?;
        }
        let have = worlds.current()?.map(|world| (world.run_id(), world.revision()));
        let current = have.is_some_and(|have| have.0 == wanted.0 && have.1 >= wanted.1);
        if current || wanted.1 == 0 || start.elapsed() > WORLD_WAIT {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Keeps to the wanted rate: by the wall clock, or in lockstep by simulated time so that runs repeat.
struct Pace {
    period: Duration,
    wall: Instant,
    lockstep: bool,
    run_id: u64,
    simulated: Duration,
}

impl Pace {
    fn new(rate: Rate) -> Self {
        Self { period: rate.period(), wall: Instant::now(), lockstep: false, run_id: 0, simulated: Duration::ZERO }
    }

    /// Sleeps until the next frame is due, for a [`SLICE`] at most. Whether it is due.
    fn sleep(&self) -> bool {
        let left = self.wall.saturating_duration_since(Instant::now());
        if self.lockstep || left.is_zero() {
            return true;
        }
        std::thread::sleep(left.min(SLICE));
        left <= SLICE
    }

    fn is_due(&mut self, frame: &Frame<'_>) -> bool {
        self.lockstep = frame.header().lockstep != 0;
        let now = Instant::now();
        // Behind by more than a period: don't hurry to catch up.
        self.wall = (self.wall + self.period).max(now.checked_sub(self.period).unwrap_or(now));
        if frame.run_id() != self.run_id {
            (self.run_id, self.simulated) = (frame.run_id(), frame.sim_time());
        }
        if self.lockstep && frame.sim_time() < self.simulated {
            return false;
        }
        self.simulated = (self.simulated + self.period).max(frame.sim_time().saturating_sub(self.period));
        true
    }
}

/// Says once, on stderr, that there is no engine.
struct Silence {
    since: Instant,
    said: bool,
}

impl Silence {
    fn look(&mut self, frames: &Subscriber) {
        if self.said || self.since.elapsed() < SILENCE {
            return;
        }
        self.since = Instant::now();
        frames.forget_dead();
        if !frames.has_producer() {
            let participant = frames.participant();
            crate::tell!("{}: waiting for an engine of fleet '{}'", participant.name(), participant.fleet());
            self.said = true;
        }
    }

    fn end(&mut self) {
        *self = Self { since: Instant::now(), said: false };
    }
}
