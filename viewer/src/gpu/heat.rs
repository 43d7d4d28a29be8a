//! The heat map: ribbons along the edges' curves, over the graph and under the robots.

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, PrimitiveTopology, RenderPass, RenderPipeline, ShaderStages,
    VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::bindings::{Binding, bind_group, bind_group_layout};
use super::device::Gpu;
use super::instances::Instances;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::resources::buffer;
use super::shaders::shader;
use crate::jams::heat::{HeatMap, HotCurve};
use crate::palette::{COLOURS, Theme, heat_ramp};

/// Vertices of a bent curve's strip, which has 16 parts; the same as in heat.wgsl.
const BENT_VERTICES: u32 = 2 * (16 + 1);

/// Draws the heat map.
#[derive(Debug)]
pub struct HeatRibbons {
    straight: (RenderPipeline, Instances<HotCurve>),
    bent: (RenderPipeline, Instances<HotCurve>),
    ramp: Buffer,
    group: BindGroup,
    /// The theme whose colours are in `ramp`.
    theme: Option<Theme>,
}

impl HeatRibbons {
    /// Creates the pipelines. `records` is the layout of the graph's records.
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout, records: &BindGroupLayout) -> Self {
        let attributes = vertex_attr_array![0 => Uint32, 1 => Float32];
        let instance = VertexBufferLayout {
            array_stride: size_of::<HotCurve>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &attributes,
        };
        let module = shader(gpu, "heat");
        let layout = bind_group_layout(gpu, "heat ramp", ShaderStages::VERTEX, &[Binding::Uniform]);
        let strip = |vertex| {
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment: "fill",
                groups: &[view, records, &layout],
                buffers: std::slice::from_ref(&instance),
                topology: PrimitiveTopology::TriangleStrip,
                depth: DepthMode::Ignored,
                blend: true,
            };
            (render_pipeline(gpu, target, &descriptor), Instances::new(gpu, vertex))
        };
        let ramp = buffer(gpu, "heat ramp", COLOURS * size_of::<[f32; 4]>(), BufferUsages::UNIFORM);
        Self {
            straight: strip("straight"),
            bent: strip("bent"),
            group: bind_group(gpu, &layout, &[(0, &ramp)]),
            ramp,
            theme: None,
        }
    }

    /// Replaces the curves.
    pub fn set(&mut self, gpu: &Gpu, map: Option<&HeatMap>) {
        self.straight.1.set(gpu, map.map_or(&[], |map| &map.straight));
        self.bent.1.set(gpu, map.map_or(&[], |map| &map.bent));
    }

    /// Uploads the colours of a theme. Call this before a picture.
    pub fn prepare(&mut self, gpu: &Gpu, theme: Theme) {
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            let colours = heat_ramp(theme).map(|colour| colour.linear().extend(1.0));
            gpu.queue.write_buffer(&self.ramp, 0, bytemuck::cast_slice(&colours));
        }
    }

    /// Draws the curves, which are those of the graph's records.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        for ((pipeline, curves), vertices) in [(&self.straight, 4), (&self.bent, BENT_VERTICES)] {
            if curves.count() > 0 {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(1, records, &[]);
                pass.set_bind_group(2, &self.group, &[]);
                curves.draw(pass, vertices);
            }
        }
    }
}
