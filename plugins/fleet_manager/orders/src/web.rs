//! The web API: orders and vehicles as JSON, in the shape of openTCS's web API, with an OpenAPI
//! document. It is served at a Unix socket of this user, and at an address, if one is given, to
//! clients that have the token.
//!
//! It has a thread with a runtime of its own, and a board of its own with all orders and vehicles.
//! The manager's tick sends it the changes and never waits for it.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use regatta_kit::private::{self, TokenError};
use regatta_kit::server::{Access, Limits, Place, ServeError, Server};
use tokio::sync::Semaphore;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::open::OrderSettings;
use super::pool::OrderPool;
use super::store::{Archive, StoreError};
use super::threads::{Channels, Update};

mod api;
mod board;
mod list;
mod routes;

use api::Api;
use board::Board;

/// The name of the Unix socket, after that of the fleet.
pub(super) const SERVICE: &str = "orders";
/// The largest number of readers of events.
const MAX_READERS: usize = 64;
/// The number of orders that are over and still shown by the board: the store has all others.
const SHOWN_BESIDE_STORE: usize = 1_000;
/// The number of orders that are over and still shown if there is no store.
const SHOWN_WITHOUT_STORE: usize = 10_000;
const LIMITS: Limits = Limits {
    request_timeout: Duration::from_secs(10),
    write_timeout: Duration::from_secs(20),
    max_age: None,
    max_connections: 256,
    body_memory: 64 << 20,
};

/// Checks that the web API could be served: the token, and that the address is free now.
pub(super) fn check(address: SocketAddr, token_file: Option<&Path>) -> Result<(), WebError> {
    token(address, token_file)?;
    let listener = std::net::TcpListener::bind(address);
    listener.map(drop).map_err(|reason| WebError::Listen { address, reason })
}

/// Reads the token. On loopback it is that of this user, unless another is given; other machines
/// get one of their own.
fn token(address: SocketAddr, file: Option<&Path>) -> Result<String, WebError> {
    match file {
        Some(file) => Ok(private::read_token(file)?),
        None if address.ip().is_loopback() => Ok(private::token()?),
        None => Err(WebError::NeedsToken(address)),
    }
}

/// The error of serving the web API.
#[derive(Debug, thiserror::Error)]
pub enum WebError {
    /// The address is taken, or not one of this machine.
    #[error("can't serve orders on {address} ({reason}); choose another port with --http")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The reason.
        reason: std::io::Error,
    },
    /// Other machines can reach the address, and could send orders.
    #[error(
        "{0} can be reached from other machines: give a token with --token-file, or use 127.0.0.1"
    )]
    NeedsToken(SocketAddr),
    /// The Unix socket can't be made.
    #[error("can't serve orders at {} ({reason}); --no-http serves none", path.display())]
    Socket {
        /// The socket.
        path: PathBuf,
        /// The reason.
        reason: std::io::Error,
    },
    /// The token can't be used.
    #[error(transparent)]
    Token(#[from] TokenError),
    /// The store can't be read.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// A running web API. Dropping it ends it.
pub(super) struct Web {
    /// To the board.
    updates: UnboundedSender<Update>,
    server: Server,
}

impl Web {
    /// Starts it with a board that shows the pool's open orders, at the places of the settings.
    pub(super) fn start(
        settings: &OrderSettings,
        pool: &OrderPool,
        now_secs: f64,
        channels: Channels,
    ) -> Result<Self, WebError> {
        let token = settings.http.map(|address| token(address, settings.token_file.as_deref()));
        let access = Access::with_token(token.transpose()?);
        let places = pool.places();
        let archive = settings.store.as_deref().map(|path| Archive::open(path, places.clone()));
        let archive = archive.transpose()?;
        let open = pool.open_orders().map(|order| Arc::new(order.clone())).collect();
        let closed = if archive.is_some() { SHOWN_BESIDE_STORE } else { SHOWN_WITHOUT_STORE };
        let board = Arc::new(Board::new(places.clone(), open, closed, now_secs));
        // Names of orders that the store has are taken.
        board.number_from(archive.as_ref().map_or(Ok(0), Archive::last_number)?);
        let (updates, updates_out) = unbounded_channel();
        let background = board.clone().follow(updates_out);
        let (archive, readers) = (archive.map(Arc::new), Arc::new(Semaphore::new(MAX_READERS)));
        let Channels { jobs, requests } = channels;
        let router =
            routes::router(Arc::new(Api { board, archive, jobs, requests, readers }), access);
        let socket = settings.socket.iter().cloned().map(Place::Socket);
        let served: Vec<_> = socket.chain(settings.http.map(Place::Tcp)).collect();
        let server = Server::start("order-api", &served, router, LIMITS, background)?;
        Ok(Self { updates, server })
    }

    /// Shows the changes of a tick, without waiting.
    pub(super) fn publish(&self, update: Update) {
        // It fails only if the thread of the web API has ended.
        let _ = self.updates.send(update);
    }

    /// The address over TCP, with the actual port.
    pub(super) fn address(&self) -> Option<SocketAddr> {
        self.server.address()
    }
}

impl From<ServeError> for WebError {
    fn from(ServeError { place, reason }: ServeError) -> Self {
        match place {
            Place::Tcp(address) => Self::Listen { address, reason },
            Place::Socket(path) => Self::Socket { path, reason },
        }
    }
}

#[cfg(all(test, feature = "store"))]
mod tests;
