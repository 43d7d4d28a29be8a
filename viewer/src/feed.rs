//! The fleet's data in shared memory: the newest frame, world, columns and contacts. Nothing here
//! iterates over robots.

use std::time::{Duration, Instant};

use regatta_interface::view_model::Counts;
use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::column::{ACTIVITY, TYPE};
use regatta_plugin::facility::FacilityState;
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::{
    ClosureReader, ColumnName, ColumnReader, ContactReader, Contacts, FacilityReader, Frame,
    Participant, ReadError, RecordingReader, ReplayedRecording, Result, Subscriber, World,
    WorldReader,
};

/// The number of polls between two checks whether a column still has a publisher.
const CHECK_EVERY: u32 = 32;
/// A publisher that stays silent this long while frames arrive is considered gone.
const LIVELINESS_TIMEOUT: Duration = Duration::from_secs(2);

/// The number of frames after which a recording that they don't belong to is forgotten: more than
/// can arrive while the run changes.
const MAX_STRANGE_FRAMES: u32 = 16;

/// The readers of a fleet's data.
#[derive(Debug)]
pub struct Feed {
    frames: Subscriber,
    worlds: WorldReader,
    robot_type: ColumnReader,
    activity: ColumnReader,
    value: Option<(ColumnName, ColumnReader)>,
    contacts: ContactReader,
    closures: ClosureReader,
    facilities: FacilityReader,
    recording: RecordingReader,
    /// The number of consecutive frames that don't belong to the announced recording.
    strange_frames: u32,
    polls: u32,
    /// Whether the value column has a publisher.
    is_value_published: bool,
    counts: Counts,
    /// The simulated time of the newest frame, if it belongs to the warm-up of a run.
    warm_up: Option<Duration>,
    /// Run and tick of the newest frame.
    last: Option<(u64, u64)>,
    liveliness: Liveliness,
}

/// The data that a [`Feed::poll`] found new.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct News {
    /// There is a new [`Feed::frame`].
    pub frame: bool,
    /// There is a new [`Feed::world`].
    pub world: bool,
    /// There is a new [`Feed::robot_type`].
    pub robot_type: bool,
    /// There is a new [`Feed::value`], or its publisher has gone.
    pub value: bool,
    /// There are new contacts.
    pub contacts: bool,
    /// Edges were closed or opened.
    pub closures: bool,
    /// Doors or lifts have changed.
    pub facilities: bool,
    /// There is a new [`Feed::recording`], or more is known of it.
    pub recording: bool,
}

