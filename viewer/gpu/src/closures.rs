//! Closed edges: a dashed ribbon along each, and a no-entry sign in its middle.

use regatta_plugin::World;
use regatta_scene::curves::midpoint;
use wgpu::{
    BindGroup, BindGroupLayout, PrimitiveTopology, RenderPass, RenderPipeline, VertexAttribute,
    VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::instances::Instances;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::shaders::shader;

/// Vertices of a curve's strip, which has 32 parts as in closures.wgsl.
const RIBBON_VERTICES: u32 = 2 * (32 + 1);

/// Draws closed edges.
#[derive(Debug)]
pub struct ClosedEdges {
    ribbon: RenderPipeline,
    sign: RenderPipeline,
    /// The indices of the closed edges' curves.
    curves: Instances<u32>,
    /// The middles of the closed edges.
    signs: Instances<[f32; 2]>,
}

impl ClosedEdges {
    /// Creates the pipelines. `records` is the layout of the graph's records.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        records: &BindGroupLayout,
    ) -> Self {
        let module = shader(gpu, "closures");
        let make = |vertex,
                    fragment,
                    array_stride,
                    attributes: &[VertexAttribute],
                    groups: &[&BindGroupLayout]| {
            let buffer = VertexBufferLayout {
                array_stride,
                step_mode: VertexStepMode::Instance,
                attributes,
            };
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment,
                groups,
                buffers: &[buffer],
                topology: PrimitiveTopology::TriangleStrip,
                depth: DepthMode::Ignored,
                blend: true,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        Self {
            ribbon: make(
                "ribbon",
                "ribbon_fill",
                4,
                &vertex_attr_array![0 => Uint32],
                &[view, records],
            ),
            sign: make("sign", "sign_fill", 8, &vertex_attr_array![0 => Float32x2], &[view]),
            curves: Instances::new(gpu, "closed curves"),
            signs: Instances::new(gpu, "no-entry signs"),
        }
    }

    /// Replaces the closed edges, by index. With a `level`, only its edges are shown.
    pub fn set(&mut self, gpu: &Gpu, world: &World<'_>, closed: &[u32], level: Option<&str>) {
        let is_shown = |level_of: u32| level.is_none_or(|level| world.text(level_of) == level);
        let edges = || {
            let found = closed.iter().filter_map(|edge| world.edges().get(*edge as usize));
            found.filter(|edge| is_shown(edge.level))
        };
        let count = world.all_curves().len() as u32;
        let curves: Vec<u32> = edges()
            .flat_map(|edge| (edge.first_curve..).take(world.curves(edge).len()))
            .filter(|curve| *curve < count)
            .collect();
        let signs: Vec<[f32; 2]> =
            edges().filter_map(|edge| midpoint(world, edge)).map(Into::into).collect();
        self.curves.set(gpu, &curves);
        self.signs.set(gpu, &signs);
    }

    /// Draws the closed edges over the graph.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        if self.curves.count() > 0 {
            pass.set_pipeline(&self.ribbon);
            pass.set_bind_group(1, records, &[]);
            self.curves.draw(pass, RIBBON_VERTICES);
        }
        if self.signs.count() > 0 {
            pass.set_pipeline(&self.sign);
            self.signs.draw(pass, 4);
        }
    }
}
