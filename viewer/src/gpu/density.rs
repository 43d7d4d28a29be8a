//! The density of robots from afar: sums by cells of the picture, which the sorting shader writes, blurred and drawn as a field.

use glam::UVec2;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, ComputePass, ComputePipeline, PrimitiveTopology, RenderPass,
    RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_group, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, compute_pipeline, render_pipeline};
use super::resources::buffer;
use super::shaders::shader;

/// Width and height of a cell in pixels; the same as in marks.wgsl.
const CELL: u32 = 4;
/// The workgroup size of the shaders.
const WORKGROUP: u32 = 64;

/// Blurs and draws the field.
#[derive(Debug)]
pub struct Density {
    /// The first pass without and with splatted marks before the cells.
    across: [ComputePipeline; 2],
    down: ComputePipeline,
    draw: RenderPipeline,
    blur_layout: BindGroupLayout,
    draw_layout: BindGroupLayout,
    /// Sums that are blurred in one direction, and in both.
    fields: [Buffer; 2],
    groups: Option<[BindGroup; 2]>,
    cells: u32,
    size: UVec2,
}

impl Density {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let bindings = [Binding::Read, Binding::Write, Binding::Write];
        let blur_layout = bind_group_layout(gpu, "density", ShaderStages::COMPUTE, &bindings);
        let draw_layout = bind_group_layout(gpu, "field", ShaderStages::FRAGMENT, &[Binding::Read]);
        let blur = shader(gpu, "density");
        let pass = |entry, splats| compute_pipeline(gpu, &blur, entry, &[view, &blur_layout], &[("SPLATS", splats)]);
        let descriptor = PipelineDescriptor {
            module: &shader(gpu, "field"),
            vertex: "place",
            fragment: "fill",
            groups: &[view, &draw_layout],
            buffers: &[],
            topology: PrimitiveTopology::TriangleList,
            depth: DepthMode::Ignored,
            blend: true,
        };
        Self {
            across: [0.0, 1.0].map(|splats| pass("across", splats)),
            down: pass("down", 0.0),
            draw: render_pipeline(gpu, target, &descriptor),
            fields: field_buffers(gpu, 1),
            blur_layout,
            draw_layout,
            groups: None,
            cells: 1,
            size: UVec2::ZERO,
        }
    }

    /// The number of words that the sums take in a picture of `size` pixels.
    pub fn words(size: UVec2) -> u64 {
        4 * u64::from(size.x.div_ceil(CELL)) * u64::from(size.y.div_ceil(CELL))
    }

    /// Makes room for a picture of `size` pixels, and binds the buffer with the sums, unless it is bound.
    pub fn fit(&mut self, gpu: &Gpu, size: UVec2, sums: &Buffer) {
        if self.size == size && self.groups.is_some() {
            return;
        }
        self.size = size;
        let cells = (Self::words(size) / 4) as u32;
        if u64::from(cells) * 16 > self.fields[0].size() {
            self.fields = field_buffers(gpu, cells);
        }
        self.cells = cells;
        let [one, both] = &self.fields;
        let blur = bind_group(gpu, &self.blur_layout, &[(0, sums), (1, one), (2, both)]);
        self.groups = Some([blur, bind_group(gpu, &self.draw_layout, &[(0, both)])]);
    }

    /// Forgets the buffer with the sums, which has been replaced.
    pub fn unbind(&mut self) {
        self.groups = None;
    }

    /// Blurs the sums. `are_splats` says whether marks were splatted.
    pub fn blur(&self, pass: &mut ComputePass<'_>, are_splats: bool) {
        let Some([blur, _]) = &self.groups else { return };
        pass.set_bind_group(1, blur, &[]);
        for pipeline in [&self.across[usize::from(are_splats)], &self.down] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(self.cells.div_ceil(WORKGROUP), 1, 1);
        }
    }

    /// Draws the field over the ground.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        let Some([_, draw]) = &self.groups else { return };
        pass.set_pipeline(&self.draw);
        pass.set_bind_group(1, draw, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn field_buffers(gpu: &Gpu, cells: u32) -> [Buffer; 2] {
    ["blurred across", "blurred"].map(|label| buffer(gpu, label, cells as usize * 16, BufferUsages::STORAGE))
}
