//! The bytes of a connection, with a limit on the time in which a client takes none of them.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

use super::clients::Client;

/// The bytes that a client takes at least within the time: one that takes a byte now and then is
/// too slow, too.
const LEAST_BYTES: usize = 16 << 10;

/// A connection over TCP, or a Unix socket.
pub(super) trait Io: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Io for T {}

/// A connection that fails when the client is too slow.
pub(super) struct Paced {
    io: Box<dyn Io>,
    client: Arc<Client>,
    write_timeout: Duration,
    wait: Option<Wait>,
}

/// The time for which bytes have been waiting for the client.
struct Wait {
    deadline: Pin<Box<Sleep>>,
    /// The bytes that it has taken since.
    taken: usize,
}

impl Paced {
    pub(super) fn new(io: Box<dyn Io>, client: Arc<Client>, write_timeout: Duration) -> Self {
        Self { io, client, write_timeout, wait: None }
    }

    /// Notes the outcome of a write of `length` bytes.
    fn written(
        &mut self,
        context: &mut Context<'_>,
        length: usize,
        outcome: Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        let Poll::Ready(written) = outcome else {
            let deadline = || Box::pin(sleep(self.write_timeout));
            let wait = self.wait.get_or_insert_with(|| Wait { deadline: deadline(), taken: 0 });
            ready!(wait.deadline.as_mut().poll(context));
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        };
        let written = written?;
        self.client.is_active();
        if let Some(wait) = &mut self.wait {
            wait.taken += written;
            if written == length || wait.taken >= LEAST_BYTES {
                self.wait = None;
            } else if wait.deadline.deadline() <= Instant::now() {
                return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
            }
        }
        Poll::Ready(Ok(written))
    }
}

impl AsyncRead for Paced {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = ready!(Pin::new(&mut self.io).poll_read(context, buffer));
        if buffer.filled().len() > before {
            self.client.is_active();
        }
        Poll::Ready(read)
    }
}

impl AsyncWrite for Paced {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.io).poll_write(context, bytes);
        self.written(context, bytes.len(), outcome)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let length = parts.iter().map(|part| part.len()).sum();
        let outcome = Pin::new(&mut self.io).poll_write_vectored(context, parts);
        self.written(context, length, outcome)
    }

    fn is_write_vectored(&self) -> bool {
        self.io.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_shutdown(context)
    }
}
