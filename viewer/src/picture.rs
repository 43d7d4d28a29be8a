//! A picture in memory: drawn offscreen, read back, written to a file.

use std::path::{Path, PathBuf};

use glam::UVec2;
use image::RgbaImage;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

use crate::gpu::device::Gpu;
use crate::gpu::frame::{texture, view_of};

/// Of pictures that are read back.
pub const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Larger than the adapter's textures.
    #[error("a picture of {0}x{1} is too large for this adapter: {2} pixels is its limit in either direction")]
    TooLarge(u32, u32, u32),
    /// The device was lost on the way.
    #[error("the graphics device was lost ({0}); start again")]
    Lost(String),
    /// It can't be written.
    #[error("can't write {}: {reason}", path.display())]
    Write {
        /// Where to.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

/// A texture to draw into, and the way back from it.
#[derive(Debug)]
pub struct Offscreen {
    gpu: Gpu,
    size: UVec2,
    texture: wgpu::Texture,
    /// All of the texture.
    pub view: wgpu::TextureView,
    back: wgpu::Buffer,
}

impl Offscreen {
    /// Makes one of `size` pixels.
    ///
    /// # Errors
    /// [`PictureError::TooLarge`].
    pub fn new(gpu: &Gpu, size: UVec2) -> Result<Self, PictureError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.max_element() > limit || size.min_element() == 0 {
            return Err(PictureError::TooLarge(size.x, size.y, limit));
        }
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = texture(gpu, size, FORMAT, 1, usage);
        let back = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: u64::from(row_bytes(size)) * u64::from(size.y),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Ok(Self { gpu: gpu.clone(), size, view: view_of(&texture), texture, back })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Submits what draws into the texture, and gives what it drew.
    ///
    /// # Errors
    /// [`PictureError::Lost`].
    pub fn read(&self, mut encoder: wgpu::CommandEncoder) -> Result<RgbaImage, PictureError> {
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes(self.size)), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.back, layout },
            self.texture.size(),
        );
        self.gpu.queue.submit([encoder.finish()]);
        self.back.map_async(wgpu::MapMode::Read, .., |_| ());
        self.gpu.wait();
        let lost = |reason: String| PictureError::Lost(self.gpu.lost().unwrap_or(reason));
        let mapped = self.back.get_mapped_range(..).map_err(|error| lost(error.to_string()))?;
        let rows = mapped.chunks(row_bytes(self.size) as usize);
        let pixels = rows.flat_map(|row| &row[..self.size.x as usize * 4]).copied().collect();
        drop(mapped);
        self.back.unmap();
        RgbaImage::from_raw(self.size.x, self.size.y, pixels).ok_or_else(|| lost("too few pixels".to_owned()))
    }
}

/// Rows in a buffer begin at multiples of 256 bytes.
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
