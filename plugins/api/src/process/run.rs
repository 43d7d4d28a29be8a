//! The life of a plugin's process.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use super::join::Participant;
use super::log::set_verbosity;
use super::options::{NAME_VARIABLE, Options, parse};
use super::plugin::Plugin;
use super::runner::Feed;
use super::silence::{SILENCE, Silence};
use super::termination::Termination;
use crate::error::{Error, Result};
use crate::ports::lockstep::{DoneReports, Reporter};
use crate::records::frame::Frame;
use crate::records::name::FleetName;

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
}

/// The longest sleep between two checks of the termination flag.
const SLICE: Duration = Duration::from_millis(100);
/// Waits for worlds, events and frames for a plugin, and calls it.
struct Runner<'a> {
    termination: &'a Termination,
    feed: Feed,
    lockstep: LockstepTurn,
    silence: Silence,
    /// The time when the last frame came, or the plugin was last told that none does.
    quiet_since: Instant,
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
            feed: Feed::open(participant, plugin, options.rate)?,
            lockstep: LockstepTurn {
                participant: participant.clone(),
                after,
                reporter: None,
                reports: None,
                run_id: 0,
            },
            silence: Silence::new(),
            quiet_since: Instant::now(),
        })
    }

    /// Hands over the events and the frame that have come, or else sleeps until the next wake-up,
    /// for a [`SLICE`] at most.
    fn turn(&mut self, plugin: &mut impl Plugin) -> Result {
        if self.take(plugin)? {
            return Ok(());
        }
        let left = self.feed.until_due().min(SLICE);
        if !plugin.wants_events() && !left.is_zero() {
            // Ignore frames that arrive before the next one is due.
            std::thread::sleep(left);
            return Ok(());
        }
        self.feed.frames().forget_wake_ups()?;
        if self.take(plugin)? {
            return Ok(());
        }
        self.feed.frames().sleep(if left.is_zero() { SLICE } else { left })?;
        if !left.is_zero() {
            // No frame was due: it isn't quiet yet.
            self.quiet_since = Instant::now();
        }
        if self.feed.until_due().is_zero()
            && self.quiet_since.elapsed() >= SLICE
            && !self.feed.frames().has_newer()?
        {
            self.quiet_since = Instant::now();
            self.silence.check(self.feed.frames());
            // First its columns, then its report: a reader of the report finds the columns.
            let outcome = plugin.on_idle(self.feed.frames().has_producer());
            self.feed.unless_full(outcome)?;
            self.lockstep.update();
        }
        Ok(())
    }

    /// Hands over the events that have come, then the newest frame if one is due; whether there was
    /// one.
    fn take(&mut self, plugin: &mut impl Plugin) -> Result<bool> {
        if !self.feed.receive(plugin)? {
            return Ok(false);
        }
        self.silence.end();
        let Self { feed, lockstep, termination, .. } = self;
        feed.hand_over(plugin, |frame| lockstep.wait_for_turn(frame, termination))?;
        if let Some(frame) = feed.frames().current()? {
            lockstep.report(&frame)?;
        }
        feed.release();
        self.quiet_since = Instant::now();
        Ok(true)
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
    /// The run of the last report.
    run_id: u64,
}

impl LockstepTurn {
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
        self.run_id = frame.run_id();
        Ok(reporter.done(frame.run_id(), frame.tick())?)
    }

    /// Reports that the plugin ends, if it has reported ticks.
    fn leave(&self) -> Result {
        let Some(reporter) = &self.reporter else { return Ok(()) };
        Ok(reporter.leave(self.run_id)?)
    }

    /// Gives the last report to plugins that have joined since.
    fn update(&self) {
        if let Some(reporter) = &self.reporter {
            reporter.update();
        }
    }
}
