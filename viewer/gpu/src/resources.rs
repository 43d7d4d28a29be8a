//! Buffers, textures, samplers, render passes, and the way of pixels back to the processor.

use glam::UVec2;
use wgpu::{
    Buffer, BufferUsages, Color, CommandEncoder, LoadOp, Operations, RenderPass,
    RenderPassColorAttachment, RenderPassDepthStencilAttachment, Sampler, StoreOp, Texture,
    TextureFormat, TextureUsages, TextureView,
};

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
        size: extent(size.max(UVec2::ONE)),
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Returns the extent of a single layer of `size` texels.
pub fn extent(size: UVec2) -> wgpu::Extent3d {
    wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}

/// Creates a view of a whole texture.
pub fn view_of(texture: &Texture) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Creates a sampler that interpolates between texels, and between mip levels.
pub fn linear_sampler(gpu: &Gpu) -> Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}

/// Begins a render pass without depth into a view, which is cleared to a colour or kept.
pub fn begin_pass<'a>(
    encoder: &'a mut CommandEncoder,
    label: &str,
    view: &TextureView,
    load: LoadOp<Color>,
) -> RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(stored(view, load))],
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// Returns an attachment of colours that are stored after the pass.
pub fn stored(view: &TextureView, load: LoadOp<Color>) -> RenderPassColorAttachment<'_> {
    RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: Operations { load, store: StoreOp::Store },
    }
}

/// Returns an attachment of depth that starts at infinity and is dropped after the pass.
pub fn far_depth(view: &TextureView) -> RenderPassDepthStencilAttachment<'_> {
    RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
        stencil_ops: None,
    }
}

/// Reads textures of four bytes a texel, all of one size.
#[derive(Debug)]
pub struct Readback {
    size: UVec2,
    buffer: Buffer,
}

impl Readback {
    /// Creates the buffer for textures of `size` texels.
    pub fn new(gpu: &Gpu, size: UVec2) -> Self {
        let buffer = buffer(gpu, "readback", Self::bytes(size) as usize, BufferUsages::MAP_READ);
        Self { size, buffer }
    }

    /// The size of the buffer.
    pub fn bytes(size: UVec2) -> u64 {
        u64::from(row_bytes(size)) * u64::from(size.y)
    }

    /// Submits the commands that draw into a texture, waits for them, and returns the bytes of its
    /// texels row by row.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn read(
        &self,
        gpu: &Gpu,
        mut encoder: CommandEncoder,
        texture: &Texture,
    ) -> Result<Vec<u8>, wgpu::MapRangeError> {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes(self.size)),
            rows_per_image: None,
        };
        let target = wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
        gpu.queue.submit([encoder.finish()]);
        self.buffer.map_async(wgpu::MapMode::Read, .., |_| ());
        gpu.wait();
        let mapped = self.buffer.get_mapped_range(..)?;
        let rows = mapped.chunks(row_bytes(self.size) as usize);
        let texels = rows.flat_map(|row| &row[..self.size.x as usize * 4]).copied().collect();
        drop(mapped);
        self.buffer.unmap();
        Ok(texels)
    }
}

/// The stride of the rows in the buffer, which wgpu aligns to 256 bytes.
fn row_bytes(size: UVec2) -> u32 {
    (size.x * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}
