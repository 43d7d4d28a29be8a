//! The exporter's web server, which serves a page at `/metrics`.
//!
//! Clients can't hold it up: one that sends no request for a minute is closed, and the oldest
//! connection makes room for the newest.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::State;
use axum::http::header::{ACCEPT, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, StatusCode};
use axum::response::IntoResponse;
use axum::routing::get;
use regatta_kit::server::{Limits, Server, WhenFull};
use tower_http::compression::CompressionLayer;

use crate::exposition::Format;

const LIMITS: Limits = Limits {
    request_timeout: Duration::from_secs(60),
    max_age: Some(Duration::from_secs(600)),
    max_connections: 256,
    when_full: WhenFull::CloseOldest,
};

/// The error of listening on an address.
#[derive(Debug, thiserror::Error)]
#[error(
    "can't listen on {address} ({reason}); if another exporter does, choose another port with \
     --listen IP:PORT"
)]
pub struct ListenError {
    address: SocketAddr,
    reason: io::Error,
}

/// The source of the server's pages.
pub trait PageSource: Send + Sync + 'static {
    /// Returns the page at `/metrics`.
    fn metrics(&self, format: Format) -> String;
}

/// Starts to serve pages. Dropping the server ends it, after the responses that are under way.
///
/// # Errors
/// [`ListenError`] if the address is in use or not an address of this machine.
pub fn start(address: SocketAddr, pages: Arc<impl PageSource>) -> Result<Server, ListenError> {
    Server::start("exporter", address, router(pages), LIMITS, std::future::ready(()))
        .map_err(|reason| ListenError { address, reason })
}

fn router<P: PageSource>(pages: Arc<P>) -> Router {
    Router::new()
        .route("/metrics", get(metrics::<P>))
        .route("/", get(async || "Metrics of a Regatta fleet are at /metrics.\n"))
        .fallback(async || (StatusCode::NOT_FOUND, "There is only /metrics.\n"))
        .layer(CompressionLayer::new())
        .with_state(pages)
}

async fn metrics<P: PageSource>(
    State(pages): State<Arc<P>>,
    headers: HeaderMap,
) -> impl IntoResponse {
    let accept: Vec<_> =
        headers.get_all(ACCEPT).iter().filter_map(|accept| accept.to_str().ok()).collect();
    let format = Format::accepted(&accept.join(","));
    ([(CONTENT_TYPE, format.content_type()), (VARY, "accept")], pages.metrics(format))
}

#[cfg(test)]
mod tests;
