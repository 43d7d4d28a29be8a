//! A replay: a producer like the engine, whose frames come from a recording.

mod closures;
mod contact_search;
mod histories;
mod history;
mod marks;
mod options;
mod producer;
mod search;
mod stage;
mod teller;

use std::collections::BTreeSet;
use std::time::Duration;

use regatta_plugin::producer::{Moment, Session};
use regatta_plugin::{Participant, ProducerPorts, Termination};

use crate::reading::{Reader, Recording, Selection};
use crate::schema::Topic;
use contact_search::ContactSearch;
pub use options::{ReplayArgs, ReplayError};
use stage::{Stage, StageError};
use teller::Teller;

/// Replays a recording until it is over or Ctrl-C.
///
/// # Errors
/// [`ReplayError`].
pub fn replay(args: &ReplayArgs) -> Result<(), ReplayError> {
    let termination =
        Termination::watch().map_err(|error| ReplayError::Signals(error.to_string()))?;
    let recording = Recording::open_frames(&args.file)?;
    let (start, end) = recording.span();
    if !recording.is_closed() {
        regatta_plugin::tell!(
            "replay: {} was never closed; `regatta record --repair` closes it",
            args.file.display()
        );
    }
    let mut topics = recording.topics();
    topics.retain(|topic| !args.no_columns || !topic.is_from_plugin());
    let mut ports = ProducerPorts::create_on(Participant::join(&args.fleet, "replay")?, 0)?;
    // In lockstep, nothing may depend on how fast a search is.
    let with_history = !args.no_columns && args.lockstep.names.is_empty();
    let teller = Teller::open(ports.participant(), &recording, with_history)?;
    let stage = Stage::open(&mut ports, &topics, teller);
    regatta_plugin::tell!(
        "fleet '{}': {} frames from {:.2} s to {:.2} s of {}; Ctrl-C stops",
        args.fleet,
        recording.count(&Topic::Frames),
        start.as_secs_f64(),
        end.as_secs_f64(),
        args.file.display()
    );
    // The moments of a recording are as far apart as they were.
    let mut session = Session::new(ports, Duration::ZERO, args.speed, args.lockstep.clone());
    if args.paused {
        session.pause();
    }
    let mut replay = Replay::new(&recording, stage, args)?;
    if recording.is_closed() && !session.is_lockstep() {
        replay.contact_search = ContactSearch::start(&args.file).ok();
    }
    session.run(&mut replay, &termination)
}

/// A recording that is published again.
struct Replay<'recording> {
    recording: &'recording Recording,
    reader: Reader<'recording>,
    stage: Stage,
    args: ReplayArgs,
    /// Time in the recording of the moment shown last, in nanoseconds.
    time: u64,
    /// The frame of the moment that is being shown.
    frame: Vec<u8>,
    /// The events of the first moment, if readers in lockstep may join only with its frame.
    withheld: Vec<(Topic, Vec<u8>)>,
    reported_orders: bool,
    /// The times of the repetitions of the world that is shown.
    worlds: BTreeSet<u64>,
    /// How often the world had changed when these times were noted.
    world_changes: u64,
    /// Decodes contacts after a jump. `None` in lockstep, where they are there with the frame, and
    /// for a recording that was never closed, which would have to be scanned once more.
    contact_search: Option<ContactSearch>,
}

impl<'recording> Replay<'recording> {
    fn new(
        recording: &'recording Recording,
        stage: Stage,
        args: &ReplayArgs,
    ) -> Result<Self, ReplayError> {
        Ok(Self {
            recording,
            reader: recording.read(&selection(recording))?,
            stage,
            args: args.clone(),
            time: 0,
            frame: Vec::new(),
            withheld: Vec::new(),
            reported_orders: false,
            worlds: BTreeSet::new(),
            world_changes: 0,
            contact_search: None,
        })
    }

    /// Publishes the next moment: all messages of the same time, its frame last, so that a reader
    /// that has the frame has the rest. A frame that the producer published again counts once.
    /// Returns whether there was a frame.
    ///
    /// With `withhold`, messages that reach only readers that are there already wait for the next
    /// moment.
    fn show_moment(&mut self, session: &mut Session, withhold: bool) -> Result<bool, ReplayError> {
        let Some(time) = self.reader.peek()? else { return Ok(false) };
        (self.time, self.stage.time) = (time, time);
        let Self { recording, reader, stage, frame, withheld, .. } = self;
        for (topic, message) in withheld.drain(..) {
            stage
                .publish(session, &topic, &message)
                .map_err(|error| explain(recording, &topic, time, error))?;
        }
        frame.clear();
        while reader.peek()? == Some(time) {
            let Some(entry) = reader.next()? else { break };
            if *entry.topic == Topic::Frames {
                frame.clear();
                frame.extend_from_slice(entry.message);
            } else if withhold && !entry.topic.is_state() {
                withheld.push((entry.topic.clone(), entry.message.to_vec()));
            } else {
                let shown = stage.publish(session, entry.topic, entry.message);
                shown.map_err(|error| explain(recording, entry.topic, time, error))?;
            }
        }
        if frame.is_empty() {
            return Ok(false);
        }
        let shown = stage.publish(session, &Topic::Frames, frame);
        shown.map_err(|error| explain(recording, &Topic::Frames, time, error))?;
        Ok(true)
    }

