//! The places at a service: a service has room for a fixed number of each kind of port. If none is
//! free, the error names the processes that hold them.

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::NodeView;
use iceoryx2::port::listener::ListenerCreateError;
use iceoryx2::port::notifier::NotifierCreateError;
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::server::ServerCreateError;
use iceoryx2::service::port_factory::{PortFactory, publish_subscribe};

use super::Ipc;
use super::full_memory::{FULL, guarded};
use crate::ports::error::OpenError;
use crate::ports::services::service_name;
use crate::process::join::Participant;
use crate::process::open_files::reason;
use crate::records::name::FleetName;

/// An error of iceoryx2 for a place at a service, which may mean that all places are taken.
pub(crate) trait MayBeFull: core::fmt::Display {
    /// Whether all places are taken.
    fn is_full(&self) -> bool;
}

/// Implements [`MayBeFull`] by the variants that mean that all places are taken.
macro_rules! may_be_full {
    ($($error:ty: $full:pat),* $(,)?) => {$(
        impl MayBeFull for $error {
            fn is_full(&self) -> bool {
                matches!(self, $full)
            }
        }
    )*};
}

may_be_full! {
    PublisherCreateError: PublisherCreateError::ExceedsMaxSupportedPublishers,
    SubscriberCreateError: SubscriberCreateError::ExceedsMaxSupportedSubscribers,
    NotifierCreateError: NotifierCreateError::ExceedsMaxSupportedNotifiers,
    ListenerCreateError: ListenerCreateError::ExceedsMaxSupportedListeners,
    ClientCreateError: ClientCreateError::ExceedsMaxSupportedClients,
    ServerCreateError: ServerCreateError::ExceedsMaxSupportedServers,
}

/// Opens a place at a service that has `limit` of them.
pub(crate) fn place<S: PortFactory<Service = Ipc>, P, E: MayBeFull>(
    service: &S,
    limit: usize,
    create: impl FnOnce() -> Result<P, E>,
) -> Result<P, OpenError> {
    let what = service.name().as_str().to_owned();
    match guarded(create) {
        (_, missing) if missing.any() => {
            Err(OpenError::SharedMemory { what, reason: FULL.to_owned() })
        }
        (Ok(port), _) => Ok(port),
        (Err(error), _) if error.is_full() => {
            Err(OpenError::Full { holders: holders(service), service: what, limit })
        }
        (Err(error), _) => Err(OpenError::SharedMemory { what, reason: reason(error) }),
    }
}

/// Returns the processes at a service, by name and number: `3 × hello, viewer`.
fn holders<S: PortFactory<Service = Ipc>>(service: &S) -> String {
    let mut names = Vec::new();
    // Processes that can't be listed stay unnamed.
    let _ = service.nodes(|node| {
        names.push(participant_name(&node));
        CallbackProgression::Continue
    });
    counted(names)
}

/// Returns the processes of a fleet, by name and number.
pub(super) fn participants(node: &Node<Ipc>, fleet: &FleetName) -> String {
    let prefix = service_name(fleet, "");
    let mut names = Vec::new();
    // Processes that can't be listed stay unnamed.
    let _ = Node::<Ipc>::list(node.config(), |node| {
        let details = match &node {
            NodeState::Alive(view) => view.details().as_ref(),
            NodeState::Dead(view) => view.details().as_ref(),
            _ => None,
        };
        if details.is_some_and(|details| details.name().as_str().starts_with(&prefix)) {
            names.push(participant_name(&node));
        }
        CallbackProgression::Continue
    });
    counted(names)
}

/// Returns the name under which a process has joined, and its number: `viewer (process 4711)`.
pub(super) fn node_name(config: &Config, id: UniqueNodeId) -> Option<String> {
    let state = Node::<Ipc>::state_of(config, id).ok().flatten()?;
    let name = participant_name(&state);
    Some(match state {
        NodeState::Alive(view) => {
            let details = view.details().as_ref()?;
            format!("{name} (process {})", details.process_id().value())
        }
        _ => name,
    })
}

/// Returns the name under which a process has joined.
fn participant_name(node: &NodeState<Ipc>) -> String {
    let details = match node {
        NodeState::Alive(view) => view.details().as_ref(),
        NodeState::Dead(view) => view.details().as_ref(),
        _ => None,
    };
    let name = details.and_then(|details| details.name().as_str().rsplit('/').next());
    name.unwrap_or("a process without a name").to_owned()
}

/// Returns names with their numbers of occurrences, most frequent first.
fn counted(names: Vec<String>) -> String {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for name in names {
        match counts.iter_mut().find(|(counted, _)| *counted == name) {
            Some((_, count)) => *count += 1,
            None => counts.push((name, 1)),
        }
    }
    counts.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let entries = counts
        .into_iter()
        .map(|(name, count)| if count == 1 { name } else { format!("{count} × {name}") });
    entries.collect::<Vec<_>>().join(", ")
}

/// Returns the owner of a service's publisher: `regatta (process 4711)`.
pub(super) fn publisher_owner<P, H>(
    service: &publish_subscribe::PortFactory<Ipc, P, H>,
    participant: &Participant,
) -> String
where
    P: core::fmt::Debug + ?Sized + IceoryxSend,
    H: core::fmt::Debug + ZeroCopySend,
{
    let mut owner = None;
    service.dynamic_config().list_publishers(|details| {
        owner = Some(details.node_id);
        CallbackProgression::Stop
    });
    let config = participant.node().map(Node::config);
    let state = owner.zip(config);
    let state = state.and_then(|(id, config)| Node::<Ipc>::state_of(config, id).ok().flatten());
    match state {
        Some(NodeState::Alive(view)) => match view.details() {
            Some(details) => {
                format!("{} (process {})", details.executable(), details.process_id().value())
            }
            None => "another process".to_owned(),
        },
        _ => "another process".to_owned(),
    }
}
