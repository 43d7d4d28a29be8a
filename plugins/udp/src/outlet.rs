//! Where a frame's batches go.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use regatta_plugin::frame::FrameHeader;

use crate::pacer::Pacer;
use crate::packer::Batch;
use crate::socket::{Socket, SocketError};

/// When nobody has been missed for so long, it is told again.
const FORGOTTEN_AFTER: Duration = Duration::from_secs(10);

/// What became of lines.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sent {
    pub frames: u64,
    pub lines: u64,
    pub datagrams: u64,
    pub bytes: u64,
    /// Lines that the system didn't take.
    pub refused: u64,
    /// Poses that no line can tell, since they are NaN or infinite.
    pub not_finite: u64,
}

/// Where batches go.
#[derive(Debug)]
pub struct Outlet {
    plugin: &'static str,
    socket: Socket,
    /// Where to.
    pub to: SocketAddr,
    pacer: Pacer,
    /// The counts so far.
    pub sent: Sent,
    /// Batches of this frame and of the one before.
    batches: [usize; 2],
    /// When nobody listened there, last.
    unheard_at: Option<Instant>,
    /// The last error, until it is told.
    pub failure: Option<std::io::Error>,
}

impl Outlet {
    /// An outlet of that plugin to that address, that spreads a frame over that part of the time between frames.
    pub fn open(plugin: &'static str, to: SocketAddr, pace: f64) -> Result<Self, SocketError> {
        Ok(Self {
            plugin,
            socket: Socket::towards(to)?,
            to,
            pacer: Pacer::new(pace),
            sent: Sent::default(),
            batches: [0; 2],
            unheard_at: None,
            failure: None,
        })
    }

    /// The batches of a frame that came at `now` follow.
    pub fn start_frame(&mut self, now: Instant, frame: &FrameHeader) {
        self.batches = [0, self.batches[0]];
        // At infinite speed there is no schedule, and nothing to spread over.
        let schedule = Duration::from_nanos((frame.sim_time_nanos as f64 / f64::from(frame.speed)) as u64);
        self.pacer.start_frame(now, schedule, self.batches[1], frame.lockstep != 0);
    }

    /// Sends a batch, when its time has come.
    pub fn send(&mut self, batch: Batch<'_>) {
        std::thread::sleep(self.pacer.next_pause(Instant::now()));
        self.batches[0] += 1;
        match self.socket.send(self.to, batch.bytes, batch.datagram_bytes) {
            Ok(heard) => {
                if !heard {
                    self.tell_unheard(Instant::now());
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

    /// Says that nobody listens, once until somebody has listened for a while.
    fn tell_unheard(&mut self, now: Instant) {
        if self.unheard_at.is_none_or(|before| now - before > FORGOTTEN_AFTER) {
            regatta_plugin::tell!("{}: nobody listens at {}; sending goes on", self.plugin, self.to);
        }
        self.unheard_at = Some(now);
    }
}
