//! The exporter's web server, which serves a page at `/metrics`.
//!
//! It has a thread of its own with a runtime of one thread, so that clients cost the reader of
//! frames nothing. Clients can't hold it up either: one that sends no request is closed after
//! [`REQUEST_TIMEOUT`], and when there are [`max_connections`], the oldest connection makes room
//! for the newest.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use axum::Router;
use axum::extract::State;
use axum::http::header::{ACCEPT, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, StatusCode};
use axum::response::IntoResponse;
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use tower_http::compression::CompressionLayer;

use crate::exposition::Format;

/// The longest time for a client to send a request, from its connection or its last response on.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(60);
/// The longest time that a connection is kept for further requests.
const MAX_AGE: Duration = Duration::from_secs(600);
/// The longest time for responses that are under way when a connection or the process ends.
const GRACE: Duration = Duration::from_millis(500);
/// The largest number of concurrent connections, where the process may open enough files.
const MAX_CONNECTIONS: usize = 256;
/// The largest number of bytes in a request.
const MAX_REQUEST: usize = 16 << 10;
/// The delay after a connection could not be accepted, for example because there are too many open
/// files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);

/// The error of listening on an address.
#[derive(Debug, thiserror::Error)]
#[error(
    "can't listen on {address} ({reason}); if another exporter does, choose another port with --listen IP:PORT"
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

/// A running server. Dropping it ends it, after the responses that are under way.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    /// Dropped to end the server.
    running: Option<watch::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to serve pages.
    ///
    /// # Errors
    /// [`ListenError`] if the address is in use or not an address of this machine.
    pub fn start(address: SocketAddr, pages: Arc<impl PageSource>) -> Result<Self, ListenError> {
        let start = || {
            let listener = std::net::TcpListener::bind(address)?;
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
            let listener = runtime.block_on(async { TcpListener::from_std(listener) })?;
            let (running, end) = watch::channel(());
            let serve = move || runtime.block_on(serve(listener, router(pages), end));
            let thread = thread::Builder::new().name("exporter".to_owned()).spawn(serve)?;
            Ok(Self { address, running: Some(running), thread: Some(thread) })
        };
        start().map_err(|reason| ListenError { address, reason })
    }

    /// The address, with the actual port if port 0 was requested.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.running = None;
        if let Some(thread) = self.thread.take() {
            // The result is an error only if the thread panicked, and the panic has been printed.
            let _ = thread.join();
        }
    }
}

fn router<P: PageSource>(pages: Arc<P>) -> Router {
    let index = || async { "Metrics of a Regatta fleet are at /metrics.\n" };
    let unknown = || async { (StatusCode::NOT_FOUND, "There is only /metrics.\n") };
    Router::new()
        .route("/metrics", get(metrics::<P>))
        .route("/", get(index))
        .fallback(unknown)
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

/// Returns the largest number of concurrent connections: at most a quarter of the files that the
/// process may open, because shared memory needs some.
fn max_connections() -> usize {
    #[cfg(unix)]
    let files = rustix::process::getrlimit(rustix::process::Resource::Nofile).current;
    #[cfg(not(unix))]
    let files = None::<u64>;
    files.map_or(MAX_CONNECTIONS, |files| {
        usize::try_from(files / 4).unwrap_or(MAX_CONNECTIONS).clamp(1, MAX_CONNECTIONS)
    })
}

/// Accepts connections until the sender of `end` is dropped, and then waits for the open ones.
async fn serve(listener: TcpListener, router: Router, mut end: watch::Receiver<()>) {
    let mut tasks = JoinSet::new();
    let mut connections = VecDeque::new();
    let limit = max_connections();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = end.changed() => break,
        };
        while tasks.try_join_next().is_some() {}
        connections.retain(|connection: &tokio::task::AbortHandle| !connection.is_finished());
        if accepted.is_err() || connections.len() >= limit {
            connections.pop_front().iter().for_each(tokio::task::AbortHandle::abort);
        }
        match accepted {
            Ok((stream, _)) => {
                connections.push_back(tasks.spawn(converse(stream, router.clone(), end.clone())))
            }
            Err(_) => sleep(ACCEPT_RETRY_DELAY).await,
        }
    }
    drop(listener);
    while tasks.join_next().await.is_some() {}
}

/// Answers the requests of a client.
async fn converse(stream: TcpStream, router: Router, mut end: watch::Receiver<()>) {
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REQUEST_TIMEOUT)
        .max_buf_size(MAX_REQUEST)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router));
    let mut connection = pin!(connection);
    // Any error of a connection is the client's: it has disconnected, or its request was invalid
    // and has been answered.
    tokio::select! {
        _ = connection.as_mut() => return,
        _ = end.changed() => {}
        () = sleep(MAX_AGE) => {}
    }
    connection.as_mut().graceful_shutdown();
    let _ = timeout(GRACE, connection).await;
}

#[cfg(test)]
mod tests;
