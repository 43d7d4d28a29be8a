//! Sends batches of datagrams to one address, spread over a part of the time until the next frame,
//! so that they don't overrun the receiver's buffer.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use regatta_plugin::frame::FrameHeader;

use crate::line::{LineFormat, PoseLine};
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

/// The largest assumed time between frames.
const LONGEST_PERIOD: Duration = Duration::from_secs(1);
/// The shortest pause between batches. Shorter ones are omitted, because waking up takes about as
/// long.
const SHORTEST_PAUSE: Duration = Duration::from_micros(100);

/// The schedule of a frame's batches.
#[derive(Debug)]
struct Pacer {
    part: f64,
    /// The arrival time of this frame, and its time in the producer's schedule.
    frame_at: Option<(Instant, Duration)>,
    /// The time over which the batches of this frame are spread.
    span: Duration,
    batches: u32,
    sent: u32,
}

impl Pacer {
    /// Creates a pacer that spreads batches over `part` of the time between frames, 0 to 1.
    pub fn new(part: f64) -> Self {
        Self {
            part: part.clamp(0.0, 1.0),
            frame_at: None,
            span: Duration::ZERO,
            batches: 1,
            sent: 0,
        }
    }

    /// Starts a frame of about `batches` batches that arrived at `now`. `scheduled` is its time in
    /// the producer's schedule, which doesn't advance while the fleet is paused. With
    /// `immediately`, its batches aren't delayed.
    pub fn start_frame(
        &mut self,
        now: Instant,
        scheduled: Duration,
        batches: usize,
        immediately: bool,
    ) {
        let period = self.frame_at.map_or(Duration::ZERO, |(last, last_scheduled)| {
            now.saturating_duration_since(last)
                .min(scheduled.saturating_sub(last_scheduled))
                .min(LONGEST_PERIOD)
        });
        self.span = if immediately { Duration::ZERO } else { period.mul_f64(self.part) };
        (self.frame_at, self.batches, self.sent) =
            (Some((now, scheduled)), batches.max(1) as u32, 0);
    }

    /// Returns the time to wait at `now` before the next batch of this frame is sent.
    pub fn next_pause(&mut self, now: Instant) -> Duration {
        let Some((start, _)) = self.frame_at else { return Duration::ZERO };
        let due = start + self.span * self.sent.min(self.batches) / self.batches;
        self.sent += 1;
        let pause = due.saturating_duration_since(now);
        if pause < SHORTEST_PAUSE { Duration::ZERO } else { pause }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(20);

    #[test]
    fn batches_are_spread_evenly_over_a_part_of_the_period() {
        let start = Instant::now();
        let second = start + PERIOD;
        let mut pacer = Pacer::new(0.5);
        pacer.start_frame(start, PERIOD, 5, false);
        assert_eq!(pacer.next_pause(start), Duration::ZERO, "the first frame has no known period");
        pacer.start_frame(second, PERIOD * 2, 5, false);
        let pauses: Vec<_> = (0..7).map(|_| pacer.next_pause(second).as_millis()).collect();
        assert_eq!(pauses, [0, 2, 4, 6, 8, 10, 10]);
        assert_eq!(pacer.next_pause(second + PERIOD), Duration::ZERO, "late already");
    }

    #[test]
    fn a_long_pause_does_not_count_as_the_period() {
        let start = Instant::now();
        let mut pacer = Pacer::new(1.0);
        let second = |pacer: &mut Pacer, at: Duration, scheduled: Duration| {
            pacer.start_frame(start, PERIOD, 2, false);
            pacer.start_frame(start + at, scheduled, 2, false);
            pacer.next_pause(start + at);
            pacer.next_pause(start + at)
        };
        let hour = Duration::from_secs(3_600);
        assert_eq!(second(&mut pacer, hour, PERIOD * 2), PERIOD / 2, "a pause");
        assert_eq!(second(&mut pacer, PERIOD, Duration::ZERO), Duration::ZERO, "another run");
        assert_eq!(second(&mut pacer, hour, hour), LONGEST_PERIOD / 2);
    }

    #[test]
    fn batches_are_not_delayed_in_lockstep() {
        let start = Instant::now();
        let mut pacer = Pacer::new(1.0);
        pacer.start_frame(start, PERIOD, 2, true);
        let second = start + PERIOD;
        pacer.start_frame(second, PERIOD * 2, 2, true);
        pacer.next_pause(second);
        assert_eq!(pacer.next_pause(second), Duration::ZERO);
    }
}
