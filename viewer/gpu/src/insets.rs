//! Pictures within a picture: each is drawn by itself, and then copied into its part of the target.

use glam::UVec2;
use wgpu::{CommandEncoder, TextureFormat, TextureView};

use super::copy::{Copier, Original};
use super::device::Gpu;
use super::painter::begin;
use super::pipeline::{DepthMode, TargetConfig};

/// Pictures of one size.
#[derive(Debug)]
pub struct Insets {
    gpu: Gpu,
    copier: Copier,
    size: UVec2,
    originals: Vec<Original>,
}

impl Insets {
    /// Creates the pipeline for targets of a format.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let target = TargetConfig::new(gpu, format, 1);
        let copier = Copier::new(gpu, target, DepthMode::Absent);
        Self { gpu: gpu.clone(), copier, size: UVec2::ZERO, originals: Vec::new() }
    }

    /// Makes room for so many pictures of `size` pixels, and returns what they are drawn into.
    pub fn make_room(&mut self, number: usize, size: UVec2) -> impl Iterator<Item = &TextureView> {
        if self.size != size {
            (self.size, self.originals) = (size, Vec::new());
        }
        self.originals.resize_with(number, || self.copier.original(&self.gpu, size));
        self.originals.iter().map(|original| &original.view)
    }

    /// Copies the pictures into a target. `places` are their top left corners in it; all of them
    /// lie within the target.
    pub fn copy(&self, encoder: &mut CommandEncoder, target: &TextureView, places: &[UVec2]) {
        let mut pass = begin(encoder, target, "insets");
        for (original, at) in self.originals.iter().zip(places) {
            let (at, size) = (at.as_vec2(), self.size.as_vec2());
            pass.set_viewport(at.x, at.y, size.x, size.y, 0.0, 1.0);
            self.copier.copy(&mut pass, original);
        }
    }
}
