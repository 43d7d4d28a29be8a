//! Reads a recording as a table: for each frame, the state of each robot at that time.

use std::time::Duration;

use regatta_plugin::ColumnName;
use regatta_plugin::frame::{FrameHeader, RobotState};
use regatta_plugin::world::{CurveRecord, EdgeRecord};

use crate::decode::{self, MessageError, RecordedWorld};
use crate::reading::{ReadingError, Recording, Selection};
use crate::recorded::{RecordedColumn, RecordedFrame, Row};
use crate::schema::Topic;

/// A frame with the world and the columns of its time.
pub(crate) struct Snapshot<'state> {
    /// The number of the run in the recording, from 0.
    pub run: u32,
    /// The time on the recording's clock.
    pub time: Duration,
    frame: RecordedFrame<'state>,
    world: &'state RecordedWorld,
    columns: &'state [Vec<f32>],
}

impl Snapshot<'_> {
    pub fn header(&self) -> &FrameHeader {
        &self.frame.header
    }

    /// Returns the number of rows of the frame, including those of absent robots.
    pub fn len(&self) -> usize {
        self.frame.len()
    }

    /// Returns a robot's row, or `None` if the robot is absent.
    pub fn row(&self, robot: usize) -> Option<Row> {
        self.frame.row(robot).filter(|row| RobotState::from_number(row.state) != RobotState::Absent)
    }

    /// Returns the edge of a robot's row, if it is on one.
    pub fn edge(&self, row: &Row) -> Option<&EdgeRecord> {
        self.world.data.edges.get(row.edge as usize)
    }

    /// Returns a robot's newest value in a column at this time. `column` is an index into the list
    /// of requested columns.
    pub fn column(&self, column: usize, robot: usize) -> Option<f32> {
        self.columns.get(column)?.get(robot).copied()
    }

    /// Returns the curves of the route graph's edges.
    pub fn curves(&self) -> &[CurveRecord] {
        &self.world.data.curves
    }
}

/// The newest values of all messages so far.
struct State {
    names: Vec<ColumnName>,
    columns: Vec<Vec<f32>>,
    world: RecordedWorld,
    frame: Vec<u8>,
    has_frame: bool,
    run: u32,
    run_id: Option<u64>,
}

/// A part of a recording, in nanoseconds on its clock. The end is included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub from: u64,
    pub to: u64,
}

impl Span {
    /// Returns the requested part of a recording: all of it, unless it is limited.
    pub fn of(
        recording: &Recording,
        from: Option<humantime::Duration>,
        to: Option<humantime::Duration>,
    ) -> Self {
        let (start, end) = recording.span();
        let (from, to) = (from.map_or(start, Into::into), to.map_or(end, Into::into));
        Self { from: saturating_nanos(from), to: saturating_nanos(to) }
    }

    /// Returns how much of the span lies before a time, from 0 to 1.
    pub fn done(&self, time: Duration) -> f64 {
        let done = (time.as_nanos() as u64).saturating_sub(self.from);
        done as f64 / (self.to.saturating_sub(self.from) as f64).max(1.0)
    }
}

fn saturating_nanos(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// Calls `each` with the snapshot of every frame in a part of a recording, in order of time.
pub(crate) fn for_each_snapshot<E: From<ReadingError>>(
    recording: &Recording,
    columns: &[ColumnName],
    span: &Span,
    mut each: impl FnMut(&Snapshot<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let Span { from, to } = *span;
    let mut state = State::before(recording, columns, from)?;
    let mut topics = state_topics(columns);
    topics.push(Topic::Frames);
    let mut reader = recording.read(&Selection { from, to: to.max(from), topics })?;
    while let Some(time) = reader.peek()? {
        // A column may come after the frame of the same time.
        while let Some(entry) = reader.next_at(time)? {
            if *entry.topic == Topic::Frames {
                reader.swap_message(&mut state.frame);
                state.has_frame = true;
            } else {
                let updated = state.update(entry.topic, entry.message);
                recording.located(entry.topic, time, updated)?;
            }
        }
        let snapshot = state.snapshot(time);
        if let Some(snapshot) = recording.located(&Topic::Frames, time, snapshot)? {
            each(&snapshot)?;
        }
    }
    Ok(())
}

/// Returns the topics that a frame is completed from.
fn state_topics(columns: &[ColumnName]) -> Vec<Topic> {
    let mut topics = vec![Topic::World];
    topics.extend(columns.iter().cloned().map(Topic::Column));
    topics
}

impl State {
    /// Returns the state before a time.
    fn before(
        recording: &Recording,
        columns: &[ColumnName],
        time: u64,
    ) -> Result<Self, ReadingError> {
        let mut state = Self {
            names: columns.to_vec(),
            columns: vec![Vec::new(); columns.len()],
            world: RecordedWorld::default(),
            frame: Vec::new(),
            has_frame: false,
            run: 0,
            run_id: None,
        };
        for topic in state_topics(columns) {
            if let Some((at, message)) = recording.state_before(&topic, time)? {
                recording.located(&topic, at, state.update(&topic, &message))?;
            }
        }
        Ok(state)
    }

    fn update(&mut self, topic: &Topic, message: &[u8]) -> Result<(), MessageError> {
        match topic {
            Topic::World => self.world = decode::world(message)?,
            Topic::Column(name) => {
                if let Some(column) = self.names.iter().position(|requested| requested == name) {
                    self.columns[column] = RecordedColumn::parse(message)?.values();
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn snapshot(&mut self, time: u64) -> Result<Option<Snapshot<'_>>, MessageError> {
        if !std::mem::take(&mut self.has_frame) {
            return Ok(None);
        }
        let frame = RecordedFrame::parse(&self.frame)?;
        let before = self.run_id.replace(frame.header.run_id);
        self.run += u32::from(before.is_some_and(|before| before != frame.header.run_id));
        let (run, time) = (self.run, Duration::from_nanos(time));
        Ok(Some(Snapshot { run, time, frame, world: &self.world, columns: &self.columns }))
    }
}
