//! Routes of selected robots, drawn along the edges' curves.

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, PrimitiveTopology, RenderPass, RenderPipeline,
    VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::columns::buffer;
use super::device::Gpu;
use super::layout::{Draw, Layering, TargetKind, render, shader};
use crate::route::Stretch;

/// Stretches that are drawn: as many as eight answers list.
const MOST: usize = 8 * 256;
/// Of a stretch's strip; the same as in routes.wgsl.
const VERTICES: u32 = 2 * (32 + 1);

/// All that draws routes.
#[derive(Debug)]
pub struct Routes {
    pipeline: RenderPipeline,
    stretches: Buffer,
    count: u32,
}

impl Routes {
    /// Without routes. `records` is how the graph's records are bound.
    pub fn new(gpu: &Gpu, target: TargetKind, view: &BindGroupLayout, records: &BindGroupLayout) -> Self {
        let attributes = vertex_attr_array![0 => Uint32, 1 => Float32x2, 2 => Uint32];
        let stretch = VertexBufferLayout {
            array_stride: size_of::<Stretch>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &attributes,
        };
        let draw = Draw {
            module: &shader(gpu, "routes"),
            vertex: "route",
            fragment: "route_fill",
            groups: &[view, records],
            buffers: &[stretch],
            topology: PrimitiveTopology::TriangleStrip,
            layering: Layering::Ground,
            blend: true,
        };
        let stretches = buffer(gpu, "routes", MOST * size_of::<Stretch>(), BufferUsages::VERTEX);
        Self { pipeline: render(gpu, target, &draw), stretches, count: 0 }
    }

    /// Takes what is to be drawn, in place of what was.
    pub fn set(&mut self, gpu: &Gpu, stretches: &[Stretch]) {
        let stretches = &stretches[..stretches.len().min(MOST)];
        self.count = stretches.len() as u32;
        gpu.queue.write_buffer(&self.stretches, 0, bytemuck::cast_slice(stretches));
    }

    /// Draws them along the graph's edges.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        if self.count > 0 {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(1, records, &[]);
            pass.set_vertex_buffer(0, self.stretches.slice(..));
            pass.draw(0..VERTICES, 0..self.count);
        }
    }
}
