//! The threads beside the manager's tick: the store and the web API.

use std::net::SocketAddr;
use std::sync::mpsc::Receiver;

use tokio::sync::mpsc::UnboundedSender;

use super::requests::{Request, Update};
use super::store::Writer;
use super::web::Web;

/// The store and the web API of a pool, which run on threads of their own. Neither side waits for
/// the other.
pub(super) struct Threads {
    pub(super) requests: Receiver<Request>,
    pub(super) updates: Option<UnboundedSender<Update>>,
    // The web API ends before the store, which it uses.
    pub(super) web: Option<Web>,
    pub(super) store: Option<Writer>,
}

impl Threads {
    /// Returns all requests since the last call.
    pub(super) fn requests(&mut self) -> Vec<Request> {
        self.requests.try_iter().collect()
    }

    /// Passes an update on, without waiting.
    pub(super) fn publish(&mut self, mut update: Update) {
        let done = std::mem::take(&mut update.done);
        match &self.store {
            Some(store) => store.update(update.orders.clone(), done),
            None => {
                for reply in done {
                    reply(());
                }
            }
        }
        if let Some(updates) = &self.updates {
            // It fails only if the web API has ended.
            let _ = updates.send(update);
        }
    }

    /// Whether the web API needs figures, which take time to compute.
    pub(super) fn wants_figures(&self) -> bool {
        self.updates.is_some()
    }

    /// Whether all published changes are in the store.
    pub(super) fn is_saved(&self) -> bool {
        self.store.as_ref().is_none_or(Writer::is_saved)
    }

    /// The address of the web API.
    pub(super) fn address(&self) -> Option<SocketAddr> {
        self.web.as_ref().map(Web::address)
    }
}
