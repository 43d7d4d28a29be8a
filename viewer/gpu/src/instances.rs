//! A buffer of instances that are replaced as a whole, and whose number changes.

use std::marker::PhantomData;

use bytemuck::NoUninit;
use wgpu::{Buffer, BufferUsages, RenderPass};

use super::device::Gpu;
use super::resources::buffer;

/// The number of instances that the smallest buffer has room for.
const LEAST: usize = 64;
/// The largest buffer, in bytes: instances beyond are left out.
const MAX_BYTES: usize = 64 << 20;

/// Instances on the GPU.
#[derive(Debug)]
pub struct Instances<T> {
    label: &'static str,
    buffer: Buffer,
    count: u32,
    kind: PhantomData<T>,
}

impl<T: NoUninit> Instances<T> {
    /// Creates an empty buffer.
    pub fn new(gpu: &Gpu, label: &'static str) -> Self {
        let buffer = buffer(gpu, label, LEAST * size_of::<T>(), BufferUsages::VERTEX);
        Self { label, buffer, count: 0, kind: PhantomData }
    }

    /// Replaces the instances. The buffer grows as needed.
    pub fn set(&mut self, gpu: &Gpu, instances: &[T]) {
        let instances = &instances[..instances.len().min(MAX_BYTES / size_of::<T>())];
        self.count = instances.len() as u32;
        if (size_of_val(instances) as u64) > self.buffer.size() {
            let room = instances.len().next_power_of_two();
            self.buffer = buffer(gpu, self.label, room * size_of::<T>(), BufferUsages::VERTEX);
        }
        if !instances.is_empty() {
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(instances));
        }
    }

    /// The number of instances.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Draws the instances, each with so many vertices.
    pub fn draw(&self, pass: &mut RenderPass<'_>, vertices: u32) {
        pass.set_vertex_buffer(0, self.buffer.slice(..));
        pass.draw(0..vertices, 0..self.count);
    }
}
