//! The description of a recording: its name, its time, and marks at the times of incidents. A
//! replay publishes it on `regatta/F/recording`, so that any reader can show a timeline with marks.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;
use super::{padded, text};

/// The iceoryx2 user header of `regatta/F/recording`. Its payload is a [`RecordingMark`] for each
/// mark, sorted by time.
///
/// Times are those of the recording's clock: the simulated time of its first run; further runs
/// follow without a gap.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_RecordingHeader"))]
pub struct RecordingHeader {
    /// The run of the frames that [`ahead_nanos`](Self::ahead_nanos) is about.
    pub run_id: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
    /// The first time of the recording, in nanoseconds.
    pub start_nanos: u64,
    /// The last time of the recording, in nanoseconds.
    pub end_nanos: u64,
    /// The recording's clock minus the simulated time of the frames of this run, in nanoseconds;
    /// wraps where it is negative.
    pub ahead_nanos: u64,
    /// Marks up to this time are known; the recording is still being searched for those after it.
    pub searched_nanos: u64,
    /// Marks that were left out because there were too many.
    pub left_out: u64,
    /// The name of the file without its folder, in UTF-8 padded with zeros.
    pub file: [u8; 128],
    /// The last note at or before the frame that was shown when this was published, in UTF-8 padded
    /// with zeros.
    pub note: [u8; 128],
}

/// An incident in a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_RecordingMark"))]
pub struct RecordingMark {
    /// The time on the recording's clock, in nanoseconds.
    pub time_nanos: u64,
    /// A [`MarkKind`].
    pub kind: u32,
    /// The robot, or the first of several.
    pub robot: u32,
    /// The number of robots, or of contacts, that this happened to in the same tick.
    pub count: u32,
    /// Zero.
    pub reserved: u32,
}

numbered! {
    /// Kinds of [`RecordingMark`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum MarkKind: u32 {
        /// Two robots began to touch.
        Contact = 1,
        /// A robot can't continue, or is broken.
        Fault = 2,
        /// A robot was held and has come to a stop, or stalls.
        Stop = 3,
        /// A note of a user.
        Note = 4,
    }
}

impl RecordingHeader {
    /// Creates the header of a recording, with its times still zero. `file` is cut to 128 bytes.
    pub fn new(file: &str) -> Self {
        Self { file: padded(file), ..Self::zeroed() }
    }

    /// The name of the file.
    pub fn file(&self) -> &str {
        text(&self.file)
    }

    /// The last note at or before the shown frame.
    pub fn note(&self) -> &str {
        text(&self.note)
    }

    /// Sets the [`note`](Self::note). It is cut to 128 bytes.
    pub fn set_note(&mut self, note: &str) {
        self.note = padded(note);
    }

    /// The time on the recording's clock of a frame of this run, in nanoseconds.
    pub fn time_of(&self, sim_time_nanos: u64) -> u64 {
        sim_time_nanos.wrapping_add(self.ahead_nanos)
    }
}

impl Default for RecordingHeader {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl RecordingMark {
    /// The kind of the mark; `None` if this contract doesn't know it.
    pub fn kind(&self) -> Option<MarkKind> {
        MarkKind::from_number(self.kind)
    }
}

super::sequence::sequenced!(RecordingHeader: sequence);
