//! Columns: one value per robot, published by a plugin on `regatta/F/columns/NAME`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;

use crate::error::{OpenError, PublishError, ReadError};
use crate::fleet_name::{ColumnName, FleetName};
use crate::frame::{Frame, Line, stride_lines};
use crate::participant::Participant;
use crate::qos::{self, Ipc};
use crate::subscribe::{MOST_ROUNDS, receive_error};

/// The iceoryx2 user header of a column. Its payload is `robots` values of `f32`, padded to whole lines.
///
/// The producer itself publishes the column `type`: each robot's index into the world's robot types.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_ColumnHeader")]
pub struct ColumnHeader {
    /// The run of the frame that these values belong to.
    pub run_id: u64,
    /// The tick of the frame that these values belong to.
    pub tick: u64,
    /// Number of values.
    pub robots: u32,
    /// Counts the samples of the publisher, from 1, round and round.
    pub sequence: u32,
}

/// Publishes a column: one value per robot, for the frame that they were worked out from.
#[derive(Debug)]
pub struct ColumnPublisher {
    publisher: Publisher<Ipc, [Line], ColumnHeader>,
    sent: u32,
}

impl ColumnPublisher {
    /// Opens a column of a fleet for writing.
    ///
    /// # Errors
    /// [`OpenError::ColumnTaken`] if somebody alive publishes it, [`OpenError::OtherVersion`] if the fleet
    /// speaks another contract, else [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant, name: &ColumnName) -> Result<Self, OpenError> {
        let service = qos::column(&participant.node, participant.fleet(), name)?;
        let publisher = service
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .initial_max_slice_len(1)
            .allocation_strategy(qos::GROWTH)
            .create();
        let publisher = publisher.map_err(|e| match e {
            PublisherCreateError::ExceedsMaxSupportedPublishers => OpenError::ColumnTaken {
                fleet: participant.fleet().clone(),
                column: name.clone(),
                owner: qos::publisher_owner(&service, &participant.node),
            },
            e => qos::full_or(service.name(), 1, e),
        })?;
        Ok(Self { publisher, sent: 0 })
    }

    /// Publishes `values`, one per robot of the frame.
    ///
    /// # Errors
    /// [`PublishError`].
    pub fn publish(&mut self, frame: &Frame<'_>, values: &[f32]) -> Result<(), PublishError> {
        if values.len() != frame.len() {
            return Err(PublishError::ColumnLength { values: values.len(), robots: frame.len() });
        }
        self.write(frame.run_id(), frame.tick(), frame.len(), |column| column.copy_from_slice(values))
    }

    /// Publishes the values that `fill` writes straight into shared memory. What it finds there is left over
    /// from an older column.
    ///
    /// # Errors
    /// [`PublishError`].
    pub fn write(
        &mut self,
        run_id: u64,
        tick: u64,
        robots: usize,
        fill: impl FnOnce(&mut [f32]),
    ) -> Result<(), PublishError> {
        let mut sample = self.loan(robots)?;
        fill(&mut bytemuck::cast_slice_mut(sample.payload_mut())[..robots]);
        self.sent = self.sent.wrapping_add(1);
        *sample.user_header_mut() = ColumnHeader { run_id, tick, robots: robots as u32, sequence: self.sent };
        sample.send().map_err(|e| PublishError::Send { what: "a column", reason: e.to_string() })?;
        Ok(())
    }

    /// Gives the newest values to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        if let Err(error) = self.publisher.update_connections() {
            tracing::debug!(%error, "connecting readers of a column");
        }
    }

    #[expect(unsafe_code, reason = "the one way to loan a chunk without writing it twice")]
    fn loan(&self, robots: usize) -> Result<SampleMut<Ipc, [Line], ColumnHeader>, PublishError> {
        let sample = self
            .publisher
            .loan_slice_uninit(stride_lines(robots))
            .map_err(|e| PublishError::Loan { what: "a column", reason: e.to_string() })?;
        // SAFETY: as in `Producer::loan`: plain data in memory mapped from a file.
        Ok(unsafe { sample.assume_init() })
    }
}

