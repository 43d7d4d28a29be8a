//! Leaves out columns and contacts that belong to frames that aren't recorded.

use std::collections::{HashMap, VecDeque};

use crate::schema::Topic;
use crate::sources::Sample;

/// The number of recorded frames that are remembered, because samples may arrive after their frame.
const REMEMBERED: usize = 64;

/// Chooses the samples to record if not every frame is recorded: for each recorded frame, the
/// newest sample at its tick.
#[derive(Debug, Default)]
pub(crate) struct Thinning {
    run_id: u64,
    /// The ticks of recorded frames.
    recorded: VecDeque<u64>,
    /// The newest sample of each topic, unless it is recorded.
    newest: HashMap<Topic, Option<Held>>,
}

/// A sample that is recorded if it turns out to be the newest one of a recorded frame.
#[derive(Debug)]
pub(crate) struct Held {
    pub sample: Sample,
    pub log_time: u64,
}

impl Thinning {
    /// Takes a frame that is recorded, and returns the held samples of its tick.
    pub fn record_frame(&mut self, run_id: u64, tick: u64) -> Vec<Held> {
        let mut samples = Vec::new();
        if run_id != self.run_id {
            samples = self.flush();
            self.run_id = run_id;
            self.recorded.clear();
        }
        self.recorded.push_back(tick);
        if self.recorded.len() > REMEMBERED {
            self.recorded.pop_front();
        }
        for held in self.newest.values_mut() {
            samples.extend(held.take_if(|held| held.sample.tick == tick));
        }
        samples
    }

    /// Takes a sample. Returns the one before it, if that is recorded only now, and this one, if it
    /// is recorded already.
    pub fn take(&mut self, sample: Sample, log_time: u64) -> [Option<Held>; 2] {
        let (run_id, tick) = (sample.run_id, sample.tick);
        let is_recorded = self.run_id == run_id && self.recorded.contains(&tick);
        let held = self.newest.entry(sample.topic.clone()).or_default();
        let before = held.take_if(|Held { sample: before, .. }| {
            // Whether a frame was recorded between the two samples.
            let mut recorded = self.recorded.iter().filter(|recorded| **recorded >= before.tick);
            self.run_id == before.run_id
                && recorded.any(|recorded| before.run_id != run_id || *recorded < tick)
        });
        let this = Some(Held { sample, log_time });
        if is_recorded {
            *held = None;
            [before, this]
        } else {
            *held = this;
            [before, None]
        }
    }

    /// Returns the held samples of the run's recorded frames, at its end.
    pub fn flush(&mut self) -> Vec<Held> {
        let mut samples = Vec::new();
        for held in self.newest.values_mut() {
            samples.extend(held.take_if(|held| held.sample.run_id == self.run_id));
        }
        samples.retain(|held| self.recorded.iter().any(|tick| *tick >= held.sample.tick));
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sink::Payload;

    fn sample(tick: u64) -> Sample {
        Sample {
            topic: Topic::Contacts,
            run_id: 1,
            tick,
            missed: 0,
            payload: Payload::Message(Vec::new()),
        }
    }

    /// Returns the recorded ticks of samples, if every tenth frame is recorded.
    fn recorded(samples: &[u64], comes_before_its_frame: bool) -> Vec<u64> {
        let mut thinning = Thinning::default();
        let mut recorded = Vec::new();
        for tick in 0..100 {
            let take = |thinning: &mut Thinning| {
                let taken = samples.contains(&tick).then(|| thinning.take(sample(tick), 0));
                taken.into_iter().flatten().flatten().collect::<Vec<_>>()
            };
            let before = if comes_before_its_frame { take(&mut thinning) } else { Vec::new() };
            let with = if tick % 10 == 0 { thinning.record_frame(1, tick) } else { Vec::new() };
            let after = if comes_before_its_frame { Vec::new() } else { take(&mut thinning) };
            recorded.extend([before, with, after].iter().flatten().map(|held| held.sample.tick));
        }
        recorded.extend(thinning.flush().iter().map(|held| held.sample.tick));
        recorded
    }

    #[test]
    fn each_recorded_frame_has_its_newest_sample() {
        let all: Vec<_> = (0..100).collect();
        let (tens, some) =
            ((0..100).step_by(10).collect::<Vec<_>>(), [3, 5, 9, 21, 22, 58, 60, 91]);
        for comes_before in [true, false] {
            assert_eq!(recorded(&all, comes_before), tens);
            assert_eq!(recorded(&some, comes_before), [9, 22, 60]);
            assert_eq!(recorded(&[0], comes_before), [0], "a column that never changes");
            assert_eq!(recorded(&[7], comes_before), [7]);
        }
    }
}
