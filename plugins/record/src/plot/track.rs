//! A robot's track: the samples of its motion.

use regatta_plugin::world::CurveRecord;

/// A robot in one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// The time on the recording's clock, in seconds.
    pub time: f64,
    pub x: f64,
    pub y: f64,
    /// The heading in radians.
    pub theta: f64,
    /// The speed in metres per second.
    pub speed: f64,
    pub state: u8,
}

/// A robot's track. A new segment starts with each run, and when the robot is present again after
/// an absence.
pub(super) struct Track {
    pub segments: Vec<Vec<Sample>>,
    /// The curves of the route graph's edges.
    pub curves: Vec<CurveRecord>,
}

impl Track {
    pub fn samples(&self) -> impl DoubleEndedIterator<Item = &Sample> {
        self.segments.iter().flatten()
    }

    /// Returns the times of the first and the last sample, in seconds.
    pub fn span(&self) -> (f64, f64) {
        let at = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.time);
        (at(self.samples().next()), at(self.samples().next_back()))
    }

    /// Returns the driven distance in metres.
    pub fn length(&self) -> f64 {
        let pairs = self.segments.iter().flat_map(|segment| segment.windows(2));
        pairs.map(|pair| (pair[1].x - pair[0].x).hypot(pair[1].y - pair[0].y)).sum()
    }
}
