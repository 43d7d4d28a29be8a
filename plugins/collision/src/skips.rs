//! Frames that the plugin didn't read in time, and the reason: it is too slow, or the machine is
//! busy.

use std::time::{Duration, Instant};

use regatta_plugin::Frame;

/// The number of frames whose times are kept.
const KEPT: usize = 32;

/// A counter of the frames of a run that were skipped.
#[derive(Clone, Debug)]
pub(crate) struct Skips {
    /// Whether every frame is wanted. If not, the frames in between don't count as skipped.
    every_frame: bool,
    run_id: u64,
    count: u64,
    reported: u64,
    /// The time between two published frames.
    between: Times,
    /// The plugin's own work on a frame.
    work: Times,
    last: Option<Instant>,
}

/// The times of the last frames. Their median doesn't depend on a few frames for which the machine
/// did something else.
#[derive(Clone, Debug, Default)]
struct Times {
    values: Vec<Duration>,
    next: usize,
}

impl Times {
    fn add(&mut self, time: Duration) {
        if self.values.len() < KEPT {
            self.values.push(time);
        } else {
            self.values[self.next] = time;
        }
        self.next = (self.next + 1) % KEPT;
    }

    fn median(&self) -> Duration {
        let mut sorted = self.values.clone();
        sorted.sort_unstable();
        sorted.get(sorted.len() / 2).copied().unwrap_or_default()
    }
}

impl Skips {
    pub(crate) fn new(every_frame: bool) -> Self {
        Self {
            every_frame,
            run_id: 0,
            count: 0,
            reported: 0,
            between: Times::default(),
            work: Times::default(),
            last: None,
        }
    }

    /// Notes a frame that has come at an instant. Returns a line for the user when frames begin to
    /// be skipped, and each time there are ten times as many.
    pub(crate) fn note(&mut self, frame: &Frame<'_>, now: Instant) -> Option<String> {
        if frame.run_id() != self.run_id {
            *self = Self { run_id: frame.run_id(), ..Self::new(self.every_frame) };
        }
        let frames = u32::try_from(frame.missed()).unwrap_or(u32::MAX).saturating_add(1);
        if let Some(last) = self.last.replace(now) {
            self.between.add((now - last) / frames);
        }
        self.count += if self.every_frame { frame.missed() } else { 0 };
        if self.count < 10 || self.count < 10 * self.reported {
            return None;
        }
        self.reported = self.count;
        Some(format!("{} frames skipped so far: {}", self.count, self.reason()))
    }

    /// Notes the time that the plugin worked on a frame.
    pub(crate) fn note_work(&mut self, work: Duration) {
        self.work.add(work);
    }

    /// Returns the number of frames of this run that were skipped.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// Returns the reason why frames were skipped.
    pub(crate) fn reason(&self) -> String {
        let (work, between) = (self.work.median(), self.between.median());
        let times = format!(
            "it works {:.2} ms on a frame, and one comes every {:.2} ms",
            1e3 * work.as_secs_f64(),
            1e3 * between.as_secs_f64()
        );
        if work > between {
            format!("the plugin is too slow for this fleet ({times})")
        } else {
            format!("the machine was too busy to run the plugin in time ({times})")
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::FrameHeader;

    use super::*;

    /// Notes a frame of a run, received after `missed` others.
    fn note(skips: &mut Skips, run_id: u64, missed: u64) -> Option<String> {
        let header = FrameHeader { run_id, ..FrameHeader::default() };
        let frame = Frame::new(&header, &[]).expect("an empty frame").after_missing(missed);
        skips.note(&frame, Instant::now())
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

    #[test]
    fn a_busy_machine_is_told_from_a_slow_plugin() {
        let header = FrameHeader { run_id: 1, ..FrameHeader::default() };
        let reason_of = |work_millis: u64| {
            let (mut skips, mut now) = (Skips::new(true), Instant::now());
            for missed in [0, 0, 0, 12, 0, 0] {
                let frame = Frame::new(&header, &[]).expect("a frame").after_missing(missed);
                now += Duration::from_millis(10 * (missed + 1));
                let _ = skips.note(&frame, now);
                skips.note_work(Duration::from_millis(work_millis));
            }
            skips.reason()
        };
        assert_eq!(
            reason_of(1),
            "the machine was too busy to run the plugin in time (it works 1.00 ms on a frame, and \
             one comes every 10.00 ms)"
        );
        assert!(reason_of(15).starts_with("the plugin is too slow for this fleet (it works 15.00"));
    }
}
