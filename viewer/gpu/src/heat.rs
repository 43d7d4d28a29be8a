//! The heat map: ribbons along the edges' curves, over the graph and under the robots. A compute
//! shader passes over those out of sight, and puts the rest into a draw list for each step of heat:
//! the hottest are drawn last.

use glam::{UVec2, Vec4};
use regatta_scene::heat::{HeatMap, HotCurve};
use regatta_scene::palette::{COLOURS, Theme, heat_ramp};
use wgpu::util::DrawIndirectArgs;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline,
    PrimitiveTopology, RenderPass, RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_buffers, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{
    PipelineDescriptor, TargetConfig, compute_pipeline, dispatch, render_pipeline, shader,
};
use super::resources::buffer;

/// From this number of curves on, short ribbons are drawn into pixels where the processor draws:
/// that costs a pass over all pixels.
const SPLATS_FROM: u32 = 1_000;
/// Steps of heat; the same as in heat.wgsl.
const STEPS: usize = 16;
/// The words of the shader's `starts`.
const STARTS: usize = 36;
/// The draws: one for each step of straight and of bent curves, and one of ribbons in pixels.
const DRAWS: usize = 2 * STEPS + 1;
/// The size of the arguments of an indirect draw.
const DRAW_BYTES: usize = size_of::<DrawIndirectArgs>();
/// The maximum number of curves. Further curves are left out.
const MAX_CURVES: usize = 4 << 20;

/// Draws the heat map.
#[derive(Debug)]
pub struct HeatRibbons {
    sort: ComputePipeline,
    /// As `sort`, with short ribbons drawn into pixels.
    sort_and_splat: ComputePipeline,
    count_draws: ComputePipeline,
    straight: RenderPipeline,
    bent: RenderPipeline,
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
        use Binding::{Read, Uniform, Write};
        let sorting = [Read, Uniform, Write, Write, Write, Write];
        let sorting = bind_group_layout(gpu, "sort heat", ShaderStages::COMPUTE, &sorting);
        let drawing = [Read, Uniform, Read, Read];
        let drawing = bind_group_layout(gpu, "heat", ShaderStages::VERTEX_FRAGMENT, &drawing);
        let sort_groups = [view, records, &sorting];
        let [sort, sort_and_splat, count_draws] =
            [("sort", 0.0), ("sort", 1.0), ("count_draws", 0.0)].map(|(entry, splats)| {
                compute_pipeline(gpu, &module, entry, &sort_groups, &[("SPLATS", splats)])
            });
        let draw_groups = [view, records, &drawing];
        let [straight, bent, splatted] =
            [("straight", "fill"), ("bent", "fill"), ("place", "fill_splatted")].map(
                |(vertex, fragment)| {
                    let descriptor = PipelineDescriptor {
                        topology: PrimitiveTopology::TriangleList,
                        ..PipelineDescriptor::new(&module, vertex, fragment, &draw_groups)
                    };
                    render_pipeline(gpu, target, &descriptor)
                },
            );
        Self {
            sort,
            sort_and_splat,
            count_draws,
            straight,
            bent,
            splatted,
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

    /// Sorts the visible hot curves of a picture of `size` pixels. `records` are those of the
    /// graph.
    pub fn sort(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (view, records): (&BindGroup, &BindGroup),
        size: UVec2,
        theme: Theme,
    ) {
        let curves = self.buffers.curves;
        if curves == 0 {
            return;
        }
        if self.theme != Some(theme) {
            self.theme = Some(theme);
            let ramp = heat_ramp(theme).map(|colour| colour.linear().extend(1.0));
            gpu.queue.write_buffer(&self.buffers.ramp, 0, bytemuck::cast_slice(&ramp));
        }
        self.are_splats = self.may_splat && curves >= SPLATS_FROM;
        let sorting = self.buffers.prepare(gpu, encoder, self.are_splats.then_some(size));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(if self.are_splats { &self.sort_and_splat } else { &self.sort });
        pass.set_bind_group(0, view, &[]);
        pass.set_bind_group(1, records, &[]);
        pass.set_bind_group(2, sorting, &[]);
        dispatch(&mut pass, curves);
        pass.set_pipeline(&self.count_draws);
        pass.dispatch_workgroups(1, 1, 1);
    }

    /// Draws the curves that were sorted last.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        let Some(Groups { drawing, .. }) = &self.buffers.groups else { return };
        if self.buffers.curves == 0 {
            return;
        }
        pass.set_bind_group(1, records, &[]);
        pass.set_bind_group(2, drawing, &[]);
        let arguments = &self.buffers.arguments;
        if self.are_splats {
            pass.set_pipeline(&self.splatted);
            pass.draw_indirect(arguments, ((DRAWS - 1) * DRAW_BYTES) as u64);
        }
        let kinds = [(&self.straight, 0..STEPS), (&self.bent, STEPS..2 * STEPS)];
        for (pipeline, steps) in kinds {
            pass.set_pipeline(pipeline);
            for step in steps.filter(|step| self.buffers.is_used[*step]) {
                pass.draw_indirect(arguments, (step * DRAW_BYTES) as u64);
            }
        }
    }
}

/// The curves, coldest first, and the draw lists of a picture.
#[derive(Debug)]
struct Buffers {
    sorting_layout: BindGroupLayout,
    drawing_layout: BindGroupLayout,
    /// `None` after a buffer was replaced.
    groups: Option<Groups>,
    all: Buffer,
    visible: Buffer,
    starts: Buffer,
    counts: Buffer,
    arguments: Buffer,
    pixels: Buffer,
    ramp: Buffer,
    curves: u32,
    /// The steps that have curves, of straight and then of bent ones.
    is_used: [bool; 2 * STEPS],
}

