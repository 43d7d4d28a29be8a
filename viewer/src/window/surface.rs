//! The window's surface, on which pictures are presented. It is reconfigured or recreated when the
//! window's size, the screen or the driver change.

use std::sync::Arc;

use glam::UVec2;
use image::RgbaImage;
use regatta_gpu::device::{DeviceError, Gpu};
use regatta_gpu::resources::Readback;
use wgpu::{
    CommandEncoder, CompositeAlphaMode, CurrentSurfaceTexture, PresentMode, Surface,
    SurfaceColorSpace, SurfaceConfiguration, SurfaceTexture, Texture, TextureFormat, TextureUsages,
    TextureView,
};
use winit::window::Window;

/// The number of pictures that may be queued for the screen.
const LATENCY: u32 = 2;

/// A surface and its configuration.
#[derive(Debug)]
pub struct WindowSurface {
    surface: Surface<'static>,
    config: Option<SurfaceConfiguration>,
    /// The format of the fleet's picture: sRGB, since its shaders compute in linear light.
    pub fleet_format: TextureFormat,
    /// The format of the interface: not sRGB, since egui blends encoded colours.
    pub interface_format: TextureFormat,
}

/// The texture of one picture.
#[derive(Debug)]
pub struct Canvas {
    texture: Target,
    /// The view for the fleet.
    pub fleet: TextureView,
    /// The view for the interface.
    pub interface: TextureView,
    /// Width and height, in pixels.
    pub size: UVec2,
}

/// The texture of a canvas: of the screen, or one to be read back.
#[derive(Debug)]
enum Target {
    Screen(SurfaceTexture),
    Memory(Texture),
}

/// The reason why there is no canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCanvas {
    /// The window is hidden, or has no size.
    Hidden,
    /// The surface is not ready; try again later.
    Later,
    /// The surface is lost and must be recreated.
    Lost,
}

/// Creates a window's surface, not configured yet.
///
/// # Errors
/// If no graphics driver supports the windowing system.
pub fn create_surface(
    instance: &wgpu::Instance,
    window: &Arc<Window>,
) -> Result<Surface<'static>, DeviceError> {
    instance.create_surface(Arc::clone(window)).map_err(|error| {
        tracing::debug!(%error, "no surface");
        DeviceError::NoAdapter
    })
}

impl WindowSurface {
    /// Configures a surface for a device.
    ///
    /// # Errors
    /// If the device can't draw on it.
    pub fn new(surface: Surface<'static>, gpu: &Gpu, size: UVec2) -> Result<Self, DeviceError> {
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let plain = [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm];
        let preferred =
            plain.into_iter().find(|format| formats.contains(format)).or(formats.first().copied());
        let interface_format = preferred.ok_or_else(|| DeviceError::Refused {
            adapter: gpu.info.name.clone(),
            reason: "it can't draw into this window".into(),
        })?;
        let fleet_format = interface_format.add_srgb_suffix();
        let mut surface = Self { surface, config: None, fleet_format, interface_format };
        surface.resize(gpu, size);
        Ok(surface)
    }

    /// Adapts the surface to the size of the window, in pixels.
    pub fn resize(&mut self, gpu: &Gpu, size: UVec2) {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.min_element() == 0 {
            self.config = None;
            return;
        }
        let size = size.min(UVec2::splat(limit));
        let config = SurfaceConfiguration {
            usage: TextureUsages::RENDER_ATTACHMENT,
            format: self.interface_format,
            color_space: SurfaceColorSpace::Auto,
            width: size.x,
            height: size.y,
            present_mode: PresentMode::AutoVsync,
            desired_maximum_frame_latency: LATENCY,
            alpha_mode: CompositeAlphaMode::Auto,
            view_formats: vec![self.fleet_format],
        };
        self.surface.configure(&gpu.device, &config);
        self.config = Some(config);
    }

    /// Acquires the canvas of the next picture.
    ///
    /// # Errors
    /// [`NoCanvas`] if there is none now.
    pub fn acquire(&mut self, gpu: &Gpu) -> Result<Canvas, NoCanvas> {
        let config = self.config.as_ref().ok_or(NoCanvas::Hidden)?;
        let size = UVec2::new(config.width, config.height);
        let texture = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture)
            | CurrentSurfaceTexture::Suboptimal(texture) => texture,
            CurrentSurfaceTexture::Occluded => return Err(NoCanvas::Hidden),
            CurrentSurfaceTexture::Timeout => return Err(NoCanvas::Later),
            CurrentSurfaceTexture::Outdated => {
                self.resize(gpu, size);
                return Err(NoCanvas::Later);
            }
            CurrentSurfaceTexture::Lost | CurrentSurfaceTexture::Validation => {
                return Err(NoCanvas::Lost);
            }
        };
        let [fleet, interface] = self.views(&texture.texture);
        Ok(Canvas { fleet, interface, size, texture: Target::Screen(texture) })
    }

    /// Creates a canvas like those of the screen, whose picture can be read.
    ///
    /// # Errors
    /// [`NoCanvas::Hidden`] if the window has no size.
    pub fn to_be_read(&self, gpu: &Gpu) -> Result<Canvas, NoCanvas> {
        let config = self.config.as_ref().ok_or(NoCanvas::Hidden)?;
        let size = UVec2::new(config.width, config.height);
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture of the window"),
            size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.interface_format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[self.fleet_format],
        });
        let [fleet, interface] = self.views(&texture);
        Ok(Canvas { fleet, interface, size, texture: Target::Memory(texture) })
    }

    /// The views of a texture for the fleet and for the interface.
    fn views(&self, texture: &Texture) -> [TextureView; 2] {
        [self.fleet_format, self.interface_format].map(|format| {
            let descriptor =
                wgpu::TextureViewDescriptor { format: Some(format), ..Default::default() };
            texture.create_view(&descriptor)
        })
    }
}

impl Canvas {
    /// Submits the commands that draw the picture, and presents it on the screen. Returns the
    /// picture of a canvas [to be read](WindowSurface::to_be_read); `None` if the device was lost.
    pub fn finish(self, gpu: &Gpu, encoder: CommandEncoder) -> Option<RgbaImage> {
        match self.texture {
            Target::Screen(texture) => {
                gpu.queue.submit([encoder.finish()]);
                gpu.queue.present(texture);
                None
            }
            Target::Memory(texture) => {
                let readback = Readback::new(gpu, self.size);
                let mut texels = readback.read(gpu, encoder, &texture).ok()?;
                if texture.format() == TextureFormat::Bgra8Unorm {
                    texels.chunks_exact_mut(4).for_each(|texel| texel.swap(0, 2));
                }
                RgbaImage::from_raw(self.size.x, self.size.y, texels)
            }
        }
    }
}
