//! Stations: badges at the nodes where robots pick, drop, park or charge.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::World;
use regatta_plugin::world::Role;
use wgpu::{
    BindGroupLayout, PrimitiveTopology, RenderPass, RenderPipeline, VertexBufferLayout,
    VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::instances::Instances;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::shaders::shader;

/// A badge: an instance of stations.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Station {
    /// Metres east and north of the world's origin.
    place: [f32; 2],
    /// A [`Role`].
    role: u32,
}

/// Draws the badges.
#[derive(Debug)]
pub struct Stations {
    pipeline: RenderPipeline,
    stations: Instances<Station>,
}

impl Stations {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let attributes = vertex_attr_array![0 => Float32x2, 1 => Uint32];
        let array_stride = size_of::<Station>() as u64;
        let instance = VertexBufferLayout {
            array_stride,
            step_mode: VertexStepMode::Instance,
            attributes: &attributes,
        };
        let descriptor = PipelineDescriptor {
            module: &shader(gpu, "stations"),
            vertex: "badge",
            fragment: "badge_fill",
            groups: &[view],
            buffers: &[instance],
            topology: PrimitiveTopology::TriangleStrip,
            depth: DepthMode::Ignored,
            blend: true,
        };
        Self {
            pipeline: render_pipeline(gpu, target, &descriptor),
            stations: Instances::new(gpu, "stations"),
        }
    }

    /// Takes the stations of a world.
    pub fn load(&mut self, gpu: &Gpu, world: &World<'_>, level: Option<&str>) {
        let is_shown = |level_of: u32| level.is_none_or(|level| world.text(level_of) == level);
        let nodes =
            world.nodes().iter().filter(|node| node.role() != Role::None && is_shown(node.level));
        let stations: Vec<_> =
            nodes.map(|node| Station { place: [node.x, node.y], role: node.role }).collect();
        self.stations.set(gpu, &stations);
    }

    /// Draws the badges that are large enough in the picture.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        if self.stations.count() > 0 {
            pass.set_pipeline(&self.pipeline);
            self.stations.draw(pass, 4);
        }
    }
}
