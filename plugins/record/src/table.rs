//! A recording as a table: for each frame, what is known of each robot at that time.

use std::time::Duration;

use regatta_plugin::ColumnName;
use regatta_plugin::frame::{FrameHeader, RobotState};
use regatta_plugin::world::EdgeRecord;

use crate::decode::{self, MessageError, RecordedWorld};
use crate::reading::{Entry, ReadingError, Recording, Selection};
use crate::recorded::{RecordedColumn, RecordedFrame, Row};
use crate::schema::Topic;

/// A frame and what goes with it.
pub(crate) struct Snapshot<'state> {
    /// Counts the runs of the recording, from 0.
    pub run: u32,
    /// On the recording's clock.
    pub time: Duration,
    frame: RecordedFrame<'state>,
    world: &'state RecordedWorld,
    columns: &'state [Vec<f32>],
}

impl Snapshot<'_> {
    pub fn header(&self) -> &FrameHeader {
        &self.frame.header
    }

    /// Rows of the frame; some may hold no robot.
    pub fn len(&self) -> usize {
        self.frame.len()
    }

    /// A robot, if there is one of that id.
    pub fn row(&self, robot: usize) -> Option<Row> {
        self.frame.row(robot).filter(|row| RobotState::from_number(row.state) != RobotState::Absent)
    }

    /// The edge that a robot is on.
    pub fn edge(&self, row: &Row) -> Option<&EdgeRecord> {
        self.world.edges.get(row.edge as usize)
    }

    /// The newest value of a column at this time, by the column's place in the list that was asked for.
    pub fn column(&self, column: usize, robot: usize) -> Option<f32> {
        self.columns.get(column)?.get(robot).copied()
    }

    pub fn edges(&self) -> &[EdgeRecord] {
        &self.world.edges
    }
}

/// What the messages so far tell.
struct State {
    names: Vec<ColumnName>,
    columns: Vec<Vec<f32>>,
    world: RecordedWorld,
    frame: Vec<u8>,
    has_frame: bool,
    run: u32,
    run_id: Option<u64>,
}

/// Hands over each time's snapshot, in order.
pub(crate) fn walk<E: From<ReadingError>>(
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
        // A column may stand after the frame of the same time.
        while reader.peek()? == Some(time) {
            let Some(entry) = reader.next()? else { break };
            state.take(&entry).map_err(|reason| recording.malformed(entry.topic, time, reason))?;
        }
        let snapshot = state.snapshot(time);
        if let Some(snapshot) = snapshot.map_err(|reason| recording.malformed(&Topic::Frames, time, reason))? {
            each(&snapshot)?;
        }
    }
    Ok(())
}

impl State {
    fn take(&mut self, entry: &Entry<'_>) -> Result<(), MessageError> {
        match entry.topic {
            Topic::Frames => {
                self.frame.clear();
                self.frame.extend_from_slice(entry.message);
                self.has_frame = true;
            }
            Topic::World => self.world = decode::world(entry.message)?,
            Topic::Column(name) => {
                if let Some(column) = self.names.iter().position(|known| known == name) {
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
