//! Opening a fleet's services in shared memory.

use core::time::Duration;
use std::time::Instant;

use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use super::Ipc;
use super::full_memory::{FULL, guarded};
use super::obstacle::{Obstacle, Obstructed};
use super::places::participants;
use crate::ports::error::OpenError;
use crate::ports::services::{
    MAX_PARTICIPANTS, MAX_READERS, RequestService, SliceService, VERSION_ATTRIBUTE, service_name,
};
use crate::process::domain::config;
use crate::process::health;
use crate::process::join::Participant;
use crate::process::open_files::reason;
use crate::process::termination::Termination;
use crate::records::frame::CONTRACT_VERSION;
use crate::records::lockstep::Done;
use crate::records::{Header, Record};

/// The growth of segments. Readers map a new segment with the first chunk that they get from it.
pub(super) const GROWTH: AllocationStrategy = AllocationStrategy::PowerOfTwo;

/// An open service of slices of records.
pub(super) type Slices<T, H> = publish_subscribe::PortFactory<Ipc, [T], H>;
/// An open service of requests with an answer each.
pub(super) type Requests<Q, A> = request_response::PortFactory<Ipc, Q, (), A, ()>;

/// Opens the publish-subscribe service of a name in a fleet.
pub(super) fn slices<T: Record, H: Header>(
    service: &SliceService<T, H>,
    name: &str,
    participant: &Participant,
) -> Result<Slices<T, H>, OpenError> {
    let quality = service.quality;
    open(participant, name, MessagingPattern::PublishSubscribe, |builder, version| {
        builder
            .publish_subscribe::<[T]>()
            .user_header::<H>()
            .enable_safe_overflow(quality.overflows)
            .history_size(quality.history)
            .subscriber_max_buffer_size(quality.buffer)
            .subscriber_max_borrowed_samples(quality.borrowed)
            .max_publishers(quality.publishers)
            .max_subscribers(quality.subscribers)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens a request-response service in a fleet. No overflow: a request arrives, or its sender gets
/// an error.
pub(super) fn requests<Q: Record, A: Record>(
    service: &RequestService<Q, A>,
    participant: &Participant,
) -> Result<Requests<Q, A>, OpenError> {
    open(participant, service.name, MessagingPattern::RequestResponse, |builder, version| {
        builder
            .request_response::<Q, A>()
            .enable_safe_overflow_for_requests(false)
            .enable_safe_overflow_for_responses(true)
            .enable_fire_and_forget_requests(false)
            .max_loaned_requests(1)
            .max_response_buffer_size(1)
            .max_borrowed_responses_per_pending_response(1)
            .max_active_requests_per_client(service.open_requests)
            .max_clients(service.clients)
            .max_servers(1)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the lockstep reports: the tick that each reader has finished. The producer reads them, and
/// so do plugins that come after others; one that joins late gets the last report of each.
pub(crate) fn done(
    participant: &Participant,
) -> Result<publish_subscribe::PortFactory<Ipc, Done, ()>, OpenError> {
    open(participant, "done", MessagingPattern::PublishSubscribe, |builder, version| {
        builder
            .publish_subscribe::<Done>()
            .enable_safe_overflow(true)
            .history_size(1)
            .subscriber_max_buffer_size(1)
            .subscriber_max_borrowed_samples(1)
            .max_publishers(MAX_READERS)
            .max_subscribers(MAX_READERS)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens an event service, which carries no data: `wake` wakes readers after a frame, `done` wakes
/// those that wait for lockstep reports.
///
/// Notifying can't block: a listener has a flag in shared memory and a datagram socket. Only the
/// notifier that sets the flag writes to the socket, it does so without blocking, and a full buffer
/// counts as success. A stopped reader thus costs one datagram, and nothing from then on.
pub(super) fn event(
    participant: &Participant,
    service: &str,
) -> Result<event::PortFactory<Ipc>, OpenError> {
    open(participant, service, MessagingPattern::Event, |builder, version| {
        builder
            .event()
            .event_id_max_value(0)
            .max_notifiers(MAX_READERS)
            .max_listeners(MAX_READERS)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// Opens the event service whose one notifier is a claim.
pub(super) fn claim(
    participant: &Participant,
    service: &str,
) -> Result<event::PortFactory<Ipc>, OpenError> {
    open(participant, service, MessagingPattern::Event, |builder, version| {
        builder
            .event()
            .event_id_max_value(0)
            .max_notifiers(1)
            .max_listeners(1)
            .max_nodes(MAX_PARTICIPANTS)
            .open_or_create_with_attributes(version)
    })
}

/// The time between attempts to open a service: services come and go while other processes start
/// and stop.
const PAUSE: Duration = Duration::from_millis(50);
/// The number of attempts against an obstacle that rarely goes away.
const ATTEMPTS: usize = 10;
/// The longest wait for another process that creates or removes a service. It takes milliseconds,
/// and many seconds on a machine whose processors or disks others keep busy.
const PATIENCE: Duration = Duration::from_secs(60);
/// The wait after which the user reads what is waited for.
const TOLD_AFTER: Duration = Duration::from_secs(5);

fn open<S, E: Obstructed>(
    participant: &Participant,
    service: &str,
    pattern: MessagingPattern,
    attempt: impl Fn(iceoryx2::service::builder::Builder<Ipc>, &AttributeVerifier) -> Result<S, E>,
) -> Result<S, OpenError> {
    let fleet = participant.fleet();
    let what = service_name(fleet, service);
    let failed = |reason: String| OpenError::SharedMemory { what: what.clone(), reason };
    let Some(node) = participant.node() else {
        return Err(failed("the fleet is local to its process".to_owned()));
    };
    let name = ServiceName::new(&what).map_err(|e| failed(format!("{e:?}")))?;
    let version = version_attribute(CONTRACT_VERSION).map_err(failed)?;
    let mut wait = Wait::new(what.clone());
    loop {
        let (outcome, missing) = guarded(|| attempt(node.service_builder(&name), &version));
        if missing.any() {
            return Err(failed(FULL.to_owned()));
        }
        let error = match outcome {
            Ok(service) => return Ok(service),
            Err(error) => error,
        };
        // Even if iceoryx2 has already found that the payload types differ: the version explains
        // the reason.
        if let Some(theirs) = other_version(node, &name, pattern) {
            return Err(OpenError::OtherVersion { fleet: fleet.clone(), service: what, theirs });
        }
        match wait.after(&error) {
            Next::Again => {}
            Next::Failed(error) => return Err(error),
            Next::Full => {
                let holders = participants(node, fleet);
                return Err(OpenError::Full { service: what, limit: MAX_PARTICIPANTS, holders });
            }
        }
    }
}

/// The attempts to open a service.
struct Wait {
    service: String,
    start: Instant,
    attempts: usize,
    is_told: bool,
}

/// The step after a failed attempt.
enum Next {
    Again,
    Full,
    Failed(OpenError),
}

impl Wait {
    fn new(service: String) -> Self {
        Self { service, start: Instant::now(), attempts: 0, is_told: false }
    }

    /// Waits for the next attempt after one that failed, unless there is none.
    fn after(&mut self, error: &impl Obstructed) -> Next {
        self.attempts += 1;
        let obstacle = error.obstacle();
        let waited = self.start.elapsed();
        let (is_over, next) = match obstacle {
            Obstacle::Hanging | Obstacle::InFlux => {
                (waited > PATIENCE, Next::Failed(self.in_flux()))
            }
            Obstacle::Full => (self.attempts >= ATTEMPTS, Next::Full),
            Obstacle::Other => (self.attempts >= ATTEMPTS, Next::Failed(self.failed(error))),
        };
        let is_passing = matches!(obstacle, Obstacle::Hanging | Obstacle::InFlux);
        if is_over || (is_passing && Termination::was_requested()) {
            return next;
        }
        if obstacle == Obstacle::Hanging {
            health::remove_abandoned(&self.service);
        }
        if is_passing {
            self.tell(waited);
        }
        // The creator of the service may have been killed: its remains would be in the way for ever.
        health::remove_unfinished();
        std::thread::sleep(PAUSE);
        Next::Again
    }

    /// Tells once that another process is waited for.
    fn tell(&mut self, waited: Duration) {
        if waited > TOLD_AFTER && !self.is_told {
            self.is_told = true;
            tracing::warn!("waits for another process that opens or closes {}", self.service);
        }
    }

    fn in_flux(&self) -> OpenError {
        OpenError::InFlux { service: self.service.clone(), seconds: self.start.elapsed().as_secs() }
    }

    fn failed(&self, error: &impl Obstructed) -> OpenError {
        OpenError::SharedMemory { what: self.service.clone(), reason: reason(error) }
    }
}

/// Requires the contract version of an existing service, and defines that of a new one.
fn version_attribute(version: u32) -> Result<AttributeVerifier, String> {
    let key = AttributeKey::new(VERSION_ATTRIBUTE.as_bytes()).map_err(|e| format!("{e:?}"))?;
    let value =
        AttributeValue::new(version.to_string().as_bytes()).map_err(|e| format!("{e:?}"))?;
    AttributeVerifier::new().require(&key, &value).map_err(|e| format!("{e:?}"))
}

/// Returns the contract version of an existing service if it isn't ours.
fn other_version(
    node: &Node<Ipc>,
    name: &ServiceName,
    pattern: MessagingPattern,
) -> Option<String> {
    let theirs = version_of(&Ipc::details(name, node.config(), pattern).ok()??.static_details);
    (theirs != CONTRACT_VERSION.to_string()).then_some(theirs)
}

/// Returns the contract version that a service was created with, or `unknown` if it has none.
pub(crate) fn version_of(service: &iceoryx2::service::static_config::StaticConfig) -> String {
    let key = AttributeKey::new(VERSION_ATTRIBUTE.as_bytes()).ok();
    match key.and_then(|key| service.attributes().key_value(&key, 0).copied()) {
        Some(value) => String::from_utf8_lossy(value.as_bytes()).into_owned(),
        None => "unknown".to_owned(),
    }
}

/// Returns the names of all services of this user. Those that can't be listed are left out.
pub(crate) fn service_names() -> Vec<String> {
    let mut names = Vec::new();
    let Ok(config) = config() else { return names };
    // A service that this user can't list can't be used either.
    let _ = Ipc::list(config, |service| {
        names.push(service.static_details.name().as_str().to_owned());
        CallbackProgression::Continue
    });
    names
}
