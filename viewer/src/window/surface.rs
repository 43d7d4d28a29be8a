//! The window's surface: what is drawn is presented there. It comes and goes with the window's size, the screen and
//! the driver.

use std::sync::Arc;

use glam::UVec2;
use wgpu::{
    CompositeAlphaMode, CurrentSurfaceTexture, PresentMode, Surface, SurfaceColorSpace, SurfaceConfiguration,
    SurfaceTexture, TextureFormat, TextureUsages, TextureView,
};
use winit::window::Window;

use crate::gpu::device::{DeviceError, Gpu};

/// Pictures that may be on their way to the screen.
const LATENCY: u32 = 2;

/// A surface, and how it is set up.
#[derive(Debug)]
pub struct Screen {
    surface: Surface<'static>,
    config: Option<SurfaceConfiguration>,
    /// Of the fleet's picture: its shaders compute in light.
    pub fleet: TextureFormat,
    /// Of the interface: its colours are blended as they are seen.
    pub interface: TextureFormat,
}

/// A picture to be drawn.
#[derive(Debug)]
pub struct Canvas {
    texture: SurfaceTexture,
    /// For the fleet.
    pub fleet: TextureView,
    /// For the interface.
    pub interface: TextureView,
    /// In pixels.
    pub size: UVec2,
}

/// Why there is nothing to draw on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoCanvas {
    /// The window is hidden, or has no size.
    Hidden,
    /// Not now; try the next time.
    Later,
    /// The surface is gone: make another one.
    Lost,
}

/// A window's surface, not set up yet.
///
/// # Errors
/// If the window's system and the graphics drivers don't know each other.
pub fn surface_of(instance: &wgpu::Instance, window: &Arc<Window>) -> Result<Surface<'static>, DeviceError> {
    instance.create_surface(Arc::clone(window)).map_err(|error| {
        tracing::debug!(%error, "no surface");
        DeviceError::NoAdapter
    })
}

impl Screen {
    /// Sets a surface up for a device.
    ///
    /// # Errors
    /// If the device can't draw on it.
    pub fn new(surface: Surface<'static>, gpu: &Gpu, size: UVec2) -> Result<Self, DeviceError> {
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let plain = [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm];
        let wanted = plain.into_iter().find(|format| formats.contains(format)).or(formats.first().copied());
        let interface = wanted.ok_or_else(|| DeviceError::Refused {
            adapter: gpu.info.name.clone(),
            reason: "it can't draw into this window".into(),
        })?;
        let mut screen = Self { surface, config: None, fleet: interface.add_srgb_suffix(), interface };
        screen.resize(gpu, size);
        Ok(screen)
    }

    /// Fits the surface to the window.
    pub fn resize(&mut self, gpu: &Gpu, size: UVec2) {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if size.min_element() == 0 {
            self.config = None;
            return;
        }
        let size = size.min(UVec2::splat(limit));
        let config = SurfaceConfiguration {
            usage: TextureUsages::RENDER_ATTACHMENT,
            format: self.interface,
            color_space: SurfaceColorSpace::Auto,
            width: size.x,
            height: size.y,
            present_mode: PresentMode::AutoVsync,
            desired_maximum_frame_latency: LATENCY,
            alpha_mode: CompositeAlphaMode::Auto,
            view_formats: vec![self.fleet],
        };
        self.surface.configure(&gpu.device, &config);
        self.config = Some(config);
    }

    /// The next picture to draw.
    ///
    /// # Errors
    /// [`NoCanvas`].
    pub fn acquire(&mut self, gpu: &Gpu) -> Result<Canvas, NoCanvas> {
        let config = self.config.as_ref().ok_or(NoCanvas::Hidden)?;
        let size = UVec2::new(config.width, config.height);
        let texture = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => texture,
            CurrentSurfaceTexture::Occluded => return Err(NoCanvas::Hidden),
            CurrentSurfaceTexture::Timeout => return Err(NoCanvas::Later),
            CurrentSurfaceTexture::Outdated => {
                self.resize(gpu, size);
                return Err(NoCanvas::Later);
            }
            CurrentSurfaceTexture::Lost | CurrentSurfaceTexture::Validation => return Err(NoCanvas::Lost),
        };
        let view = |format| {
            let descriptor = wgpu::TextureViewDescriptor { format: Some(format), ..Default::default() };
            texture.texture.create_view(&descriptor)
        };
        Ok(Canvas { fleet: view(self.fleet), interface: view(self.interface), size, texture })
    }
}

impl Canvas {
    /// Gives the picture to the screen, when all that draws it was submitted.
    pub fn present(self, gpu: &Gpu) {
        gpu.queue.present(self.texture);
    }
}