    /// Returns the reason if a time is outside of the recording.
    fn refuse_time(&self, time: Duration) -> Option<String> {
        let (start, end) = self.recording.span();
        let [start, end, time] = [start, end, time].map(|time| time.as_secs_f64());
        let outside = !(start..=end).contains(&time);
        outside.then(|| {
            format!("the recording goes from {start:.3} s to {end:.3} s; {time:.3} s is outside")
        })
    }

    /// Shows the newest frame at or before `time`, and continues from there.
    fn go_to(
        &mut self,
        session: &mut Session,
        time: Duration,
        withhold: bool,
    ) -> Result<(), ReplayError> {
        let time = time.as_nanos() as u64;
        let frame = self.recording.time_until(&Topic::Frames, time)?.unwrap_or(0);
        if frame < self.time {
            self.stage.begin_run(session)?;
        }
        self.withheld.clear();
        session.begin_jump();
        self.show_state_before(session, frame)?;
        self.reader =
            self.recording.read(&Selection { from: frame, ..selection(self.recording) })?;
        // The first moments of a recording may have no frame.
        while self.reader.peek()?.is_some() && !self.show_moment(session, withhold)? {}
        session.jump(Moment { tick: session.tick(), sim_nanos: self.time });
        Ok(())
    }

    /// Publishes what is valid until something newer comes: the world, columns, contacts.
    fn show_state_before(&mut self, session: &mut Session, frame: u64) -> Result<(), ReplayError> {
        for topic in self.recording.topics().into_iter().filter(Topic::is_state) {
            if matches!(topic, Topic::Contacts | Topic::ContactUpdates) {
                continue;
            }
            if self.is_shown(&topic, frame)? {
                continue;
            }
            let Some((time, message)) = self.recording.state_before(&topic, frame)? else {
                continue;
            };
            let shown = self.stage.publish(session, &topic, &message);
            shown.map_err(|error| explain(self.recording, &topic, time, error))?;
            if topic == Topic::World {
                self.worlds.insert(time);
            }
        }
        if let Some(search) = &mut self.contact_search {
            search.jump();
            return Ok(());
        }
        let contacts = self.recording.contacts_before(frame)?;
        Ok(self.stage.take_contacts(session, contacts)?)
    }

    /// Whether what is valid before a frame need not be read: a column of the frame itself replaces
    /// it, or the world is the one that is shown. The index tells.
    fn is_shown(&mut self, topic: &Topic, frame: u64) -> Result<bool, ReplayError> {
        if topic.column().is_some() {
            return Ok(self.recording.time_until(topic, frame)? == Some(frame));
        }
        let changes = self.stage.world_changes;
        if std::mem::replace(&mut self.world_changes, changes) != changes {
            self.worlds.clear();
        }
        let Some(before) = frame.checked_sub(1) else { return Ok(false) };
        Ok(self
            .recording
            .time_until(topic, before)?
            .is_some_and(|time| self.worlds.contains(&time)))
    }

    /// Publishes the list of contacts of the frame that the playhead jumped to, if it hasn't been
    /// published yet. It is needed now: the next one may be a change of it.
    fn finish_jump(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        if self.contact_search.as_mut().is_some_and(ContactSearch::cancel) {
            let contacts = self.recording.contacts_before(self.time.saturating_add(1))?;
            self.stage.take_contacts(session, contacts)?;
        }
        Ok(())
    }
}

/// What a replay reads: everything but what was recorded for other programs.
fn selection(recording: &Recording) -> Selection {
    let mut topics = recording.topics();
    topics.retain(|topic| {
        !matches!(topic, Topic::Poses | Topic::Robots | Topic::Graph | Topic::GraphPoints)
    });
    Selection::all_of(topics)
}

/// Adds to an error where in the recording the message is.
fn explain(recording: &Recording, topic: &Topic, time: u64, error: StageError) -> ReplayError {
    match error {
        StageError::Message(error) => recording.malformed(topic, time, error).into(),
        StageError::Replay(error) => error,
    }
}
