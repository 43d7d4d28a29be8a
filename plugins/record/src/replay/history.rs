//! The history of a recording's runs: hot spots and figures over time of all of it, whatever part
//! is replayed.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use regatta_kit::RunHistory;
use regatta_plugin::Frame;
use regatta_plugin::frame::{
    ColumnsMut, FrameHeader, Line, NO_EDGE, RobotState, frame_lines, stride_lines,
};
use regatta_plugin::history::{FleetSample, HistoryHeader, HotSpot};

use crate::contacts::ContactDecoder;
use crate::reading::{Entry, ReadingError, Recording, Selection};
use crate::recorded::RecordedFrame;
use crate::schema::Topic;

/// The least time between two frames that are counted, on the recording's clock, in nanoseconds.
const FRAME_EVERY: u64 = 100_000_000;
/// The time between two messages of the search.
const TELL_EVERY: Duration = Duration::from_millis(500);
/// The search works at most so long, and then rests as long: whoever scrubs wants the processor,
/// too.
const WORKS: Duration = Duration::from_millis(20);
/// The time over which throughput is counted, in seconds.
const THROUGHPUT_SECS: f64 = 60.0;

/// The history of a recorded run, as far as it is known.
#[derive(Clone, Debug, Default)]
pub(super) struct RecordedHistory {
    /// `run_id` is that of the recording.
    pub header: HistoryHeader,
    pub samples: Vec<FleetSample>,
    pub spots: Vec<HotSpot>,
}

/// Searches a recording, and passes on the history of its run so far, until `tell` wants no more.
pub(super) fn search(
    recording: &Recording,
    mut tell: impl FnMut(RecordedHistory) -> bool,
) -> Result<(), ReadingError> {
    let topics = vec![Topic::Contacts, Topic::ContactUpdates, Topic::Frames];
    let mut reader = recording.read(&Selection::all_of(topics))?;
    let (mut counter, mut next) = (Counter::default(), 0);
    let (mut told, mut rested) = (Instant::now(), Instant::now());
    while let Some(Entry { topic, log_time, message }) = reader.next()? {
        let damaged = |reason| recording.malformed(topic, log_time, reason);
        if *topic != Topic::Frames {
            counter.contacts.decode(topic, message).map_err(damaged)?;
        } else if log_time >= next {
            next = log_time.saturating_add(FRAME_EVERY);
            let frame = RecordedFrame::parse(message).map_err(damaged)?;
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

/// Counts the frames of a run.
#[derive(Debug, Default)]
struct Counter {
    contacts: ContactDecoder,
    run: RunHistory,
    throughput: Throughput,
    newest: FrameHeader,
    lines: Vec<Line>,
}

impl Counter {
    /// Whether a frame ends the run that is being counted.
    fn is_of_another_run(&self, frame: &RecordedFrame<'_>) -> bool {
        self.newest.run_id != 0 && self.newest.run_id != frame.header.run_id
    }

    fn count(&mut self, recorded: &RecordedFrame<'_>) {
        let robots = recorded.len();
        self.lines.resize(frame_lines(robots), Line::default());
        recorded.copy_to(&mut ColumnsMut::split(&mut self.lines, robots));
        let header = FrameHeader { stride_lines: stride_lines(robots) as u32, ..recorded.header };
        let Some(frame) = Frame::new(&header, &self.lines) else { return };
        let throughput = self.throughput.count(&frame);
        self.run.add(&frame, self.contacts.list(), || throughput);
        self.newest = header;
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

/// Counts how many robots enter an edge.
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
    /// Counts a frame. Returns the robots that have entered an edge in the last minute, per hour;
    /// `None` for the first frame of a run.
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
