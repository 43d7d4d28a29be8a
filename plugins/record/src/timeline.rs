//! The clock of a recording.

use regatta_plugin::frame::FrameHeader;

/// The recording's clock, in nanoseconds. It is the simulated time of the first run; each further
/// run in the recording follows the previous one without a gap.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Timeline {
    newest: FrameHeader,
    /// The simulated time of the run's first frame.
    first: u64,
    /// The time of the run's first frame in the recording.
    start: u64,
    /// The time of the newest frame in the recording.
    now: u64,
}

impl Timeline {
    /// Advances to a frame and returns its time.
    pub fn advance(&mut self, header: &FrameHeader) -> u64 {
        let simulated = header.sim_time_nanos;
        if header.run_id != self.newest.run_id {
            let is_first_run = self.newest.run_id == 0;
            self.first = simulated;
            let next = self.now.saturating_add(header.tick_period_nanos.max(1));
            self.start = if is_first_run { simulated } else { next };
        }
        self.newest = *header;
        self.now = self.start.saturating_add(simulated.saturating_sub(self.first));
        self.now
    }

    /// Returns the time of the newest frame.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Returns the time of a tick. A tick of another run gets the time of the newest frame; a tick
    /// before the run's first recorded frame gets that frame's time.
    pub fn time_of(&self, run_id: u64, tick: u64) -> u64 {
        if run_id != self.newest.run_id {
            return self.now;
        }
        let ticks = i128::from(tick) - i128::from(self.newest.tick);
        let time = i128::from(self.now) + ticks * i128::from(self.newest.tick_period_nanos);
        u64::try_from(time).unwrap_or(0).max(self.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(run_id: u64, tick: u64) -> FrameHeader {
        let sim_time_nanos = tick * 10;
        FrameHeader {
            run_id,
            tick,
            sim_time_nanos,
            tick_period_nanos: 10,
            ..FrameHeader::default()
        }
    }

    #[test]
    fn the_first_run_keeps_its_simulated_time() {
        let mut timeline = Timeline::default();
        assert_eq!(timeline.advance(&frame(1, 500)), 5000);
        assert_eq!(timeline.time_of(1, 502), 5020);
        assert_eq!(timeline.time_of(1, 3), 5000, "not before the recording starts");
        assert_eq!(timeline.advance(&frame(1, 501)), 5010);
        assert_eq!(timeline.time_of(1, 500), 5000);
    }

    #[test]
    fn each_run_follows_the_previous_one() {
        let mut timeline = Timeline::default();
        timeline.advance(&frame(1, 30));
        assert_eq!(timeline.advance(&frame(2, 0)), 310);
        assert_eq!(timeline.time_of(1, 31), 310, "a late message of the previous run");
        assert_eq!(timeline.advance(&frame(2, 5)), 360);
        assert_eq!(timeline.advance(&frame(3, 100)), 370, "without a gap");
        assert_eq!(timeline.advance(&frame(3, 103)), 400);
    }
}
