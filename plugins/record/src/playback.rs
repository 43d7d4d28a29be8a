//! Reads a whole recording as what its fleet published, for programs that judge or sum up a run
//! without a fleet.

use std::path::Path;

use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::task::{TaskHeader, TaskRecord};
use regatta_plugin::{Frame, World};

use crate::decode::{self, MessageError};
use crate::reading::{ReadingError, Recording, Selection};
use crate::recorded::{RecordedColumn, RecordedFrame};
use crate::schema::{PRODUCERS_COLUMN, Topic};

/// Something that a recorded fleet published.
#[derive(Clone, Copy, Debug)]
pub enum Published<'a> {
    /// The route graph and the robot types.
    World(World<'a>),
    /// The column `type`.
    Types(&'a [f32]),
    /// The events of a tick.
    Events(EventHeader, &'a [EventRecord]),
    /// The task log's records of a tick, and how many samples the recorder missed before them.
    Tasks(TaskHeader, u64, &'a [TaskRecord]),
    /// A frame.
    Frame(Frame<'a>),
}

/// Passes what a recorded fleet published to `take`: in the order of time; of one time the frame
/// last.
///
/// # Errors
/// [`ReadingError`] if the file isn't a recording with frames, or is damaged.
pub fn play(path: &Path, mut take: impl FnMut(Published<'_>)) -> Result<(), ReadingError> {
    let recording = Recording::open_frames(path)?;
    let types = PRODUCERS_COLUMN.parse().map(Topic::Column).ok();
    let topics = [Topic::World, Topic::Events, Topic::Tasks, Topic::Frames]
        .into_iter()
        .chain(types)
        .collect();
    let mut reader = recording.read(&Selection::all_of(topics))?;
    let mut player = Player::default();
    let mut frames: Vec<Vec<u8>> = Vec::new();
    while let Some(time) = reader.peek()? {
        while reader.peek()? == Some(time) {
            let Some(entry) = reader.next()? else { break };
            let topic = entry.topic;
            if *topic == Topic::Frames {
                frames.push(entry.message.to_vec());
                continue;
            }
            let played = player.publish(topic, entry.message, &mut take);
            played.map_err(|reason| recording.malformed(topic, time, reason))?;
        }
        for frame in frames.drain(..) {
            let played = player.frame(&frame, &mut take);
            played.map_err(|reason| recording.malformed(&Topic::Frames, time, reason))?;
        }
    }
    Ok(())
}

#[derive(Default)]
struct Player {
    lines: Vec<Line>,
    last: Option<FrameHeader>,
}

impl Player {
    fn publish(
        &self,
        topic: &Topic,
        message: &[u8],
        take: &mut impl FnMut(Published<'_>),
    ) -> Result<(), MessageError> {
        match topic {
            Topic::World => {
                let world = decode::world(message)?;
                if !world.is_repeated || self.last.is_none() {
                    take(Published::World(world.data.view(world.run_id, 1)));
                }
            }
            Topic::Column(_) => take(Published::Types(&RecordedColumn::parse(message)?.values())),
            Topic::Events => {
                let (header, events) = decode::events(message)?;
                take(Published::Events(header, &events));
            }
            Topic::Tasks => {
                let (header, tasks, missed) = decode::tasks(message)?;
                take(Published::Tasks(header, missed, &tasks));
            }
            _ => {}
        }
        Ok(())
    }

    fn frame(
        &mut self,
        message: &[u8],
        take: &mut impl FnMut(Published<'_>),
    ) -> Result<(), MessageError> {
        let recorded = RecordedFrame::parse(message)?;
        let robots = recorded.len();
        let header = FrameHeader { stride_lines: stride_lines(robots) as u32, ..recorded.header };
        self.lines.resize(frame_lines(robots), Line::default());
        recorded.copy_to(&mut ColumnsMut::split(&mut self.lines, robots));
        let of_run = self.last.filter(|last| last.run_id == header.run_id && last.sequence > 0);
        let missed = of_run.map_or(0, |last| header.sequence.saturating_sub(last.sequence + 1));
        self.last = Some(header);
        if let Some(frame) = Frame::new(&header, &self.lines) {
            take(Published::Frame(frame.after_missing(missed)));
        }
        Ok(())
    }
}
