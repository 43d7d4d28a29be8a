//! Constructors of buffers, textures and texture views.

use glam::UVec2;
use wgpu::{Buffer, BufferUsages, Texture, TextureFormat, TextureUsages, TextureView};

use super::device::Gpu;

/// Creates a buffer that the queue can write to.
pub fn buffer(gpu: &Gpu, label: &str, bytes: usize, usage: BufferUsages) -> Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes as u64,
        usage: usage | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Creates a 2D texture without mipmaps, of at least 1x1 texels.
pub fn texture(
    gpu: &Gpu,
    size: UVec2,
    format: TextureFormat,
    samples: u32,
    usage: TextureUsages,
) -> Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size.x.max(1),
            height: size.y.max(1),
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Creates a view of a whole texture.
pub fn view_of(texture: &Texture) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
