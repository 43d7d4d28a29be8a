//! A fleet's columns on the GPU: two frames of poses, and what else colours and sizes robots. Each column goes up as
//! it lies in shared memory.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::Frame;
use regatta_plugin::world::{RobotTypeRecord, Shape};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ShaderStages};

use super::device::Gpu;
use super::layout::{Kind, bind, bindings};

/// Robot types whose sizes are known; robots of later ones are drawn as the last.
pub const TYPES: usize = 64;
/// Rows of the smallest buffers.
const LEAST_ROWS: usize = 256;

/// The shaders' `RobotType`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct TypeLook {
    pub length: f32,
    pub width: f32,
    pub height: f32,
    /// Bit 0: a circle; bit 1: the mesh has its own size; from bit 8 on: the mesh's number.
    pub look: u32,
}

impl TypeLook {
    /// A type drawn as the built-in mesh of its shape.
    pub fn of(record: &RobotTypeRecord) -> Self {
        let round = record.shape() == Shape::Circle;
        let length = sane(record.length);
        let width = if round { length } else { sane(record.width) };
        let height = (0.5 * length.min(width)).clamp(0.05, 2.5);
        Self { length, width, height, look: if round { 1 | 1 << 8 } else { 0 } }
    }

    /// The same, drawn as a mesh that has its own size.
    pub fn with_mesh(self, mesh: usize) -> Self {
        Self { look: self.look & 1 | 2 | (mesh as u32) << 8, ..self }
    }
}

impl Default for TypeLook {
    fn default() -> Self {
        Self { length: 0.9, width: 0.6, height: 0.3, look: 0 }
    }
}

/// A size that can be drawn.
fn sane(metres: f32) -> f32 {
    if metres.is_finite() { metres.clamp(0.05, 100.0) } else { 1.0 }
}

/// The columns.
#[derive(Debug)]
pub struct Columns {
    poses: [Buffer; 2],
    attributes: Buffer,
    types: Buffer,
    layout: BindGroupLayout,
    /// One for either way round of the poses; made when needed.
    groups: [Option<BindGroup>; 2],
    /// Which of the poses are the current ones.
    newest: usize,
    /// Rows that the buffers have room for.
    rows: usize,
    robots: [usize; 2],
    /// Rows that have a value.
    known: usize,
    has_kinds: bool,
    run: u64,
    sim_nanos: u64,
    /// Longest way that a robot drives between the two frames, in metres.
    jump: f32,
}

impl Columns {
    /// Without robots.
    pub fn new(gpu: &Gpu) -> Self {
        let types = buffer(gpu, "robot types", TYPES * size_of::<TypeLook>(), BufferUsages::UNIFORM);
        gpu.queue.write_buffer(&types, 0, bytemuck::cast_slice(&[TypeLook::default(); TYPES]));
        let (poses, attributes) = make(gpu, LEAST_ROWS);
        let kinds = [Kind::Read, Kind::Read, Kind::Read, Kind::Uniform];
        let layout = bindings(gpu, "poses", ShaderStages::VERTEX | ShaderStages::COMPUTE, &kinds);
        Self {
            poses,
            attributes,
            types,
            layout,
            groups: [None, None],
            newest: 0,
            rows: LEAST_ROWS,
            robots: [0; 2],
            known: 0,
            has_kinds: false,
            run: 0,
            sim_nanos: 0,
            jump: 0.0,
        }
    }

    /// Sets how the robot types are drawn.
    pub fn set_types(&self, gpu: &Gpu, types: &[TypeLook]) {
        let mut all = [*types.last().unwrap_or(&TypeLook::default()); TYPES];
        let count = types.len().min(TYPES);
        all[..count].copy_from_slice(&types[..count]);
        gpu.queue.write_buffer(&self.types, 0, bytemuck::cast_slice(&all));
    }

