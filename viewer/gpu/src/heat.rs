//! The heat map: ribbons along the edges' curves, over the graph and under the robots. A compute
//! shader passes over those out of sight, and puts the rest into a draw list for each step of heat:
//! the hottest are drawn last.

mod buffers;

use glam::UVec2;
use regatta_scene::heat::HeatMap;
use regatta_scene::palette::{Theme, heat_ramp};
use wgpu::{
    BindGroup, BindGroupLayout, CommandEncoder, ComputePipeline, PrimitiveTopology, RenderPass,
    RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_group_layout, numbered_bind_group_layout};
use super::device::Gpu;
use super::pipeline::{
    DepthMode, PipelineDescriptor, TargetConfig, compute_pipeline, render_pipeline,
};
use super::shaders::shader;
use buffers::Buffers;

/// The workgroup size of the sorting shader.
const WORKGROUP: u32 = 64;
/// From this number of curves on, short ribbons are drawn into pixels where the processor draws:
/// that costs a pass over all pixels.
const SPLATS_FROM: u32 = 1_000;

/// Draws the heat map.
#[derive(Debug)]
pub struct HeatRibbons {
    /// Without and with short ribbons that are drawn into pixels.
    sort: [ComputePipeline; 2],
    count_draws: ComputePipeline,
    /// Of straight and of bent curves.
    ribbons: [RenderPipeline; 2],
    splatted: RenderPipeline,
    buffers: Buffers,
    /// Whether the processor draws, one sample per pixel.
    may_splat: bool,
    are_splats: bool,
    /// The theme whose colours are uploaded.
    theme: Option<Theme>,
}

impl HeatRibbons {
    /// Creates the pipelines. `records` is the layout of the graph's records.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        records: &BindGroupLayout,
    ) -> Self {
        let module = shader(gpu, "heat");
        let sorting = [
            Binding::Read,
            Binding::Uniform,
            Binding::Write,
            Binding::Write,
            Binding::Write,
            Binding::Write,
        ];
        let sorting = bind_group_layout(gpu, "sort heat", ShaderStages::COMPUTE, &sorting);
        let drawing =
            [(0, Binding::Read), (6, Binding::Uniform), (7, Binding::Read), (8, Binding::Read)];
        let drawing =
            numbered_bind_group_layout(gpu, "heat", ShaderStages::VERTEX_FRAGMENT, &drawing);
        let compute = |entry, splats| {
            compute_pipeline(
                gpu,
                &module,
                entry,
                &[view, records, &sorting],
                &[("SPLATS", f64::from(splats))],
            )
        };
        let draw = |vertex, fragment| {
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment,
                groups: &[view, records, &drawing],
                buffers: &[],
                topology: PrimitiveTopology::TriangleList,
                depth: DepthMode::Ignored,
                blend: true,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        Self {
            sort: [0, 1].map(|splats| compute("sort", splats)),
            count_draws: compute("count_draws", 0),
            ribbons: ["straight", "bent"].map(|vertex| draw(vertex, "fill")),
            splatted: draw("place", "fill_splatted"),
            buffers: Buffers::new(gpu, sorting, drawing),
            may_splat: target.splats_from < u32::MAX,
            are_splats: false,
            theme: None,
        }
    }

    /// Replaces the curves.
    pub fn set(&mut self, gpu: &Gpu, map: Option<&HeatMap>) {
        self.buffers.set(gpu, map);
    }

    /// Sorts what is in sight of a picture of `size` pixels. `records` are those of the graph.
    pub fn sort(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (view, records): (&BindGroup, &BindGroup),
        size: UVec2,
        theme: Theme,
    ) {
        let curves = self.buffers.curves();
        if curves == 0 {
            return;
        }
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            self.buffers.set_ramp(gpu, &heat_ramp(theme).map(|colour| colour.linear().extend(1.0)));
        }
        self.are_splats = self.may_splat && curves >= SPLATS_FROM;
        let sorting = self.buffers.prepare(gpu, encoder, self.are_splats.then_some(size));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.sort[usize::from(self.are_splats)]);
        pass.set_bind_group(0, view, &[]);
        pass.set_bind_group(1, records, &[]);
        pass.set_bind_group(2, sorting, &[]);
        let needed = curves.div_ceil(WORKGROUP);
        let across = needed.min(32_768);
        pass.dispatch_workgroups(across, needed.div_ceil(across), 1);
        pass.set_pipeline(&self.count_draws);
        pass.dispatch_workgroups(1, 1, 1);
    }

    /// Draws what was sorted last.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        let Some(drawing) = self.buffers.drawing().filter(|_| self.buffers.curves() > 0) else {
            return;
        };
        pass.set_bind_group(1, records, &[]);
        pass.set_bind_group(2, drawing, &[]);
        if self.are_splats {
            pass.set_pipeline(&self.splatted);
            pass.draw_indirect(self.buffers.arguments(), self.buffers.splatted_draw());
        }
        for (pipeline, draws) in self.ribbons.iter().zip(self.buffers.draws()) {
            pass.set_pipeline(pipeline);
            draws.into_iter().for_each(|at| pass.draw_indirect(self.buffers.arguments(), at));
        }
    }
}
