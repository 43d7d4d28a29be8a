//! Instances that are drawn by one pipeline, are replaced as a whole, and change in number.

use std::marker::PhantomData;

use bytemuck::NoUninit;
use glam::Vec2;
use regatta_scene::facilities::Bar;
use regatta_scene::plans::{GoalMark, WaitArrow};
use regatta_scene::route::RouteSegment;
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, RenderPass, RenderPipeline, ShaderModule,
    VertexAttribute, VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::pipeline::{PipelineDescriptor, TargetConfig, render_pipeline};
use super::resources::buffer;

/// The number of instances that the smallest buffer has room for.
const LEAST: usize = 64;
/// The largest buffer, in bytes: instances beyond are left out.
const MAX_BYTES: usize = 64 << 20;

/// The data of an instance in a vertex buffer.
pub trait Instance: NoUninit {
    /// The shader's inputs.
    const ATTRIBUTES: &'static [VertexAttribute];
}

/// An index into a storage buffer.
impl Instance for u32 {
    const ATTRIBUTES: &'static [VertexAttribute] = &vertex_attr_array![0 => Uint32];
}

impl Instance for Vec2 {
    const ATTRIBUTES: &'static [VertexAttribute] = &vertex_attr_array![0 => Float32x2];
}

impl Instance for Bar {
    const ATTRIBUTES: &'static [VertexAttribute] = &vertex_attr_array![0 => Float32x4, 1 => Uint32];
}

impl Instance for RouteSegment {
    const ATTRIBUTES: &'static [VertexAttribute] =
        &vertex_attr_array![0 => Uint32, 1 => Float32x2, 2 => Uint32];
}

impl Instance for GoalMark {
    const ATTRIBUTES: &'static [VertexAttribute] = &vertex_attr_array![0 => Uint32, 1 => Uint32];
}

impl Instance for WaitArrow {
    const ATTRIBUTES: &'static [VertexAttribute] =
        &vertex_attr_array![0 => Uint32, 1 => Uint32, 2 => Uint32];
}

/// Instances on the GPU, and the pipeline that draws each of them as a strip of triangles.
#[derive(Debug)]
pub struct Instances<T> {
    pipeline: RenderPipeline,
    /// The vertices of each instance.
    vertices: u32,
    buffer: Buffer,
    count: u32,
    kind: PhantomData<T>,
}

impl<T: Instance> Instances<T> {
    /// Creates an empty buffer and the pipeline. `entries` are the entry points of the vertex and
    /// the fragment shader.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        module: &ShaderModule,
        entries: (&str, &str),
        groups: &[&BindGroupLayout],
        vertices: u32,
    ) -> Self {
        let layout = VertexBufferLayout {
            array_stride: size_of::<T>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: T::ATTRIBUTES,
        };
        let descriptor = PipelineDescriptor {
            buffers: &[layout],
            ..PipelineDescriptor::new(module, entries.0, entries.1, groups)
        };
        Self {
            pipeline: render_pipeline(gpu, target, &descriptor),
            vertices,
            buffer: buffer(gpu, entries.0, LEAST * size_of::<T>(), BufferUsages::VERTEX),
            count: 0,
            kind: PhantomData,
        }
    }

    /// Replaces the instances. The buffer grows as needed.
    pub fn set(&mut self, gpu: &Gpu, instances: &[T]) {
        let instances = &instances[..instances.len().min(MAX_BYTES / size_of::<T>())];
        self.count = instances.len() as u32;
        if (size_of_val(instances) as u64) > self.buffer.size() {
            let bytes = instances.len().next_power_of_two() * size_of::<T>();
            self.buffer = buffer(gpu, "instances", bytes, BufferUsages::VERTEX);
        }
        if !instances.is_empty() {
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(instances));
        }
    }

    /// Draws the instances, if there are any.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        if self.count > 0 {
            pass.set_pipeline(&self.pipeline);
            pass.set_vertex_buffer(0, self.buffer.slice(..));
            pass.draw(0..self.vertices, 0..self.count);
        }
    }
}
