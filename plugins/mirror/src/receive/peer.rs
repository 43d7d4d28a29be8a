//! The other host: what is asked of it, and what it sends to the mailbox.

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use regatta_plugin::FleetName;
use regatta_plugin::control::{ControlRequest, ControlResponse};
use zenoh::bytes::ZBytes;
use zenoh::handlers::CallbackDrop;
use zenoh::qos::Priority;
use zenoh::query::Reply;
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use super::mailbox::Mailbox;
use crate::link::{LinkError, Outlet, declare_error, key};
use crate::wire::{Encoding, control_response, encode_control_request};

/// The longest wait for an answer to a control request; a step takes time of its own.
const CONTROL_TIMEOUT: Duration = Duration::from_secs(65);
/// The longest wait for a world or for columns.
const STATE_TIMEOUT: Duration = Duration::from_secs(10);
/// The number of messages of commands that wait for the link.
const COMMAND_QUEUE: usize = 64;

/// The reason why commands aren't sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSent {
    /// No host takes commands for the fleet.
    Nobody,
    /// The link is slow or broken.
    Full,
}

/// The connection to the host that has the fleet.
pub struct Peer {
    session: Session,
    fleet: FleetName,
    mailbox: Arc<Mailbox>,
    /// Ends its thread when dropped.
    commands: SyncSender<Vec<u8>>,
    command_outlet: Arc<Outlet>,
}

impl Peer {
    /// Subscribes to a fleet. Its messages go to the mailbox.
    pub fn open(
        session: &Session,
        fleet: &FleetName,
        encoding: Encoding,
        mailbox: &Arc<Mailbox>,
    ) -> Result<Self, LinkError> {
        let (commands, queue) = sync_channel::<Vec<u8>>(COMMAND_QUEUE);
        let command_outlet = Arc::new(Outlet::blocking(session, key(fleet, "commands"))?);
        let outlet = Arc::clone(&command_outlet);
        std::thread::spawn(move || {
            while let Ok(message) = queue.recv() {
                outlet.put(message);
            }
        });
        let (session, mailbox) = (session.clone(), Arc::clone(mailbox));
        let peer = Self { session, fleet: fleet.clone(), mailbox, commands, command_outlet };
        let frames = format!("frames/{}", encoding.name());
        peer.subscribe(&frames, |mailbox, sample| mailbox.put_frame(sample.payload().clone()))?;
        peer.subscribe("events", |mailbox, sample| mailbox.put_events(sample.payload().clone()))?;
        peer.subscribe("columns/*", |mailbox, sample| put_column(mailbox, &sample))?;
        Ok(peer)
    }

    fn subscribe(&self, name: &str, take: fn(&Mailbox, Sample)) -> Result<(), LinkError> {
        let (key, mailbox) = (key(&self.fleet, name), Arc::clone(&self.mailbox));
        self.session
            .declare_subscriber(key.clone())
            .callback(move |sample| take(&mailbox, sample))
            .background()
            .wait()
            .map_err(|error| declare_error(&key, &error))
    }

    /// Asks for the world. It comes to the mailbox.
    pub fn ask_world(&self) {
        self.ask("world", |mailbox, sample| mailbox.put_world(sample.payload().clone()));
    }

    /// Asks for the newest values of all columns.
    pub fn ask_columns(&self) {
        self.ask("columns/*", |mailbox, sample| put_column(mailbox, &sample));
    }

    fn ask(&self, name: &str, take: fn(&Mailbox, Sample)) {
        let mailbox = Arc::clone(&self.mailbox);
        // The caller asks again when no answer has come.
        let _ = self
            .session
            .get(key(&self.fleet, name))
            .timeout(STATE_TIMEOUT)
            .callback(move |reply: Reply| {
                if let Ok(sample) = reply.into_result() {
                    take(&mailbox, sample);
                }
            })
            .wait();
    }

    /// Passes a control request on. Its answer comes to the mailbox; without one, a refusal does.
    pub fn ask_control(&self, ticket: u64, request: &ControlRequest) {
        let answers = Arc::clone(&self.mailbox);
        let end = Arc::clone(&self.mailbox);
        let handler = CallbackDrop {
            callback: move |reply: Reply| answers.put_answer(ticket, answer_of(reply)),
            // The first answer to a ticket counts.
            drop: move || end.put_answer(ticket, refusal("the fleet's host can't be reached")),
        };
        let asked = self
            .session
            .get(key(&self.fleet, "control"))
            .payload(encode_control_request(request))
            .priority(Priority::InteractiveHigh)
            .timeout(CONTROL_TIMEOUT)
            .with(handler)
            .wait();
        if asked.is_err() {
            self.mailbox.put_answer(ticket, refusal("the fleet's host can't be asked"));
        }
    }

    /// Sends commands, without waiting.
    pub fn send_commands(&self, message: Vec<u8>) -> Result<(), NotSent> {
        if !self.command_outlet.is_wanted() {
            return Err(NotSent::Nobody);
        }
        self.commands.try_send(message).map_err(|error| match error {
            TrySendError::Full(_) => NotSent::Full,
            TrySendError::Disconnected(_) => NotSent::Nobody,
        })
    }
}

fn put_column(mailbox: &Mailbox, sample: &Sample) {
    let name = sample.key_expr().as_str().rsplit('/').next().unwrap_or_default();
    if let Ok(name) = name.parse() {
        mailbox.put_column(name, sample.payload().clone());
    }
}

fn refusal(reason: &str) -> ControlResponse {
    ControlResponse::default().refuse(reason)
}

fn answer_of(reply: Reply) -> ControlResponse {
    let text = |payload: &ZBytes| payload.try_to_string().map(|text| text.into_owned());
    match reply.into_result() {
        Ok(sample) => match control_response(&sample.payload().to_bytes()) {
            Ok(response) => response,
            Err(error) => refusal(&format!("the answer of the fleet's host is ignored: {error}")),
        },
        Err(error) => refusal(&text(error.payload()).unwrap_or_default()),
    }
}
