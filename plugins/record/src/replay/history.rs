//! The history of a recording's runs: hot spots and figures over time of the whole recording,
//! independent of the part that is replayed.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use regatta_kit::RunHistory;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::frame::{FrameHeader, NO_EDGE, RobotState};
use regatta_plugin::history::{FleetSample, HistoryHeader, HotSpot};
use regatta_plugin::{Frame, HistoryPublisher, Participant, PublishError};

use super::stage::or_left_out;
use crate::contacts::ContactDecoder;
use crate::decode::MessageError;
use crate::reading::{Entry, ReadingError, Recording, Selection};
use crate::recorded::{FrameBuffer, RecordedColumn, RecordedFrame};
use crate::schema::Topic;

/// The least time between two frames that are counted, on the recording's clock, in nanoseconds.
const FRAME_EVERY: u64 = 100_000_000;
/// The time between two messages of the search.
const TELL_EVERY: Duration = Duration::from_millis(500);
/// The search works at most this long, and then rests as long: scrubbing needs the processor, too.
const WORKS: Duration = Duration::from_millis(20);
/// The time over which throughput is counted, in seconds.
const THROUGHPUT_SECS: f64 = 60.0;

/// The known part of the history of a recorded run.
#[derive(Clone, Debug, Default)]
pub(super) struct RecordedHistory {
    /// `run_id` is that of the recording.
    pub header: HistoryHeader,
    pub samples: Vec<FleetSample>,
    pub spots: Vec<HotSpot>,
}

/// Searches a recording, and passes the history of its run so far to `tell`, until that returns
/// `false`.
pub(super) fn search(
    recording: &Recording,
    mut tell: impl FnMut(RecordedHistory) -> bool,
) -> Result<(), ReadingError> {
    let mut topics = vec![Topic::Contacts, Topic::ContactUpdates, Topic::Frames];
    topics.extend(recording.topics().into_iter().filter(is_of_activities));
    let mut reader = recording.read(&Selection::all_of(topics))?;
    let (mut counter, mut next) = (Counter::default(), 0);
    let (mut told, mut rested) = (Instant::now(), Instant::now());
    while let Some(Entry { topic, log_time, message }) = reader.next()? {
        if is_of_activities(topic) {
            recording.located(topic, log_time, counter.take_activities(message))?;
        } else if *topic != Topic::Frames {
            recording.located(topic, log_time, counter.contacts.decode(topic, message))?;
        } else if log_time >= next {
            next = log_time.saturating_add(FRAME_EVERY);
            let frame = recording.located(topic, log_time, RecordedFrame::parse(message))?;
            if counter.is_of_another_run(&frame) && !tell(counter.history()) {
                return Ok(());
            }
            counter.count(&frame);
        }
        if told.elapsed() > TELL_EVERY {
            told = Instant::now();
            if !tell(counter.history()) {
                return Ok(());
            }
        }
        let worked = rested.elapsed();
        if worked > WORKS {
            std::thread::sleep(worked);
            rested = Instant::now();
        }
    }
    tell(counter.history());
    Ok(())
}

/// Whether a topic has the activities of robots, as a fleet manager published them.
fn is_of_activities(topic: &Topic) -> bool {
    topic.column().is_some_and(|name| name.as_str() == ACTIVITY.name())
}

/// The counter of a run's frames.
#[derive(Debug, Default)]
struct Counter {
    contacts: ContactDecoder,
    run: RunHistory,
    throughput: Throughput,
    /// The newest values of the column `activity`, and their run.
    activities: (u64, Vec<f32>),
    newest: FrameHeader,
    buffer: FrameBuffer,
}

impl Counter {
    /// Whether a frame ends the run that is being counted.
    fn is_of_another_run(&self, frame: &RecordedFrame<'_>) -> bool {
        self.newest.run_id != 0 && self.newest.run_id != frame.header.run_id
    }

    fn take_activities(&mut self, message: &[u8]) -> Result<(), MessageError> {
        let column = RecordedColumn::parse(message)?;
        self.activities = (column.run_id, column.values());
        Ok(())
    }

    fn count(&mut self, recorded: &RecordedFrame<'_>) {
        let Some(frame) = self.buffer.fill(recorded) else { return };
        let throughput = self.throughput.count(&frame);
        let (run_id, values) = &self.activities;
        let published = if *run_id == frame.run_id() { values.as_slice() } else { &[] };
        self.run.add(&frame, self.contacts.list(), published, || throughput);
        self.newest = recorded.header;
    }

