//! A frame under construction.

use core::cell::Cell;
use std::rc::Rc;
use std::time::{SystemTime, UNIX_EPOCH};

use super::error::PublishError;
use super::slices::Sequence;
use crate::records::frame::{ColumnsMut, FrameHeader, Line};
use crate::transport::Loan;

/// A frame under construction, where its readers find it. Dropped without [`send`](Self::send), it is never
/// seen.
pub struct FrameLoan {
    sample: Loan<Line, FrameHeader>,
    robots: usize,
    sequence: Sequence,
    last_tick: LastTick,
}

/// Run and tick of the frame that was sent last.
pub(super) type LastTick = Rc<Cell<Option<(u64, u64)>>>;

impl FrameLoan {
    pub(super) fn new(
        sample: Loan<Line, FrameHeader>,
        robots: usize,
        sequence: Sequence,
        last_tick: LastTick,
    ) -> Self {
        Self { sample, robots, sequence, last_tick }
    }

    /// The header. `robots` and `stride_lines` describe the columns and must not be changed;
    /// `sequence`, `repeated` and `wall_time_nanos` are filled in by [`send`](Self::send).
    pub fn header_mut(&mut self) -> &mut FrameHeader {
        self.sample.header_mut()
    }

    /// The columns, to be written in full for all robots.
    pub fn columns_mut(&mut self) -> ColumnsMut<'_> {
        ColumnsMut::split(self.sample.records_mut(), self.robots)
    }

    /// Publishes the frame, with its sequence number and the time of day in its header. From here
    /// on readers have it: everything that belongs to its tick (events, the command log, columns)
    /// must have been published before.
    ///
    /// # Errors
    /// [`PublishError::Send`] if a connection is broken; the readers on the others have it.
    pub fn send(mut self) -> Result<(), PublishError> {
        let header = self.sample.header_mut();
        let tick = (header.run_id, header.tick);
        header.repeated = (self.last_tick.replace(Some(tick)) == Some(tick)).into();
        header.sequence = self.sequence.next(header.run_id);
        header.wall_time_nanos = wall_time_nanos();
        self.sample.send().map(drop)
    }
}

impl core::fmt::Debug for FrameLoan {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("FrameLoan").field("robots", &self.robots).finish_non_exhaustive()
    }
}

/// The time of day, in nanoseconds since the Unix epoch.
pub(super) fn wall_time_nanos() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64)
}
