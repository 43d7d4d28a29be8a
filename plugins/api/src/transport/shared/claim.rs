//! Claims between processes. A claim is the one notifier of an event service, which notifies
//! nobody: iceoryx2 gives it to one process, and takes it back when that process has died.

use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::event;

use super::Ipc;
use super::open;
use super::places::{node_name, place};
use crate::ports::error::OpenError;
use crate::process::join::Participant;

/// The notifier that is the claim.
pub(crate) type Claim = Notifier<Ipc>;

/// The shortest time between two searches for dead processes.
const SEARCH: Duration = Duration::from_secs(1);
/// The longest time that a claim waits until a process that has just died is cleaned up.
const CLEANUP: Duration = Duration::from_secs(1);

/// Claims the thing of a name. `taken` makes the error if another process has it.
pub(crate) fn claim(
    participant: &Participant,
    name: &str,
    taken: impl FnOnce(String) -> OpenError,
) -> Result<Claim, OpenError> {
    let service = open::claim(participant, name)?;
    let mut created = place(&service, 1, || service.notifier_builder().create());
    if matches!(created, Err(OpenError::Full { .. })) {
        // Its holder may have died just now, or another process may be cleaning up after it.
        service.blocking_cleanup_dead_nodes(CLEANUP);
        created = place(&service, 1, || service.notifier_builder().create());
    }
    match created {
        Err(OpenError::Full { holders, .. }) => {
            let holder = Holder::of(service, participant);
            Err(taken(holder.name().unwrap_or(holders)))
        }
        created => created,
    }
}

/// Tells which process holds a claim.
pub(crate) struct Holder {
    service: event::PortFactory<Ipc>,
    config: Option<Config>,
    searched: Option<Instant>,
}

impl Holder {
    pub(crate) fn open(participant: &Participant, name: &str) -> Result<Self, OpenError> {
        Ok(Self::of(open::claim(participant, name)?, participant))
    }

    fn of(service: event::PortFactory<Ipc>, participant: &Participant) -> Self {
        let config = participant.node().map(|node| node.config().clone());
        Self { service, config, searched: None }
    }

    pub(crate) fn member(&self) -> Option<UniqueNodeId> {
        let mut member = None;
        self.service.dynamic_config().list_notifiers(|details| {
            member = Some(details.node_id);
            CallbackProgression::Stop
        });
        member
    }

    pub(crate) fn name(&self) -> Option<String> {
        let id = self.member()?;
        Some(node_name(self.config.as_ref()?, id).unwrap_or_else(|| "another process".to_owned()))
    }

    pub(crate) fn forget_dead(&mut self) {
        if self.searched.is_none_or(|searched| searched.elapsed() > SEARCH) {
            self.service.try_cleanup_dead_nodes();
            self.searched = Some(Instant::now());
        }
    }
}
