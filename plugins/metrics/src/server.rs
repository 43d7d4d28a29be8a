//! The exporter's web server: a page at `/metrics`, for whoever asks, as long as they ask properly.
//!
//! It can't be held up: each connection has a thread of its own and [`PATIENCE`] to ask and to listen, there are
//! [`MOST_CONNECTIONS`] at most, and none of them is waited for by anybody.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::request::{MAX_REQUEST, Refusal, Request};

/// How long a client may take to ask, and again to take the answer.
const PATIENCE: Duration = Duration::from_secs(2);
/// Clients at the same time. More are sent away.
const MOST_CONNECTIONS: usize = 32;
/// Pause after a connection could not be accepted: there are too many open files, say.
const BREATH: Duration = Duration::from_millis(100);

/// Why the exporter can't listen.
#[derive(Debug, thiserror::Error)]
#[error("can't listen on {address} ({reason}); if another exporter does, choose another port with --listen IP:PORT")]
pub struct ListenError {
    address: SocketAddr,
    reason: io::Error,
}

/// What the server shows.
pub trait Pages: Send + Sync + 'static {
    /// The page at `/metrics`.
    fn metrics(&self) -> String;
}

/// Starts to serve, for as long as the process lives. Returns the address: with its real port if port 0 was asked for.
///
/// # Errors
/// [`ListenError`] if the address is taken, or not ours.
pub fn start(address: SocketAddr, pages: Arc<impl Pages>) -> Result<SocketAddr, ListenError> {
    let listen = || {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        thread::Builder::new().name("exporter".to_owned()).spawn(move || accept(&listener, &pages))?;
        Ok(address)
    };
    listen().map_err(|reason| ListenError { address, reason })
}

fn accept(listener: &TcpListener, pages: &Arc<impl Pages>) {
    let connections = Arc::new(AtomicUsize::new(0));
    loop {
        let Ok((stream, _)) = listener.accept() else {
            thread::sleep(BREATH);
            continue;
        };
        let place = Place::take(&connections);
        if connections.load(Ordering::Relaxed) > MOST_CONNECTIONS {
            // Dropped: the client sees a closed connection and may come again.
            continue;
        }
        let pages = Arc::clone(pages);
        // Without a thread, it is dropped as well.
        let _ = thread::Builder::new().name("scrape".to_owned()).stack_size(256 << 10).spawn(move || {
            let _place = place;
            serve(stream, &*pages);
        });
    }
}

/// One of the connections; given back when dropped.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn take(connections: &Arc<AtomicUsize>) -> Self {
        connections.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(connections))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// One request and its answer. A client that has gone, or is too slow, gets none.
fn serve(mut stream: TcpStream, pages: &impl Pages) {
    let request = match read_request(&mut stream) {
        Ok(request) => request,
        Err(_) => return,
    };
    let answer = match request {
        Ok(request) => answer(&request, pages),
        Err(refusal) => text(refusal.status(), "", true),
    };
    // All errors mean that the client doesn't listen.
    if write_all(&mut stream, &answer, Instant::now() + PATIENCE).is_ok() && stream.shutdown(Shutdown::Write).is_ok() {
        drain(&mut stream);
    }
}

fn answer(request: &Request, pages: &impl Pages) -> Vec<u8> {
    let with_body = !request.head;
    match &*request.path {
        "/metrics" => response("200 OK", crate::page::CONTENT_TYPE, &pages.metrics(), with_body),
        "/" => text("200 OK", "Figures of a Regatta fleet are at /metrics.\n", with_body),
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

/// Reads until the request is complete, or can't become one.
fn read_request(stream: &mut TcpStream) -> io::Result<Result<Request, Refusal>> {
    let deadline = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    let mut chunk = [0; 1024];
    loop {
        let count = read_some(stream, &mut chunk, deadline)?;
        bytes.extend_from_slice(&chunk[..count]);
        match Request::parse(&bytes) {
            Ok(None) if count > 0 && bytes.len() <= MAX_REQUEST => {}
            Ok(None) if count == 0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(None) => return Ok(Err(Refusal::TooLong)),
            Ok(Some(request)) => return Ok(Ok(request)),
            Err(refusal) => return Ok(Err(refusal)),
        }
    }
}

/// Reads what a client still sends, for a moment: closing with it unread would take the answer away from the client.
fn drain(stream: &mut TcpStream) {
    let deadline = Instant::now() + PATIENCE;
    let mut chunk = [0; 1024];
    while read_some(stream, &mut chunk, deadline).is_ok_and(|count| count > 0) {}
}

fn read_some(stream: &mut TcpStream, chunk: &mut [u8], deadline: Instant) -> io::Result<usize> {
    loop {
        stream.set_read_timeout(Some(left_until(deadline)?))?;
        match stream.read(chunk) {
            // This process was stopped, and goes on.
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            outcome => return outcome,
        }
    }
}

fn write_all(stream: &mut TcpStream, mut bytes: &[u8], deadline: Instant) -> io::Result<()> {
    while !bytes.is_empty() {
        stream.set_write_timeout(Some(left_until(deadline)?))?;
        match stream.write(bytes) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(count) => bytes = &bytes[count..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

fn left_until(deadline: Instant) -> io::Result<Duration> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(left) }
}

#[cfg(test)]
#[path = "server_tests.rs"]
mod tests;