impl Feed {
    /// Opens a fleet for reading, whether or not it has a producer yet.
    ///
    /// # Errors
    /// If shared memory can't be used, or the fleet uses another version of the contract.
    pub fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(participant)?,
            worlds: WorldReader::open_on(participant)?,
            robot_type: ColumnReader::open_on(participant, TYPE.name())?,
            activity: ColumnReader::open_on(participant, ACTIVITY.name())?,
            value: None,
            contacts: ContactReader::open_on(participant)?,
            closures: ClosureReader::open_on(participant)?,
            facilities: FacilityReader::open_on(participant)?,
            recording: RecordingReader::open_on(participant)?,
            strange_frames: 0,
            polls: 0,
            is_value_published: false,
            counts: Counts::default(),
            warm_up: None,
            last: None,
            liveliness: Liveliness::default(),
        })
    }

    /// Sets the column that [`value`](Self::value) reads from now on, or none.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn watch(&mut self, column: Option<&ColumnName>) -> Result<()> {
        if self.value.as_ref().map(|(name, _)| name) == column {
            return Ok(());
        }
        self.value = None;
        self.is_value_published = false;
        if let Some(name) = column {
            self.value = Some((
                name.clone(),
                ColumnReader::open_on(self.frames.participant(), name.as_str())?,
            ));
        }
        Ok(())
    }

    /// Receives the newest data. Call this once for each picture.
    ///
    /// # Errors
    /// [`ReadError`] if a connection is broken, or a message contradicts its header.
    pub fn poll(&mut self) -> Result<News, ReadError> {
        self.activity.latest()?;
        let mut news = News {
            world: self.worlds.latest()?.is_some(),
            robot_type: self.robot_type.latest()?.is_some(),
            value: self.poll_value()?,
            contacts: self.contacts.latest()?.is_some(),
            closures: self.closures.take()?,
            facilities: self.facilities.take()?,
            frame: self.frames.latest()?.is_some(),
            // This follows the frame, because the facts of its run are published before it.
            recording: self.recording.take()?,
        };
        self.update_liveliness(&news);
        if news.frame {
            let header = self.frames.current()?.map(|frame| *frame.header());
            let warm_up = header.filter(FrameHeader::is_warm_up);
            self.warm_up = warm_up.map(|header| Duration::from_nanos(header.sim_time_nanos));
            news.frame = self.warm_up.is_none();
        }
        if news.frame
            && let Some(frame) = self.frames.current()?
        {
            let now = (frame.run_id(), frame.tick());
            self.counts = Counts {
                read: self.counts.read + 1,
                skipped: self.counts.skipped + frame.missed(),
            };
            self.last = Some(now);
            self.forget_recording(now.0);
        }
        self.polls = self.polls.wrapping_add(1);
        Ok(news)
    }

    /// Forgets the recording of a replay after which another producer has come.
    fn forget_recording(&mut self, run: u64) {
        let is_strange =
            self.recording.current().is_some_and(|recording| recording.header.run_id != run);
        self.strange_frames = if is_strange { self.strange_frames + 1 } else { 0 };
        if self.strange_frames > MAX_STRANGE_FRAMES {
            self.recording.forget();
        }
    }

    /// Notes when each publisher last sent, and cleans up after publishers that were killed.
    fn update_liveliness(&mut self, news: &News) {
        let now = Instant::now();
        let last = &mut self.liveliness;
        for (is_new, at) in [
            (news.frame, &mut last.frame),
            (news.contacts, &mut last.contacts),
            (news.value, &mut last.value),
        ] {
            if is_new {
                *at = Some(now);
            }
        }
        if self.polls.is_multiple_of(CHECK_EVERY) {
            last.has_checker = self.contacts.has_publisher();
        }
        // A killed process counts as a publisher until it is cleaned up.
        let is_silent =
            [last.contacts, last.value].into_iter().flatten().any(|at| last.is_silent(at));
        if is_silent
            && last.cleaned.is_none_or(|cleaned| now.duration_since(cleaned) > LIVELINESS_TIMEOUT)
        {
            last.cleaned = Some(now);
            self.frames.forget_dead();
        }
    }

    fn poll_value(&mut self) -> Result<bool, ReadError> {
        let Some((_, reader)) = &mut self.value else { return Ok(false) };
        let mut changed = reader.latest()?.is_some();
        self.is_value_published |= changed;
        // The last picture of a fleet that has ended stays.
        let is_due = self.is_value_published && self.polls.is_multiple_of(CHECK_EVERY);
        if is_due && !reader.has_publisher() && self.frames.has_producer() {
            self.is_value_published = false;
            changed = true;
        }
        Ok(changed)
    }

    /// The newest frame. Those of a warm-up aren't shown: the run begins at its end.
    pub fn frame(&self) -> Option<Frame<'_>> {
        // `poll` has reported a malformed frame.
        self.frames.current().ok()?.filter(|_| self.warm_up.is_none())
    }

    /// The simulated time that a run in its warm-up has driven so far.
    pub fn warm_up(&self) -> Option<Duration> {
        self.warm_up
    }

    /// The newest world.
    pub fn world(&self) -> Option<World<'_>> {
        self.worlds.current().ok()?
    }

    /// The column `activity` of the newest frame's run, if a fleet manager publishes it.
    pub fn activity(&self) -> Option<&[f32]> {
        let column = self.activity.current().ok()??;
        let is_current = self.last.is_some_and(|(run, _)| run == column.header.run_id);
        is_current.then_some(column.values)
    }

    /// The column `type`: each robot's index into the world's robot types.
    pub fn robot_type(&self) -> Option<&[f32]> {
        Some(self.robot_type.current().ok()??.values)
    }

    /// The values of the watched column, while it has a publisher.
    pub fn value(&self) -> Option<&[f32]> {
        let (_, reader) = self.value.as_ref()?;
        Some(reader.current().ok()??.values).filter(|_| self.is_value_published)
    }

    /// The contacts that a collision checker has found in the current run, while it is alive.
    pub fn contacts(&self) -> Option<Contacts<'_>> {
        let (run, _) = self.last?;
        let is_silent = self.liveliness.contacts.is_none_or(|at| self.liveliness.is_silent(at));
        let is_alive = self.liveliness.has_checker && !is_silent;
        self.contacts.current().filter(|contacts| is_alive && contacts.header.run_id == run)
    }

    /// The edges that are closed in the current run, sorted by id.
    pub fn closed(&self) -> &[ClosedEdge] {
        self.last.map_or(&[], |(run, _)| self.closures.closed(run))
    }

    /// The states of the doors and lifts in the current run.
    pub fn facilities(&self) -> &[FacilityState] {
        self.last.map_or(&[], |(run, _)| self.facilities.states(run))
    }

    /// The recording that is replayed, if the producer is a replay.
    pub fn recording(&self) -> Option<ReplayedRecording<'_>> {
        self.recording.current()
    }

    /// The recording's clock minus the simulated time of its shown run, in seconds; zero of a live
    /// run.
    pub fn ahead_secs(&self) -> f64 {
        self.recording().map_or(0.0, |recording| recording.header.ahead_nanos as i64 as f64 * 1e-9)
    }

    /// The time of a frame in seconds, on the clock of its recording, or else in simulated time.
    pub fn clock_secs(&self, frame: &Frame<'_>) -> f64 {
        let simulated = frame.header().sim_time_nanos;
        let recording =
            self.recording().filter(|recording| recording.header.run_id == frame.run_id());
        recording.map_or(simulated, |recording| recording.header.time_of(simulated)) as f64 * 1e-9
    }

    /// Whether the fleet has a producer.
    pub fn has_producer(&self) -> bool {
        self.frames.has_producer()
    }

    /// Whether there is a frame that hasn't been read yet.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the producer is broken.
    pub fn has_newer(&self) -> Result<bool, ReadError> {
        self.frames.has_newer()
    }

    /// Cleans up after a producer that was killed. Until then, it counts as a producer.
    pub fn forget_dead(&self) {
        self.frames.forget_dead();
    }

    /// The numbers of frames read and missed.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

/// The times at which publishers last sent.
#[derive(Clone, Copy, Debug, Default)]
struct Liveliness {
    frame: Option<Instant>,
    contacts: Option<Instant>,
    value: Option<Instant>,
    /// Whether the contacts have a publisher.
    has_checker: bool,
    /// Time of the last cleanup after killed processes.
    cleaned: Option<Instant>,
}

impl Liveliness {
    /// Whether a publisher that last sent `at` this time has been silent for too long while frames
    /// arrived.
    fn is_silent(&self, at: Instant) -> bool {
        self.frame.is_some_and(|frame| frame.saturating_duration_since(at) > LIVELINESS_TIMEOUT)
    }
}
