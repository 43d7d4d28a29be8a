//! The routes of selected robots, drawn along the edges' curves.

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, PrimitiveTopology, RenderPass, RenderPipeline,
    VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::resources::buffer;
use super::shaders::shader;
use crate::route::{MAX_ROBOTS, RouteSegment};

/// The most segments that are drawn: all legs of [`MAX_ROBOTS`] answers, each of which lists at most 256, of edges with four
/// curves on average.
const MAX_SEGMENTS: usize = MAX_ROBOTS * 256 * 4;
/// Vertices of a segment's strip, which has 32 parts; the same as in routes.wgsl.
const VERTICES: u32 = 2 * (32 + 1);

/// Draws routes.
#[derive(Debug)]
pub struct Routes {
    pipeline: RenderPipeline,
    segments: Buffer,
    count: u32,
}

impl Routes {
    /// Creates the pipeline. `records` is the layout of the graph's records.
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout, records: &BindGroupLayout) -> Self {
        let attributes = vertex_attr_array![0 => Uint32, 1 => Float32x2, 2 => Uint32];
        let segment = VertexBufferLayout {
            array_stride: size_of::<RouteSegment>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &attributes,
        };
        let descriptor = PipelineDescriptor {
            module: &shader(gpu, "routes"),
            vertex: "route",
            fragment: "route_fill",
            groups: &[view, records],
            buffers: &[segment],
            topology: PrimitiveTopology::TriangleStrip,
            depth: DepthMode::Ignored,
            blend: true,
        };
        let segments = buffer(gpu, "routes", MAX_SEGMENTS * size_of::<RouteSegment>(), BufferUsages::VERTEX);
        Self { pipeline: render_pipeline(gpu, target, &descriptor), segments, count: 0 }
    }

    /// Replaces the segments that are drawn.
    pub fn set(&mut self, gpu: &Gpu, segments: &[RouteSegment]) {
        let segments = &segments[..segments.len().min(MAX_SEGMENTS)];
        self.count = segments.len() as u32;
        gpu.queue.write_buffer(&self.segments, 0, bytemuck::cast_slice(segments));
    }

    /// Draws the segments along the graph's edges.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        if self.count > 0 {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(1, records, &[]);
            pass.set_vertex_buffer(0, self.segments.slice(..));
            pass.draw(0..VERTICES, 0..self.count);
        }
    }
}
