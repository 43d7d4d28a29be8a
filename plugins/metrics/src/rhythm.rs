//! Every how many ticks the producer publishes a frame, and how fast simulated time passes: both told from
//! the frames alone, so that they hold for any producer.

use std::collections::VecDeque;

/// Every how many ticks there is a frame, found from the gaps between those that were read.
///
/// A reader that skips frames sees multiples of it: so it is the greatest common divisor of the last few.
#[derive(Clone, Debug, Default)]
pub struct Stride {
    gaps: VecDeque<u64>,
}

impl Stride {
    /// Gaps to go by. After so many more, one that was out of step is forgotten.
    const MEMORY: usize = 8;

    /// Notes the ticks from one frame to the next that was read.
    pub fn note(&mut self, gap: u64) {
        if self.gaps.len() == Self::MEMORY {
            self.gaps.pop_front();
        }
        self.gaps.push_back(gap);
    }

    /// Ticks from frame to frame; `None` before there is anything to go by.
    pub fn ticks(&self) -> Option<u64> {
        self.gaps.iter().copied().reduce(greatest_common_divisor).filter(|&ticks| ticks > 0)
    }
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// A moment: wall time of the producer and simulated time, both in nanoseconds.
#[derive(Clone, Copy, Debug)]
struct Moment {
    wall: u64,
    simulated: u64,
}

/// Simulated seconds per wall second, over the last second or so.
#[derive(Clone, Debug, Default)]
pub struct RealTimeFactor {
    moments: VecDeque<Moment>,
}

const SECOND: u64 = 1_000_000_000;

impl RealTimeFactor {
    /// Nanoseconds. Frames that follow faster than this make one moment.
    const APART: u64 = SECOND / 10;

    /// Starts anew: the clock was paused, say.
    pub fn restart(&mut self) {
        self.moments.clear();
    }

    /// Notes a frame's wall time and simulated time, in nanoseconds.
    pub fn note(&mut self, wall: u64, simulated: u64) {
        let moment = Moment { wall, simulated };
        let close = self.spacing().is_some_and(|spacing| spacing < Self::APART);
        match self.moments.back_mut() {
            Some(last) if close => *last = moment,
            _ => self.moments.push_back(moment),
        }
        // Two stay, however slowly frames come.
        while self.moments.len() > 2 && self.moments[1].wall.saturating_add(SECOND) <= wall {
            self.moments.pop_front();
        }
    }

    /// The factor at a wall time in nanoseconds; 0 when frames have ceased to come, `None` when there were too
    /// few to tell.
    pub fn at(&self, now: u64) -> Option<f64> {
        let (first, last) = (self.moments.front()?, self.moments.back()?);
        if now.saturating_sub(last.wall) > SECOND.max(self.spacing()?).saturating_mul(2) {
            return Some(0.0);
        }
        let wall = last.wall.checked_sub(first.wall).filter(|wall| *wall > 0)?;
        Some(last.simulated.saturating_sub(first.simulated) as f64 / wall as f64)
    }

    /// Wall time between the last two moments.
    fn spacing(&self) -> Option<u64> {
        let before = self.moments.len().checked_sub(2)?;
        Some(self.moments[before + 1].wall.saturating_sub(self.moments[before].wall))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn stride_of(gaps: impl IntoIterator<Item = u64>) -> Option<u64> {
        let mut stride = Stride::default();
        gaps.into_iter().for_each(|gap| stride.note(gap));
        stride.ticks()
    }

    #[test]
    fn the_stride_is_what_all_gaps_are_multiples_of() {
        assert_eq!(stride_of([]), None);
        assert_eq!(stride_of([1, 1, 3]), Some(1));
        assert_eq!(stride_of([20, 30, 10]), Some(10));
        assert_eq!(stride_of([7, 9]), Some(1), "a reader that skips frames");
    }

    #[test]
    fn a_gap_out_of_step_is_forgotten() {
        assert_eq!(stride_of([10, 10, 4, 6]), Some(2));
        assert_eq!(stride_of([10, 10, 4, 6].into_iter().chain([10; Stride::MEMORY])), Some(10));
    }

    /// Frames of a run at that factor, `period` nanoseconds of wall time apart, up to `end`.
    fn run(factor: f64, period: u64, end: u64) -> RealTimeFactor {
        let mut measured = RealTimeFactor::default();
        (0..=end / period).for_each(|k| measured.note(k * period, (k as f64 * period as f64 * factor) as u64));
        measured
    }

    proptest! {
        #[test]
        fn finds_the_factor(factor in 0.01_f64..1000.0, period in 1_000_000_u64..3_000_000_000) {
            let end = 10 * SECOND;
            let measured = run(factor, period, end).at(end).expect("frames enough");
            prop_assert!((measured / factor - 1.0).abs() < 1e-6, "{measured} of {factor}");
        }
    }

    #[test]
    fn only_the_last_second_counts() {
        let mut measured = run(1.0, SECOND / 100, 10 * SECOND);
        (1..=150).for_each(|k| measured.note(10 * SECOND + k * SECOND / 100, 10 * SECOND + k * SECOND / 50));
        let factor = measured.at(11 * SECOND + SECOND / 2).expect("frames enough");
        assert!((factor - 2.0).abs() < 0.01, "{factor}");
    }

    #[test]
    fn when_frames_cease_the_factor_is_zero() {
        let measured = run(1.0, SECOND / 100, 5 * SECOND);
        assert_eq!(measured.at(8 * SECOND), Some(0.0));
        assert_eq!(run(1.0, 4 * SECOND, 20 * SECOND).at(25 * SECOND), Some(1.0), "slow frames are no end");
        let mut one = RealTimeFactor::default();
        one.note(0, 0);
        assert_eq!(one.at(1), None);
    }
}
