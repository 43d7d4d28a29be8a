//! The life of a plugin's process.

use std::ffi::OsString;
use std::path::Path;
use std::time::{Duration, Instant};

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser};

use super::join::Participant;
use super::log::set_verbosity;
use super::plugin::Plugin;
use super::rate::{Rate, RateLimiter};
use super::silence::{SILENCE, Silence};
use super::termination::Termination;
use super::usage::usage_line;
use crate::error::{Error, Result};
use crate::ports::events::EventReader;
use crate::ports::frames::Subscriber;
use crate::ports::lockstep::{DoneReports, Reporter};
use crate::ports::worlds::WorldReader;
use crate::records::frame::Frame;
use crate::records::name::{FleetName, NameError};

/// The command-line options of every plugin. A plugin with options of its own flattens these into
/// them (`#[command(flatten)]`) and calls [`run`](Self::run).
///
/// ```no_run
/// use clap::Parser;
/// use regatta_plugin::{Frame, Options, Plugin, Result};
///
/// #[derive(Parser)]
/// struct Cli {
///     /// The speed above which a robot is reported, in metres per second
///     #[arg(long, default_value_t = 1.0)]
///     limit: f32,
///     #[command(flatten)]
///     options: Options,
/// }
///
/// struct Watch(f32);
///
/// impl Plugin for Watch {
///     fn on_frame(&mut self, frame: &Frame) -> Result {
///         let fast = frame.speed().iter().filter(|speed| **speed > self.0).count();
///         println!("tick {}: {fast} robots are fast", frame.tick());
///         Ok(())
///     }
/// }
///
/// fn main() -> Result {
///     let cli = Cli::parse();
///     cli.options.run(Watch(cli.limit), "watch")
/// }
/// ```
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// The fleet to read
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Frames per second to read, or 'all' [default: the plugin's own]
    #[arg(long, value_name = "N")]
    pub rate: Option<Rate>,
    /// The name to go by, in lockstep and in `regatta doctor` [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// In lockstep, handle each tick after this plugin has; may be repeated
    #[arg(long, value_name = "NAME", value_parser = parse_plugin_name)]
    pub after: Vec<String>,
    /// Show warnings of shared memory (iceoryx2); twice for all of its log
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Checks the name of a plugin: the rules are those for fleets.
fn parse_plugin_name(text: &str) -> Result<String, NameError> {
    text.parse::<FleetName>().map(|name| name.to_string())
}

/// Runs a plugin until Ctrl-C or `SIGTERM`, with the options on this process's command line.
///
/// Waits for an engine if there is none yet, and continues when the engine is replaced.
///
/// ```no_run
/// use regatta_plugin::{Frame, Plugin, Result};
///
/// struct Counter;
///
/// impl Plugin for Counter {
///     fn on_frame(&mut self, frame: &Frame) -> Result {
///         println!("tick {}: {} robots", frame.tick(), frame.len());
///         Ok(())
///     }
/// }
///
/// fn main() -> Result {
///     regatta_plugin::run(Counter)
/// }
/// ```
///
/// # Errors
/// If an option is invalid, shared memory can't be used, the fleet uses another version of the
/// contract, or one of the plugin's functions returns an error.
pub fn run(plugin: impl Plugin) -> Result {
    run_from(plugin, std::env::args_os())
}

/// Runs a plugin with a given command line. Its first argument is the program (`regatta plugin
/// hello`, for example), whose last word is the plugin's name unless `--name` gives one.
///
/// ```
/// # use regatta_plugin::{Frame, Plugin, Result};
/// # struct Quiet;
/// # impl Plugin for Quiet { fn on_frame(&mut self, _: &Frame) -> Result { Ok(()) } }
/// regatta_plugin::run_from(Quiet, ["my-plugin", "--help"])?;
/// # Ok::<(), regatta_plugin::Error>(())
/// ```
///
/// # Errors
/// As [`run`].
pub fn run_from<A: Into<OsString> + Clone>(
    plugin: impl Plugin,
    args: impl IntoIterator<Item = A>,
) -> Result {
    let about = "A Regatta plugin: reads the frames of a fleet";
    let Some((options, program)) = parse::<Options, A>(args, "plugin", about)? else {
        return Ok(());
    };
    options.run(plugin, program.rsplit(' ').next().unwrap_or(&program))
}

/// A command line that has these options and no others.
#[derive(Parser)]
struct Cli<T: Args> {
    #[command(flatten)]
    options: T,
}

/// Parses a command line. Returns its options and the name of the program, or `None` if the help
/// was printed.
pub(crate) fn parse<T: Args, A: Into<OsString>>(
    args: impl IntoIterator<Item = A>,
    default_program: &str,
    about: &'static str,
) -> Result<Option<(T, String)>> {
    let args: Vec<OsString> = args.into_iter().map(Into::into).collect();
    let program = args.first().and_then(|path| Path::new(path).file_stem()?.to_str());
    let program = program.unwrap_or(default_program).to_owned();
    let parsed = Cli::<T>::command().bin_name(&program).about(about).try_get_matches_from(args);
    match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => Ok(Some((cli.options, program))),
        Err(error) if error.kind() == ErrorKind::DisplayHelp => {
            error.print()?;
            Ok(None)
        }
        Err(error) => {
            Err(Error::new(format_args!("{}; --help lists the options", usage_line(&error))))
        }
    }
}

