//! Spreads a frame's batches over part of the time until the next frame, so that they don't overrun the buffer of
//! the receiver.

use std::time::{Duration, Instant};

/// Longest time between frames that is reckoned with.
const LONGEST_PERIOD: Duration = Duration::from_secs(1);
/// Shorter pauses are left out: waking up again takes about as long.
const SHORTEST_PAUSE: Duration = Duration::from_micros(100);

/// When the batches of a frame are due.
#[derive(Debug)]
pub struct Pacer {
    part: f64,
    /// When this frame came, and when it was to come by its producer's schedule.
    frame_at: Option<(Instant, Duration)>,
    /// How long the batches of this frame may take.
    span: Duration,
    batches: u32,
    sent: u32,
}

impl Pacer {
    /// Spreads over that part of the time between frames, 0 to 1.
    pub fn new(part: f64) -> Self {
        Self { part: part.clamp(0.0, 1.0), frame_at: None, span: Duration::ZERO, batches: 1, sent: 0 }
    }

    /// A frame of about so many batches starts at `now`; `hurry` if somebody waits for its end. By the schedule of its
    /// producer it is to come at `schedule`, since any one moment: after a pause, that is one tick later.
    pub fn start_frame(&mut self, now: Instant, schedule: Duration, batches: usize, hurry: bool) {
        let period = self.frame_at.map_or(Duration::ZERO, |(at, scheduled)| {
            now.saturating_duration_since(at).min(schedule.saturating_sub(scheduled)).min(LONGEST_PERIOD)
        });
        self.span = if hurry { Duration::ZERO } else { period.mul_f64(self.part) };
        (self.frame_at, self.batches, self.sent) = (Some((now, schedule)), batches.max(1) as u32, 0);
    }

    /// How long to wait at `now` before the next batch of this frame is sent.
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
    fn batches_are_spread_evenly_over_their_part_of_the_period() {
        let start = Instant::now();
        let second = start + PERIOD;
        let mut pacer = Pacer::new(0.5);
        pacer.start_frame(start, PERIOD, 5, false);
        assert_eq!(pacer.next_pause(start), Duration::ZERO, "nothing is known of the first frame's period");
        pacer.start_frame(second, PERIOD * 2, 5, false);
        let pauses: Vec<_> = (0..7).map(|_| pacer.next_pause(second).as_millis()).collect();
        assert_eq!(pauses, [0, 2, 4, 6, 8, 10, 10]);
        assert_eq!(pacer.next_pause(second + PERIOD), Duration::ZERO, "late already");
    }

    #[test]
    fn a_long_break_is_not_taken_for_the_period() {
        let start = Instant::now();
        let mut pacer = Pacer::new(1.0);
        let second = |pacer: &mut Pacer, at: Duration, schedule: Duration| {
            pacer.start_frame(start, PERIOD, 2, false);
            pacer.start_frame(start + at, schedule, 2, false);
            pacer.next_pause(start + at);
            pacer.next_pause(start + at)
        };
        let hour = Duration::from_secs(3_600);
        assert_eq!(second(&mut pacer, hour, PERIOD * 2), PERIOD / 2, "a pause");
        assert_eq!(second(&mut pacer, PERIOD, Duration::ZERO), Duration::ZERO, "another run");
        assert_eq!(second(&mut pacer, hour, hour), LONGEST_PERIOD / 2);
    }

    #[test]
    fn nobody_is_kept_waiting_in_lockstep() {
        let start = Instant::now();
        let mut pacer = Pacer::new(1.0);
        pacer.start_frame(start, PERIOD, 2, true);
        let second = start + PERIOD;
        pacer.start_frame(second, PERIOD * 2, 2, true);
        pacer.next_pause(second);
        assert_eq!(pacer.next_pause(second), Duration::ZERO);
    }
}
