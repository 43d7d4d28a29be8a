//! Handing worlds, events and frames over to a plugin.

use std::time::{Duration, Instant};

use super::join::Participant;
use super::plugin::Plugin;
use super::rate::{Rate, RateLimiter};
use crate::error::Result;
use crate::ports::error::PublishError;
use crate::ports::events::EventReader;
use crate::ports::frames::Subscriber;
use crate::ports::worlds::WorldReader;
use crate::records::frame::Frame;

/// The time after which full memory is told again.
const FULL_AGAIN: Duration = Duration::from_secs(60);
/// The time to wait for the world that a frame refers to.
const WORLD_WAIT: Duration = Duration::from_millis(500);

/// A plugin of a [`LocalFleet`](crate::LocalFleet). A driver calls it after each frame, in the
/// place of [`run`](crate::run).
///
/// ```
/// use regatta_plugin::{Frame, LocalFleet, LocalPlugin, Plugin, ProducerPorts, Result};
///
/// #[derive(Default)]
/// struct Count(usize);
///
/// impl Plugin for Count {
///     fn on_frame(&mut self, _: &Frame) -> Result {
///         self.0 += 1;
///         Ok(())
///     }
/// }
///
/// # fn main() -> Result {
/// let fleet = LocalFleet::new("example".parse()?);
/// let producer = ProducerPorts::create_on(fleet.join("producer"), 1)?;
/// let mut count = Count::default();
/// let mut plugin = LocalPlugin::start(&fleet.join("count"), &mut count)?;
/// producer.loan(1)?.send()?;
/// plugin.turn()?;
/// plugin.stop()?;
/// assert_eq!(count.0, 1);
/// # Ok(())
/// # }
/// ```
pub struct LocalPlugin<P> {
    plugin: P,
    feed: Feed,
}

impl<P: Plugin> LocalPlugin<P> {
    /// Opens the ports of a plugin.
    ///
    /// # Errors
    /// The plugin's own, or that of opening a port.
    pub fn start(participant: &Participant, mut plugin: P) -> Result<Self> {
        let feed = Feed::open(participant, &plugin, None)?;
        plugin.on_start(participant)?;
        Ok(Self { plugin, feed })
    }

    /// Hands over what was published since the last turn.
    ///
    /// # Errors
    /// The plugin's own, or that of reading a port.
    pub fn turn(&mut self) -> Result {
        if self.feed.receive(&mut self.plugin)? {
            self.feed.hand_over(&mut self.plugin, |_| Ok(true))?;
            self.feed.release();
        }
        Ok(())
    }

    /// Ends the plugin.
    ///
    /// # Errors
    /// The plugin's own.
    pub fn stop(mut self) -> Result {
        self.plugin.on_stop()
    }
}

impl<P> core::fmt::Debug for LocalPlugin<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("LocalPlugin").field("feed", &self.feed).finish_non_exhaustive()
    }
}

/// The worlds, events and frames that a plugin gets.
#[derive(Debug)]
pub(super) struct Feed {
    worlds: WorldReader,
    frames: Subscriber,
    events: Option<EventReader>,
    limiter: RateLimiter,
    /// Run and tick of the last frame.
    last: (u64, u64),
    /// Frames that the plugin's rate has skipped since the last one that it got.
    skipped: u64,
    /// Ticks with events that were lost, as last reported.
    reported_lost: u64,
    /// The time when the user was last told that shared memory is full.
    told_full: Option<Instant>,
}

impl Feed {
    /// Opens the ports. `rate` replaces that of the plugin.
    pub(super) fn open(
        participant: &Participant,
        plugin: &impl Plugin,
        rate: Option<Rate>,
    ) -> Result<Self> {
        Ok(Self {
            worlds: WorldReader::open_on(participant)?,
            frames: Subscriber::open_on(participant)?,
            events: plugin.wants_events().then(|| EventReader::open_on(participant)).transpose()?,
            limiter: RateLimiter::new(rate.unwrap_or_else(|| plugin.rate())),
            last: (0, u64::MAX),
            skipped: 0,
            reported_lost: 0,
            told_full: None,
        })
    }

    /// The frames.
    pub(super) fn frames(&self) -> &Subscriber {
        &self.frames
    }

    /// The time until a frame is due.
    pub(super) fn until_due(&self) -> Duration {
        self.limiter.left()
    }

    /// Receives the newest frame if one is due, and hands its world over, and the events that have
    /// come. Returns whether there is a frame to [hand over](Self::hand_over).
    pub(super) fn receive(&mut self, plugin: &mut impl Plugin) -> Result<bool> {
        // The frame is received first: its events were published before it, so they have all come.
        let due = self.limiter.left().is_zero() && self.frames.latest()?.is_some();
        if due && let Some(frame) = self.frames.current()? {
            hand_over_world(&mut self.worlds, &frame, plugin)?;
        }
        self.take_events(plugin)?;
        Ok(due)
    }

    /// Hands the received frame over, if the plugin's rate admits it. `wait` waits for the plugins
    /// that come before this one in lockstep, and returns `false` at the end of the process.
    pub(super) fn hand_over(
        &mut self,
        plugin: &mut impl Plugin,
        wait: impl FnOnce(&Frame<'_>) -> Result<bool>,
    ) -> Result {
        let Some(frame) = self.frames.current()? else { return Ok(()) };
        let is_lockstep = frame.header().lockstep != 0;
        let this = (frame.run_id(), frame.tick());
        // In lockstep each tick counts once: the speed of processes would decide whether a frame
        // that is published again is seen.
        let is_new = core::mem::replace(&mut self.last, this) != this || !is_lockstep;
        if !self.limiter.admits(&frame) || !is_new || !wait(&frame)? {
            self.skipped += u64::from(is_new);
            return Ok(());
        }
        // In lockstep no tick is lost, but a frame that is published again may be: only the frames
        // that the plugin's rate has skipped count, so that runs repeat.
        let skipped = core::mem::take(&mut self.skipped);
        let frame = if is_lockstep { frame.after_missing(skipped) } else { frame };
        let outcome = plugin.on_frame(&frame);
        if is_lockstep { outcome } else { self.unless_full(outcome) }
    }

    /// Passes the outcome of a plugin's function on, except that full shared memory is no error:
    /// what could not be published is left out, which sequence numbers tell readers, and the plugin
    /// goes on. The user is told once a minute at most.
    pub(super) fn unless_full(&mut self, outcome: Result) -> Result {
        let Err(error) = outcome else { return Ok(()) };
        match error.get_ref().downcast_ref() {
            Some(PublishError::MemoryFull { .. } | PublishError::NoRoom { .. }) => {}
            _ => return Err(error),
        }
        if self.told_full.is_none_or(|told| told.elapsed() >= FULL_AGAIN) {
            self.told_full = Some(Instant::now());
            let name = self.frames.participant().name();
            crate::tell!("{name}: {error}; samples are left out until there is room");
        }
        Ok(())
    }

    /// Gives the frame back.
    pub(super) fn release(&mut self) {
        self.frames.release();
    }

    fn take_events(&mut self, plugin: &mut impl Plugin) -> Result {
        let Some(events) = &mut self.events else { return Ok(()) };
        events.take(|events| plugin.on_events(events))?;
        // Now, and whenever it has become ten times as bad.
        if events.lost() >= (10 * self.reported_lost).max(1) {
            self.reported_lost = events.lost();
            let name = self.frames.participant().name();
            crate::tell!(
                "{name}: events of {} ticks lost so far: they weren't read in time, because the \
                 plugin or the machine is too slow",
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
