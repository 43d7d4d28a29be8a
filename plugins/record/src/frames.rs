//! Reads a recording's frames and contacts as those of a live fleet.

use std::time::Duration;

use regatta_plugin::Frame;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};

use crate::contacts::ContactDecoder;
use crate::reading::{ReadingError, Recording, Selection};
use crate::recorded::RecordedFrame;
use crate::schema::Topic;

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
        let mut lines = Vec::new();
        let mut reader = self.read(&Selection::all_of(vec![Topic::Frames]))?;
        while let Some(entry) = reader.next()? {
            let damaged = |reason| self.malformed(entry.topic, entry.log_time, reason);
            let recorded = RecordedFrame::parse(entry.message).map_err(damaged)?;
            let robots = recorded.len();
            lines.resize(frame_lines(robots), Line::default());
            recorded.copy_to(&mut ColumnsMut::split(&mut lines, robots));
            let header =
                FrameHeader { stride_lines: stride_lines(robots) as u32, ..recorded.header };
            if let Some(frame) = Frame::new(&header, &lines) {
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
        let mut reader =
            self.read(&Selection::all_of(vec![Topic::Contacts, Topic::ContactUpdates]))?;
        while let Some(entry) = reader.next()? {
            let damaged = |reason| self.malformed(entry.topic, entry.log_time, reason);
            let is_new = decoder.decode(entry.topic, entry.message).map_err(damaged)?;
            if let Some((header, pairs)) = decoder.list().filter(|_| is_new) {
                each(Duration::from_nanos(entry.log_time), header, pairs)?;
            }
        }
        Ok(())
    }
}
