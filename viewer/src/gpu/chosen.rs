//! Trails behind robots, and rings around those that are selected.

use bytemuck::{Pod, Zeroable};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, PrimitiveTopology, RenderPass,
    RenderPipeline, ShaderStages,
};

use super::columns::{Columns, buffer};
use super::device::Gpu;
use super::layout::{Draw, Kind, Layering, TargetKind, bind, compute, layout_of, render, shader};
use crate::scene::{MAX_SELECTED, Trails};

/// Simulated nanoseconds between two points of a trail.
const INTERVAL_NANOS: u64 = 250_000_000;
/// Threads of a group of the appending shader.
const GROUP: u32 = 64;

/// The shaders' `Ring`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Ring {
    newest: u32,
    filled: u32,
    slots: u32,
    count: u32,
}

/// All that draws trails and rings.
#[derive(Debug)]
pub struct Chosen {
    append: ComputePipeline,
    append_layout: BindGroupLayout,
    draw_layout: BindGroupLayout,
    trail: RenderPipeline,
    halo: RenderPipeline,
    uniform: Buffer,
    ids: Buffer,
    selected: u32,
    points: Option<Points>,
    halo_group: BindGroup,
    ring: Ring,
    /// Run and simulated time of the newest point.
    last: (u64, u64),
    /// A frame came that is far enough from the newest point.
    due: bool,
}

/// The ring buffer.
#[derive(Debug)]
struct Points {
    rows: usize,
    append: BindGroup,
    draw: BindGroup,
}

impl Chosen {
    pub fn new(gpu: &Gpu, target: TargetKind, view: &BindGroupLayout, columns: &Columns) -> Self {
        use Kind::{Read, Uniform, Write};
        let module = shader(gpu, "chosen");
        let append_layout = layout_of(gpu, "append", ShaderStages::COMPUTE, &[(0, Write), (1, Uniform)]);
        let draw_layout = layout_of(gpu, "chosen", ShaderStages::VERTEX, &[(1, Uniform), (2, Read), (3, Read)]);
        let strip = |vertex, fragment| {
            render(
                gpu,
                target,
                &Draw {
                    module: &module,
                    vertex,
                    fragment,
                    groups: &[view, columns.layout(), &draw_layout],
                    buffers: &[],
                    topology: PrimitiveTopology::TriangleStrip,
                    layering: Layering::Ground,
                    blend: true,
                },
            )
        };
        let uniform = buffer(gpu, "ring", size_of::<Ring>(), BufferUsages::UNIFORM);
        let ids = buffer(gpu, "selected", MAX_SELECTED * 4, BufferUsages::STORAGE);
        let no_points = buffer(gpu, "no points", 8, BufferUsages::STORAGE);
        Self {
            append: compute(gpu, &module, "append", &[view, columns.layout(), &append_layout]),
            trail: strip("trail", "trail_fill"),
            halo: strip("halo", "halo_fill"),
            halo_group: bind(gpu, &draw_layout, &[(1, &uniform), (2, &no_points), (3, &ids)]),
            append_layout,
            draw_layout,
            uniform,
            ids,
            selected: 0,
            points: None,
            ring: Ring::default(),
            last: (0, 0),
            due: false,
        }
    }

    /// Notes that a frame of that run and simulated time has come.
    pub fn push(&mut self, run_id: u64, sim_time_nanos: u64) {
        let (run, time) = self.last;
        if run != run_id || sim_time_nanos < time {
            self.ring.filled = 0;
        }
        self.due |= self.ring.filled == 0 || sim_time_nanos >= time + INTERVAL_NANOS;
        if self.due {
            self.last = (run_id, sim_time_nanos);
        }
    }

    /// Takes the newest point of every trail if one is due, and who is selected.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        view: &BindGroup,
        columns: &mut Columns,
        trails: Trails,
        selected: &[u32],
    ) {
        self.selected = selected.len().min(MAX_SELECTED) as u32;
        gpu.queue.write_buffer(&self.ids, 0, bytemuck::cast_slice(&selected[..self.selected as usize]));
        self.fit(gpu, columns, trails.points);
        self.ring.count = if trails.only_selected { self.selected } else { 0 };
        let append = self.due && self.points.is_some() && columns.robots()[0] > 0;
        if append {
            self.ring.newest = (self.ring.newest + 1) % self.ring.slots;
            self.ring.filled = (self.ring.filled + 1).min(self.ring.slots);
            self.due = false;
        }
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&self.ring));
        if let (true, Some(points)) = (append, &self.points) {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.append);
            pass.set_bind_group(0, view, &[]);
            pass.set_bind_group(1, &columns.group(gpu), &[]);
            pass.set_bind_group(2, &points.append, &[]);
            let needed = columns.robots()[0].div_ceil(GROUP);
            let across = needed.clamp(1, 32_768);
            pass.dispatch_workgroups(across, needed.div_ceil(across), 1);
        }
    }

    /// Points of the longest trail that there is room for now.
    pub fn trail_points(&self) -> u32 {
        self.ring.slots
    }

    /// Makes the ring buffer of the wanted length, or of the longest that the adapter has room for.
    fn fit(&mut self, gpu: &Gpu, columns: &Columns, wanted: u32) {
        let limits = gpu.device.limits();
        let row = columns.rows() as u64 * 8;
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / row;
        let slots = u64::from(wanted).min(most) as u32;
        let fits = self.points.as_ref().is_some_and(|points| points.rows == columns.rows());
        if slots == 0 {
            self.points = None;
        } else if !fits || slots != self.ring.slots {
            let made = buffer(gpu, "trails", (row * u64::from(slots)) as usize, BufferUsages::STORAGE);
            self.points = Some(Points {
                rows: columns.rows(),
                append: bind(gpu, &self.append_layout, &[(0, &made), (1, &self.uniform)]),
                draw: bind(gpu, &self.draw_layout, &[(1, &self.uniform), (2, &made), (3, &self.ids)]),
            });
            self.ring = Ring { slots, ..Ring::default() };
            self.due = true;
        }
    }

    /// Draws trails.
    pub fn draw_trails(&self, pass: &mut RenderPass<'_>, poses: &BindGroup, robots: u32, trails: Trails) {
        let Some(points) = &self.points else { return };
        let robots = if trails.only_selected { self.selected } else { robots };
        pass.set_pipeline(&self.trail);
        pass.set_bind_group(1, poses, &[]);
        pass.set_bind_group(2, &points.draw, &[]);
        pass.draw(0..4, 0..robots.saturating_mul(self.ring.filled));
    }

    /// Draws rings.
    pub fn draw_rings(&self, pass: &mut RenderPass<'_>, poses: &BindGroup) {
        if self.selected > 0 {
            pass.set_pipeline(&self.halo);
            pass.set_bind_group(1, poses, &[]);
            pass.set_bind_group(2, &self.halo_group, &[]);
            pass.draw(0..4, 0..self.selected);
        }
    }
}
