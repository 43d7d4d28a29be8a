//! The exporter's web server: serves a page at `/metrics` to any number of clients.
//!
//! Clients can't hold it up: each connection has a thread of its own and [`TIMEOUT`] to send the request and again to
//! read the response, there are [`MAX_CONNECTIONS`] at most, and no thread waits for a connection to end.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::request::{MAX_REQUEST, Request, RequestError};

/// The longest time for a client to send its request, and again to read the response.
const TIMEOUT: Duration = Duration::from_secs(2);
/// The largest number of concurrent connections. Further ones are closed.
const MAX_CONNECTIONS: usize = 32;
/// The delay after a connection could not be accepted, for example because there are too many open files.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);

/// The error of listening on an address.
#[derive(Debug, thiserror::Error)]
#[error("can't listen on {address} ({reason}); if another exporter does, choose another port with --listen IP:PORT")]
pub struct ListenError {
    address: SocketAddr,
    reason: io::Error,
}

/// The source of the server's pages.
pub trait PageSource: Send + Sync + 'static {
    /// Returns the page at `/metrics`.
    fn metrics(&self) -> String;
}

/// Starts to serve pages until the process ends. Returns the address, with its actual port if port 0 was requested.
///
/// # Errors
/// [`ListenError`] if the address is in use or not an address of this machine.
pub fn start(address: SocketAddr, pages: Arc<impl PageSource>) -> Result<SocketAddr, ListenError> {
    let listen = || {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        thread::Builder::new().name("exporter".to_owned()).spawn(move || accept(&listener, &pages))?;
        Ok(address)
    };
    listen().map_err(|reason| ListenError { address, reason })
}

fn accept(listener: &TcpListener, pages: &Arc<impl PageSource>) {
    let connections = Arc::new(AtomicUsize::new(0));
    loop {
        let Ok((stream, _)) = listener.accept() else {
            thread::sleep(ACCEPT_RETRY_DELAY);
            continue;
        };
        let guard = ConnectionGuard::new(&connections);
        if connections.load(Ordering::Relaxed) > MAX_CONNECTIONS {
            // The connection is closed; the client may retry.
            continue;
        }
        let pages = Arc::clone(pages);
        // If no thread can be started, the connection is closed, too.
        let _ = thread::Builder::new().name("scrape".to_owned()).stack_size(256 << 10).spawn(move || {
            let _guard = guard;
            serve(stream, &*pages);
        });
    }
}

/// A guard that counts an open connection until it is dropped.
struct ConnectionGuard(Arc<AtomicUsize>);

impl ConnectionGuard {
    fn new(connections: &Arc<AtomicUsize>) -> Self {
        connections.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(connections))
    }
}

impl Drop for ConnectionGuard {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Reads one request and sends the response. A client that has disconnected, or is too slow, gets none.
fn serve(mut stream: TcpStream, pages: &impl PageSource) {
    let request = match read_request(&mut stream) {
        Ok(request) => request,
        Err(_) => return,
    };
    let response = match request {
        Ok(request) => respond(&request, pages),
        Err(error) => text(error.status(), "", true),
    };
    // Any error means that the client doesn't read.
    if write_all(&mut stream, &response, Instant::now() + TIMEOUT).is_ok() && stream.shutdown(Shutdown::Write).is_ok() {
        drain(&mut stream);
    }
}

fn respond(request: &Request, pages: &impl PageSource) -> Vec<u8> {
    let with_body = !request.head;
    match &*request.path {
        "/metrics" => response("200 OK", crate::page::CONTENT_TYPE, &pages.metrics(), with_body),
        "/" => text("200 OK", "Metrics of a Regatta fleet are at /metrics.\n", with_body),
        _ => text("404 Not Found", "There is only /metrics.\n", with_body),
    }
}

fn text(status: &str, body: &str, with_body: bool) -> Vec<u8> {
    response(status, "text/plain; charset=utf-8", body, with_body)
}

fn response(status: &str, content_type: &str, body: &str, with_body: bool) -> Vec<u8> {
    let length = body.len();
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {content_type}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
    );
    [head.as_bytes(), if with_body { body.as_bytes() } else { &[] }].concat()
}

/// Reads until the request is complete or invalid.
fn read_request(stream: &mut TcpStream) -> io::Result<Result<Request, RequestError>> {
    let deadline = Instant::now() + TIMEOUT;
    let mut bytes = Vec::new();
    let mut chunk = [0; 1024];
    loop {
        let count = read_some(stream, &mut chunk, deadline)?;
        bytes.extend_from_slice(&chunk[..count]);
        match Request::parse(&bytes) {
            Ok(None) if count > 0 && bytes.len() <= MAX_REQUEST => {}
            Ok(None) if count == 0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(None) => return Ok(Err(RequestError::TooLong)),
            Ok(Some(request)) => return Ok(Ok(request)),
            Err(error) => return Ok(Err(error)),
        }
    }
}

/// Discards what the client still sends, for a limited time: closing the connection with unread bytes would discard the
/// response.
fn drain(stream: &mut TcpStream) {
    let deadline = Instant::now() + TIMEOUT;
    let mut chunk = [0; 1024];
    while read_some(stream, &mut chunk, deadline).is_ok_and(|count| count > 0) {}
}

fn read_some(stream: &mut TcpStream, chunk: &mut [u8], deadline: Instant) -> io::Result<usize> {
    loop {
        stream.set_read_timeout(Some(time_until(deadline)?))?;
        match stream.read(chunk) {
            // The process was stopped and continued.
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            outcome => return outcome,
        }
    }
}

fn write_all(stream: &mut TcpStream, mut bytes: &[u8], deadline: Instant) -> io::Result<()> {
    while !bytes.is_empty() {
        stream.set_write_timeout(Some(time_until(deadline)?))?;
        match stream.write(bytes) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(count) => bytes = &bytes[count..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

fn time_until(deadline: Instant) -> io::Result<Duration> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(left) }
}

#[cfg(test)]
mod tests;
