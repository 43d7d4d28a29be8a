//! The server: takes connections, and decides which of them become clients.

mod client;
mod gate;

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;

use crate::desk::Desk;
use crate::hub::{Fault, Hub};
use crate::protocol::MOST_BYTES;
use client::Client;
pub(crate) use gate::Gate;

/// The most clients.
const MOST_CLIENTS: usize = 32;
/// The most connections that are not clients yet.
const MOST_STRANGERS: usize = 64;
/// The time for a connection to become a client.
const HANDSHAKE_TIME: Duration = Duration::from_secs(10);
/// The pause after an error of the listener, such as too many open files.
const ERROR_PAUSE: Duration = Duration::from_millis(100);
/// The bytes that the system keeps for a client that reads slowly: some of the largest frames would
/// make all that follows old.
const SEND_BUFFER_BYTES: u32 = 512 << 10;
/// The bytes that are read or written at a time.
const BUFFER_BYTES: usize = 64 << 10;

/// The error of listening.
#[derive(Debug, thiserror::Error)]
#[error("can't listen on {address} ({reason}); choose another port with --listen IP:PORT")]
pub(crate) struct ListenError {
    address: SocketAddr,
    reason: io::Error,
}

/// A running server. Dropping it ends it and its connections.
#[derive(Debug)]
pub(crate) struct Server {
    address: SocketAddr,
    /// Dropped to end the server.
    running: Option<watch::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens at an address, on a thread of its own.
    pub fn start(
        address: SocketAddr,
        gate: Gate,
        hub: Arc<Hub>,
        desk: Desk,
    ) -> Result<Self, ListenError> {
        Self::open(address, gate, hub, desk).map_err(|reason| ListenError { address, reason })
    }

    fn open(address: SocketAddr, gate: Gate, hub: Arc<Hub>, desk: Desk) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let listener = {
            let _entered = runtime.enter();
            listen(address)?
        };
        let address = listener.local_addr()?;
        let (running, end) = watch::channel(());
        let strangers = Arc::new(Semaphore::new(MOST_STRANGERS));
        let seats = Arc::new(Semaphore::new(MOST_CLIENTS));
        let shared = Shared { gate: Arc::new(gate), hub, desk, strangers, seats };
        let thread = std::thread::Builder::new().name("server".to_owned());
        let thread = thread.spawn(move || runtime.block_on(serve(listener, shared, end)))?;
        Ok(Self { address, running: Some(running), thread: Some(thread) })
    }

    /// The address, with the actual port where port 0 was requested.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.running = None;
        if let Some(thread) = self.thread.take() {
            // Its panic has been printed.
            let _ = thread.join();
        }
    }
}

fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    // So that the port is free at once when the plugin starts again; Windows means more by it.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(SEND_BUFFER_BYTES)?;
    socket.bind(address)?;
    socket.listen(MOST_STRANGERS as u32)
}

/// The state that connections share.
#[derive(Clone)]
struct Shared {
    gate: Arc<Gate>,
    hub: Arc<Hub>,
    desk: Desk,
    strangers: Arc<Semaphore>,
    seats: Arc<Semaphore>,
}

async fn serve(listener: TcpListener, shared: Shared, mut end: watch::Receiver<()>) {
    let mut connections = JoinSet::new();
    loop {
        while connections.try_join_next().is_some() {}
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = end.changed() => break,
        };
        match accepted {
            Ok((stream, peer)) => drop(connections.spawn(shared.clone().connect(stream, peer))),
            Err(_) => sleep(ERROR_PAUSE).await,
        }
    }
    connections.shutdown().await;
}

impl Shared {
    /// Makes a connection a client, and serves it.
    async fn connect(self, stream: TcpStream, peer: SocketAddr) {
        let Ok(stranger) = self.strangers.clone().try_acquire_owned() else {
            let format = format_args!("{MOST_STRANGERS} connections are no clients yet");
            self.hub.tell(Fault::Crowd, format);
            return;
        };
        let seat = self.seats.clone().try_acquire_owned().ok();
        // Without it frames are late; if the system refuses, they are.
        let _ = stream.set_nodelay(true);
        let config = WebSocketConfig::default()
            .read_buffer_size(BUFFER_BYTES)
            .write_buffer_size(BUFFER_BYTES)
            .max_message_size(Some(MOST_BYTES))
            .max_frame_size(Some(MOST_BYTES));
        let check = self.gate.check(&self.hub, peer, seat.is_some());
        let handshake =
            tokio_tungstenite::accept_hdr_async_with_config(stream, check, Some(config));
        let Ok(Ok(socket)) = timeout(HANDSHAKE_TIME, handshake).await else { return };
        drop(stranger);
        Client::join(socket, peer, self.hub, self.desk).serve().await;
        drop(seat);
    }
}