    /// Takes a frame; the one before becomes the previous one.
    pub fn push(&mut self, gpu: &Gpu, frame: &Frame<'_>) {
        self.resize(gpu, frame.len());
        self.newest = 1 - self.newest;
        // Nobody drives from one run into another.
        let before = if frame.run_id() == self.run { self.robots[0] } else { 0 };
        self.robots = [frame.len(), before];
        let nanos = frame.header().sim_time_nanos;
        let passed = nanos.saturating_sub(self.sim_nanos) as f32 * 1e-9;
        // No robot is faster than 50 m/s.
        self.jump = 50.0 * passed + 0.5;
        (self.run, self.sim_nanos) = (frame.run_id(), nanos);
        let columns = frame.columns();
        let poses = &self.poses[self.newest];
        for (place, column) in [columns.x, columns.y, columns.theta].into_iter().enumerate() {
            gpu.queue.write_buffer(poses, self.column(place), bytemuck::cast_slice(column));
        }
        self.write_bytes(gpu, columns.state);
    }

    /// Sets each robot's type.
    pub fn set_kinds(&mut self, gpu: &Gpu, kinds: &[f32]) {
        self.has_kinds = true;
        let count = kinds.len().min(self.rows);
        gpu.queue.write_buffer(&self.attributes, self.column(1), bytemuck::cast_slice(&kinds[..count]));
    }

    /// Sets the values that robots are coloured by; those of further robots are unknown.
    pub fn set_values(&mut self, gpu: &Gpu, values: &[f32]) {
        self.known = values.len().min(self.rows);
        gpu.queue.write_buffer(&self.attributes, 0, bytemuck::cast_slice(&values[..self.known]));
    }

    /// Bytes, four in a word. Uploads are of whole words.
    fn write_bytes(&self, gpu: &Gpu, states: &[u8]) {
        let whole = states.len() / 4 * 4;
        let at = self.column(2);
        gpu.queue.write_buffer(&self.attributes, at, &states[..whole]);
        let rest = &states[whole..];
        if !rest.is_empty() {
            let mut word = [0; 4];
            word[..rest.len()].copy_from_slice(rest);
            gpu.queue.write_buffer(&self.attributes, at + whole as u64, &word);
        }
    }

    /// Where a column begins, in bytes.
    fn column(&self, place: usize) -> u64 {
        (place * self.rows * size_of::<f32>()) as u64
    }

    /// Makes room, or gives much of it back.
    fn resize(&mut self, gpu: &Gpu, robots: usize) {
        if robots <= self.rows && robots * 8 + LEAST_ROWS >= self.rows {
            return;
        }
        // A bit more than needed, in whole groups of rows.
        self.rows = (robots + robots / 8).next_multiple_of(LEAST_ROWS).max(LEAST_ROWS);
        (self.poses, self.attributes) = make(gpu, self.rows);
        (self.robots, self.known, self.has_kinds) = ([0; 2], 0, false);
        self.groups = [None, None];
    }

    /// What shaders see of the columns.
    pub fn layout(&self) -> &BindGroupLayout {
        &self.layout
    }

    /// The columns as they are now.
    pub fn group(&mut self, gpu: &Gpu) -> BindGroup {
        let [previous, current] = [&self.poses[1 - self.newest], &self.poses[self.newest]];
        let buffers = [(0, previous), (1, current), (2, &self.attributes), (3, &self.types)];
        self.groups[self.newest].get_or_insert_with(|| bind(gpu, &self.layout, &buffers)).clone()
    }

    /// Robots in the current and in the previous frame.
    pub fn robots(&self) -> [u32; 2] {
        self.robots.map(|count| count as u32)
    }

    /// Robots of which the value is known.
    pub fn known(&self) -> usize {
        self.known
    }

    /// Whether nobody has said yet of which types the robots are.
    pub fn lacks_kinds(&self) -> bool {
        !self.has_kinds
    }

    /// No robot has a value any more.
    pub fn forget_values(&mut self) {
        self.known = 0;
    }

    /// Rows that the buffers have room for.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Longest way between the two frames that is driven rather than jumped, in metres.
    pub fn jump(&self) -> f32 {
        self.jump
    }
}

fn make(gpu: &Gpu, rows: usize) -> ([Buffer; 2], Buffer) {
    let word = size_of::<f32>();
    let poses = [(); 2].map(|()| buffer(gpu, "poses", 3 * rows * word, BufferUsages::STORAGE));
    (poses, buffer(gpu, "attributes", (2 * rows + rows / 4) * word, BufferUsages::STORAGE))
}

/// A buffer that uploads go into.
pub fn buffer(gpu: &Gpu, label: &str, bytes: usize, usage: BufferUsages) -> Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes as u64,
        usage: usage | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
