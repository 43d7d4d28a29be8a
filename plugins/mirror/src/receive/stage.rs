//! Publishes what arrives through the ports of a producer.

use std::time::{Duration, Instant};

use regatta_plugin::event::{EventHeader, EventRecord};
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::records::name::ColumnName;
use regatta_plugin::{OpenError, ProducerPorts, PublishError};
use zenoh::bytes::ZBytes;

use super::peer::Peer;
use crate::figures::Figures;
use crate::grievances::Grievances;
use crate::wire::{Encoding, FrameMessage, decode_column, decode_events, decode_world};

/// The time after which a world is asked for again.
const ASK_AGAIN: Duration = Duration::from_secs(1);

/// A run of the other host's fleet, and the revision of its world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Source {
    run_id: u64,
    revision: u64,
}

/// The fleet on this host.
pub struct Stage {
    /// The ports.
    pub ports: ProducerPorts,
    encoding: Encoding,
    /// The world that is shown; `None` before the first one.
    source: Option<Source>,
    asked: Option<Instant>,
    /// The tick that is shown.
    pub tick: u64,
    /// The figures.
    pub figures: Figures,
    /// The faults of messages.
    pub grievances: Grievances,
    is_full: bool,
}

impl Stage {
    /// Creates a stage on ports, for frames in an encoding.
    pub fn new(ports: ProducerPorts, encoding: Encoding) -> Self {
        Self {
            ports,
            encoding,
            source: None,
            asked: None,
            tick: 0,
            figures: Figures::default(),
            grievances: Grievances::default(),
            is_full: false,
        }
    }

    /// Publishes a frame. If its world isn't shown yet, that is asked for instead.
    pub fn frame(&mut self, payload: &ZBytes, peer: &Peer) -> Result<(), PublishError> {
        let bytes = payload.to_bytes();
        let parsed = FrameMessage::parse(&bytes, self.encoding);
        let Some(message) = self.grievances.accept("a frame", parsed) else { return Ok(()) };
        let header = message.header;
        let source = Source { run_id: header.run_id, revision: header.world_revision };
        if self.source != Some(source) {
            if source.revision > 0 {
                self.ask_world(peer);
                return Ok(());
            }
            // The producer has no world.
            self.show_run(source);
        }
        let shown = self.publish_frame(&message);
        if self.unless_full(shown)? {
            self.figures.note(&header, bytes.len());
        }
        Ok(())
    }

    fn publish_frame(&mut self, message: &FrameMessage<'_>) -> Result<(), PublishError> {
        let mut loan = self.ports.loan(message.len())?;
        let (source, own) = (message.header, *loan.header_mut());
        *loan.header_mut() = FrameHeader {
            run_id: own.run_id,
            world_revision: own.world_revision,
            robots: own.robots,
            stride_lines: own.stride_lines,
            lockstep: 0,
            ..source
        };
        message.write(&mut loan.columns_mut());
        loan.send()?;
        self.tick = source.tick;
        self.ports.notify();
        Ok(())
    }

    fn ask_world(&mut self, peer: &Peer) {
        if self.asked.is_none_or(|asked| asked.elapsed() > ASK_AGAIN) {
            self.asked = Some(Instant::now());
            peer.ask_world();
        }
    }

    /// Publishes a world, and asks for the columns of its run.
    pub fn world(&mut self, payload: &ZBytes, peer: &Peer) -> Result<(), PublishError> {
        let parsed = decode_world(&payload.to_bytes());
        let Some((header, world)) = self.grievances.accept("a world", parsed) else {
            return Ok(());
        };
        let source = Source { run_id: header.run_id, revision: header.revision };
        if self.source == Some(source) {
            return Ok(());
        }
        self.show_run(Source { revision: 0, ..source });
        let published = self.ports.publish_world(&world).map(drop);
        if self.unless_full(published)? {
            self.source = Some(source);
            self.asked = None;
            peer.ask_columns();
        }
        Ok(())
    }

    /// Begins a run if the source's is another one.
    fn show_run(&mut self, source: Source) {
        if self.source.is_some_and(|shown| shown.run_id != source.run_id) {
            self.ports.begin_run();
        }
        self.source = Some(source);
    }

    /// Publishes events of the run that is shown, before which `lost` messages were lost.
    pub fn events(&mut self, payload: &ZBytes, lost: u64) -> Result<(), PublishError> {
        let parsed = decode_events(&payload.to_bytes());
        let Some((header, events)) = self.grievances.accept("an event", parsed) else {
            return Ok(());
        };
        if !self.shows(header.run_id) {
            return Ok(());
        }
        let EventHeader { tick, dropped, .. } = header;
        let published = self.ports.publish_events(tick, dropped.saturating_add(lost), &events);
        self.unless_full(published)?;
        self.ports.notify();
        Ok(())
    }

    /// Publishes answers of this host to commands.
    pub fn answers(&mut self, events: &[EventRecord]) -> Result<(), PublishError> {
        if events.is_empty() {
            return Ok(());
        }
        let published = self.ports.publish_events(self.tick, 0, events);
        self.unless_full(published)?;
        self.ports.notify();
        Ok(())
    }

    /// Publishes a column of the run that is shown. A name that a process of this host publishes
    /// stays its own.
    pub fn column(&mut self, name: ColumnName, payload: &ZBytes) -> Result<(), PublishError> {
        let parsed = decode_column(&payload.to_bytes());
        let Some(column) = self.grievances.accept("a column", parsed) else { return Ok(()) };
        if !self.shows(column.header.run_id) {
            return Ok(());
        }
        let (run_id, tick) = (self.ports.run_id(), column.header.tick);
        let published = match self.ports.open_column(name) {
            Ok(port) => port.write(run_id, tick, column.values.len(), |values| {
                values.copy_from_slice(&column.values);
            }),
            Err(OpenError::ColumnTaken { .. }) => return Ok(()),
            Err(error) => return Err(error.into()),
        };
        self.unless_full(published).map(drop)
    }

    fn shows(&self, run_id: u64) -> bool {
        self.source.is_some_and(|source| source.run_id == run_id)
    }

    /// Returns whether something was published. Full shared memory is no error: readers miss it.
    fn unless_full(&mut self, outcome: Result<(), PublishError>) -> Result<bool, PublishError> {
        match outcome {
            Ok(()) => Ok(true),
            Err(error @ (PublishError::MemoryFull { .. } | PublishError::NoRoom { .. })) => {
                if !std::mem::replace(&mut self.is_full, true) {
                    regatta_plugin::tell!("mirror: {error}");
                }
                Ok(false)
            }
            Err(error) => Err(error),
        }
    }
}
