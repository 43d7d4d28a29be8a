//! Trails behind robots, and halos (rings) around the selected ones.

use bytemuck::{Pod, Zeroable};
use regatta_scene::{MAX_SELECTED, Scene, TRAIL_INTERVAL, Trails};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, RenderPass,
    RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_buffers, bind_group_layout};
use super::columns::Columns;
use super::device::Gpu;
use super::pipeline::{
    PipelineDescriptor, TargetConfig, compute_pipeline, dispatch, render_pipeline, shader,
};
use super::resources::buffer;

/// The simulated time between two points of a trail, in nanoseconds.
const INTERVAL_NANOS: u64 = TRAIL_INTERVAL.as_nanos() as u64;

/// The shaders' `RingBuffer`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct RingBuffer {
    /// Slot of the newest point.
    newest: u32,
    /// Slots that have a point.
    filled: u32,
    /// All slots.
    slots: u32,
    /// Selected robots if only their trails are drawn, else 0.
    selected: u32,
}

/// Draws trails and halos.
#[derive(Debug)]
pub struct Highlights {
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
    ring: RingBuffer,
    /// Run and simulated time of the newest point.
    last: (u64, u64),
    /// Whether a point is to be appended: the newest frame is late enough after the newest point.
    due: bool,
}

/// The bind groups of the points' ring buffer.
#[derive(Debug)]
struct Points {
    rows: usize,
    append: BindGroup,
    draw: BindGroup,
}

impl Highlights {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout, columns: &Columns) -> Self {
        use Binding::{Read, Uniform, Write};
        let module = shader(gpu, "highlights");
        let append_layout =
            bind_group_layout(gpu, "append", ShaderStages::COMPUTE, &[Uniform, Write]);
        let draw_layout =
            bind_group_layout(gpu, "highlights", ShaderStages::VERTEX, &[Uniform, Read, Read]);
        let append_groups = [view, columns.layout(), &append_layout];
        let draw_groups = [view, columns.layout(), &draw_layout];
        let [trail, halo] =
            [("trail", "trail_fill"), ("halo", "halo_fill")].map(|(vertex, fragment)| {
                let strip = PipelineDescriptor::new(&module, vertex, fragment, &draw_groups);
                render_pipeline(gpu, target, &strip)
            });
        let uniform = buffer(gpu, "ring buffer", size_of::<RingBuffer>(), BufferUsages::UNIFORM);
        let ids = buffer(gpu, "selected", MAX_SELECTED * 4, BufferUsages::STORAGE);
        let no_points = buffer(gpu, "no points", 8, BufferUsages::STORAGE);
        Self {
            append: compute_pipeline(gpu, &module, "append", &append_groups, &[]),
            trail,
            halo,
            halo_group: bind_buffers(gpu, &draw_layout, &[&uniform, &no_points, &ids]),
            append_layout,
            draw_layout,
            uniform,
            ids,
            selected: 0,
            points: None,
            ring: RingBuffer::default(),
            last: (0, 0),
            due: false,
        }
    }

    /// Records a new frame. Another run, or a step back in time, begins new trails.
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

    /// Appends a point to every trail if one is due, and uploads the selected robots' ids.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        view: &BindGroup,
        columns: &mut Columns,
        scene: &Scene,
    ) {
        let Scene { selected, trails, .. } = scene;
        let selected = &selected[..selected.len().min(MAX_SELECTED)];
        self.selected = selected.len() as u32;
        gpu.queue.write_buffer(&self.ids, 0, bytemuck::cast_slice(selected));
        self.fit(gpu, columns, trails.points);
        self.ring.selected = if trails.only_selected { self.selected } else { 0 };
        let append = self.due && self.points.is_some() && columns.robots() > 0;
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
            dispatch(&mut pass, columns.robots());
        }
    }

    /// Points of each trail, as far as there is memory.
    pub fn trail_points(&self) -> u32 {
        self.ring.slots
    }

    /// Creates the ring buffer with the requested number of slots, or with as many as the adapter's
    /// limits allow.
    fn fit(&mut self, gpu: &Gpu, columns: &Columns, requested: u32) {
        let limits = gpu.device.limits();
        let row = columns.rows() as u64 * 8;
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / row;
        let slots = u64::from(requested).min(limit) as u32;
        let fits = self.points.as_ref().is_some_and(|points| points.rows == columns.rows());
        if slots == 0 {
            self.points = None;
        } else if !fits || slots != self.ring.slots {
            let bytes = (row * u64::from(slots)) as usize;
            let points = buffer(gpu, "trails", bytes, BufferUsages::STORAGE);
            let drawn = [&self.uniform, &points, &self.ids];
            self.points = Some(Points {
                rows: columns.rows(),
                append: bind_buffers(gpu, &self.append_layout, &[&self.uniform, &points]),
                draw: bind_buffers(gpu, &self.draw_layout, &drawn),
            });
            self.ring = RingBuffer { slots, ..RingBuffer::default() };
            self.due = true;
        }
    }

    /// Draws the trails of all robots, or of the selected ones.
    pub fn draw_trails(
        &self,
        pass: &mut RenderPass<'_>,
        poses: &BindGroup,
        robots: u32,
        trails: Trails,
    ) {
        let Some(points) = &self.points else { return };
        let robots = if trails.only_selected { self.selected } else { robots };
        pass.set_pipeline(&self.trail);
        pass.set_bind_group(1, poses, &[]);
        pass.set_bind_group(2, &points.draw, &[]);
        pass.draw(0..4, 0..robots.saturating_mul(self.ring.filled));
    }

    /// Draws a halo around each selected robot.
    pub fn draw_halos(&self, pass: &mut RenderPass<'_>, poses: &BindGroup) {
        if self.selected > 0 {
            pass.set_pipeline(&self.halo);
            pass.set_bind_group(1, poses, &[]);
            pass.set_bind_group(2, &self.halo_group, &[]);
            pass.draw(0..4, 0..self.selected);
        }
    }
}
