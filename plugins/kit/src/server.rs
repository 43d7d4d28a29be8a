//! A web server on a thread of its own, with a runtime of one thread.
//!
//! Clients can't hold it up, and can't exhaust its memory: each connection has a bounded part, and
//! the bodies of requests share the rest. A client that takes its answers too slowly is cut off. If
//! there are too many connections, or too little memory, the one that has been idle for the longest
//! time is closed. The handlers keep their part by answers in pieces of [`PIECE_BYTES`].

use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::response::Response;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

mod body;
mod clients;
mod guard;
mod place;
mod stream;

pub use body::{BodyError, read_body};
pub use guard::{Access, Refusal, is_foreign, is_own_host, is_token};
pub use place::{Place, socket_path};

use body::Memory;
use clients::{Client, Clients, Turn};
use place::Listener;
use stream::{Io, Paced};

/// The largest head of a request, in bytes.
pub const MAX_HEAD_BYTES: usize = 16 << 10;
/// The size of the pieces in which handlers should make long answers, in bytes.
pub const PIECE_BYTES: usize = 32 << 10;
/// The longest time for responses that are under way when a connection or the process ends.
const GRACE: Duration = Duration::from_millis(500);
/// The delay after a connection could not be accepted, for example because there are too many open
/// files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);
/// The largest number of handlers that do blocking work at the same time.
const BLOCKING_THREADS: usize = 4;

/// The limits of a server.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The longest time for a client to send the head of a request, from its connection or its
    /// last response on.
    pub request_timeout: Duration,
    /// The longest time in which a client takes no part of an answer that waits for it.
    pub write_timeout: Duration,
    /// The longest time that a connection is kept for further requests; any if absent.
    pub max_age: Option<Duration>,
    /// The largest number of concurrent connections. It is less where the process may open few
    /// files.
    pub max_connections: usize,
    /// The memory for the bodies of requests of all connections, in bytes.
    pub body_memory: usize,
}

/// The error of serving at a place.
#[derive(Debug, thiserror::Error)]
#[error("can't serve at {place} ({reason})")]
pub struct ServeError {
    /// The place.
    pub place: Place,
    /// The reason.
    pub reason: io::Error,
}

