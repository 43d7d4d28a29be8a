//! The real-time factor, derived from the frames alone, so that it holds for any producer.

use std::collections::VecDeque;

/// A moment: wall time of the producer and simulated time, both in nanoseconds.
#[derive(Clone, Copy, Debug)]
struct Moment {
    wall: u64,
    simulated: u64,
}

/// Simulated seconds per wall second, over about the last second.
#[derive(Clone, Debug, Default)]
pub struct RealTimeFactor {
    moments: VecDeque<Moment>,
}

const SECOND: u64 = 1_000_000_000;

impl RealTimeFactor {
    /// The least wall time between two moments, in nanoseconds. Frames that follow faster are
    /// merged into one moment.
    const APART: u64 = SECOND / 10;

    /// Restarts the measurement, for example after a pause.
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
        // At least two moments are kept, however slowly frames arrive.
        while self.moments.len() > 2 && self.moments[1].wall.saturating_add(SECOND) <= wall {
            self.moments.pop_front();
        }
    }

    /// Returns the factor at a wall time in nanoseconds: 0 when frames have stopped arriving,
    /// `None` with too few frames.
    pub fn at(&self, now: u64) -> Option<f64> {
        let (first, last) = (self.moments.front()?, self.moments.back()?);
        if now.saturating_sub(last.wall) > SECOND.max(self.spacing()?).saturating_mul(2) {
            return Some(0.0);
        }
        let wall = last.wall.checked_sub(first.wall).filter(|wall| *wall > 0)?;
        Some(last.simulated.saturating_sub(first.simulated) as f64 / wall as f64)
    }

    /// Returns the wall time between the last two moments, in nanoseconds.
    fn spacing(&self) -> Option<u64> {
        let before = self.moments.len().checked_sub(2)?;
        Some(self.moments[before + 1].wall.saturating_sub(self.moments[before].wall))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Returns the measurement of a run at that factor, with frames every `period` nanoseconds of
    /// wall time up to `end`.
    fn run(factor: f64, period: u64, end: u64) -> RealTimeFactor {
        let mut measured = RealTimeFactor::default();
        (0..=end / period)
            .for_each(|k| measured.note(k * period, (k as f64 * period as f64 * factor) as u64));
        measured
    }

    proptest! {
        #[test]
        fn the_factor_is_measured(factor in 0.01_f64..1000.0, period in 1_000_000_u64..3_000_000_000) {
            let end = 10 * SECOND;
            let measured = run(factor, period, end).at(end).expect("enough frames");
            prop_assert!((measured / factor - 1.0).abs() < 1e-6, "{measured} of {factor}");
        }
    }

    #[test]
    fn only_the_last_second_counts() {
        let mut measured = run(1.0, SECOND / 100, 10 * SECOND);
        (1..=150).for_each(|k| {
            measured.note(10 * SECOND + k * SECOND / 100, 10 * SECOND + k * SECOND / 50)
        });
        let factor = measured.at(11 * SECOND + SECOND / 2).expect("enough frames");
        assert!((factor - 2.0).abs() < 0.01, "{factor}");
    }

    #[test]
    fn the_factor_is_zero_when_frames_stop() {
        let measured = run(1.0, SECOND / 100, 5 * SECOND);
        assert_eq!(measured.at(8 * SECOND), Some(0.0));
        assert_eq!(
            run(1.0, 4 * SECOND, 20 * SECOND).at(25 * SECOND),
            Some(1.0),
            "slow frames have not stopped"
        );
        let mut one = RealTimeFactor::default();
        one.note(0, 0);
        assert_eq!(one.at(1), None);
    }
}
