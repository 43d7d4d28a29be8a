//! Both sides of the description of a recording: its replay publishes it, any process reads it.

use super::error::{OpenError, PublishError, ReadError};
use super::receive::Newest;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::recording::{RecordingHeader, RecordingMark};

/// Publishes the description of a recording and its marks. Only a replay does, as the fleet's
/// producer.
///
/// ```
/// use regatta_plugin::recording::RecordingHeader;
/// use regatta_plugin::{Participant, RecordingPublisher, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-recording-{}", std::process::id()).parse()?;
/// let mut publisher = RecordingPublisher::open_on(&Participant::join(&fleet, "replay")?)?;
/// publisher.publish(&RecordingHeader::new("night shift.mcap"), &[])?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RecordingPublisher {
    sender: SliceSender<RecordingMark, RecordingHeader>,
}

impl RecordingPublisher {
    /// Opens a fleet's recording for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes it, [`OpenError::OtherVersion`] if
    /// the fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { sender: SliceSender::open_only(&services::RECORDING, participant)? })
    }

    /// Publishes the header and all marks. Fills in the header's `sequence`.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish(
        &mut self,
        header: &RecordingHeader,
        marks: &[RecordingMark],
    ) -> Result<(), PublishError> {
        self.sender.publish(*header, marks)
    }

    /// Gives the newest sample to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.sender.update();
    }
}

/// A recording that is being replayed, borrowed from shared memory.
#[derive(Clone, Copy, Debug)]
pub struct ReplayedRecording<'sample> {
    /// Its name and its time.
    pub header: &'sample RecordingHeader,
    /// The marks, sorted by time.
    pub marks: &'sample [RecordingMark],
}

/// Reads the description of the recording that a fleet's producer replays. Nothing arrives unless
/// it is a replay.
///
/// ```no_run
/// use regatta_plugin::{FleetName, Participant, RecordingReader, Result};
///
/// # fn main() -> Result {
/// let participant = Participant::join(&FleetName::default(), "reader")?;
/// let mut reader = RecordingReader::open_on(&participant)?;
/// if reader.take()? && let Some(recording) = reader.current() {
///     println!("{} has {} marks", recording.header.file(), recording.marks.len());
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RecordingReader {
    recording: Newest<RecordingMark, RecordingHeader>,
}

impl RecordingReader {
    /// Opens a fleet's recording, whether or not there is one.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { recording: Newest::open(&services::RECORDING, participant)? })
    }

    /// Takes the newest sample, and returns whether there was one that this hasn't taken yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken.
    pub fn take(&mut self) -> Result<bool, ReadError> {
        self.recording.take_newest()
    }

    /// The sample that was taken last.
    pub fn current(&self) -> Option<ReplayedRecording<'_>> {
        self.recording.held().map(|(header, marks)| ReplayedRecording { header, marks })
    }

    /// Gives the sample back: it belongs to a producer that has gone.
    pub fn forget(&mut self) {
        self.recording.release();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FleetName;
    use crate::records::recording::MarkKind;

    #[test]
    fn a_late_reader_gets_the_name_and_the_marks_and_only_one_process_publishes_them() {
        let name: FleetName =
            format!("unit-recording-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut publisher = RecordingPublisher::open_on(&participant).expect("a publisher");
        let second = RecordingPublisher::open_on(&participant).expect_err("one at a time");
        assert!(matches!(second, OpenError::Taken { .. }), "{second}");
        let marks = [RecordingMark {
            time_nanos: 5,
            kind: MarkKind::Fault as u32,
            robot: 7,
            count: 2,
            reserved: 0,
        }];
        let header = RecordingHeader {
            run_id: 3,
            end_nanos: 9,
            ahead_nanos: 4,
            ..RecordingHeader::new("a run.mcap")
        };
        publisher.publish(&header, &marks).expect("published");
        let mut reader = RecordingReader::open_on(&participant).expect("a reader");
        publisher.update();
        assert!(reader.take().expect("readable"));
        let found = reader.current().expect("a sample");
        assert_eq!(
            (found.header.file(), found.header.time_of(6), found.marks),
            ("a run.mcap", 10, &marks[..])
        );
        assert_eq!(found.marks[0].kind(), Some(MarkKind::Fault));
        reader.forget();
        assert!(reader.current().is_none());
    }
}
