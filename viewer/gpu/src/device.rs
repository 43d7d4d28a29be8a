//! The graphics adapter and its device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use parking_lot::Mutex;
use wgpu::{
    Backends, DeviceType, Features, InstanceDescriptor, InstanceFlags, Limits, PowerPreference,
};

/// The error of opening a graphics device.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// There is no usable driver.
    #[error(
        "no graphics adapter: install a Vulkan driver (on Debian and Ubuntu `apt install \
         mesa-vulkan-drivers` has one that needs no graphics card)"
    )]
    NoAdapter,
    /// The adapter lacks a required feature or limit.
    #[error(
        "the adapter {adapter} can't be used: {reason}; install another Vulkan driver, or update \
         this one"
    )]
    Refused {
        /// The adapter's name.
        adapter: String,
        /// The error of the driver or of wgpu.
        reason: String,
    },
    /// The adapter's memory is full.
    #[error(
        "the memory of the adapter {adapter} is full; choose a smaller picture or floor image, \
         --samples 1, or fewer trails"
    )]
    OutOfMemory {
        /// The adapter's name.
        adapter: String,
    },
}

/// A device with its queue and its adapter. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device, which creates buffers, textures and pipelines.
    pub device: wgpu::Device,
    /// The queue, which accepts uploads and commands.
    pub queue: wgpu::Queue,
    /// The device's adapter, which knows the capabilities of surfaces.
    pub adapter: wgpu::Adapter,
    /// The adapter's name, driver and device type.
    pub info: wgpu::AdapterInfo,
    lost: Arc<Mutex<Option<String>>>,
    is_full: Arc<AtomicBool>,
}

/// Creates the wgpu instance.
pub fn instance() -> wgpu::Instance {
    wgpu::Instance::new(InstanceDescriptor {
        backends: Backends::PRIMARY,
        // The counts of indirect draws come only from our own shaders; validating them costs a
        // dispatch per draw.
        flags: InstanceFlags::from_build_config()
            .difference(InstanceFlags::VALIDATION_INDIRECT_CALL)
            .with_env(),
        ..InstanceDescriptor::new_without_display_handle()
    })
}

impl Gpu {
    /// Opens the best adapter that can draw on `surface`, or any adapter if there is no surface.
    /// The environment variable `WGPU_ADAPTER_NAME` selects an adapter by a part of its name.
    ///
    /// # Errors
    /// [`DeviceError`] if there is no adapter, or it lacks a required feature or limit.
    pub fn open(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Self, DeviceError> {
        Self::from_adapter(&choose(instance, surface)?)
    }

    /// Opens a software adapter, which renders on the CPU: its pictures don't depend on the
    /// graphics card.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn software() -> Result<Self, DeviceError> {
        let options = wgpu::RequestAdapterOptions {
            force_fallback_adapter: true,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance().request_adapter(&options))
            .map_err(|_| DeviceError::NoAdapter)?;
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
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| {
                DeviceError::Refused { adapter: info.name.clone(), reason: error.to_string() }
            })?;
        let lost = Arc::new(Mutex::new(None));
        let lost_reason = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            *lost_reason.lock() = Some(format!("{reason:?}: {message}"));
        });
        let is_full = Arc::new(AtomicBool::new(false));
        let has_filled = Arc::clone(&is_full);
        device.on_uncaptured_error(Arc::new(move |error| match error {
            wgpu::Error::OutOfMemory { .. } => has_filled.store(true, Ordering::Relaxed),
            // Resources that had no room are invalid: the errors of their use follow from that.
            _ if has_filled.load(Ordering::Relaxed) => {}
            // Any other error is a bug of the viewer. This is what wgpu does by default.
            error => panic!("wgpu error: {error}"),
        }));
        Ok(Self { device, queue, adapter: adapter.clone(), info, lost, is_full })
    }

    /// Opens the best adapter for drawing offscreen.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn offscreen() -> Result<Self, DeviceError> {
        Self::open(&instance(), None)
    }

    /// Whether the adapter renders on the CPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Returns the reason why the device was lost, if it was. All of its resources have to be
    /// created anew then.
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().clone()
    }

    /// Fails if there was no room for something that was created outside of
    /// [`allocate`](Self::allocate). Pictures that need it are incomplete.
    ///
    /// # Errors
    /// [`DeviceError::OutOfMemory`].
    pub fn check_memory(&self) -> Result<(), DeviceError> {
        let full = DeviceError::OutOfMemory { adapter: self.info.name.clone() };
        if self.is_full.load(Ordering::Relaxed) { Err(full) } else { Ok(()) }
    }

    /// Creates buffers or textures. Returns `None` if the adapter's memory has no room for them.
    ///
    /// # Panics
    /// If wgpu considers a created resource invalid.
    pub fn allocate<T>(&self, create: impl FnOnce() -> T) -> Option<T> {
        let invalid = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let full = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let created = create();
        let (full, invalid) = (pollster::block_on(full.pop()), pollster::block_on(invalid.pop()));
        if full.is_some() {
            drop(created);
            // The next poll frees dropped resources.
            self.poll();
            return None;
        }
        if let Some(error) = invalid {
            panic!("wgpu error: {error}");
        }
        Some(created)
    }

    /// Creates an encoder of commands.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Waits until all submitted commands are finished.
    pub fn wait(&self) {
        // A lost device has nothing left to do; callers check `lost`.
        if let Err(error) = self.device.poll(wgpu::PollType::wait_indefinitely()) {
            tracing::debug!(%error, "waiting for the device");
        }
    }

    /// Runs the callbacks of finished commands, without waiting.
    pub fn poll(&self) {
        if let Err(error) = self.device.poll(wgpu::PollType::Poll) {
            tracing::debug!(%error, "polling the device");
        }
    }
}

fn choose(
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface<'_>>,
) -> Result<wgpu::Adapter, DeviceError> {
    if let Ok(wanted) = std::env::var("WGPU_ADAPTER_NAME") {
        let mut all =
            pollster::block_on(instance.enumerate_adapters(Backends::PRIMARY)).into_iter();
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

/// Returns WebGPU's default limits, with the adapter's own limits for sizes: large fleets need
/// large buffers.
fn limits(adapter: &Limits) -> Limits {
    Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        ..Limits::default().or_worse_values_from(adapter)
    }
}
