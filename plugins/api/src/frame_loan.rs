//! A frame under construction.

use std::time::{SystemTime, UNIX_EPOCH};

use iceoryx2::sample_mut::SampleMut;

use crate::error::PublishError;
use crate::frame::{ColumnsMut, FrameHeader, Line};
use crate::qos::Ipc;

/// A frame under construction, in shared memory. Dropped without [`send`](Self::send), it is never seen.
pub struct FrameLoan {
    sample: SampleMut<Ipc, [Line], FrameHeader>,
    robots: usize,
}

impl FrameLoan {
    pub(crate) fn new(sample: SampleMut<Ipc, [Line], FrameHeader>, robots: usize) -> Self {
        Self { sample, robots }
    }

    /// The header. `robots` and `stride_lines` describe the columns: leave them as they are.
    pub fn header_mut(&mut self) -> &mut FrameHeader {
        self.sample.user_header_mut()
    }

    /// The columns, to be written in full for all robots.
    pub fn columns_mut(&mut self) -> ColumnsMut<'_> {
        ColumnsMut::split(self.sample.payload_mut(), self.robots)
    }

    /// Publishes the frame, with the time of day in its header. From here on readers have it.
    ///
    /// # Errors
    /// [`PublishError::Send`] if a connection is broken; the readers on the others have it.
    pub fn send(mut self) -> Result<(), PublishError> {
        self.sample.user_header_mut().wall_time_nanos = wall_time_nanos();
        self.sample.send().map_err(|e| PublishError::Send { what: "a frame", reason: e.to_string() })?;
        Ok(())
    }
}

impl core::fmt::Debug for FrameLoan {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("FrameLoan").field("robots", &self.robots).finish_non_exhaustive()
    }
}

/// Time of day, in nanoseconds since the Unix epoch.
pub(crate) fn wall_time_nanos() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64)
}
