//! The web server: a thread with a runtime of its own.
//!
//! Clients can't hold it up: one that sends no request is closed after [`REQUEST_TIMEOUT`]. With
//! [`max_connections`] open, further ones wait.

use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

/// The longest time for a client to send the head of a request, from its connection or its last
/// response on.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);
/// The longest time for responses that are under way when the process ends.
const GRACE: Duration = Duration::from_millis(500);
/// The largest number of concurrent connections, where the process may open enough files.
const MAX_CONNECTIONS: usize = 1_024;
/// The largest head of a request, in bytes.
const MAX_HEAD: usize = 16 << 10;
/// The delay after a connection could not be accepted, for example because there are too many open
/// files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);

/// A running server. Dropping it ends it, after the responses that are under way.
pub(super) struct Server {
    address: SocketAddr,
    /// Dropped to end the server.
    running: Option<watch::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to serve, and runs `beside` on the same thread.
    pub(super) fn start(
        address: SocketAddr,
        router: Router,
        beside: impl Future<Output = ()> + Send + 'static,
    ) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let listener = runtime.block_on(async { TcpListener::from_std(listener) })?;
        let (running, end) = watch::channel(());
        let run = move || {
            runtime.spawn(beside);
            runtime.block_on(serve(listener, router, end));
        };
        let thread = thread::Builder::new().name("order-api".to_owned()).spawn(run)?;
        Ok(Self { address, running: Some(running), thread: Some(thread) })
    }

    /// The address, with the actual port if port 0 was requested.
    pub(super) fn address(&self) -> SocketAddr {
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
    let mut connections = JoinSet::new();
    let limit = max_connections();
    loop {
        while connections.try_join_next().is_some() {}
        if connections.len() >= limit {
            tokio::select! {
                _ = connections.join_next() => continue,
                _ = end.changed() => break,
            }
        }
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = end.changed() => break,
        };
        match accepted {
            Ok((stream, _)) => {
                drop(connections.spawn(converse(stream, router.clone(), end.clone())))
            }
            Err(_) => sleep(ACCEPT_RETRY_DELAY).await,
        }
    }
    drop(listener);
    while connections.join_next().await.is_some() {}
}

/// Answers the requests of a client.
async fn converse(stream: TcpStream, router: Router, mut end: watch::Receiver<()>) {
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REQUEST_TIMEOUT)
        .max_buf_size(MAX_HEAD)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router));
    let mut connection = pin!(connection);
    // Any error of a connection is the client's: it has disconnected, or its request was invalid
    // and has been answered.
    tokio::select! {
        _ = connection.as_mut() => return,
        _ = end.changed() => {}
    }
    connection.as_mut().graceful_shutdown();
    let _ = timeout(GRACE, connection).await;
}
