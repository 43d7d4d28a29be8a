//! The replay as a [`Producer`]: its clock, control service and lockstep are those of every
//! producer.

use std::collections::BTreeSet;
use std::time::Duration;

use regatta_plugin::control::ControlKind;
use regatta_plugin::frame::{ClockState, RobotState};
use regatta_plugin::producer::{Moment, Producer, RefusalReason, Session};

use super::search::ContactSearch;
use super::stage::Stage;
use super::{ReplayArgs, ReplayError};
use crate::reading::{Entry, Reader, Recording, Selection};
use crate::schema::Topic;

/// A recording that is published again.
pub(super) struct Replay<'recording> {
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
    reported_commands: bool,
    /// The times of the repetitions of the world that is shown.
    worlds: BTreeSet<u64>,
    /// The number of changes of the world when these times were noted.
    world_changes: u64,
    /// Decodes contacts after a jump. It is `None` in lockstep, where contacts come with the frame,
    /// and for a recording that was never closed, which would have to be scanned again.
    pub contact_search: Option<ContactSearch>,
}

impl<'recording> Replay<'recording> {
    pub fn new(
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
            reported_commands: false,
            worlds: BTreeSet::new(),
            world_changes: 0,
            contact_search: None,
        })
    }

    /// Publishes the next moment: all messages of the same time, its frame last, so that a reader
    /// that has the frame has the rest. A frame that the producer published again counts once.
    /// Returns whether there was a frame.
    ///
    /// With `withhold`, messages that only present readers get wait for the next moment.
    fn show_moment(&mut self, session: &mut Session, withhold: bool) -> Result<bool, ReplayError> {
        let Some(log_time) = self.reader.peek()? else { return Ok(false) };
        (self.time, self.stage.time) = (log_time, log_time);
        let Self { recording, reader, stage, frame, withheld, .. } = self;
        for (topic, message) in withheld.drain(..) {
            let entry = Entry { topic: &topic, log_time, message: &message };
            stage.publish(session, recording, entry)?;
        }
        frame.clear();
        while let Some(entry) = reader.next_at(log_time)? {
            if *entry.topic == Topic::Frames {
                frame.clear();
                frame.extend_from_slice(entry.message);
            } else if withhold && !entry.topic.is_state() {
                withheld.push((entry.topic.clone(), entry.message.to_vec()));
            } else {
                stage.publish(session, recording, entry)?;
            }
        }
        if frame.is_empty() {
            return Ok(false);
        }
        let entry = Entry { topic: &Topic::Frames, log_time, message: frame };
        stage.publish(session, recording, entry)?;
        Ok(true)
    }

    /// Returns the reason if a time is outside of the recording.
    fn refuse_time(&self, time: Duration) -> Option<String> {
        let (start, end) = self.recording.span();
        let [start, end, time] = [start, end, time].map(|time| time.as_secs_f64());
        if (start..=end).contains(&time) {
            return None;
        }
        Some(format!("the recording goes from {start:.3} s to {end:.3} s; {time:.3} s is outside"))
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

    /// Publishes the state before a frame: the world, columns, doors, lifts, contacts.
    fn show_state_before(&mut self, session: &mut Session, frame: u64) -> Result<(), ReplayError> {
        for topic in self.recording.topics().into_iter().filter(Topic::is_state) {
            let are_contacts = matches!(topic, Topic::Contacts | Topic::ContactUpdates);
            if are_contacts || self.is_shown(&topic, frame)? {
                continue;
            }
            let Some((log_time, message)) = self.recording.state_before(&topic, frame)? else {
                continue;
            };
            let entry = Entry { topic: &topic, log_time, message: &message };
            self.stage.publish(session, self.recording, entry)?;
            if topic == Topic::World {
                self.worlds.insert(log_time);
            }
        }
        if let Some(search) = &mut self.contact_search {
            search.jump();
            return Ok(());
        }
        let contacts = self.recording.contacts_before(frame)?;
        Ok(self.stage.take_contacts(session, contacts)?)
    }

    /// Whether the state before a frame need not be read: one of the frame itself replaces it, or
    /// the world is the one that is shown. Only the index is read.
    fn is_shown(&mut self, topic: &Topic, frame: u64) -> Result<bool, ReplayError> {
        if *topic != Topic::World {
            return Ok(self.recording.time_until(topic, frame)? == Some(frame));
        }
        let changes = self.stage.world_changes;
        if std::mem::replace(&mut self.world_changes, changes) != changes {
            self.worlds.clear();
        }
        let Some(before) = frame.checked_sub(1) else { return Ok(false) };
        let time = self.recording.time_until(topic, before)?;
        Ok(time.is_some_and(|time| self.worlds.contains(&time)))
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

impl Producer for Replay<'_> {
    type Error = ReplayError;

    fn start(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        let (start, _) = self.recording.span();
        let from = self.args.from.map_or(start, Into::into);
        if let Some(reason) = self.refuse_time(from) {
            return Err(ReplayError::Time(reason));
        }
        let withhold = session.is_lockstep();
        self.go_to(session, from, withhold)
    }

    fn next_moment(&mut self, session: &Session) -> Result<Option<Moment>, ReplayError> {
        Ok(self.reader.peek()?.map(|sim_nanos| Moment { tick: session.tick(), sim_nanos }))
    }

    fn tick(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        self.finish_jump(session)?;
        self.show_moment(session, false).map(drop)
    }

    fn show(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        let frame = self.recording.last_until(&Topic::Frames, self.time)?;
        let Some((log_time, message)) = frame else { return Ok(()) };
        let entry = Entry { topic: &Topic::Frames, log_time, message: &message };
        self.stage.publish(session, self.recording, entry)
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        self.stage.robots_by_state()
    }

    fn between_ticks(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        self.stage.update()?;
        self.stage.publish_closures(session)?;
        if let Some(search) = &mut self.contact_search
            && let Some(contacts) = search.poll(self.time)
        {
            self.stage.take_contacts(session, contacts)?;
        }
        session.refuse_commands()?;
        if session.commands_refused() > 0 && !std::mem::replace(&mut self.reported_commands, true) {
            regatta_plugin::tell!(
                "replay: commands are refused: the robots of a recording can't be steered"
            );
        }
        Ok(())
    }

    fn refuses(&self, kind: ControlKind) -> Option<RefusalReason> {
        (kind == ControlKind::Robots)
            .then(|| "a replay can't change the number of robots".to_owned())
    }

    fn seek(
        &mut self,
        session: &mut Session,
        sim_time: Duration,
    ) -> Result<Result<(), RefusalReason>, ReplayError> {
        match self.refuse_time(sim_time) {
            Some(reason) => Ok(Err(reason)),
            None => self.go_to(session, sim_time, false).map(Ok),
        }
    }

    fn at_end(&mut self, session: &mut Session) -> Result<bool, ReplayError> {
        let is_paused = session.clock_state() == ClockState::Paused;
        if self.args.repeat && !is_paused {
            let (start, _) = self.recording.span();
            self.go_to(session, start, false)?;
            return Ok(false);
        }
        let stays = self.args.hold || self.args.repeat || is_paused;
        if stays && !is_paused {
            session.pause();
            self.show(session)?;
        }
        Ok(!stays)
    }
}

/// Returns the part of a recording that a replay reads: all topics but those for other programs.
fn selection(recording: &Recording) -> Selection {
    let mut topics = recording.topics();
    topics.retain(|topic| {
        !matches!(topic, Topic::Poses | Topic::Robots | Topic::Graph | Topic::GraphPoints)
    });
    Selection::all_of(topics)
}
