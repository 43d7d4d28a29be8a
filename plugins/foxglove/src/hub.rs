//! The clients, for those who have something to tell all of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bytes::Bytes;
use parking_lot::Mutex;
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::{FleetName, tell};

use crate::channel::{Channel, ChannelSet};
use crate::outbox::{Outbox, Sample};
use crate::parameters::Parameters;
use crate::protocol::response;

/// The state that all threads share.
#[derive(Debug)]
pub(crate) struct Hub {
    fleet: FleetName,
    /// Whether clients may steer the fleet.
    can_steer: bool,
    clients: Mutex<Vec<Arc<Outbox>>>,
    run: Mutex<Run>,
    has_told: [AtomicBool; Fault::COUNT],
}

/// The run that is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Run {
    id: u64,
    nanos: u64,
    /// `None` before the first frame.
    parameters: Option<Parameters>,
}

/// The faults of clients; the first of each kind is told on standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Fault {
    /// A page of another site.
    Site,
    /// A handshake or a credential that is wrong.
    Handshake,
    /// A message that isn't one of the protocol.
    Message,
    /// More messages than one may send.
    Flood,
    /// A client that reads nothing.
    Stuck,
    /// One client more than there is room for.
    Crowd,
}

impl Fault {
    const COUNT: usize = 6;
}

impl Hub {
    pub fn new(fleet: FleetName, can_steer: bool) -> Self {
        Self {
            fleet,
            can_steer,
            clients: Mutex::default(),
            run: Mutex::default(),
            has_told: Default::default(),
        }
    }

    pub fn can_steer(&self) -> bool {
        self.can_steer
    }

    /// Tells the first fault of a kind.
    pub fn tell(&self, fault: Fault, message: std::fmt::Arguments<'_>) {
        if !self.has_told[fault as usize].swap(true, Ordering::Relaxed) {
            tell!("foxglove: {message} (further ones aren't reported)");
        }
    }

    /// Adds a client, which gets what it has to know first.
    pub fn join(&self) -> Arc<Outbox> {
        let outbox = Arc::new(Outbox::default());
        // First, so that no run begins in between unseen.
        let mut clients = self.clients.lock();
        let run = *self.run.lock();
        self.introduce(&outbox, &run);
        if self.can_steer {
            outbox.answer(response::advertise_services());
        }
        if run.parameters.is_some() {
            outbox.set_time(run.nanos);
        }
        clients.push(Arc::clone(&outbox));
        outbox
    }

    fn introduce(&self, outbox: &Outbox, run: &Run) {
        let session = format!("{:016x}", run.id);
        outbox.answer(response::server_info(self.fleet.as_str(), &session, self.can_steer));
        outbox.answer(response::advertise());
    }

    /// Removes a client.
    pub fn leave(&self, outbox: &Arc<Outbox>) {
        self.clients.lock().retain(|other| !Arc::ptr_eq(other, outbox));
    }

    /// The values of the parameters; `None` before the first frame.
    pub fn parameters(&self) -> Option<Parameters> {
        self.run.lock().parameters
    }

    /// The channels that somebody reads, and those of them on which somebody has had no message
    /// yet.
    pub fn wanted(&self) -> (ChannelSet, ChannelSet) {
        let clients = self.clients.lock();
        clients.iter().fold(Default::default(), |(wanted, hungry), client| {
            let (more, hungrier) = client.wanted();
            (wanted.or(more), hungry.or(hungrier))
        })
    }

    /// Takes the run, the time and the parameters of a frame.
    pub fn take_header(&self, header: &FrameHeader) {
        let parameters = Parameters::of(header);
        let run =
            Run { id: header.run_id, nanos: header.sim_time_nanos, parameters: Some(parameters) };
        let before = std::mem::replace(&mut *self.run.lock(), run);
        for client in &*self.clients.lock() {
            if before.id != run.id {
                client.forget_run();
                self.introduce(client, &run);
            }
            client.set_time(run.nanos);
            if before.parameters != run.parameters {
                client.tell_parameters(&parameters);
            }
        }
    }

    /// Has the messages of channels sent again.
    pub fn renew(&self, channels: &[Channel]) {
        for client in &*self.clients.lock() {
            client.renew(channels);
        }
    }

    /// Gives a message to all who read its channel.
    pub fn publish(&self, channel: Channel, nanos: u64, data: Vec<u8>) {
        let sample = Sample { channel, nanos, data: Bytes::from(data) };
        for client in &*self.clients.lock() {
            client.put(&sample);
        }
    }

    /// Gives a message to those who have had none on its channel yet.
    pub fn feed(&self, channel: Channel, nanos: u64, data: Vec<u8>) {
        let sample = Sample { channel, nanos, data: Bytes::from(data) };
        for client in &*self.clients.lock() {
            if client.wanted().1.has(channel) {
                client.put(&sample);
            }
        }
    }
}