/// Joins a fleet under a given name, or else that of the environment, or else the program's.
pub(crate) fn join(fleet: &FleetName, name: Option<&str>, program: &str) -> Result<Participant> {
    let of_environment = std::env::var(NAME_VARIABLE).ok();
    Ok(Participant::join(fleet, name.or(of_environment.as_deref()).unwrap_or(program))?)
}

impl Options {
    /// Runs a plugin with these options. `program` is its name, unless `--name` gives one.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&self, mut plugin: impl Plugin, program: &str) -> Result {
        set_verbosity(self.verbose);
        let termination = Termination::watch()?;
        let participant = join(&self.fleet, self.name.as_deref(), program)?;
        let result =
            Runner::open(&participant, &plugin, self, &termination).and_then(|mut runner| {
                plugin.on_start(&participant)?;
                while !termination.requested() {
                    runner.turn(&mut plugin)?;
                }
                runner.lockstep.leave()
            });
        result.and(plugin.on_stop())
    }

    /// The names of the plugins that a plugin comes after in lockstep.
    fn after(&self, plugin: &impl Plugin) -> Vec<String> {
        let given = std::env::var(AFTER_VARIABLE).unwrap_or_default();
        let given =
            given.split(',').map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned);
        self.after.iter().cloned().chain(given).chain(plugin.after()).collect()
    }
}

/// The environment variable with the name that a plugin goes by unless `--name` says otherwise:
/// `regatta run` sets it to the name in the scenario.
pub const NAME_VARIABLE: &str = "REGATTA_PLUGIN_NAME";
/// The environment variable with the names of the plugins that this one comes after in lockstep,
/// separated by commas: `regatta run` sets it to the names in the scenario.
pub const AFTER_VARIABLE: &str = "REGATTA_PLUGIN_AFTER";
/// The environment variable with the path of a scenario that describes a load of transport orders
/// (its key `load`), for a fleet manager: `regatta run` sets it.
pub const LOAD_VARIABLE: &str = "REGATTA_LOAD";

/// The longest sleep between two checks of the termination flag.
const SLICE: Duration = Duration::from_millis(100);
/// The time to wait for the world that a frame refers to.
const WORLD_WAIT: Duration = Duration::from_millis(500);

