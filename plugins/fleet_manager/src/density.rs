//! The number of robots that may be under way at the same time.
//!
//! Roads carry most robots at a certain density; with more, each waits for others, and fewer arrive
//! (the macroscopic fundamental diagram: N. Geroliminis, C. Daganzo: Existence of urban-scale
//! macroscopic fundamental diagrams, 2008).

/// The settings of a [`Density`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensitySettings {
    /// The share of robots under way that may wait for others, from 0 to 1; 1 for no limit on the
    /// robots under way.
    pub waiting_share: f64,
    /// The relative change of the number of robots for each unit by which the share differs, per
    /// second.
    pub gain: f64,
}

impl Default for DensitySettings {
    fn default() -> Self {
        Self { waiting_share: 0.3, gain: 0.05 }
    }
}

/// The number of robots that may be under way, controlled so that a certain share of them waits.
#[derive(Clone, Debug)]
pub struct Density {
    settings: DensitySettings,
    /// The number that may be under way in any case.
    least: f64,
    most: f64,
    /// Robots under way.
    out: usize,
}

impl Density {
    /// Begins with `least` robots, 1 at least, which may be under way in any case.
    pub fn new(settings: DensitySettings, least: f64) -> Self {
        let least = least.max(1.0);
        Self { settings, least, most: least, out: 0 }
    }

    /// Whether one more robot may get under way.
    pub fn is_open(&self) -> bool {
        self.settings.waiting_share >= 1.0 || (self.out as f64) < self.most
    }

    /// Records that a robot gets under way.
    pub fn enter(&mut self) {
        self.out += 1;
    }

    /// Changes the number of robots that may be under way, after some seconds in which `waiting` of
    /// `out` robots have been waiting.
    pub fn adapt(&mut self, out: usize, waiting: usize, seconds: f32) {
        self.out = out;
        let share = waiting as f64 / out.max(1) as f64;
        let change =
            self.settings.gain * (self.settings.waiting_share - share) * f64::from(seconds);
        // A number far above the tried numbers of robots under way is untested.
        let tried = self.least.max(1.1 * out as f64 + 1.0);
        self.most = (self.most * (1.0 + change)).clamp(self.least, tried);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_robots_are_admitted_while_few_of_them_wait() {
        let mut density = Density::new(DensitySettings::default(), 10.0);
        let mut out = 0;
        for _ in 0..600 {
            density.adapt(out, out / 10, 0.1);
            out += usize::from(density.is_open());
        }
        assert!(out > 15, "{out} robots after a minute");
    }

    #[test]
    fn fewer_robots_are_admitted_while_many_of_them_wait() {
        let mut density = Density::new(DensitySettings::default(), 10.0);
        density.most = 100.0;
        (0..600).for_each(|_| density.adapt(99, 60, 0.1));
        assert!(
            density.most < 50.0 && !density.is_open(),
            "{} robots after a minute",
            density.most
        );
        (0..6000).for_each(|_| density.adapt(9, 9, 0.1));
        assert!(density.is_open(), "the least number is always admitted");
    }
}
