//! The web API: orders and vehicles as JSON, in the shape of openTCS's web API, with an OpenAPI document.
//!
//! It has a thread with a runtime of its own, and a board of its own with all orders and vehicles. The manager's tick sends
//! it what has changed and never waits for it.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::Sender;

use tokio::sync::mpsc::UnboundedReceiver;

use super::desk::{Request, Update};
use super::order::Order;
use super::places::Places;
use super::store::Job;

mod board;
mod events;
mod json;
mod routes;
mod server;

/// The settings of the web API.
pub(super) struct WebSettings {
    pub(super) address: SocketAddr,
    pub(super) token_file: Option<PathBuf>,
}

/// Why the web API can't be served.
#[derive(Debug, thiserror::Error)]
pub enum WebError {
    /// The address is taken, or not one of this machine.
    #[error("can't serve orders on {address} ({reason}); choose another port with --http, or --http off")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The reason.
        reason: std::io::Error,
    },
    /// Others may reach the address, and anybody could send orders.
    #[error("{0} can be reached from other machines: give a token with --token-file, or use 127.0.0.1")]
    NeedsToken(SocketAddr),
    /// The file with the token can't be used.
    #[error("can't use the token of {} ({reason})", path.display())]
    Token {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

/// A running web API. Dropping it ends it.
pub(super) struct Web(server::Server);

impl Web {
    /// Starts it with the open orders. `jobs` leads to the store, `requests` to the book, and `updates` comes from it.
    pub(super) fn start(
        settings: &WebSettings,
        places: Arc<Places>,
        jobs: Option<Sender<Job>>,
        requests: Sender<Request>,
        updates: UnboundedReceiver<Update>,
        open: Vec<Arc<Order>>,
    ) -> Result<Self, WebError> {
        let address = settings.address;
        let token = settings.token_file.as_deref().map(read_token).transpose()?;
        if token.is_none() && !address.ip().is_loopback() {
            return Err(WebError::NeedsToken(address));
        }
        let board = Arc::new(board::Board::new(places, open));
        let desk = routes::Desk::new(board.clone(), jobs, requests, token);
        let server = server::Server::start(address, routes::router(desk), board.follow(updates));
        server.map(Self).map_err(|reason| WebError::Listen { address, reason })
    }

    /// The address, with the actual port.
    pub(super) fn address(&self) -> SocketAddr {
        self.0.address()
    }
}

/// The shortest token.
const MIN_TOKEN_BYTES: usize = 8;

fn read_token(path: &Path) -> Result<String, WebError> {
    let error = |reason: String| WebError::Token { path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(|reason| error(reason.to_string()))?;
    let token = text.trim();
    match token.len() >= MIN_TOKEN_BYTES && token.bytes().all(|byte| byte.is_ascii_graphic()) {
        true => Ok(token.to_owned()),
        false => Err(error(format!("it must have at least {MIN_TOKEN_BYTES} visible ASCII characters"))),
    }
}

#[cfg(test)]
mod tests;
