//! The connections of a server, and which of them is closed for another.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use parking_lot::Mutex;
use tokio::task::AbortHandle;

use super::guard::Peer;

/// The side of a connection that is to act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(super) enum Turn {
    /// The client: it sends a request, or takes an answer.
    Theirs,
    /// The client follows events, and hears something now and then.
    Follows,
    /// The handler of a request.
    Ours,
}

/// The state of a connection.
#[derive(Debug)]
pub(super) struct Client {
    peer: Peer,
    since: Instant,
    /// The time of the last byte from or to the client, in milliseconds after `since`.
    active_ms: AtomicU64,
    turn: AtomicU8,
    /// The bytes of bodies that it holds.
    held: AtomicUsize,
}

impl Client {
    pub(super) fn new(peer: Peer) -> Self {
        Self {
            peer,
            since: Instant::now(),
            active_ms: AtomicU64::new(0),
            turn: AtomicU8::new(Turn::Theirs as u8),
            held: AtomicUsize::new(0),
        }
    }

    pub(super) fn peer(&self) -> Peer {
        self.peer
    }

    /// Notes that bytes came or went.
    pub(super) fn is_active(&self) {
        self.active_ms.store(self.since.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    pub(super) fn begin(&self, turn: Turn) {
        self.turn.store(turn as u8, Ordering::Relaxed);
    }

    /// Notes that it holds so many bytes of a body.
    pub(super) fn hold(&self, bytes: usize) {
        self.held.store(bytes, Ordering::Relaxed);
    }

    pub(super) fn is_any(&self) -> bool {
        true
    }

    pub(super) fn holds_memory(&self) -> bool {
        self.held.load(Ordering::Relaxed) > 0
    }

    /// The order in which connections are closed: clients whose turn it is come first, and among
    /// them the one that was active the longest time ago.
    fn rank(&self) -> (u8, Instant) {
        let active = std::time::Duration::from_millis(self.active_ms.load(Ordering::Relaxed));
        (self.turn.load(Ordering::Relaxed), self.since + active)
    }
}

/// All open connections.
#[derive(Debug)]
pub(super) struct Clients {
    open: Mutex<Vec<(Arc<Client>, AbortHandle)>>,
    max: usize,
}

impl Clients {
    pub(super) fn new(max: usize) -> Self {
        Self { open: Mutex::default(), max }
    }

    pub(super) fn are_full(&self) -> bool {
        let mut open = self.open.lock();
        open.retain(|(_, connection)| !connection.is_finished());
        open.len() >= self.max
    }

    pub(super) fn add(&self, client: Arc<Client>, connection: AbortHandle) {
        self.open.lock().push((client, connection));
    }

    /// Closes the connection of a kind that has been idle for the longest time.
    pub(super) fn close_idlest(&self, is_of_kind: impl Fn(&Client) -> bool) {
        let mut open = self.open.lock();
        open.retain(|(_, connection)| !connection.is_finished());
        let candidates = open.iter().enumerate().filter(|(_, (client, _))| is_of_kind(client));
        let idlest = candidates.min_by_key(|(_, (client, _))| client.rank());
        if let Some(index) = idlest.map(|(index, _)| index) {
            let (_, connection) = open.swap_remove(index);
            connection.abort();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn idle(turn: Turn) -> Arc<Client> {
        let client = Client::new(Peer::Socket);
        client.begin(turn);
        Arc::new(client)
    }

    #[tokio::test]
    async fn the_idlest_client_is_closed_before_one_that_is_served() {
        let clients = Clients::new(3);
        let mut tasks = Vec::new();
        for turn in [Turn::Ours, Turn::Theirs, Turn::Theirs, Turn::Follows] {
            let task = tokio::spawn(std::future::pending::<()>());
            clients.add(idle(turn), task.abort_handle());
            tasks.push(task);
        }
        clients.open.lock()[1].0.active_ms.store(60_000, Ordering::Relaxed);
        for closed in [2, 1, 3, 0] {
            assert!(!tasks[closed].is_finished());
            clients.close_idlest(Client::is_any);
            tokio::task::yield_now().await;
            assert!(tasks[closed].is_finished(), "{closed}");
        }
        clients.close_idlest(Client::is_any);
        assert!(!clients.are_full());
    }
}
