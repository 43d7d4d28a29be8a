//! The exporter's web server, which serves a page at `/metrics`: at a Unix socket of this user, or
//! at an address, to clients that have the token.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{Request, State};
use axum::http::header::{ACCEPT, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use regatta_kit::server::{Access, Limits, Place, Refusal, ServeError, Server};
use tower_http::compression::CompressionLayer;

use crate::exposition::Format;

const LIMITS: Limits = Limits {
    request_timeout: Duration::from_secs(60),
    write_timeout: Duration::from_secs(20),
    max_age: Some(Duration::from_secs(600)),
    max_connections: 128,
    body_memory: 1 << 20,
};

/// The error of listening on an address.
#[derive(Debug, thiserror::Error)]
#[error(
    "can't listen on {place} ({reason}); if another exporter does, choose another port with \
     --listen IP:PORT"
)]
pub struct ListenError {
    place: Place,
    reason: io::Error,
}

/// The source of the server's pages.
pub trait PageSource: Send + Sync + 'static {
    /// Returns the page at `/metrics`.
    fn metrics(&self, format: Format) -> String;
}

/// Starts to serve pages at a place, over TCP to those who have the token. Dropping the server ends
/// it, after the responses that are under way.
///
/// # Errors
/// [`ListenError`] if the address is in use or not an address of this machine, or if the socket
/// can't be made.
pub fn start(
    place: Place,
    access: Access,
    pages: Arc<impl PageSource>,
) -> Result<Server, ListenError> {
    let router = router(pages, access);
    Server::start("exporter", &[place], router, LIMITS, std::future::ready(()))
        .map_err(|ServeError { place, reason }| ListenError { place, reason })
}

fn router<P: PageSource>(pages: Arc<P>, access: Access) -> Router {
    Router::new()
        .route("/metrics", get(metrics::<P>))
        .route("/", get(async || "Metrics of a Regatta fleet are at /metrics.\n"))
        .fallback(async || (StatusCode::NOT_FOUND, "There is only /metrics.\n"))
        .layer(CompressionLayer::new())
        .layer(from_fn_with_state(access, guard))
        .with_state(pages)
}

/// Accepts requests of this user, and those that have the token.
async fn guard(State(access): State<Access>, request: Request, next: Next) -> Response {
    match access.check(&request) {
        Ok(()) => next.run(request).await,
        Err(refusal @ Refusal::Token) => refused(StatusCode::UNAUTHORIZED, refusal),
        Err(refusal @ Refusal::Site) => refused(StatusCode::FORBIDDEN, refusal),
    }
}

fn refused(status: StatusCode, refusal: Refusal) -> Response {
    (status, format!("{refusal}\n")).into_response()
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
