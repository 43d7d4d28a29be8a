//! Meshes on the GPU.

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{Buffer, BufferUsages};

use crate::device::Gpu;
use crate::mesh::Mesh;

/// A mesh's vertex and index buffers.
#[derive(Debug)]
pub struct MeshBuffers {
    pub vertices: Buffer,
    pub indices: Buffer,
    /// The number of indices.
    pub count: u32,
}

impl MeshBuffers {
    /// Uploads a mesh.
    pub fn new(gpu: &Gpu, mesh: &Mesh) -> Self {
        Self {
            vertices: init_buffer(gpu, bytemuck::cast_slice(&mesh.vertices), BufferUsages::VERTEX),
            indices: init_buffer(gpu, bytemuck::cast_slice(&mesh.indices), BufferUsages::INDEX),
            count: mesh.indices.len() as u32,
        }
    }
}

/// Creates a buffer with these contents.
pub fn init_buffer(gpu: &Gpu, contents: &[u8], usage: BufferUsages) -> Buffer {
    gpu.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
}
