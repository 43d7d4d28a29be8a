//! What the viewer knows of a fleet: the newest frame, world, columns and contacts, read from the contract.
//! Nothing here looks at robots one by one.

use std::time::{Duration, Instant};

use regatta_plugin::{
    ColumnName, ColumnReader, ContactReader, Contacts, Frame, Participant, ReadError, Result, Subscriber, World,
    WorldReader,
};

/// How often to ask whether a column still has a publisher, in polls.
const CHECK_EVERY: u32 = 32;
/// Of whom nothing came so long, while frames did, is gone.
const SILENCE: Duration = Duration::from_secs(2);

/// Reads a fleet for drawing.
#[derive(Debug)]
pub struct Feed {
    frames: Subscriber,
    worlds: WorldReader,
    kinds: ColumnReader,
    value: Option<(ColumnName, ColumnReader)>,
    contacts: ContactReader,
    polls: u32,
    published: bool,
    /// Frames that this read, and frames of the same run that passed unread in between.
    counts: Counts,
    last: Option<(u64, u64)>,
    heard: Heard,
}

/// What a [`Feed::poll`] found new.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct News {
    /// There is a new [`Feed::frame`].
    pub frame: bool,
    /// There is a new [`Feed::world`].
    pub world: bool,
    /// There are new [`Feed::kinds`].
    pub kinds: bool,
    /// There are new [`Feed::value`]s, or they are gone.
    pub value: bool,
    /// There are new contacts.
    pub contacts: bool,
}

/// How many frames were seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames read.
    pub read: u64,
    /// Ticks of the same run that passed between two frames read.
    pub skipped: u64,
}

impl Feed {
    /// Opens a fleet for reading, whether or not it has a producer yet.
    ///
    /// # Errors
    /// If shared memory can't be used, or the fleet speaks another version of the contract.
    pub fn open(participant: &Participant) -> Result<Self> {
        Ok(Self {
            frames: Subscriber::open_on(participant)?,
            worlds: WorldReader::open_on(participant)?,
            kinds: ColumnReader::open_on(participant, "type")?,
            value: None,
            contacts: ContactReader::open_on(participant)?,
            polls: 0,
            published: false,
            counts: Counts::default(),
            last: None,
            heard: Heard::default(),
        })
    }

    /// Reads this column's values from now on, or none.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn watch(&mut self, column: Option<&ColumnName>) -> Result<()> {
        if self.value.as_ref().map(|(name, _)| name) == column {
            return Ok(());
        }
        self.value = None;
        self.published = false;
        if let Some(name) = column {
            self.value = Some((name.clone(), ColumnReader::open_on(self.frames.participant(), name.as_str())?));
        }
        Ok(())
    }

    /// Takes what is newest. Called once for each picture.
    ///
    /// # Errors
    /// [`ReadError`] if a connection is broken, or something contradicts its header.
    pub fn poll(&mut self) -> Result<News, ReadError> {
        let news = News {
            world: self.worlds.latest()?.is_some(),
            kinds: self.kinds.latest()?.is_some(),
            value: self.poll_value()?,
            contacts: self.contacts.latest()?.is_some(),
            frame: self.frames.latest()?.is_some(),
        };
        self.listen(&news);
        if news.frame
            && let Some(frame) = self.frames.current()?
        {
            let now = (frame.run_id(), frame.tick());
            let between = self.last.filter(|last| last.0 == now.0).map_or(0, |last| now.1.saturating_sub(last.1 + 1));
            self.counts = Counts { read: self.counts.read + 1, skipped: self.counts.skipped + between };
            self.last = Some(now);
        }
        self.polls = self.polls.wrapping_add(1);
        Ok(news)
    }

    /// Remembers when it heard of whom, and who is gone.
    fn listen(&mut self, news: &News) {
        let now = Instant::now();
        let heard = &mut self.heard;
        for (is_new, at) in
            [(news.frame, &mut heard.frame), (news.contacts, &mut heard.contacts), (news.value, &mut heard.value)]
        {
            if is_new {
                *at = Some(now);
            }
        }
        if self.polls.is_multiple_of(CHECK_EVERY) {
            heard.has_checker = self.contacts.has_publisher();
        }
        // Who was killed counts as there until this.
        let silent = [heard.contacts, heard.value].into_iter().flatten().any(|at| heard.is_silent(at));
        if silent && heard.cleaned.is_none_or(|cleaned| now.duration_since(cleaned) > SILENCE) {
            heard.cleaned = Some(now);
            self.frames.forget_dead();
        }
    }

    fn poll_value(&mut self) -> Result<bool, ReadError> {
        let Some((_, reader)) = &mut self.value else { return Ok(false) };
        let mut changed = reader.latest()?.is_some();
        self.published |= changed;
        if self.published && self.polls.is_multiple_of(CHECK_EVERY) && !reader.has_publisher() {
            self.published = false;
            changed = true;
        }
        Ok(changed)
    }

    /// The newest frame.
    pub fn frame(&self) -> Option<Frame<'_>> {
        // A malformed one was reported when it came.
        self.frames.current().ok()?
    }

    /// The newest world.
    pub fn world(&self) -> Option<World<'_>> {
        self.worlds.current().ok()?
    }

    /// Each robot's index into the world's robot types.
    pub fn kinds(&self) -> Option<&[f32]> {
        Some(self.kinds.current().ok()??.values)
    }

    /// The values of the watched column, while somebody publishes it.
    pub fn value(&self) -> Option<&[f32]> {
        let (_, reader) = self.value.as_ref()?;
        Some(reader.current().ok()??.values).filter(|_| self.published)
    }

    /// What a collision checker says of the run that is shown, while there is one.
    pub fn contacts(&self) -> Option<Contacts<'_>> {
        let (run, _) = self.last?;
        let is_silent = self.heard.contacts.is_none_or(|at| self.heard.is_silent(at));
        self.contacts.current().filter(|contacts| self.heard.has_checker && !is_silent && contacts.header.run_id == run)
    }

    /// Whether the fleet has a producer.
    pub fn has_producer(&self) -> bool {
        self.frames.has_producer()
    }

    /// Whether there is a frame that was not read yet.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if the connection to the producer is broken.
    pub fn has_newer(&self) -> Result<bool, ReadError> {
        self.frames.has_newer()
    }

    /// Forgets a producer that was killed: it counts as one until then.
    pub fn forget_dead(&self) {
        self.frames.forget_dead();
    }

    /// How many frames were read and skipped.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