#[derive(Debug)]
struct Groups {
    sorting: BindGroup,
    drawing: BindGroup,
}

impl Buffers {
    /// Creates small buffers. The layouts are those of the groups for sorting and for drawing.
    fn new(gpu: &Gpu, sorting: BindGroupLayout, drawing: BindGroupLayout) -> Self {
        let (word, storage) = (size_of::<u32>(), BufferUsages::STORAGE);
        let indirect = storage | BufferUsages::INDIRECT;
        let ramp_bytes = COLOURS * size_of::<Vec4>();
        Self {
            sorting_layout: sorting,
            drawing_layout: drawing,
            groups: None,
            all: buffer(gpu, "hot curves", size_of::<HotCurve>(), storage),
            visible: buffer(gpu, "hot curves in sight", word, storage),
            starts: buffer(gpu, "steps of heat", STARTS * word, BufferUsages::UNIFORM),
            counts: buffer(gpu, "counts of heat", DRAWS * word, storage),
            arguments: buffer(gpu, "draws of heat", DRAWS * DRAW_BYTES, indirect),
            pixels: buffer(gpu, "pixels of heat", word, storage),
            ramp: buffer(gpu, "heat ramp", ramp_bytes, BufferUsages::UNIFORM),
            curves: 0,
            is_used: [false; 2 * STEPS],
        }
    }

    /// Replaces the curves. The buffers grow as needed.
    fn set(&mut self, gpu: &Gpu, map: Option<&HeatMap>) {
        let all: Vec<HotCurve> = map
            .iter()
            .flat_map(|map| map.straight.iter().chain(&map.bent))
            .copied()
            .take(MAX_CURVES)
            .collect();
        let straight = map.map_or(0, |map| map.straight.len()).min(all.len());
        self.curves = all.len() as u32;
        if size_of_val(&all[..]) as u64 > self.all.size() {
            let (room, usage) = (all.len().next_power_of_two(), BufferUsages::STORAGE);
            self.all = buffer(gpu, "hot curves", room * size_of::<HotCurve>(), usage);
            self.visible = buffer(gpu, "hot curves in sight", room * size_of::<u32>(), usage);
            self.groups = None;
        }
        if all.is_empty() {
            return;
        }
        let starts = starts(&all, straight);
        self.is_used = std::array::from_fn(|step| starts[step] < starts[step + 1]);
        gpu.queue.write_buffer(&self.all, 0, bytemuck::cast_slice(&all));
        gpu.queue.write_buffer(&self.starts, 0, bytemuck::cast_slice(&starts));
    }

    /// Clears the counts and the pixels of the picture before, and makes room for the pixels of a
    /// picture of `size`, if ribbons are drawn into them. Returns the group for sorting.
    fn prepare(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        size: Option<UVec2>,
    ) -> &BindGroup {
        encoder.clear_buffer(&self.counts, 0, None);
        if let Some(size) = size {
            let bytes = size.as_u64vec2().element_product() * size_of::<u32>() as u64;
            if bytes > self.pixels.size() {
                self.pixels = buffer(gpu, "pixels of heat", bytes as usize, BufferUsages::STORAGE);
                self.groups = None;
            }
            encoder.clear_buffer(&self.pixels, 0, Some(bytes));
        }
        let groups = self.groups.take().unwrap_or_else(|| self.bind(gpu));
        &self.groups.insert(groups).sorting
    }

    fn bind(&self, gpu: &Gpu) -> Groups {
        let Self { all, visible, starts, counts, arguments, pixels, ramp, .. } = self;
        let sorted = [all, starts, visible, counts, arguments, pixels];
        Groups {
            sorting: bind_buffers(gpu, &self.sorting_layout, &sorted),
            drawing: bind_buffers(gpu, &self.drawing_layout, &[all, ramp, visible, pixels]),
        }
    }
}

/// Returns the index of the first curve of each step of heat: of the straight curves, which come
/// first, then of the bent ones; then the end. Both are sorted by heat.
fn starts(all: &[HotCurve], straight: usize) -> [u32; STARTS] {
    let mut starts = [all.len() as u32; STARTS];
    let kinds = [(&all[..straight], 0), (&all[straight..], straight)];
    for (kind, (curves, first)) in kinds.into_iter().enumerate() {
        for step in 0..STEPS {
            let colder = curves.partition_point(|hot| step_of(hot) < step);
            starts[kind * STEPS + step] = (first + colder) as u32;
        }
    }
    starts
}

fn step_of(hot: &HotCurve) -> usize {
    ((hot.level * STEPS as f32) as usize).min(STEPS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_heat_begin_where_their_curves_do() {
        let hot = |level| HotCurve { curve: 0, level };
        let all = [0.0, 0.05, 0.07, 0.5, 1.0, 0.0, 0.99].map(hot);
        let starts = starts(&all, 5);
        assert_eq!(starts[..3], [0, 2, 3], "two of the first step, one of the second");
        assert_eq!((starts[8], starts[9], starts[15], starts[16]), (3, 4, 4, 5));
        assert_eq!(
            (starts[17], starts[31], starts[32]),
            (6, 6, 7),
            "then the bent ones, and the end"
        );
    }
}
