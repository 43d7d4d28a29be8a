//! The playhead: the moment that is shown, which makes motion smooth at any refresh rate.

use std::time::Instant;

use regatta_plugin::Frame;

/// Chooses the moment between the two newest frames to show.
///
/// The shown moment lags one frame period behind the producer, so that there is a frame on either
/// side of it to interpolate between.
#[derive(Debug)]
pub struct Playhead {
    started: Instant,
    /// Send times of the previous and the newest frame, on the producer's clock, in seconds.
    sent: [f64; 2],
    tick: u64,
    run: u64,
    jumps: u64,
    /// Fewest ticks between two frames.
    gap: u64,
    /// Seconds between two frames, smoothed.
    period: f64,
    /// This process's clock minus the producer's, in seconds, at the least delay so far.
    lead: f64,
}

impl Playhead {
    /// Creates a playhead without frames.
    pub fn new() -> Self {
        Self {
            started: Instant::now(),
            sent: [0.0; 2],
            tick: 0,
            run: 0,
            jumps: 0,
            gap: u64::MAX,
            period: 0.0,
            lead: f64::INFINITY,
        }
    }

    /// Takes the send time of a new frame.
    pub fn push(&mut self, frame: &Frame<'_>, now: Instant) {
        let sent = frame.header().wall_time_nanos as f64 * 1e-9;
        let lead = now.duration_since(self.started).as_secs_f64() - sent;
        // Clocks drift, so the least lead rises slowly when it is no longer reached.
        self.lead = if frame.run_id() == self.run { lead.min(self.lead + 1e-4) } else { lead };
        let ticks = frame.tick().saturating_sub(self.tick);
        let passed = sent - self.sent[1];
        if frame.run_id() != self.run {
            (self.gap, self.period) = (u64::MAX, 0.0);
        } else if ticks > 0 && passed > 0.0 {
            self.gap = self.gap.min(ticks);
            let period = passed * self.gap as f64 / ticks as f64;
            self.period = if self.period == 0.0 {
                period
            } else {
                self.period + (period - self.period) * 0.1
            };
        }
        // A jump to a later time of a recording isn't motion.
        let has_jumped = frame.run_id() == self.run && frame.jumps() != self.jumps;
        self.sent = [if has_jumped { sent } else { self.sent[1] }, sent];
        (self.tick, self.run, self.jumps) = (frame.tick(), frame.run_id(), frame.jumps());
    }

    /// Shows the newest frame at once: the user has asked for this one.
    pub fn arrive(&mut self) {
        self.sent[0] = self.sent[1];
    }

    /// Returns the moment to show, from the previous frame (0) to the newest (1).
    pub fn alpha(&self, now: Instant) -> f32 {
        let shown =
            now.duration_since(self.started).as_secs_f64() - self.lead - self.period.min(1.0);
        let between = self.sent[1] - self.sent[0];
        if between <= 0.0 { 1.0 } else { ((shown - self.sent[0]) / between).clamp(0.0, 1.0) as f32 }
    }
}

impl Default for Playhead {
    fn default() -> Self {
        Self::new()
    }
}
