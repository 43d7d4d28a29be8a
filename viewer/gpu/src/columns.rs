//! The fleet's columns on the GPU: the poses of two frames, and the attributes that colour and size
//! robots. Each column is uploaded as it is in shared memory.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::Frame;
use regatta_plugin::world::{RobotTypeRecord, Shape};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ShaderStages};

use super::bindings::{Binding, bind_buffers, bind_group_layout};
use super::device::Gpu;
use super::resources::buffer;

/// The number of robot types in the uniform buffer; robots of further types are drawn as the last
/// one.
pub const MAX_ROBOT_TYPES: usize = 64;
/// The number of rows that the smallest buffers have room for.
const MIN_ROWS: usize = 256;
/// The speed above which a move between two frames counts as a teleport, in metres per second.
const MAX_SPEED: f32 = 50.0;
/// Bit 0 of [`RobotTypeUniform::flags`]: the robot is round.
const ROUND: u32 = 1;
/// Bit 1 of [`RobotTypeUniform::flags`]: the mesh has its own size in metres.
const OWN_SIZE: u32 = 2;

/// The shaders' `RobotType`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RobotTypeUniform {
    pub length: f32,
    pub width: f32,
    pub height: f32,
    /// [`ROUND`] and [`OWN_SIZE`]; from bit 8 on the mesh's number.
    pub flags: u32,
}

impl RobotTypeUniform {
    /// Returns a type that is drawn with the built-in mesh of its shape.
    pub fn new(record: &RobotTypeRecord) -> Self {
        let round = record.shape() == Shape::Circle;
        let length = drawable(record.length);
        let width = if round { length } else { drawable(record.width) };
        let height = (0.5 * length.min(width)).clamp(0.05, 2.5);
        Self { length, width, height, flags: if round { ROUND | 1 << 8 } else { 0 } }
    }

    /// Draws the type with a mesh that has its own size.
    pub fn with_mesh(self, mesh: usize) -> Self {
        Self { flags: self.flags & ROUND | OWN_SIZE | (mesh as u32) << 8, ..self }
    }

    /// Whether robots of the type are round.
    pub fn is_round(&self) -> bool {
        self.flags & ROUND != 0
    }
}

impl Default for RobotTypeUniform {
    fn default() -> Self {
        Self { length: 0.9, width: 0.6, height: 0.3, flags: 0 }
    }
}

/// Limits a length to a range that can be drawn.
fn drawable(metres: f32) -> f32 {
    if metres.is_finite() { metres.clamp(0.05, 100.0) } else { 1.0 }
}

/// The fleet's columns.
#[derive(Debug)]
pub struct Columns {
    poses: [Buffer; 2],
    attributes: Buffer,
    robot_types: Buffer,
    layout: BindGroupLayout,
    /// A bind group for either order of the two pose buffers, created when needed.
    groups: [Option<BindGroup>; 2],
    /// Index of the pose buffer with the newest frame.
    newest: usize,
    /// Rows that the buffers have room for.
    rows: usize,
    /// Robots in the newest frame.
    robots: usize,
    /// Robots in the frame before.
    previous_robots: usize,
    /// Rows that have a value.
    values: usize,
    has_robot_type_column: bool,
    /// The robots that match the filter, and those on the level that is shown, a bit each; empty
    /// for all robots.
    sets: [Vec<u32>; 2],
    run: u64,
    sim_nanos: u64,
    teleport_distance: f32,
}

