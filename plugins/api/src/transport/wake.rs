//! Sleeping until another process has news. Nobody sleeps in a local fleet.

use std::time::Duration;

#[cfg(feature = "shared-memory")]
use super::shared;
use crate::ports::error::{OpenError, ReadError};
use crate::process::join::Participant;

/// The notifying end of one of a fleet's event services.
pub(crate) struct Notifier {
    /// `None` if no other process can listen.
    #[cfg(feature = "shared-memory")]
    port: Option<shared::Notifier>,
}

impl Notifier {
    /// Opens the event service of a name.
    pub(crate) fn open(participant: &Participant, service: &str) -> Result<Self, OpenError> {
        let _ = (participant, service);
        Ok(Self {
            #[cfg(feature = "shared-memory")]
            port: match participant.shared() {
                Some(participant) => Some(shared::notifier(participant, service)?),
                None => None,
            },
        })
    }

    /// Wakes the processes that listen. Never blocks: see [`shared::notifier`].
    pub(crate) fn notify(&self) {
        // A process that can't be woken polls; that is no reason to stop the fleet.
        #[cfg(feature = "shared-memory")]
        if let Some(port) = &self.port
            && let Err(error) = port.notify()
        {
            tracing::debug!(%error, "waking other processes");
        }
    }
}

/// The listening end of one of a fleet's event services.
pub(crate) struct Wake {
    /// `None` in a local fleet.
    #[cfg(feature = "shared-memory")]
    port: Option<shared::Wake>,
}

impl Wake {
    /// Opens the event service of a name.
    pub(crate) fn open(participant: &Participant, service: &str) -> Result<Self, OpenError> {
        let _ = (participant, service);
        Ok(Self {
            #[cfg(feature = "shared-memory")]
            port: match participant.home() {
                crate::process::join::Home::Shared(_) => {
                    Some(shared::Wake::open(participant, service)?)
                }
                crate::process::join::Home::Local(_) => None,
            },
        })
    }

    /// Forgets the wake-ups so far. Must be followed by a check for the news that they announced:
    /// samples that are sent after this check wake again.
    pub(crate) fn forget(&self) -> Result<(), ReadError> {
        #[cfg(feature = "shared-memory")]
        if let Some(port) = &self.port {
            return port.forget();
        }
        Ok(())
    }

    /// Sleeps until woken, but no longer than `left` or a tenth of a second. Returns `false` if no
    /// news can have come: a signal ended the sleep, or the fleet is local.
    pub(crate) fn sleep(&self, left: Duration) -> Result<bool, ReadError> {
        let _ = left;
        #[cfg(feature = "shared-memory")]
        if let Some(port) = &self.port {
            return port.sleep(left);
        }
        Ok(false)
    }
}
