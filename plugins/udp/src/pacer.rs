//! Spreads a frame's batches over a part of the time until the next frame, so that they don't
//! overrun the receiver's buffer.

use std::time::{Duration, Instant};

/// The largest assumed time between frames.
const LONGEST_PERIOD: Duration = Duration::from_secs(1);
/// The shortest pause between batches. Shorter ones are omitted, because waking up takes about as
/// long.
const SHORTEST_PAUSE: Duration = Duration::from_micros(100);

/// The schedule of a frame's batches.
#[derive(Debug)]
pub struct Pacer {
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