impl Columns {
    /// Creates the buffers of an empty fleet.
    pub fn new(gpu: &Gpu) -> Self {
        let bytes = MAX_ROBOT_TYPES * size_of::<RobotTypeUniform>();
        let robot_types = buffer(gpu, "robot types", bytes, BufferUsages::UNIFORM);
        let defaults = [RobotTypeUniform::default(); MAX_ROBOT_TYPES];
        gpu.queue.write_buffer(&robot_types, 0, bytemuck::cast_slice(&defaults));
        let (poses, attributes) = column_buffers(gpu, MIN_ROWS);
        let bindings = [Binding::Read, Binding::Read, Binding::Read, Binding::Uniform];
        let stages = ShaderStages::VERTEX | ShaderStages::COMPUTE;
        let layout = bind_group_layout(gpu, "poses", stages, &bindings);
        Self {
            poses,
            attributes,
            robot_types,
            layout,
            groups: [None, None],
            newest: 0,
            rows: MIN_ROWS,
            robots: 0,
            previous_robots: 0,
            values: 0,
            has_robot_type_column: false,
            sets: [Vec::new(), Vec::new()],
            run: 0,
            sim_nanos: 0,
            teleport_distance: 0.0,
        }
    }

    /// Uploads the robot types.
    pub fn set_robot_types(&self, gpu: &Gpu, robot_types: &[RobotTypeUniform]) {
        let mut all =
            [*robot_types.last().unwrap_or(&RobotTypeUniform::default()); MAX_ROBOT_TYPES];
        let count = robot_types.len().min(MAX_ROBOT_TYPES);
        all[..count].copy_from_slice(&robot_types[..count]);
        gpu.queue.write_buffer(&self.robot_types, 0, bytemuck::cast_slice(&all));
    }

    /// Uploads a frame; the newest one so far becomes the previous one.
    pub fn push(&mut self, gpu: &Gpu, frame: &Frame<'_>) {
        self.resize(gpu, frame.len());
        self.newest = 1 - self.newest;
        // Poses of two runs can't be interpolated.
        self.previous_robots = if frame.run_id() == self.run { self.robots } else { 0 };
        self.robots = frame.len();
        let nanos = frame.header().sim_time_nanos;
        let passed = nanos.saturating_sub(self.sim_nanos) as f32 * 1e-9;
        self.teleport_distance = MAX_SPEED * passed + 0.5;
        (self.run, self.sim_nanos) = (frame.run_id(), nanos);
        let columns = frame.columns();
        let poses = &self.poses[self.newest];
        for (index, column) in [columns.x, columns.y, columns.theta].into_iter().enumerate() {
            gpu.queue.write_buffer(poses, self.column_offset(index), bytemuck::cast_slice(column));
        }
        self.write_states(gpu, columns.state);
    }

    /// Uploads each robot's index into the robot types.
    pub fn set_robot_type_column(&mut self, gpu: &Gpu, robot_type: &[f32]) {
        self.has_robot_type_column = true;
        let count = robot_type.len().min(self.rows);
        let bytes = bytemuck::cast_slice(&robot_type[..count]);
        gpu.queue.write_buffer(&self.attributes, self.column_offset(1), bytes);
    }

    /// Uploads the values that robots are coloured by. Robots beyond the end of `values` have none.
    pub fn set_values(&mut self, gpu: &Gpu, values: Option<&[f32]>) {
        let values = values.unwrap_or_default();
        self.values = values.len().min(self.rows);
        gpu.queue.write_buffer(&self.attributes, 0, bytemuck::cast_slice(&values[..self.values]));
    }

    /// Sets the robots that are not dimmed, or with `None` all: a bit per robot, 32 to a word.
    /// Robots beyond the end are dimmed.
    pub fn set_matches(&mut self, gpu: &Gpu, matches: Option<&[u32]>) {
        self.set_robots(gpu, 0, matches);
    }

    /// Sets the robots that are not hidden, or with `None` all: a bit per robot, 32 to a word.
    /// Robots beyond the end are hidden.
    pub fn set_on_level(&mut self, gpu: &Gpu, on_level: Option<&[u32]>) {
        self.set_robots(gpu, 1, on_level);
    }

    /// The shaders' `view.filtered`.
    pub fn filtered(&self) -> u32 {
        self.sets.iter().zip(0..).map(|(set, index)| u32::from(!set.is_empty()) << index).sum()
    }