/// A running server. Dropping it ends it, after the responses that are under way.
#[derive(Debug)]
pub struct Server {
    places: Vec<Place>,
    /// Dropped to end the server.
    running: Option<watch::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Starts to serve at these places on a thread with a name, and runs `background` on the same
    /// thread.
    ///
    /// ```
    /// use std::io::{Read, Write};
    /// use std::time::Duration;
    /// use axum::{Router, routing::get};
    /// use regatta_kit::server::{Limits, Place, Server};
    ///
    /// let limits = Limits {
    ///     request_timeout: Duration::from_secs(10),
    ///     write_timeout: Duration::from_secs(10),
    ///     max_age: None,
    ///     max_connections: 64,
    ///     body_memory: 1 << 20,
    /// };
    /// let router = Router::new().route("/", get(|| async { "hello" }));
    /// let place = Place::Tcp(([127, 0, 0, 1], 0).into());
    /// let server = Server::start("hello", &[place], router, limits, async {})?;
    /// let mut client = std::net::TcpStream::connect(server.address().expect("a port"))?;
    /// client.write_all(b"GET / HTTP/1.0\r\n\r\n")?;
    /// let mut response = String::new();
    /// client.read_to_string(&mut response)?;
    /// assert!(response.ends_with("hello"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ServeError`] if an address is in use or not an address of this machine, or a socket can't
    /// be made.
    ///
    /// # Panics
    /// If there are no places.
    pub fn start(
        name: &str,
        places: &[Place],
        router: Router,
        limits: Limits,
        background: impl Future<Output = ()> + Send + 'static,
    ) -> Result<Self, ServeError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(BLOCKING_THREADS)
            .build()
            .map_err(|reason| ServeError { place: places[0].clone(), reason })?;
        let listeners = {
            let _entered = runtime.enter();
            places.iter().map(Listener::bind).collect::<Result<Vec<_>, _>>()?
        };
        let served = listeners.iter().map(|listener| listener.place().clone()).collect();
        let (running, end) = watch::channel(());
        let clients = Arc::new(Clients::new(within_open_files(limits.max_connections)));
        let memory = Memory::new(limits.body_memory, clients.clone());
        let shared = Shared { router, limits, clients, memory, end };
        let thread = thread::Builder::new().name(name.to_owned()).spawn(move || {
            runtime.spawn(background);
            runtime.block_on(serve(listeners, shared));
        });
        let thread = thread.map_err(|reason| ServeError { place: places[0].clone(), reason })?;
        Ok(Self { places: served, running: Some(running), thread: Some(thread) })
    }

    /// The places, with the actual port where port 0 was requested.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The address over TCP, if there is one.
    pub fn address(&self) -> Option<SocketAddr> {
        self.places.iter().find_map(Place::address)
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

/// The parts of a server that its connections share.
#[derive(Clone)]
struct Shared {
    router: Router,
    limits: Limits,
    clients: Arc<Clients>,
    memory: Memory,
    /// Changes at the end of the server.
    end: watch::Receiver<()>,
}

/// Serves at all places until the end, and then finishes the answers that are under way.
async fn serve(listeners: Vec<Listener>, shared: Shared) {
    let mut places = JoinSet::new();
    for listener in listeners {
        places.spawn(accept(listener, shared.clone()));
    }
    while places.join_next().await.is_some() {}
}

/// Accepts the connections of a place until the end, and then waits for the open ones.
async fn accept(listener: Listener, mut shared: Shared) {
    let mut tasks = JoinSet::new();
    loop {
        while tasks.try_join_next().is_some() {}
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = shared.end.changed() => break,
        };
        if accepted.is_err() || shared.clients.are_full() {
            shared.clients.close_idlest(Client::is_any);
        }
        match accepted {
            Ok(io) => {
                let client = Arc::new(Client::new(listener.peer()));
                let connection = connection(io, client.clone(), shared.clone());
                shared.clients.add(client, tasks.spawn(connection));
            }
            Err(_) => sleep(ACCEPT_RETRY_DELAY).await,
        }
    }
    drop(listener);
    while tasks.join_next().await.is_some() {}
}

/// Answers the requests of a client.
async fn connection(io: Box<dyn Io>, client: Arc<Client>, shared: Shared) {
    let Shared { router, limits, memory, mut end, .. } = shared;
    let io = Paced::new(io, client.clone(), limits.write_timeout);
    let answers = Answers { router: TowerToHyperService::new(router), client, memory };
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(limits.request_timeout)
        .max_buf_size(MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(io), answers);
    let mut connection = pin!(connection);
    let old = async {
        match limits.max_age {
            Some(max_age) => sleep(max_age).await,
            None => std::future::pending().await,
        }
    };
    // Any error of a connection is the client's: it has disconnected, it was too slow, or its
    // request was invalid and has been answered.
    tokio::select! {
        _ = connection.as_mut() => return,
        _ = end.changed() => {}
        () = old => {}
    }
    connection.as_mut().graceful_shutdown();
    let _ = timeout(GRACE, connection).await;
}

/// The handlers of a connection.
struct Answers {
    router: TowerToHyperService<Router>,
    client: Arc<Client>,
    memory: Memory,
}

impl Service<hyper::Request<Incoming>> for Answers {
    type Response = Response;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Response, Infallible>> + Send>>;

    fn call(&self, mut request: hyper::Request<Incoming>) -> Self::Future {
        let client = self.client.clone();
        request.extensions_mut().insert(client.peer());
        request.extensions_mut().insert(client.clone());
        request.extensions_mut().insert(self.memory.clone());
        let answer = self.router.call(request);
        Box::pin(async move {
            client.begin(Turn::Ours);
            let answer = answer.await?;
            client.begin(if is_endless(&answer) { Turn::Follows } else { Turn::Theirs });
            Ok(answer)
        })
    }
}

/// Whether an answer is a stream of events, which has no end.
fn is_endless(answer: &Response) -> bool {
    let kind = answer.headers().get(CONTENT_TYPE).map_or(&[][..], |kind| kind.as_bytes());
    kind.starts_with(b"text/event-stream")
}
