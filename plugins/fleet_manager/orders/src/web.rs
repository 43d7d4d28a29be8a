//! The web API: orders and vehicles as JSON, in the shape of openTCS's web API, with an OpenAPI
//! document.
//!
//! It has a thread with a runtime of its own, and a board of its own with all orders and vehicles.
//! The manager's tick sends it the changes and never waits for it.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use regatta_kit::server::{Limits, Server, WhenFull};
use tokio::sync::Semaphore;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::open::OrderSettings;
use super::pool::OrderPool;
use super::store::{Archive, StoreError};
use super::threads::{Channels, Update};

mod api;
mod board;
mod routes;

use api::Api;
use board::Board;

/// The largest number of readers of events.
const MAX_READERS: usize = 64;
/// Readers of events stay, and so the oldest connection isn't closed for a new one.
const LIMITS: Limits = Limits {
    request_timeout: Duration::from_secs(10),
    max_age: None,
    max_connections: 1_024,
    when_full: WhenFull::Wait,
};

/// Checks that the web API could be served: the token, and that the address is free now.
pub(super) fn check(address: SocketAddr, token_file: Option<&Path>) -> Result<(), WebError> {
    token(address, token_file)?;
    let listener = std::net::TcpListener::bind(address);
    listener.map(drop).map_err(|reason| WebError::Listen { address, reason })
}

/// Reads the token, which addresses that others may reach need.
fn token(address: SocketAddr, file: Option<&Path>) -> Result<Option<String>, WebError> {
    match file {
        Some(file) => read_token(file).map(Some),
        None if address.ip().is_loopback() => Ok(None),
        None => Err(WebError::NeedsToken(address)),
    }
}

/// The error of serving the web API.
#[derive(Debug, thiserror::Error)]
pub enum WebError {
    /// The address is taken, or not one of this machine.
    #[error(
        "can't serve orders on {address} ({reason}); choose another port with --http, or --http off"
    )]
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
    /// The file with the token can't be used.
    #[error("can't use the token of {} ({reason})", path.display())]
    Token {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
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
    /// Starts it with a board that shows the pool's open orders.
    pub(super) fn start(
        address: SocketAddr,
        settings: &OrderSettings,
        pool: &OrderPool,
        now_secs: f64,
        channels: Channels,
    ) -> Result<Self, WebError> {
        let token = token(address, settings.token_file.as_deref())?;
        let places = pool.places();
        let archive = settings.store.as_deref().map(|path| Archive::open(path, places.clone()));
        let archive = archive.transpose()?;
        let open = pool.open_orders().map(|order| Arc::new(order.clone())).collect();
        let board = Arc::new(Board::new(places.clone(), open, now_secs));
        // Names of orders that the store has are taken.
        board.number_from(archive.as_ref().map_or(Ok(0), Archive::last_number)?);
        let (updates, updates_out) = unbounded_channel();
        let background = board.clone().follow(updates_out);
        let (archive, readers) = (archive.map(Arc::new), Arc::new(Semaphore::new(MAX_READERS)));
        let Channels { jobs, requests } = channels;
        let api = Api { board, archive, jobs, requests, token, readers };
        let router = routes::router(Arc::new(api));
        match Server::start("order-api", address, router, LIMITS, background) {
            Ok(server) => Ok(Self { updates, server }),
            Err(reason) => Err(WebError::Listen { address, reason }),
        }
    }

    /// Shows the changes of a tick, without waiting.
    pub(super) fn publish(&self, update: Update) {
        // It fails only if the thread of the web API has ended.
        let _ = self.updates.send(update);
    }

    /// The address, with the actual port.
    pub(super) fn address(&self) -> SocketAddr {
        self.server.address()
    }
}

/// The shortest token.
const MIN_TOKEN_BYTES: usize = 8;
/// The size of the largest file of a token.
const MAX_TOKEN_FILE_BYTES: u64 = 4096;

fn read_token(path: &Path) -> Result<String, WebError> {
    let reason = match regatta_base::file::read_text(path, MAX_TOKEN_FILE_BYTES) {
        Ok(text) => {
            let token = text.trim();
            if token.len() >= MIN_TOKEN_BYTES && token.bytes().all(|byte| byte.is_ascii_graphic()) {
                return Ok(token.to_owned());
            }
            format!("it must have at least {MIN_TOKEN_BYTES} visible ASCII characters")
        }
        Err(error) => error.to_string(),
    };
    Err(WebError::Token { path: path.to_owned(), reason })
}

#[cfg(all(test, feature = "store"))]
mod tests;