    fn history(&self) -> RecordedHistory {
        let header = HistoryHeader {
            run_id: self.newest.run_id,
            tick: self.newest.tick,
            sim_time_nanos: self.newest.sim_time_nanos,
            began_nanos: (self.run.spots.began().1 * 1e9) as u64,
            sequence: 0,
        };
        RecordedHistory {
            header,
            samples: self.run.series.samples.clone(),
            spots: self.run.spots.list(),
        }
    }
}

/// The counter of robots that enter an edge.
#[derive(Debug, Default)]
struct Throughput {
    run_id: u64,
    began: f64,
    /// By robot: the edge that it was on in the frame before.
    edges: Vec<u32>,
    /// The frames of the last minute: simulated seconds, and the robots that have entered an edge.
    entered: VecDeque<(f64, u32)>,
}

impl Throughput {
    /// Counts a frame. Returns the rate at which robots entered an edge in the last minute, per
    /// hour; `None` for the first frame of a run.
    fn count(&mut self, frame: &Frame<'_>) -> Option<f32> {
        let secs = frame.sim_time().as_secs_f64();
        if self.run_id != frame.run_id() {
            *self = Self { run_id: frame.run_id(), began: secs, ..Self::default() };
        }
        self.edges.resize(frame.len(), NO_EDGE);
        let mut entered = 0;
        for ((before, edge), state) in self.edges.iter_mut().zip(frame.edge()).zip(frame.state()) {
            let edge = if *state == RobotState::Absent as u8 { NO_EDGE } else { *edge };
            entered += u32::from(*before != NO_EDGE && edge != NO_EDGE && edge != *before);
            *before = edge;
        }
        self.entered.push_back((secs, entered));
        while self.entered.front().is_some_and(|(at, _)| *at <= secs - THROUGHPUT_SECS) {
            self.entered.pop_front();
        }
        let counted_secs = (secs - self.began).min(THROUGHPUT_SECS);
        let sum: u32 = self.entered.iter().map(|(_, entered)| entered).sum();
        (counted_secs > 0.0).then(|| (3600.0 * f64::from(sum) / counted_secs) as f32)
    }
}

/// The histories that were found, and the one that is published.
#[derive(Debug)]
pub(super) struct Histories {
    publisher: HistoryPublisher,
    /// One for each recorded run.
    found: Vec<RecordedHistory>,
    /// The run of the replay, and the recorded run that it shows.
    shown: (u64, u64),
    /// Whether the history of the shown run has changed since it was published.
    is_changed: bool,
}

impl Histories {
    /// Opens the services. Returns `None`, and prints the reason, if another process publishes the
    /// history, or shared memory fails.
    pub fn open(participant: &Participant) -> Option<Self> {
        let publisher =
            or_left_out("hot spots and plots are", HistoryPublisher::open_on(participant))?;
        Some(Self { publisher, found: Vec::new(), shown: (0, 0), is_changed: false })
    }

    /// Takes the known part of the history of a recorded run.
    pub fn take(&mut self, history: RecordedHistory) {
        let run_id = history.header.run_id;
        self.is_changed |= run_id == self.shown.1;
        match self.found.iter_mut().find(|known| known.header.run_id == run_id) {
            Some(known) => *known = history,
            None => self.found.push(history),
        }
    }

    /// Publishes the history of the shown recorded run under the run of the replay, if either has
    /// changed.
    pub fn show(&mut self, run_id: u64, recorded_run: u64) -> Result<(), PublishError> {
        let shown = (run_id, recorded_run);
        self.is_changed |= std::mem::replace(&mut self.shown, shown) != shown;
        self.publish()
    }

    /// Publishes a changed history, and connects readers that have joined.
    pub fn update(&mut self) -> Result<(), PublishError> {
        self.publish()?;
        self.publisher.update();
        Ok(())
    }

    fn publish(&mut self) -> Result<(), PublishError> {
        let (run_id, recorded_run) = self.shown;
        if !std::mem::take(&mut self.is_changed) {
            return Ok(());
        }
        let history = self.found.iter().find(|known| known.header.run_id == recorded_run);
        let Some(history) = history else { return Ok(()) };
        let header = HistoryHeader { run_id, ..history.header };
        self.publisher.publish(&header, &history.samples, &history.spots)
    }
}
