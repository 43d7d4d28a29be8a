//! Sends batches of datagrams to one address.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use regatta_plugin::frame::FrameHeader;

use crate::line::{LineFormat, PoseLine};
use crate::pacer::Pacer;
use crate::packer::{Batch, Packer};
use crate::socket::{Socket, SocketError};

/// An unreachable receiver is reported again after it has been reachable for this long.
const REACHABLE_AFTER: Duration = Duration::from_secs(10);

/// The numbers of sent and failed lines.
#[derive(Clone, Copy, Debug, Default)]
pub struct SendTotals {
    pub frames: u64,
    pub lines: u64,
    pub datagrams: u64,
    pub bytes: u64,
    /// Lines that the system refused to send.
    pub refused: u64,
    /// Poses that were not sent because they are NaN or infinite.
    pub not_finite: u64,
}

/// A paced sender of batches to one address.
#[derive(Debug)]
pub struct Outlet {
    plugin: &'static str,
    socket: Socket,
    /// The receiver's address.
    pub to: SocketAddr,
    pacer: Pacer,
    /// The counts so far.
    pub sent: SendTotals,
    /// The number of batches of this frame so far.
    batches: usize,
    /// The time at which the receiver was last found to be unreachable.
    unreachable_at: Option<Instant>,
    /// The last error that isn't reported yet.
    pub failure: Option<std::io::Error>,
}

impl Outlet {
    /// Opens a socket that sends to `to`. `plugin` is the name in messages; `pace` is the part of
    /// the time between frames over which a frame's batches are spread, 0 to 1.
    pub fn open(plugin: &'static str, to: SocketAddr, pace: f64) -> Result<Self, SocketError> {
        Ok(Self {
            plugin,
            socket: Socket::towards(to)?,
            to,
            pacer: Pacer::new(pace),
            sent: SendTotals::default(),
            batches: 0,
            unreachable_at: None,
            failure: None,
        })
    }

    /// Starts the batches of a frame that was received at `now`.
    pub fn start_frame(&mut self, now: Instant, frame: &FrameHeader) {
        let batches = std::mem::take(&mut self.batches);
        // At infinite speed the scheduled time is always 0, so that batches aren't delayed.
        let schedule =
            Duration::from_nanos((frame.sim_time_nanos as f64 / f64::from(frame.speed)) as u64);
        self.pacer.start_frame(now, schedule, batches, frame.lockstep != 0);
    }

    /// Waits until a batch is due and sends it.
    pub fn send(&mut self, batch: Batch<'_>) {
        std::thread::sleep(self.pacer.next_pause(Instant::now()));
        self.batches += 1;
        match self.socket.send(self.to, batch.bytes, batch.datagram_bytes) {
            Ok(reachable) => {
                if !reachable {
                    self.report_unreachable(Instant::now());
                }
                self.sent.lines += batch.lines;
                self.sent.datagrams += batch.bytes.len().div_ceil(batch.datagram_bytes) as u64;
                self.sent.bytes += batch.bytes.len() as u64;
            }
            Err(error) => {
                self.sent.refused += batch.lines;
                self.failure = Some(error);
            }
        }
    }

    /// Prints that the receiver is unreachable, unless it was unreachable a short time ago.
    fn report_unreachable(&mut self, now: Instant) {
        if self.unreachable_at.is_none_or(|before| now - before > REACHABLE_AFTER) {
            regatta_plugin::tell!(
                "{}: no program receives at {}; sending continues",
                self.plugin,
                self.to
            );
        }
        self.unreachable_at = Some(now);
    }
}

/// The sender of answers: a line `id x y theta` for each accepted line. Positions are those in the
/// fleet, with the offset added.
#[derive(Debug)]
pub struct Answers {
    packer: Packer,
    /// The sender of datagrams.
    pub outlet: Outlet,
}

impl Answers {
    /// Opens a socket that sends answers to `to`.
    ///
    /// # Errors
    /// Returns [`SocketError::Send`].
    pub fn open(
        to: SocketAddr,
        format: LineFormat,
        datagram_bytes: usize,
    ) -> Result<Self, SocketError> {
        Ok(Self {
            packer: Packer::new(format, datagram_bytes),
            outlet: Outlet::open("udp-source", to, 0.0)?,
        })
    }

    /// Adds an answer. Answers are sent when a batch is full, or by [`flush`](Self::flush).
    pub fn push(&mut self, line: &PoseLine) {
        let Self { packer, outlet } = self;
        packer.push(line, |batch| outlet.send(batch));
    }

    /// Sends the remaining answers.
    pub fn flush(&mut self) {
        let Self { packer, outlet } = self;
        packer.flush(|batch| outlet.send(batch));
    }
}
