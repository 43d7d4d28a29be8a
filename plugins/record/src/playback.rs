//! Reads a whole recording as a fleet published it, for programs that judge or sum up a run without
//! a fleet.

use std::path::Path;
use std::time::Duration;

use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::order::{OrderHeader, OrderRecord};
use regatta_plugin::{Frame, World};

use crate::contacts::ContactDecoder;
use crate::decode::{self, MessageError};
use crate::reading::{ReadingError, Recording, Selection};
use crate::recorded::{FrameBuffer, RecordedColumn, RecordedFrame};
use crate::schema::Topic;

/// Something that a recorded fleet published.
#[derive(Clone, Copy, Debug)]
pub enum Published<'a> {
    /// The route graph and the robot types.
    World(&'a World<'a>),
    /// The column `type`.
    Types(&'a [f32]),
    /// The column `activity`.
    Activities(&'a [f32]),
    /// The events of a tick.
    Events(EventHeader, &'a [EventRecord]),
    /// The order log's records of a tick, and the number of samples that the recorder missed before
    /// them.
    Orders(OrderHeader, u64, &'a [OrderRecord]),
    /// A frame.
    Frame(Frame<'a>),
}

/// Passes everything that a recorded fleet published to `take`, in order of time, and the frame
/// last among messages of the same time.
///
/// # Errors
/// Returns a [`ReadingError`] if the file isn't a recording with frames, or is damaged.
pub fn play(path: &Path, mut take: impl FnMut(Published<'_>)) -> Result<(), ReadingError> {
    let recording = Recording::open_frames(path)?;
    let mut topics = vec![Topic::World, Topic::Events, Topic::Orders, Topic::Frames];
    topics.extend(Topic::types().into_iter().chain(Topic::activities()));
    let mut reader = recording.read(&Selection::all_of(topics))?;
    let mut player = Player::default();
    let mut frames: Vec<Vec<u8>> = Vec::new();
    while let Some(time) = reader.peek()? {
        while let Some(entry) = reader.next_at(time)? {
            if *entry.topic == Topic::Frames {
                frames.push(entry.message.to_vec());
            } else {
                let played = player.publish(entry.topic, entry.message, &mut take);
                recording.located(entry.topic, time, played)?;
            }
        }
        for frame in frames.drain(..) {
            recording.located(&Topic::Frames, time, player.frame(&frame, &mut take))?;
        }
    }
    Ok(())
}

#[derive(Default)]
struct Player {
    buffer: FrameBuffer,
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
                    take(Published::World(&world.data.view(world.run_id, 1)));
                }
            }
            Topic::Column(_) => {
                let values = RecordedColumn::parse(message)?.values();
                take(match Topic::activities().as_ref() == Some(topic) {
                    true => Published::Activities(&values),
                    false => Published::Types(&values),
                });
            }
            Topic::Events => {
                let (header, events) = decode::events(message)?;
                take(Published::Events(header, &events));
            }
            Topic::Orders => {
                let (header, orders, missed) = decode::orders(message)?;
                take(Published::Orders(header, missed, &orders));
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
        let header = recorded.header;
        let of_run = self.last.filter(|last| last.run_id == header.run_id && last.sequence > 0);
        let next = of_run.map(|last| last.sequence.saturating_add(1));
        let missed = next.map_or(0, |next| header.sequence.saturating_sub(next));
        self.last = Some(header);
        if let Some(frame) = self.buffer.fill(&recorded) {
            take(Published::Frame(frame.after_missing(missed)));
        }
        Ok(())
    }
}

impl Recording {
    /// Calls `each` with every frame and its time in the recording, in order, until it returns an
    /// error.
    ///
    /// # Errors
    /// Returns a [`ReadingError`] if the recording is damaged, or the error of `each`.
    pub fn frames<E: From<ReadingError>>(
        &self,
        mut each: impl FnMut(Duration, &Frame<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut buffer = FrameBuffer::default();
        let mut reader = self.read(&Selection::all_of(vec![Topic::Frames]))?;
        while let Some(entry) = reader.next()? {
            let recorded = RecordedFrame::parse(entry.message);
            let recorded = self.located(entry.topic, entry.log_time, recorded)?;
            if let Some(frame) = buffer.fill(&recorded) {
                each(Duration::from_nanos(entry.log_time), &frame)?;
            }
        }
        Ok(())
    }

    /// Calls `each` with every list of contacts and its time in the recording, in order, until it
    /// returns an error.
    ///
    /// # Errors
    /// Returns a [`ReadingError`] if the recording is damaged, or the error of `each`.
    pub fn contacts<E: From<ReadingError>>(
        &self,
        mut each: impl FnMut(Duration, &ContactHeader, &[ContactRecord]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut decoder = ContactDecoder::default();
        let topics = vec![Topic::Contacts, Topic::ContactUpdates];
        let mut reader = self.read(&Selection::all_of(topics))?;
        while let Some(entry) = reader.next()? {
            let decoded = decoder.decode(entry.topic, entry.message);
            let is_new = self.located(entry.topic, entry.log_time, decoded)?;
            if let Some((header, pairs)) = decoder.list().filter(|_| is_new) {
                each(Duration::from_nanos(entry.log_time), header, pairs)?;
            }
        }
        Ok(())
    }
}
