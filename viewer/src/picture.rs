//! Offscreen pictures: rendered into a texture, read back, and written to files.

use std::path::{Path, PathBuf};

use glam::UVec2;
use image::RgbaImage;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

use crate::gpu::device::Gpu;
use crate::gpu::resources::view_of;

/// The format of offscreen pictures.
pub const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// The format in which text is drawn over offscreen pictures: it is blended in sRGB rather than in linear colours.
pub const OVERLAY_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// The error of rendering or writing a picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The size exceeds the adapter's texture limit.
    #[error("a picture of {0}x{1} pixels is too large for this adapter, whose limit is {2} in either direction")]
    TooLarge(u32, u32, u32),
    /// The graphics device was lost.
    #[error("the graphics device was lost ({0}); start again")]
    Lost(String),
    /// The file can't be written.
    #[error("can't write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        reason: String,
    },
}

/// A texture to render into, and the buffer that it is read back through.
#[derive(Debug)]
pub struct Offscreen {
    gpu: Gpu,
    size: UVec2,
    texture: wgpu::Texture,
    /// A view of the texture in the [`FORMAT`].
    pub view: wgpu::TextureView,
    /// A view of the texture in the [`OVERLAY_FORMAT`].
    pub overlay: wgpu::TextureView,
    readback: wgpu::Buffer,
}

impl Offscreen {
    /// Creates a texture of `size` pixels.
    ///
    /// # Errors
    /// [`PictureError::TooLarge`].
    pub fn new(gpu: &Gpu, size: UVec2) -> Result<Self, PictureError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.max_element() > limit || size.min_element() == 0 {
            return Err(PictureError::TooLarge(size.x, size.y, limit));
        }
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("offscreen"),
            size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage,
            view_formats: &[OVERLAY_FORMAT],
        });
        let overlay = wgpu::TextureViewDescriptor { format: Some(OVERLAY_FORMAT), ..Default::default() };
        let readback = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(row_bytes(size)) * u64::from(size.y),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Ok(Self {
            gpu: gpu.clone(),
            size,
            view: view_of(&texture),
            overlay: texture.create_view(&overlay),
            texture,
            readback,
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Submits the commands that draw into the texture, waits for them, and returns the picture.
    ///
    /// # Errors
    /// [`PictureError::Lost`].
    pub fn read(&self, mut encoder: wgpu::CommandEncoder) -> Result<RgbaImage, PictureError> {
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes(self.size)), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.readback, layout },
            self.texture.size(),
        );
        self.gpu.queue.submit([encoder.finish()]);
        self.readback.map_async(wgpu::MapMode::Read, .., |_| ());
        self.gpu.wait();
        let lost = |reason: String| PictureError::Lost(self.gpu.lost().unwrap_or(reason));
        let mapped = self.readback.get_mapped_range(..).map_err(|error| lost(error.to_string()))?;
        let rows = mapped.chunks(row_bytes(self.size) as usize);
        let pixels = rows.flat_map(|row| &row[..self.size.x as usize * 4]).copied().collect();
        drop(mapped);
        self.readback.unmap();
        RgbaImage::from_raw(self.size.x, self.size.y, pixels)
            .ok_or_else(|| lost("the buffer has too few pixels".to_owned()))
    }
}

/// The stride of the rows in the readback buffer, which wgpu aligns to 256 bytes.
fn row_bytes(size: UVec2) -> u32 {
    (size.x * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Writes a picture as PNG.
///
/// # Errors
/// [`PictureError::Write`].
pub fn write_png(picture: &RgbaImage, path: &Path) -> Result<(), PictureError> {
    let failed = |reason: String| PictureError::Write { path: path.to_owned(), reason };
    let file = std::fs::File::create(path).map_err(|error| failed(error.to_string()))?;
    let encoder = image::codecs::png::PngEncoder::new(std::io::BufWriter::new(file));
    picture.write_with_encoder(encoder).map_err(|error| failed(error.to_string()))
}
