//! Frames that the plugin didn't read, because it was too slow for them.

use regatta_plugin::Frame;

/// A counter of the frames of a run that were skipped.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Skips {
    /// Whether every frame is wanted. If not, the frames in between don't count as skipped.
    every_frame: bool,
    run_id: u64,
    count: u64,
    reported: u64,
}

impl Skips {
    pub(crate) fn new(every_frame: bool) -> Self {
        Self { every_frame, run_id: 0, count: 0, reported: 0 }
    }

    /// Notes a frame. Returns a line for the user when frames begin to be skipped, and each time
    /// there are ten times as many.
    pub(crate) fn note(&mut self, frame: &Frame<'_>) -> Option<String> {
        if frame.run_id() != self.run_id {
            *self = Self { run_id: frame.run_id(), ..Self::new(self.every_frame) };
        }
        self.count += if self.every_frame { frame.missed() } else { 0 };
        if self.count < 10 || self.count < 10 * self.reported {
            return None;
        }
        self.reported = self.count;
        Some(format!("{} frames skipped so far: the plugin is too slow for this fleet", self.count))
    }

    /// Returns the number of frames of this run that were skipped.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::FrameHeader;

    use super::*;

    /// Notes a frame of a run, received after `missed` others.
    fn note(skips: &mut Skips, run_id: u64, missed: u64) -> Option<String> {
        let header = FrameHeader { run_id, ..FrameHeader::default() };
        skips.note(&Frame::new(&header, &[]).expect("an empty frame").after_missing(missed))
    }

    #[test]
    fn skipped_frames_are_counted_unless_a_rate_was_chosen() {
        for (every_frame, count) in [(true, 6), (false, 0)] {
            let mut skips = Skips::new(every_frame);
            [0, 2, 0, 4].into_iter().for_each(|missed| drop(note(&mut skips, 1, missed)));
            assert_eq!(skips.count(), count);
        }
    }

    #[test]
    fn another_run_counts_from_zero_and_reports_again() {
        let mut skips = Skips::new(true);
        assert_eq!(note(&mut skips, 1, 9), None);
        assert!(note(&mut skips, 1, 20).is_some());
        assert_eq!(note(&mut skips, 1, 10), None, "not ten times as many");
        assert_eq!((note(&mut skips, 2, 0), skips.count()), (None, 0));
        assert!(note(&mut skips, 2, 10).is_some());
    }
}