/// Receives worlds, events and frames for a plugin, and calls it.
struct Runner<'a> {
    termination: &'a Termination,
    worlds: WorldReader,
    frames: Subscriber,
    events: Option<EventReader>,
    lockstep: LockstepTurn,
    limiter: RateLimiter,
    silence: Silence,
    /// The time when the last frame came, or the plugin was last told that none does.
    quiet_since: Instant,
    /// Ticks with events that were lost, as last reported.
    reported_lost: u64,
}

impl<'a> Runner<'a> {
    fn open(
        participant: &Participant,
        plugin: &impl Plugin,
        options: &Options,
        termination: &'a Termination,
    ) -> Result<Self> {
        let after = options.after(plugin);
        if after.iter().any(|name| name == participant.name()) {
            return Err(Error::new(format_args!(
                "{} can't come after itself; see --after",
                participant.name()
            )));
        }
        Ok(Self {
            termination,
            worlds: WorldReader::open_on(participant)?,
            frames: Subscriber::open_on(participant)?,
            events: plugin.wants_events().then(|| EventReader::open_on(participant)).transpose()?,
            lockstep: LockstepTurn {
                participant: participant.clone(),
                after,
                reporter: None,
                reports: None,
                last: (0, u64::MAX),
                skipped: 0,
            },
            limiter: RateLimiter::new(options.rate.unwrap_or_else(|| plugin.rate())),
            silence: Silence::new(),
            quiet_since: Instant::now(),
            reported_lost: 0,
        })
    }

    /// Hands over the events and the frame that have come, or else sleeps until the next wake-up,
    /// for a [`SLICE`] at most.
    fn turn(&mut self, plugin: &mut impl Plugin) -> Result {
        if self.take(plugin)? {
            return Ok(());
        }
        let left = self.limiter.left().min(SLICE);
        if self.events.is_none() && !left.is_zero() {
            // Ignore frames that arrive before the next one is due.
            std::thread::sleep(left);
            return Ok(());
        }
        self.frames.forget_wake_ups()?;
        if self.take(plugin)? {
            return Ok(());
        }
        self.frames.sleep(if left.is_zero() { SLICE } else { left })?;
        if !left.is_zero() {
            // No frame was due: it isn't quiet yet.
            self.quiet_since = Instant::now();
        }
        if self.limiter.left().is_zero()
            && self.quiet_since.elapsed() >= SLICE
            && !self.frames.has_newer()?
        {
            self.quiet_since = Instant::now();
            self.silence.check(&self.frames);
            // First its columns, then its report: a reader of the report finds the columns.
            plugin.on_idle(self.frames.has_producer())?;
            self.lockstep.update();
        }
        Ok(())
    }

    /// Hands over the events that have come, then the newest frame if one is due; whether there was
    /// one.
    fn take(&mut self, plugin: &mut impl Plugin) -> Result<bool> {
        // The frame is received first: its events were published before it, so they have all come.
        let due = self.limiter.left().is_zero() && self.frames.latest()?.is_some();
        if due && let Some(frame) = self.frames.current()? {
            hand_over_world(&mut self.worlds, &frame, plugin)?;
        }
        self.take_events(plugin)?;
        if !due {
            return Ok(false);
        }
        self.silence.end();
        if let Some(frame) = self.frames.current()? {
            let is_new = self.lockstep.is_new(&frame);
            let admitted = self.limiter.admits(&frame) && is_new;
            if admitted && self.lockstep.wait_for_turn(&frame, self.termination)? {
                plugin.on_frame(&self.lockstep.count_missed(frame))?;
            } else {
                self.lockstep.skipped += u64::from(is_new);
            }
            self.lockstep.report(&frame)?;
        }
        self.frames.release();
        self.quiet_since = Instant::now();
        Ok(true)
    }

    fn take_events(&mut self, plugin: &mut impl Plugin) -> Result {
        let Some(events) = &mut self.events else { return Ok(()) };
        events.take(|events| plugin.on_events(events))?;
        // Now, and whenever it has become ten times as bad.
        if events.lost() >= (10 * self.reported_lost).max(1) {
            self.reported_lost = events.lost();
            let name = self.frames.participant().name();
            crate::tell!(
                "{name}: events of {} ticks lost so far: too slow for this fleet",
                events.lost()
            );
        }
        Ok(())
    }
}

