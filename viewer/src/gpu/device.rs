//! The adapter and its device.

use std::sync::{Arc, Mutex};

use wgpu::{Backends, DeviceType, Features, InstanceDescriptor, InstanceFlags, Limits, PowerPreference};

/// Why there is no device to draw with.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// No driver that this program can use.
    #[error(
        "no graphics adapter: install a Vulkan driver (on Debian and Ubuntu `apt install mesa-vulkan-drivers` has one that needs no graphics card)"
    )]
    NoAdapter,
    /// The adapter lacks something.
    #[error("the adapter {adapter} can't be used: {reason}; install another Vulkan driver, or update this one")]
    Refused {
        /// Its name.
        adapter: String,
        /// What the driver or wgpu said.
        reason: String,
    },
}

/// A device and its queue, and what is known about it. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// What makes buffers, textures and pipelines.
    pub device: wgpu::Device,
    /// What takes uploads and commands.
    pub queue: wgpu::Queue,
    /// What the device was opened on: it knows what surfaces can do.
    pub adapter: wgpu::Adapter,
    /// The adapter's name, driver and kind.
    pub info: wgpu::AdapterInfo,
    lost: Arc<Mutex<Option<String>>>,
}

/// How this program uses wgpu.
pub fn instance() -> wgpu::Instance {
    wgpu::Instance::new(InstanceDescriptor {
        backends: Backends::PRIMARY,
        // Indirect draws take only counts that our own shader wrote: checking them costs a dispatch per draw.
        flags: InstanceFlags::from_build_config().difference(InstanceFlags::VALIDATION_INDIRECT_CALL).with_env(),
        ..InstanceDescriptor::new_without_display_handle()
    })
}

impl Gpu {
    /// Opens the best adapter that can draw on `surface`, or offscreen without one. `WGPU_ADAPTER_NAME` (a part of
    /// its name) chooses another.
    ///
    /// # Errors
    /// [`DeviceError`] if there is none, or it lacks something.
    pub fn open(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<Self, DeviceError> {
        Self::from_adapter(&choose(instance, surface)?)
    }

    /// Opens an adapter that draws on the processor: all of them draw the same.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn software() -> Result<Self, DeviceError> {
        let options =
            wgpu::RequestAdapterOptions { force_fallback_adapter: true, ..wgpu::RequestAdapterOptions::default() };
        let adapter = pollster::block_on(instance().request_adapter(&options)).map_err(|_| DeviceError::NoAdapter)?;
        Self::from_adapter(&adapter)
    }

    fn from_adapter(adapter: &wgpu::Adapter) -> Result<Self, DeviceError> {
        let info = adapter.get_info();
        let optional = Features::TIMESTAMP_QUERY;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("viewer"),
            required_features: adapter.features() & optional,
            required_limits: limits(&adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| DeviceError::Refused { adapter: info.name.clone(), reason: error.to_string() })?;
        let lost = Arc::new(Mutex::new(None));
        let note = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            if let Ok(mut lost) = note.lock() {
                *lost = Some(format!("{reason:?}: {message}"));
            }
        });
        Ok(Self { device, queue, adapter: adapter.clone(), info, lost })
    }

    /// Opens the best adapter for drawing offscreen.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn offscreen() -> Result<Self, DeviceError> {
        Self::open(&instance(), None)
    }

    /// Whether the processor does the drawing.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Why the device is gone, if it is: then all that was made with it has to be made anew.
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().ok()?.clone()
    }

    /// Waits until all that was submitted is done.
    pub fn wait(&self) {
        // A device that is lost has nothing left to do; whoever asks `lost` learns of it.
        if let Err(error) = self.device.poll(wgpu::PollType::wait_indefinitely()) {
            tracing::debug!(%error, "waiting for the device");
        }
    }

    /// Takes note of what the GPU has finished, without waiting.
    pub fn poll(&self) {
        if let Err(error) = self.device.poll(wgpu::PollType::Poll) {
            tracing::debug!(%error, "asking the device");
        }
    }
}

fn choose(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<wgpu::Adapter, DeviceError> {
    if let Ok(wanted) = std::env::var("WGPU_ADAPTER_NAME") {
        let mut all = pollster::block_on(instance.enumerate_adapters(Backends::PRIMARY)).into_iter();
        return all
            .find(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted.to_lowercase()))
            .ok_or(DeviceError::NoAdapter);
    }
    let options = wgpu::RequestAdapterOptions {
        power_preference: PowerPreference::HighPerformance,
        compatible_surface: surface,
        ..wgpu::RequestAdapterOptions::default()
    };
    pollster::block_on(instance.request_adapter(&options)).map_err(|error| {
        tracing::debug!(%error, "no adapter");
        DeviceError::NoAdapter
    })
}

/// What WebGPU guarantees, and of the sizes as much as the adapter has: large fleets need large buffers.
fn limits(adapter: &Limits) -> Limits {
    Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        ..Limits::default().or_worse_values_from(adapter)
    }
}
