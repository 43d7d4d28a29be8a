//! The floor, over the whole picture.

use wgpu::{BindGroupLayout, PrimitiveTopology, RenderPass, RenderPipeline};

use super::device::Gpu;
use super::layout::{Draw, Layering, TargetKind, render, shader};

/// Draws the floor, its grid and what lies beyond it.
#[derive(Debug)]
pub struct Floor {
    plain: RenderPipeline,
}

impl Floor {
    pub fn new(gpu: &Gpu, target: TargetKind, view: &BindGroupLayout) -> Self {
        let module = shader(gpu, "floor");
        let draw = |fragment, groups| Draw {
            module: &module,
            vertex: "ray",
            fragment,
            groups,
            buffers: &[],
            topology: PrimitiveTopology::TriangleList,
            layering: Layering::Ground,
            blend: false,
        };
        Self { plain: render(gpu, target, &draw("plain", &[view])) }
    }

    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        pass.set_pipeline(&self.plain);
        pass.draw(0..3, 0..1);
    }
}