/// Hands over a new world, if there is one. A process that has just joined can get its first frame
/// some moments before the world that it refers to.
fn hand_over_world(
    worlds: &mut WorldReader,
    frame: &Frame<'_>,
    plugin: &mut impl Plugin,
) -> Result {
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

/// A plugin's part in lockstep: it comes after the plugins that it names, and reports each tick.
struct LockstepTurn {
    participant: Participant,
    after: Vec<String>,
    /// Opened with the first frame in lockstep.
    reporter: Option<Reporter>,
    /// Opened only if there are plugins to wait for: each report wakes all that read reports.
    reports: Option<DoneReports>,
    /// Run and tick of the last frame.
    last: (u64, u64),
    /// Frames that the plugin's rate has skipped since the last one that it got.
    skipped: u64,
}

impl LockstepTurn {
    /// Records a frame. In lockstep each tick counts once: the speed of processes would decide
    /// whether a frame that is published again is seen.
    fn is_new(&mut self, frame: &Frame<'_>) -> bool {
        let this = (frame.run_id(), frame.tick());
        std::mem::replace(&mut self.last, this) != this || frame.header().lockstep == 0
    }

    /// Adjusts the number of frames that were missed before a frame. In lockstep no tick is lost,
    /// but a frame that is published again may be: only the frames that the plugin's rate has
    /// skipped count, so that runs repeat.
    fn count_missed<'frame>(&mut self, frame: Frame<'frame>) -> Frame<'frame> {
        let skipped = std::mem::take(&mut self.skipped);
        if frame.header().lockstep == 0 { frame } else { frame.after_missing(skipped) }
    }

    /// Waits until the plugins that this one comes after have finished a frame's tick. Returns
    /// `false` if the process is asked to end.
    fn wait_for_turn(&mut self, frame: &Frame<'_>, termination: &Termination) -> Result<bool> {
        if frame.header().lockstep == 0 || self.after.is_empty() {
            return Ok(true);
        }
        let reports = match &mut self.reports {
            Some(reports) => reports,
            none => none.insert(DoneReports::open(&self.participant)?),
        };
        let start = Instant::now();
        let mut reported = false;
        while !termination.requested() {
            if reports.missing(&self.after, frame.run_id(), frame.tick())?.next().is_none() {
                return Ok(true);
            }
            // Checked again, because a report may have come in between: its wake-up is forgotten
            // now.
            reports.forget_wake_ups()?;
            let missing: Vec<_> =
                reports.missing(&self.after, frame.run_id(), frame.tick())?.cloned().collect();
            if missing.is_empty() {
                return Ok(true);
            }
            if !reported && start.elapsed() >= SILENCE {
                let (name, tick) = (self.participant.name(), frame.tick());
                crate::tell!("{name}: waiting for {} to finish tick {tick}", missing.join(", "));
                reported = true;
            }
            reports.sleep(SLICE)?;
        }
        Ok(false)
    }

    /// Reports that a frame's tick is finished.
    fn report(&mut self, frame: &Frame<'_>) -> Result {
        if frame.header().lockstep == 0 {
            return Ok(());
        }
        let reporter = match &mut self.reporter {
            Some(reporter) => reporter,
            none => none.insert(Reporter::open_on(&self.participant)?),
        };
        Ok(reporter.done(frame.run_id(), frame.tick())?)
    }

    /// Reports that the plugin ends, if it has reported ticks.
    fn leave(&self) -> Result {
        let Some(reporter) = &self.reporter else { return Ok(()) };
        Ok(reporter.leave(self.last.0)?)
    }

    /// Gives the last report to plugins that have joined since.
    fn update(&self) {
        if let Some(reporter) = &self.reporter {
            reporter.update();
        }
    }
}
