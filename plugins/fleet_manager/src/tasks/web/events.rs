//! Server-sent events: changes of orders and vehicles as they happen.

use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, Bytes};
use hyper::body::Frame;
use tokio::sync::broadcast::{Receiver, error::RecvError};
use tokio::sync::{OwnedSemaphorePermit, mpsc};

/// A comment is sent after so much silence, so that a reader that has gone is noticed.
const HEARTBEAT: Duration = Duration::from_secs(15);
/// The largest number of events that are on their way to a reader.
const ON_THE_WAY: usize = 64;

/// Returns a body that passes events on until the reader goes. A reader that is too slow misses
/// some, and is told how many.
pub(super) fn body(events: Receiver<Bytes>, permit: OwnedSemaphorePermit) -> Body {
    let (sender, receiver) = mpsc::channel(ON_THE_WAY);
    tokio::spawn(pass_on(events, sender));
    Body::new(EventBody(receiver, permit))
}

async fn pass_on(mut events: Receiver<Bytes>, sender: mpsc::Sender<Bytes>) {
    let mut next = Bytes::from_static(b": changes of orders and vehicles\n\n");
    while sender.send(next).await.is_ok() {
        next = match tokio::time::timeout(HEARTBEAT, events.recv()).await {
            Ok(Ok(event)) => event,
            Ok(Err(RecvError::Lagged(count))) => {
                Bytes::from(format!("event: missed\ndata: {count}\n\n"))
            }
            Ok(Err(RecvError::Closed)) => return,
            Err(_) => Bytes::from_static(b": still here\n\n"),
        };
    }
}

/// It holds the permit as long as the reader is there.
struct EventBody(
    mpsc::Receiver<Bytes>,
    #[expect(dead_code, reason = "given back when dropped")] OwnedSemaphorePermit,
);

impl hyper::body::Body for EventBody {
    type Data = Bytes;
    type Error = std::convert::Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
        self.0.poll_recv(context).map(|event| event.map(|event| Ok(Frame::data(event))))
    }
}