/// When something came last.
#[derive(Clone, Copy, Debug, Default)]
struct Heard {
    frame: Option<Instant>,
    contacts: Option<Instant>,
    value: Option<Instant>,
    has_checker: bool,
    /// When the dead were forgotten last.
    cleaned: Option<Instant>,
}

impl Heard {
    /// Whether frames went on long after somebody was heard last.
    fn is_silent(&self, at: Instant) -> bool {
        self.frame.is_some_and(|frame| frame.saturating_duration_since(at) > SILENCE)
    }
}

/// Says which moment between the two newest frames to show, so that motion is smooth at any rate of display.
///
/// What is shown lags one frame's period behind the producer: then there is a frame on either side of it.
#[derive(Debug)]
pub struct Playhead {
    started: Instant,
    /// Of the two newest frames, on the producer's clock, in seconds.
    sent: [f64; 2],
    tick: u64,
    run: u64,
    /// Fewest ticks between two frames.
    gap: u64,
    /// Seconds between two frames.
    period: f64,
    /// This process's clock minus the producer's, in seconds, at the least delay seen.
    lead: f64,
}

impl Playhead {
    /// Starts without frames.
    pub fn new() -> Self {
        Self {
            started: Instant::now(),
            sent: [0.0; 2],
            tick: 0,
            run: 0,
            gap: u64::MAX,
            period: 0.0,
            lead: f64::INFINITY,
        }
    }

    /// Takes a new frame.
    pub fn push(&mut self, frame: &Frame<'_>, now: Instant) {
        let sent = frame.header().wall_time_nanos as f64 * 1e-9;
        let lead = now.duration_since(self.started).as_secs_f64() - sent;
        // Clocks drift: a lead that is no longer reached is given up slowly.
        self.lead = if frame.run_id() == self.run { lead.min(self.lead + 1e-4) } else { lead };
        let ticks = frame.tick().saturating_sub(self.tick);
        let passed = sent - self.sent[1];
        if frame.run_id() != self.run {
            (self.gap, self.period) = (u64::MAX, 0.0);
        } else if ticks > 0 && passed > 0.0 {
            self.gap = self.gap.min(ticks);
            let period = passed * self.gap as f64 / ticks as f64;
            self.period = if self.period == 0.0 { period } else { self.period + (period - self.period) * 0.1 };
        }
        self.sent = [self.sent[1], sent];
        (self.tick, self.run) = (frame.tick(), frame.run_id());
    }

    /// How far from the frame before (0) to the newest (1) the shown moment is.
    pub fn alpha(&self, now: Instant) -> f32 {
        let shown = now.duration_since(self.started).as_secs_f64() - self.lead - self.period.min(1.0);
        let between = self.sent[1] - self.sent[0];
        if between <= 0.0 { 1.0 } else { ((shown - self.sent[0]) / between).clamp(0.0, 1.0) as f32 }
    }
}

impl Default for Playhead {
    fn default() -> Self {
        Self::new()
    }
}
