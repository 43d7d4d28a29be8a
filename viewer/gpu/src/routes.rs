//! Routes, drawn along the edges' curves: those of selected robots as wide ribbons, over narrow
//! ones of all robots.

use regatta_scene::route::RouteSegment;
use wgpu::{
    BindGroup, BindGroupLayout, PrimitiveTopology, RenderPass, RenderPipeline, VertexBufferLayout,
    VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::instances::Instances;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::shaders::shader;

/// Vertices of a wide segment's strip, which has 32 parts, and of a narrow one's with 12; the same
/// as in routes.wgsl.
const VERTICES: u32 = 2 * (32 + 1);
const NARROW_VERTICES: u32 = 2 * (12 + 1);

/// Draws routes.
#[derive(Debug)]
pub struct Routes {
    wide: RenderPipeline,
    narrow: RenderPipeline,
    selected: Instances<RouteSegment>,
    all: Instances<RouteSegment>,
}

impl Routes {
    /// Creates the pipelines. `records` is the layout of the graph's records.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        records: &BindGroupLayout,
    ) -> Self {
        let attributes = vertex_attr_array![0 => Uint32, 1 => Float32x2, 2 => Uint32];
        let segment = VertexBufferLayout {
            array_stride: size_of::<RouteSegment>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &attributes,
        };
        let module = shader(gpu, "routes");
        let strip = |vertex| {
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment: "route_fill",
                groups: &[view, records],
                buffers: std::slice::from_ref(&segment),
                topology: PrimitiveTopology::TriangleStrip,
                depth: DepthMode::Ignored,
                blend: true,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        Self {
            wide: strip("route"),
            narrow: strip("narrow_route"),
            selected: Instances::new(gpu, "routes"),
            all: Instances::new(gpu, "all routes"),
        }
    }

    /// Replaces the routes of selected robots.
    pub fn set(&mut self, gpu: &Gpu, segments: &[RouteSegment]) {
        self.selected.set(gpu, segments);
    }

    /// Replaces the routes of all robots.
    pub fn set_all(&mut self, gpu: &Gpu, segments: &[RouteSegment]) {
        self.all.set(gpu, segments);
    }

    /// Draws the segments along the graph's edges: those of selected robots, and with `all` those
    /// of all.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup, all: bool) {
        let narrow = (&self.narrow, &self.all, NARROW_VERTICES, all);
        for (pipeline, segments, vertices, is_shown) in
            [narrow, (&self.wide, &self.selected, VERTICES, true)]
        {
            if is_shown && segments.count() > 0 {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(1, records, &[]);
                segments.draw(pass, vertices);
            }
        }
    }
}
