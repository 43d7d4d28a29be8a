//! Both sides of the task log: a fleet manager writes it, any process reads it.

use super::error::{OpenError, PublishError};
use super::every_tick::{TickReader, TickRecords};
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::task::{TaskHeader, TaskRecord};

/// Publishes a fleet's task log. A fleet has one such publisher at a time.
#[derive(Debug)]
pub struct TaskPublisher {
    tasks: SliceSender<TaskRecord, TaskHeader>,
}

impl TaskPublisher {
    /// Opens a fleet's task log for writing.
    ///
    /// # Errors
    /// [`OpenError::TasksTaken`] if a live process publishes it, [`OpenError::OtherVersion`] if the
    /// fleet uses another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        let (node, fleet) = (participant.node(), participant.fleet());
        let service = services::tasks(node, fleet)?;
        let taken = |owner| OpenError::TasksTaken { fleet: fleet.clone(), owner };
        Ok(Self {
            tasks: SliceSender::open_only(
                service,
                "the task log",
                services::FIRST_RECORDS,
                node,
                taken,
            )?,
        })
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
        let sequence = self.tasks.sequence().next(run_id);
        self.tasks.send(TaskHeader { run_id, tick, dropped, sequence }, records).map(drop)
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

/// What happened to tasks in one tick, borrowed from shared memory, in the order in which it
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
        Self::of(&services::tasks(participant.node(), participant.fleet())?, "the task log")
    }
}
