//! Frames that the plugin didn't read, because it was too slow for them or a replay lacks them.

/// A counter of the frames between those that were read. A producer may publish only every n-th tick, so the smallest
/// step of a run counts as one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Skips {
    /// Whether every frame is wanted. If not, the frames in between don't count as skipped.
    every_frame: bool,
    last: Option<(u64, u64)>,
    step: u64,
    /// Sum of the ticks between frames, and the number of such gaps.
    ticks: u64,
    gaps: u64,
    reported: u64,
}

impl Skips {
    pub(crate) fn new(every_frame: bool) -> Self {
        Self { every_frame, last: None, step: u64::MAX, ticks: 0, gaps: 0, reported: 0 }
    }

    /// Notes a frame. Returns a line for the user when frames begin to be skipped, and each time there are ten times as
    /// many.
    pub(crate) fn note(&mut self, run_id: u64, tick: u64) -> Option<String> {
        let before = self.last.replace((run_id, tick));
        match before {
            Some((run, last)) if run == run_id && tick > last => {
                self.step = self.step.min(tick - last);
                self.ticks += tick - last;
                self.gaps += 1;
            }
            // The same frame is published again when the clock or the fleet has changed.
            Some((run, last)) if run == run_id && tick == last => {}
            _ => *self = Self { last: self.last, ..Self::new(self.every_frame) },
        }
        let count = self.count();
        if count < 10 || count < 10 * self.reported {
            return None;
        }
        self.reported = count;
        Some(format!(
            "{count} frames skipped so far: the plugin is too slow for this fleet, or they were never published"
        ))
    }

    /// Returns the number of frames of this run that were skipped.
    pub(crate) fn count(&self) -> u64 {
        match self.every_frame && self.gaps > 0 {
            true => (self.ticks / self.step).saturating_sub(self.gaps),
            false => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(every_frame: bool, ticks: &[u64]) -> u64 {
        let mut skips = Skips::new(every_frame);
        for tick in ticks {
            skips.note(1, *tick);
        }
        skips.count()
    }

    #[test]
    fn frames_between_those_read_are_counted() {
        assert_eq!(count(true, &[5, 6, 7]), 0);
        assert_eq!(count(true, &[5, 6, 9, 10]), 2);
        assert_eq!(count(true, &[4, 8, 8, 12]), 0, "every fourth tick is published");
        assert_eq!(count(true, &[4, 8, 16, 20]), 1);
        assert_eq!(count(false, &[4, 8, 16, 20]), 0, "not every frame is wanted");
    }

    #[test]
    fn another_run_resets_the_count_and_the_report() {
        let mut skips = Skips::new(true);
        assert_eq!(skips.note(1, 1), None);
        assert_eq!(skips.note(1, 2), None);
        assert!(skips.note(1, 30).is_some());
        assert_eq!(skips.note(1, 40), None, "not ten times as many");
        assert_eq!((skips.note(2, 1), skips.count()), (None, 0));
    }
}
