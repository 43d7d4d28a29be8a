//! A web server on a thread of its own, with a runtime of one thread.
//!
//! Clients can't hold it up: a connection without a request is closed after a while, and
//! [`WhenFull`] decides on connections beyond the limit.

use std::collections::VecDeque;
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
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{sleep, timeout};

/// The largest head of a request, in bytes.
pub const MAX_HEAD_BYTES: usize = 16 << 10;
/// The longest time for responses that are under way when a connection or the process ends.
const GRACE: Duration = Duration::from_millis(500);
/// The delay after a connection could not be accepted, for example because there are too many open
/// files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);

/// The behaviour of a server when it has as many connections as it may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhenFull {
    /// New connections wait.
    Wait,
    /// The oldest connection is closed.
    CloseOldest,
}

/// The limits of a server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The longest time for a client to send the head of a request, from its connection or its
    /// last response on.
    pub request_timeout: Duration,
    /// The longest time that a connection is kept for further requests; any if absent.
    pub max_age: Option<Duration>,
    /// The largest number of concurrent connections. It is less where the process may open few
    /// files.
    pub max_connections: usize,
    /// The fate of connections beyond the limit.
    pub when_full: WhenFull,
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
    /// Starts to serve on a thread with a name, and runs `background` on the same thread.
    ///
    /// ```
    /// use std::io::{Read, Write};
    /// use std::time::Duration;
    /// use axum::{Router, routing::get};
    /// use regatta_kit::server::{Limits, Server, WhenFull};
    ///
    /// let limits = Limits {
    ///     request_timeout: Duration::from_secs(10),
    ///     max_age: None,
    ///     max_connections: 64,
    ///     when_full: WhenFull::Wait,
    /// };
    /// let router = Router::new().route("/", get(|| async { "hello" }));
    /// let address = ([127, 0, 0, 1], 0).into();
    /// let server = Server::start("hello", address, router, limits, async {})?;
    /// let mut client = std::net::TcpStream::connect(server.address())?;
    /// client.write_all(b"GET / HTTP/1.0\r\n\r\n")?;
    /// let mut response = String::new();
    /// client.read_to_string(&mut response)?;
    /// assert!(response.ends_with("hello"));
    /// # std::io::Result::Ok(())
    /// ```
    ///
    /// # Errors
    /// If the address is in use or not an address of this machine.
    pub fn start(
        name: &str,
        address: SocketAddr,
        router: Router,
        limits: Limits,
        background: impl Future<Output = ()> + Send + 'static,
    ) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let listener = runtime.block_on(async { TcpListener::from_std(listener) })?;
        let (running, end) = watch::channel(());
        let thread = thread::Builder::new().name(name.to_owned()).spawn(move || {
            runtime.spawn(background);
            runtime.block_on(accept(listener, router, limits, end));
        })?;
        Ok(Self { address, running: Some(running), thread: Some(thread) })
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

/// Returns the largest number of concurrent connections: at most a quarter of the files that the
/// process may open, because shared memory needs some.
fn within_open_files(max_connections: usize) -> usize {
    #[cfg(unix)]
    let files = rustix::process::getrlimit(rustix::process::Resource::Nofile).current;
    #[cfg(not(unix))]
    let files = None::<u64>;
    let quarter = files.and_then(|files| usize::try_from(files / 4).ok());
    quarter.unwrap_or(max_connections).clamp(1, max_connections)
}

/// Accepts connections until the sender of `end` is dropped, and then waits for the open ones.
async fn accept(
    listener: TcpListener,
    router: Router,
    limits: Limits,
    mut end: watch::Receiver<()>,
) {
    let max_connections = within_open_files(limits.max_connections);
    let mut tasks = JoinSet::new();
    let mut connections = VecDeque::<AbortHandle>::new();
    loop {
        while tasks.try_join_next().is_some() {}
        if limits.when_full == WhenFull::Wait && tasks.len() >= max_connections {
            tokio::select! {
                _ = tasks.join_next() => continue,
                _ = end.changed() => break,
            }
        }
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = end.changed() => break,
        };
        connections.retain(|connection| !connection.is_finished());
        let is_full = accepted.is_err() || connections.len() >= max_connections;
        if is_full
            && limits.when_full == WhenFull::CloseOldest
            && let Some(oldest) = connections.pop_front()
        {
            oldest.abort();
        }
        match accepted {
            Ok((stream, _)) => {
                let connection = serve(stream, router.clone(), limits, end.clone());
                connections.push_back(tasks.spawn(connection));
            }
            Err(_) => sleep(ACCEPT_RETRY_DELAY).await,
        }
    }
    drop(listener);
    while tasks.join_next().await.is_some() {}
}

/// Answers the requests of a client.
async fn serve(stream: TcpStream, router: Router, limits: Limits, mut end: watch::Receiver<()>) {
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limits.request_timeout)
        .max_buf_size(MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router));
    let mut connection = pin!(connection);
    let old = async {
        match limits.max_age {
            Some(max_age) => sleep(max_age).await,
            None => std::future::pending().await,
        }
    };
    // Any error of a connection is the client's: it has disconnected, or its request was invalid
    // and has been answered.
    tokio::select! {
        _ = connection.as_mut() => return,
        _ = end.changed() => {}
        () = old => {}
    }
    connection.as_mut().graceful_shutdown();
    let _ = timeout(GRACE, connection).await;
}
