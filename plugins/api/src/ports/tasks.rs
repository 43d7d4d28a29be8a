//! Both sides of the task log: a fleet manager writes it, any process reads it.

use super::error::{OpenError, PublishError};
use super::receive::{TickReader, TickRecords};
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::task::{TaskHeader, TaskRecord};

/// Publishes a fleet's task log. A fleet has one such publisher at a time.
///
/// ```
/// use regatta_plugin::task::{TaskKind, TaskRecord};
/// use regatta_plugin::{Participant, Result, TaskPublisher, TaskReader};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-tasks-{}", std::process::id()).parse()?;
/// let participant = Participant::join(&fleet, "manager")?;
/// let mut log = TaskPublisher::open_on(&participant)?;
/// let mut reader = TaskReader::open_on(&participant)?;
/// log.publish(1, 7, 0, &[TaskRecord::new(3, TaskKind::Assigned).of_robot(5)])?;
/// reader.take(|tick| -> Result {
///     assert_eq!((tick.header.tick, tick.records[0].robot), (7, 5));
///     Ok(())
/// })?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct TaskPublisher {
    tasks: SliceSender<TaskRecord, TaskHeader>,
}

impl TaskPublisher {
    /// Opens a fleet's task log for writing.
    ///
    /// # Errors
    /// [`OpenError::Taken`] if a live process publishes it, [`OpenError::OtherVersion`] if the
    /// fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { tasks: SliceSender::open_only(&services::TASKS, participant)? })
    }

    /// Publishes the records of one tick, `dropped` of which were left out because there were too
    /// many.
    ///
    /// # Errors
    /// [`PublishError`] when shared memory is full.
    pub fn publish(
        &mut self,
        run_id: u64,
        tick: u64,
        dropped: u64,
        records: &[TaskRecord],
    ) -> Result<(), PublishError> {
        self.tasks.publish(TaskHeader { run_id, tick, dropped, sequence: 0 }, records)
    }

    /// Connects readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.tasks.update();
    }

    /// Whether a process reads the task log.
    pub fn has_readers(&self) -> bool {
        self.tasks.readers() > 0
    }
}

/// The records of tasks of one tick, borrowed from shared memory, in the order in which they
/// happened.
pub type Tasks<'sample> = TickRecords<'sample, TaskHeader, TaskRecord>;

/// Reads a fleet's task log.
pub type TaskReader = TickReader<TaskHeader, TaskRecord>;

impl TaskReader {
    /// Opens the task log of a fleet, whether or not a process writes it yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Self::of(&services::TASKS, participant)
    }
}
