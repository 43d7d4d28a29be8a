//! The bodies of requests, which share a budget of memory.

use std::sync::Arc;
use std::time::Duration;

use axum::body::HttpBody as _;
use axum::extract::Request;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, MissedTickBehavior, interval_at, timeout};

use super::clients::{Client, Clients, Turn};

/// The time without free memory after which a connection is closed for another.
const PATIENCE: Duration = Duration::from_millis(100);

/// The error of reading the body of a request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BodyError {
    /// It is longer than the route allows.
    #[error("the body has more than {0} bytes")]
    TooLarge(usize),
    /// The client sends it too slowly.
    #[error("the body arrived too slowly")]
    TooSlow,
    /// The connection ended, or its framing is wrong.
    #[error("the body is incomplete ({0})")]
    Incomplete(String),
}

/// The memory for bodies.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    free: Arc<Semaphore>,
    total: usize,
    clients: Arc<Clients>,
}

impl Memory {
    pub(super) fn new(bytes: usize, clients: Arc<Clients>) -> Self {
        let total = bytes.min(Semaphore::MAX_PERMITS);
        Self { free: Arc::new(Semaphore::new(total)), total, clients }
    }

    /// Takes so many bytes, when they are free. While they aren't, the idlest connections that hold
    /// memory are closed, one after the other.
    async fn take(&self, bytes: usize) -> Option<OwnedSemaphorePermit> {
        let bytes = u32::try_from(bytes.min(self.total)).unwrap_or(u32::MAX);
        let taken = self.free.clone().acquire_many_owned(bytes);
        tokio::pin!(taken);
        let mut patience = interval_at(Instant::now() + PATIENCE, PATIENCE);
        patience.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                // It fails only if the semaphore is closed, which nothing does.
                taken = &mut taken => return taken.ok(),
                _ = patience.tick() => self.clients.close_idlest(Client::holds_memory),
            }
        }
    }
}

/// Reads the body of a request: at most `limit` bytes, within a time. Its memory is that of all
/// connections, until it is returned.
///
/// # Errors
/// [`BodyError`] if it is too long, too slow or incomplete.
pub async fn read_body(
    request: Request,
    limit: usize,
    longest: Duration,
) -> Result<Vec<u8>, BodyError> {
    let (parts, mut body) = request.into_parts();
    if body.size_hint().lower() > limit as u64 {
        return Err(BodyError::TooLarge(limit));
    }
    let (client, memory) = (parts.extensions.get(), parts.extensions.get::<Memory>());
    let _turn = client.map(|client: &Arc<Client>| TheirTurn::begin(client));
    let read = async {
        let (mut bytes, mut shares) = (Vec::new(), Vec::new());
        while let Some(frame) =
            std::future::poll_fn(|c| std::pin::Pin::new(&mut body).poll_frame(c)).await
        {
            let frame = frame.map_err(|error| BodyError::Incomplete(error.to_string()))?;
            let Ok(data) = frame.into_data() else { continue };
            if bytes.len() + data.len() > limit {
                return Err(BodyError::TooLarge(limit));
            }
            if let Some(memory) = memory {
                shares.push(memory.take(data.len()).await);
            }
            bytes.extend_from_slice(&data);
            if let Some(client) = client {
                client.hold(bytes.len());
            }
        }
        Ok(bytes)
    };
    timeout(longest, read).await.map_err(|_| BodyError::TooSlow)?
}

/// The time in which a client sends a body.
struct TheirTurn<'a>(&'a Client);

impl<'a> TheirTurn<'a> {
    fn begin(client: &'a Client) -> Self {
        client.begin(Turn::Theirs);
        Self(client)
    }
}

impl Drop for TheirTurn<'_> {
    fn drop(&mut self) {
        self.0.hold(0);
        self.0.begin(Turn::Ours);
    }
}