    fn set_robots(&mut self, gpu: &Gpu, index: usize, robots: Option<&[u32]>) {
        self.sets[index].clear();
        self.sets[index].extend_from_slice(robots.unwrap_or_default());
        self.write_sets(gpu);
    }

    fn write_sets(&mut self, gpu: &Gpu) {
        let (rows, first) = (self.rows, self.column_offset(2) + self.rows as u64);
        for (set, index) in self.sets.iter_mut().zip(0..).filter(|(set, _)| !set.is_empty()) {
            // Bits of robots that have left the fleet are not cut off by a smaller buffer, but by
            // the number of rows.
            set.resize(rows / 32, 0);
            let at = first + index * (rows / 8) as u64;
            gpu.queue.write_buffer(&self.attributes, at, bytemuck::cast_slice(set));
        }
    }

    /// Uploads the states, four to a word. wgpu accepts uploads of whole words only.
    fn write_states(&self, gpu: &Gpu, states: &[u8]) {
        let whole = states.len() / 4 * 4;
        let at = self.column_offset(2);
        gpu.queue.write_buffer(&self.attributes, at, &states[..whole]);
        let rest = &states[whole..];
        if !rest.is_empty() {
            let mut word = [0; 4];
            word[..rest.len()].copy_from_slice(rest);
            gpu.queue.write_buffer(&self.attributes, at + whole as u64, &word);
        }
    }

    /// The offset of a column in its buffer, in bytes.
    fn column_offset(&self, index: usize) -> u64 {
        (index * self.rows * size_of::<f32>()) as u64
    }

    /// Grows the buffers if they are too small, or shrinks them if they are far too large.
    fn resize(&mut self, gpu: &Gpu, robots: usize) {
        if robots <= self.rows && robots * 8 + MIN_ROWS >= self.rows {
            return;
        }
        // Some spare rows, so that a growing fleet seldom needs new buffers.
        self.rows = (robots + robots / 8).next_multiple_of(MIN_ROWS).max(MIN_ROWS);
        (self.poses, self.attributes) = column_buffers(gpu, self.rows);
        (self.robots, self.previous_robots, self.values) = (0, 0, 0);
        self.has_robot_type_column = false;
        self.groups = [None, None];
        self.write_sets(gpu);
    }

    /// The layout of the columns' bind group.
    pub fn layout(&self) -> &BindGroupLayout {
        &self.layout
    }

    /// Returns the bind group of the current columns.
    pub fn group(&mut self, gpu: &Gpu) -> BindGroup {
        let (previous, current) = (&self.poses[1 - self.newest], &self.poses[self.newest]);
        let buffers = [previous, current, &self.attributes, &self.robot_types];
        self.groups[self.newest]
            .get_or_insert_with(|| bind_buffers(gpu, &self.layout, &buffers))
            .clone()
    }

    /// Robots in the newest frame.
    pub fn robots(&self) -> u32 {
        self.robots as u32
    }

    /// Robots in the frame before.
    pub fn previous_robots(&self) -> u32 {
        self.previous_robots as u32
    }

    /// Robots that have a value.
    pub fn values(&self) -> usize {
        self.values
    }

    /// Whether the column of robot types hasn't been uploaded into the current buffers.
    pub fn lacks_robot_type_column(&self) -> bool {
        !self.has_robot_type_column
    }

    /// Rows that the buffers have room for.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The distance between two frames' positions from which on a robot is teleported rather than
    /// moved, in metres.
    pub fn teleport_distance(&self) -> f32 {
        self.teleport_distance
    }
}

fn column_buffers(gpu: &Gpu, rows: usize) -> ([Buffer; 2], Buffer) {
    let word = size_of::<f32>();
    let poses = [(); 2].map(|()| buffer(gpu, "poses", 3 * rows * word, BufferUsages::STORAGE));
    let attributes = (2 * rows + rows / 4 + 2 * rows / 32) * word;
    (poses, buffer(gpu, "attributes", attributes, BufferUsages::STORAGE))
}
