//! GPU timing by timestamp queries.

use std::sync::{Arc, OnceLock};

use wgpu::{
    Buffer, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Features, QuerySet,
    RenderPassTimestampWrites,
};

use super::device::Gpu;
use super::resources::buffer;

/// Measures the time between the first and the last command of a picture. While a result is
/// pending, no other picture is measured.
#[derive(Debug)]
pub struct Timer {
    queries: QuerySet,
    resolved: Buffer,
    readback: Buffer,
    /// The pending result: set once the GPU has finished the picture, to whether the buffer was
    /// mapped.
    pending: Option<Arc<OnceLock<bool>>>,
}

impl Timer {
    /// Returns `None` on an adapter without timestamp queries.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let resolved = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        Some(Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(gpu, "timestamps", 16, resolved),
            readback: buffer(gpu, "read timestamps", 16, BufferUsages::MAP_READ),
            pending: None,
        })
    }

    /// The timestamp that the first pass writes.
    pub fn start(&self) -> ComputePassTimestampWrites<'_> {
        ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: None,
        }
    }

    /// The timestamp that the last pass writes.
    pub fn end(&self) -> RenderPassTimestampWrites<'_> {
        RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: None,
            end_of_pass_write_index: Some(1),
        }
    }

    /// Copies the timestamps into the readback buffer, after the last pass.
    pub fn finish(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, 16);
    }

    /// Whether the next picture can be measured.
    pub fn is_free(&self) -> bool {
        self.pending.is_none()
    }

    /// Requests the time of the picture that was submitted last.
    pub fn request(&mut self) {
        let mapped = Arc::new(OnceLock::new());
        self.pending = Some(Arc::clone(&mapped));
        self.readback.map_async(wgpu::MapMode::Read, .., move |result| {
            mapped.get_or_init(|| result.is_ok());
        });
    }

    /// Returns the requested time in seconds if the GPU has finished that picture.
    pub fn take_result(&mut self, gpu: &Gpu) -> Option<f64> {
        let mapped = *self.pending.as_ref()?.get()?;
        self.pending = None;
        if !mapped {
            return None;
        }
        let [start, end]: [u64; 2] =
            bytemuck::pod_read_unaligned(&self.readback.get_mapped_range(..).ok()?);
        self.readback.unmap();
        let nanos_per_tick = f64::from(gpu.queue.get_timestamp_period());
        Some(end.saturating_sub(start) as f64 * nanos_per_tick * 1e-9)
    }
}
