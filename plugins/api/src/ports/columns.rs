//! Both sides of columns: a plugin publishes one, any process reads it.

use std::time::Duration;

use super::error::{OpenError, PublishError, ReadError};
use super::receive::Newest;
use super::services;
use super::slices::SliceSender;
use crate::process::join::Participant;
use crate::records::column::ColumnHeader;
use crate::records::frame::{Frame, Line, stride_lines};
use crate::records::name::ColumnName;

/// Publishes a column: one value per robot, for the frame that they were computed from.
#[derive(Debug)]
pub struct ColumnPublisher {
    sender: SliceSender<Line, ColumnHeader>,
    cost_micros: u32,
}

impl ColumnPublisher {
    /// Opens a column of a fleet for writing.
    ///
    /// # Errors
    /// [`OpenError::Name`] if the name is invalid, [`OpenError::ColumnTaken`] if a live process
    /// publishes it, [`OpenError::OtherVersion`] if the fleet uses another contract, else
    /// [`OpenError::SharedMemory`].
    pub fn open_on(participant: &Participant, name: &str) -> Result<Self, OpenError> {
        let name: ColumnName = name.parse()?;
        let (service, fleet) = (services::column_service(&name), participant.fleet().clone());
        let sender = SliceSender::only(&services::COLUMNS, &service, 1, participant, |owner| {
            OpenError::ColumnTaken { fleet, column: name, owner }
        })?;
        Ok(Self { sender, cost_micros: 0 })
    }

    /// Sets the time that the publisher spent on a frame, for the headers of the next samples.
    pub fn set_cost(&mut self, cost: Duration) {
        self.cost_micros = cost.as_micros().min(u32::MAX.into()) as u32;
    }

    /// Publishes `values`, one per robot of the frame.
    pub fn publish(&mut self, frame: &Frame<'_>, values: &[f32]) -> Result<(), PublishError> {
        if values.len() != frame.len() {
            return Err(PublishError::ColumnLength { values: values.len(), robots: frame.len() });
        }
        self.write(frame.run_id(), frame.tick(), frame.len(), |column| {
            column.copy_from_slice(values)
        })
    }

    /// Publishes the values that `fill` writes straight into shared memory. They are left over from
    /// an older column before that.
    pub fn write(
        &mut self,
        run_id: u64,
        tick: u64,
        robots: usize,
        fill: impl FnOnce(&mut [f32]),
    ) -> Result<(), PublishError> {
        let mut sample = self.sender.loan(stride_lines(robots))?;
        fill(&mut bytemuck::cast_slice_mut(sample.records_mut())[..robots]);
        let sequence = self.sender.sequence().next(run_id);
        let (robots, cost_micros) = (robots as u32, self.cost_micros);
        *sample.header_mut() = ColumnHeader { run_id, tick, sequence, robots, cost_micros };
        sample.send().map(drop)
    }

    /// Gives the newest values to readers that have joined since. Publishing does so as well.
    pub fn update(&self) {
        self.sender.update();
    }
}

/// A reader's view of a column.
#[derive(Clone, Copy, Debug)]
pub struct ColumnValues<'sample> {
    /// The run and tick that the values belong to.
    pub header: &'sample ColumnHeader,
    /// One value per robot of that tick.
    pub values: &'sample [f32],
    /// The number of samples that were published between the one that this reader returned before
    /// and this one.
    pub missed: u64,
}

/// Reads a column: the newest values, or [all of them](Self::take_next).
///
/// ```
/// use regatta_plugin::{ColumnReader, ProducerPorts, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-column-{}", std::process::id()).parse()?;
/// let mut producer = ProducerPorts::create(&fleet, 2)?;
/// producer.publish_column("battery", 1, &[99.5, 42.0])?;
/// let mut batteries = ColumnReader::open_on(producer.participant(), "battery")?;
/// # producer.update();
/// let column = batteries.latest()?.expect("a column");
/// assert_eq!((column.header.tick, column.values), (1, &[99.5, 42.0][..]));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct ColumnReader {
    columns: Newest<Line, ColumnHeader>,
}

impl ColumnReader {
    /// Opens a column of a fleet, whether or not a process publishes it yet.
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_on(participant: &Participant, name: &str) -> Result<Self, OpenError> {
        Self::open(participant, name, 1)
    }

    /// Opens a column for a reader that wants all values: the last
    /// [`COLUMN_BUFFER`](services::COLUMN_BUFFER) samples wait for [`take_next`](Self::take_next).
    ///
    /// # Errors
    /// As [`Subscriber::open`](crate::Subscriber::open).
    pub fn open_for_all_on(participant: &Participant, name: &str) -> Result<Self, OpenError> {
        Self::open(participant, name, services::COLUMN_BUFFER)
    }

    fn open(participant: &Participant, name: &str, buffer: usize) -> Result<Self, OpenError> {
        let columns = Newest::of_column(&services::COLUMNS, participant, &name.parse()?, buffer)?;
        Ok(Self { columns })
    }

    /// Returns the oldest values that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken, or the values contradict their header.
    pub fn take_next(&mut self) -> Result<Option<ColumnValues<'_>>, ReadError> {
        if self.columns.take_next()? { self.current() } else { Ok(None) }
    }

    /// Returns the newest values, if there are some that this hasn't returned yet.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken, or the values contradict their header.
    pub fn latest(&mut self) -> Result<Option<ColumnValues<'_>>, ReadError> {
        if self.columns.take_newest()? { self.current() } else { Ok(None) }
    }

    /// The values that [`latest`](Self::latest) or [`take_next`](Self::take_next) returned last.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if they contradict their header.
    pub fn current(&self) -> Result<Option<ColumnValues<'_>>, ReadError> {
        let Some((header, lines)) = self.columns.held() else { return Ok(None) };
        let missed = self.columns.missed();
        match bytemuck::cast_slice(lines).get(..header.robots as usize) {
            Some(values) => Ok(Some(ColumnValues { header, values, missed })),
            None => Err(ReadError::Malformed { what: "a column", lines: lines.len() }),
        }
    }

    /// Takes the newest values. Returns them if a process publishes them in this run, else none.
    ///
    /// # Errors
    /// [`ReadError`] if the connection is broken, or the values contradict their header.
    pub fn newest_of_run(&mut self, run_id: u64) -> Result<&[f32], ReadError> {
        self.columns.take_newest()?;
        let has_publisher = self.has_publisher();
        let column = self.current()?.filter(|column| column.header.run_id == run_id);
        Ok(column.filter(|_| has_publisher).map_or(&[], |column| column.values))
    }

    /// Whether a process publishes it. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_publisher(&self) -> bool {
        self.columns.has_publisher()
    }
}

/// Returns the columns of a fleet that a process publishes or reads, sorted. Lists all services of
/// the machine, which is too slow to do for every frame.
///
/// ```
/// use regatta_plugin::{FleetName, column_names};
///
/// for name in column_names(&FleetName::default()) {
///     println!("{name}");
/// }
/// ```
#[cfg(feature = "shared-memory")]
pub fn column_names(fleet: &crate::FleetName) -> Vec<ColumnName> {
    let prefix = services::service_name(fleet, "columns/");
    let names = crate::transport::shared::service_names();
    let columns = names.iter().filter_map(|name| name.strip_prefix(&prefix)?.parse().ok());
    let mut columns: Vec<ColumnName> = columns.collect();
    columns.sort();
    columns
}
