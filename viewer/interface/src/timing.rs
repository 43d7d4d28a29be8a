//! The durations of the last pictures, by their parts.

use std::collections::VecDeque;

/// The number of pictures over which durations are kept.
pub const PICTURES: usize = 120;
/// The parts of a picture's duration.
pub const PARTS: [&str; 5] =
    ["reading", "uploads", "encoding", "interface", "waiting for the screen"];

/// The durations of the last pictures.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The name of the graphics adapter.
    pub adapter: String,
    /// Per picture: the seconds of its [`PARTS`], and the seconds since the picture before.
    pictures: VecDeque<([f32; 5], f32)>,
    /// GPU seconds of the pictures for which they were measured.
    gpu: VecDeque<f32>,
}

impl Timing {
    /// Creates an empty record.
    pub fn new(adapter: String) -> Self {
        Self { adapter, ..Self::default() }
    }

    /// Adds a picture: the seconds of its [`PARTS`], and the seconds since the picture before.
    pub fn push(&mut self, parts: [f32; 5], period: f32) {
        if self.pictures.len() == PICTURES {
            self.pictures.pop_front();
        }
        self.pictures.push_back((parts, period));
    }

    /// Adds the seconds that the GPU spent on one picture of the fleet.
    pub fn push_gpu(&mut self, seconds: f32) {
        if self.gpu.len() == PICTURES {
            self.gpu.pop_front();
        }
        self.gpu.push_back(seconds);
    }

    /// Returns the mean GPU seconds of a picture of the fleet; `None` where the adapter doesn't
    /// measure them.
    pub fn gpu(&self) -> Option<f32> {
        (!self.gpu.is_empty()).then(|| self.gpu.iter().sum::<f32>() / self.gpu.len() as f32)
    }

    /// Returns the pictures per second, over the last 30 pictures.
    pub fn rate(&self) -> f32 {
        let last = self.pictures.iter().rev().take(30);
        let (count, time) =
            last.fold((0.0, 0.0), |(count, time), (_, period)| (count + 1.0, time + period));
        if time > 0.0 { count / time } else { 0.0 }
    }

    /// Returns the mean seconds of one of the [`PARTS`].
    pub fn mean(&self, part: usize) -> f32 {
        self.pictures.iter().map(|(parts, _)| parts[part]).sum::<f32>()
            / self.pictures.len().max(1) as f32
    }

    /// Returns the seconds of the [`PARTS`] of each picture, oldest first.
    pub fn parts(&self) -> impl Iterator<Item = &[f32; 5]> {
        self.pictures.iter().map(|(parts, _)| parts)
    }
}