/// A column as a reader sees it.
#[derive(Clone, Copy, Debug)]
pub struct ColumnValues<'sample> {
    /// The run and tick that the values belong to.
    pub header: &'sample ColumnHeader,
    /// One value per robot of that tick.
    pub values: &'sample [f32],
    /// Samples that were published between the ones that this reader returned last and these.
    pub missed: u64,
}

/// Reads a column: the newest values, or [all of them](Self::take_next).
#[derive(Debug)]
pub struct ColumnReader {
    columns: Subscriber<Ipc, [Line], ColumnHeader>,
    held: Option<Sample<Ipc, [Line], ColumnHeader>>,
    gaps: qos::Gaps,
    missed: u64,
    service: qos::Column,
}

impl ColumnReader {
    /// Opens a column of a fleet, whether or not anybody publishes it yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant, name: &ColumnName) -> Result<Self, OpenError> {
        Self::open(participant, name, 1)
    }

    /// The same for a reader that wants all values: the last [`COLUMN_BUFFER`](qos::COLUMN_BUFFER) samples wait for
    /// [`take_next`](Self::take_next).
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_for_all_on(participant: &Participant, name: &ColumnName) -> Result<Self, OpenError> {
        Self::open(participant, name, qos::COLUMN_BUFFER)
    }

    fn open(participant: &Participant, name: &ColumnName, buffer: usize) -> Result<Self, OpenError> {
        let service = qos::column(&participant.node, participant.fleet(), name)?;
        let columns = service.subscriber_builder().buffer_size(buffer).create();
        let columns = columns.map_err(|e| qos::full_or(service.name(), qos::MAX_READERS, e))?;
        Ok(Self { columns, held: None, gaps: qos::Gaps::default(), missed: 0, service })
    }

    /// The oldest values that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken, or the values contradict their header.
    pub fn take_next(&mut self) -> Result<Option<ColumnValues<'_>>, ReadError> {
        self.missed = 0;
        if self.receive()? { self.current() } else { Ok(None) }
    }

    /// Holds the oldest sample that is waiting, if there is one.
    fn receive(&mut self) -> Result<bool, ReadError> {
        if !self.columns.has_samples().map_err(|e| receive_error("a column", e))? {
            return Ok(false);
        }
        self.held = None;
        self.held = self.columns.receive().map_err(|e| receive_error("a column", e))?;
        if let Some(header) = self.held.as_ref().map(Sample::user_header) {
            self.missed += self.gaps.before(header.run_id, header.sequence.into());
        }
        Ok(self.held.is_some())
    }

    /// The newest values, if there are some that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken, or the values contradict their header.
    pub fn latest(&mut self) -> Result<Option<ColumnValues<'_>>, ReadError> {
        let mut received = 0;
        self.missed = 0;
        while received < MOST_ROUNDS && self.receive()? {
            received += 1;
        }
        self.missed += received.saturating_sub(1);
        if received > 0 { self.current() } else { Ok(None) }
    }

    /// The values that [`latest`](Self::latest) or [`take_next`](Self::take_next) returned last.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if they contradict their header.
    pub fn current(&self) -> Result<Option<ColumnValues<'_>>, ReadError> {
        let Some(sample) = &self.held else { return Ok(None) };
        let (header, lines, missed) = (sample.user_header(), sample.payload(), self.missed);
        match bytemuck::cast_slice(lines).get(..header.robots as usize) {
            Some(values) => Ok(Some(ColumnValues { header, values, missed })),
            None => Err(ReadError::Malformed { what: "a column", lines: lines.len() }),
        }
    }

    /// Whether anybody publishes it. One that was killed counts until another process joins the fleet.
    pub fn has_publisher(&self) -> bool {
        self.service.dynamic_config().number_of_publishers() > 0
    }
}

/// The columns of a fleet that somebody publishes or reads, sorted. Looks through all services of the
/// machine: not for every frame.
pub fn column_names(fleet: &FleetName) -> Vec<ColumnName> {
    let prefix = qos::service_name(fleet, "columns/");
    let mut names = Vec::new();
    // Whatever can't be listed isn't there for us.
    let _ = Ipc::list(crate::participant::config(), |service| {
        let name = service.static_details.name().as_str();
        names.extend(name.strip_prefix(&prefix).and_then(|name| name.parse().ok()));
        CallbackProgression::Continue
    });
    names.sort();
    names
}
