//! Offscreen pictures: rendered into a texture, read back, and written to files.

use std::path::{Path, PathBuf};

use glam::UVec2;
use image::RgbaImage;
use regatta_gpu::TargetConfig;
use regatta_gpu::attachments::Attachments;
use regatta_gpu::device::{DeviceError, Gpu};
use regatta_gpu::resources::{Readback, begin_pass, extent, view_of};
use regatta_interface::text::with_plural;
use regatta_scene::palette::Rgb;
use wgpu::{TextureFormat, TextureUsages};

/// The format of offscreen pictures.
pub const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// The format in which text is drawn over offscreen pictures: it is blended in sRGB rather than in
/// linear colours.
pub const OVERLAY_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// The error of rendering or writing a picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The size exceeds the limits of the adapter, or its memory.
    #[error(
        "a picture of {}x{} pixels with {} each doesn't fit into this adapter; the largest of this \
         shape is {}x{}",
        size.x, size.y, with_plural((*samples).into(), "sample"), largest.x, largest.y
    )]
    TooLarge {
        /// Width and height.
        size: UVec2,
        /// Samples per pixel.
        samples: u32,
        /// The largest possible width and height.
        largest: UVec2,
    },
    /// The adapter's memory is full.
    #[error(transparent)]
    OutOfMemory(#[from] DeviceError),
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
    readback: Readback,
}

impl Offscreen {
    /// Creates a texture of `size` pixels for a renderer with this target, for whose own textures
    /// there is room, too.
    ///
    /// # Errors
    /// [`PictureError::TooLarge`].
    pub fn new(gpu: &Gpu, size: UVec2, target: TargetConfig) -> Result<Self, PictureError> {
        Self::allocate(gpu, size, target).ok_or_else(|| PictureError::TooLarge {
            size,
            samples: target.samples,
            largest: largest(gpu, size, target),
        })
    }

    /// Returns `None` if the adapter has no room.
    fn allocate(gpu: &Gpu, size: UVec2, target: TargetConfig) -> Option<Self> {
        let limits = gpu.device.limits();
        let is_within = size.min_element() > 0
            && size.max_element() <= limits.max_texture_dimension_2d
            && Readback::bytes(size) <= limits.max_buffer_size;
        // A software adapter hands out more than the machine has, and the system then kills the
        // process.
        let available = available_memory().filter(|_| gpu.is_software());
        if !is_within || available.is_some_and(|bytes| bytes_of(size, target.samples) > bytes) {
            return None;
        }
        let (offscreen, attachments) =
            gpu.allocate(|| (Self::create(gpu, size), Attachments::new(gpu, target, size)))?;
        drop(attachments);
        gpu.poll();
        Some(offscreen)
    }

    fn create(gpu: &Gpu, size: UVec2) -> Self {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("offscreen"),
            size: extent(size),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage,
            view_formats: &[OVERLAY_FORMAT],
        });
        let overlay =
            wgpu::TextureViewDescriptor { format: Some(OVERLAY_FORMAT), ..Default::default() };
        Self {
            gpu: gpu.clone(),
            size,
            view: view_of(&texture),
            overlay: texture.create_view(&overlay),
            texture,
            readback: Readback::new(gpu, size),
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Fills the texture with a colour.
    pub fn fill(&self, encoder: &mut wgpu::CommandEncoder, colour: Rgb) {
        let [r, g, b] = colour.linear().to_array().map(f64::from);
        let colour = wgpu::Color { r, g, b, a: 1.0 };
        begin_pass(encoder, "fill", &self.view, wgpu::LoadOp::Clear(colour));
    }

    /// Submits the commands that draw into the texture, waits for them, and returns the picture.
    ///
    /// # Errors
    /// [`PictureError::Lost`] and [`PictureError::OutOfMemory`].
    pub fn read(&self, encoder: wgpu::CommandEncoder) -> Result<RgbaImage, PictureError> {
        let read = self.readback.read(&self.gpu, encoder, &self.texture);
        self.gpu.check_memory()?;
        let pixels = read.map_err(|error| {
            PictureError::Lost(self.gpu.lost().unwrap_or_else(|| error.to_string()))
        })?;
        Ok(RgbaImage::from_raw(self.size.x, self.size.y, pixels).expect("a buffer of all pixels"))
    }
}

/// Returns the memory that a picture takes: the texture, the buffer to read it, the picture, and
/// the renderer's depth and samples, with four bytes for each.
fn bytes_of(size: UVec2, samples: u32) -> u64 {
    let layers = 3 + samples + if samples > 1 { samples } else { 0 };
    size.as_u64vec2().element_product() * 4 * u64::from(layers)
}

/// Returns the largest size of the same shape for which there is room.
fn largest(gpu: &Gpu, size: UVec2, target: TargetConfig) -> UVec2 {
    const PARTS: u64 = 4096;
    let (mut low, mut high) = (0, PARTS);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if Offscreen::allocate(gpu, scaled(size, middle, PARTS), target).is_some() {
            low = middle
        } else {
            high = middle
        }
    }
    scaled(size, low, PARTS)
}

/// Returns a size scaled by `part` of `parts`, of at least 1x1 pixels.
fn scaled(size: UVec2, part: u64, parts: u64) -> UVec2 {
    (size.as_u64vec2() * part / parts).as_uvec2().max(UVec2::ONE)
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

/// Returns the bytes of main memory that are available; `None` where the system doesn't tell.
fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}
