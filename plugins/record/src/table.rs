//! Reads a recording as a table: for each frame, the state of each robot at that time.

use std::time::Duration;

use regatta_plugin::ColumnName;
use regatta_plugin::frame::{FrameHeader, RobotState};
use regatta_plugin::world::EdgeRecord;

use crate::decode::{self, MessageError, RecordedWorld};
use crate::reading::{Entry, ReadingError, Recording, Selection};
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
        self.world.edges.get(row.edge as usize)
    }

    /// Returns a robot's newest value in a column at this time. `column` is an index into the list of requested columns.
    pub fn column(&self, column: usize, robot: usize) -> Option<f32> {
        self.columns.get(column)?.get(robot).copied()
    }

    pub fn edges(&self) -> &[EdgeRecord] {
        &self.world.edges
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

/// Calls `each` with the snapshot of every frame, in order of time.
pub(crate) fn for_each_snapshot<E: From<ReadingError>>(
    recording: &Recording,
    columns: &[ColumnName],
    mut each: impl FnMut(&Snapshot<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let topics = [Topic::Frames, Topic::World].into_iter().chain(columns.iter().cloned().map(Topic::Column));
    let mut reader = recording.read(&Selection { from: 0, topics: topics.collect() })?;
    let mut state = State {
        names: columns.to_vec(),
        columns: vec![Vec::new(); columns.len()],
        world: RecordedWorld::default(),
        frame: Vec::new(),
        has_frame: false,
        run: 0,
        run_id: None,
    };
    while let Some(time) = reader.peek()? {
        // A column may come after the frame of the same time.
        while reader.peek()? == Some(time) {
            let Some(entry) = reader.next()? else { break };
            state.update(&entry).map_err(|reason| recording.malformed(entry.topic, time, reason))?;
        }
        let snapshot = state.snapshot(time);
        if let Some(snapshot) = snapshot.map_err(|reason| recording.malformed(&Topic::Frames, time, reason))? {
            each(&snapshot)?;
        }
    }
    Ok(())
}

impl State {
    fn update(&mut self, entry: &Entry<'_>) -> Result<(), MessageError> {
        match entry.topic {
            Topic::Frames => {
                self.frame.clear();
                self.frame.extend_from_slice(entry.message);
                self.has_frame = true;
            }
            Topic::World => self.world = decode::world(entry.message)?,
            Topic::Column(name) => {
                if let Some(column) = self.names.iter().position(|requested| requested == name) {
                    self.columns[column] = RecordedColumn::parse(entry.message)?.values();
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
