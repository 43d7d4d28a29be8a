//! The packets of a connection. A client that is too slow is cut off.

use std::sync::Arc;
use std::time::Duration;

use bytes::BytesMut;
use rumqttc::Packet;
use rumqttc::mqttbytes::Error as PacketError;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, timeout, timeout_at};

/// The largest packet, in bytes.
pub(super) const MOST_BYTES: usize = 16 << 20;
/// The bytes of a packet beyond which it is a large one, and the most connections that receive one
/// at the same time: the others wait.
const LARGE_BYTES: usize = 64 << 10;
pub(super) const MOST_LARGE: usize = 8;
/// The longest time in which a client sends a large packet, or takes a packet.
const PATIENCE: Duration = Duration::from_secs(30);

/// A connection.
pub(super) struct Stream {
    stream: TcpStream,
    input: BytesMut,
    /// Permits for large packets.
    permits: Arc<Semaphore>,
    /// The permit for the packet that is received, and the time by which it must be complete.
    large: Option<(OwnedSemaphorePermit, Instant)>,
}

impl Stream {
    pub(super) fn new(stream: TcpStream, permits: Arc<Semaphore>) -> Self {
        Self { stream, input: BytesMut::new(), permits, large: None }
    }

    /// Reads a packet; `None` at the end of the connection, and for what is no packet or has more
    /// than `most_bytes`. A dropped future loses nothing.
    pub(super) async fn read(&mut self, most_bytes: usize) -> Option<Packet> {
        loop {
            match Packet::read(&mut self.input, most_bytes) {
                Ok(packet) => {
                    self.end_large();
                    return Some(packet);
                }
                Err(PacketError::InsufficientBytes(_)) => {}
                Err(_) => return None,
            }
            if self.input.len() > LARGE_BYTES && self.large.is_none() {
                let permit = self.permits.clone().acquire_owned().await.ok()?;
                self.large = Some((permit, Instant::now() + PATIENCE));
            }
            if self.receive().await? == 0 {
                return None;
            }
        }
    }

    async fn receive(&mut self) -> Option<usize> {
        let received = self.stream.read_buf(&mut self.input);
        match &self.large {
            Some((_, deadline)) => timeout_at(*deadline, received).await.ok()?.ok(),
            None => received.await.ok(),
        }
    }

    /// Gives back the permit and the memory of a large packet.
    fn end_large(&mut self) {
        if self.large.take().is_some() {
            self.input = BytesMut::from(&self.input[..]);
        }
    }

    /// Writes a packet; `None` if the client is gone or doesn't take it.
    pub(super) async fn write(&mut self, packet: Packet) -> Option<()> {
        let mut output = BytesMut::new();
        packet.write(&mut output, MOST_BYTES).ok()?;
        timeout(PATIENCE, self.stream.write_all(&output)).await.ok()?.ok()
    }
}
