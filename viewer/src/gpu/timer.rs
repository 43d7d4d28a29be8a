//! How long the GPU takes for a picture, where it can tell.

use std::sync::{Arc, OnceLock};

use wgpu::{
    Buffer, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Features, QuerySet, RenderPassTimestampWrites,
};

use super::device::Gpu;

/// Takes the time between the first and the last command of a picture. While the GPU is asked for one, no other is taken.
#[derive(Debug)]
pub struct Timer {
    queries: QuerySet,
    resolved: Buffer,
    back: Buffer,
    /// Whether the time came, once the GPU is through with the picture that it was asked for.
    asked: Option<Arc<OnceLock<bool>>>,
}

impl Timer {
    /// `None` on an adapter without timestamps.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        if !gpu.device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |usage| {
            let descriptor = wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false };
            gpu.device.create_buffer(&descriptor)
        };
        Some(Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            back: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            asked: None,
        })
    }

    /// For the first pass.
    pub fn start(&self) -> ComputePassTimestampWrites<'_> {
        ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: None,
        }
    }

    /// For the last pass.
    pub fn end(&self) -> RenderPassTimestampWrites<'_> {
        RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: None,
            end_of_pass_write_index: Some(1),
        }
    }

    /// After the last pass.
    pub fn finish(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.back, 0, 16);
    }

    /// Whether the next picture can be timed.
    pub fn is_free(&self) -> bool {
        self.asked.is_none()
    }

    /// Asks for the time of the picture that was submitted last.
    pub fn ask(&mut self) {
        let came = Arc::new(OnceLock::new());
        self.asked = Some(Arc::clone(&came));
        self.back.map_async(wgpu::MapMode::Read, .., move |result| {
            came.get_or_init(|| result.is_ok());
        });
    }

    /// The time that was asked for, in seconds, if the GPU has told it by now.
    pub fn answer(&mut self, gpu: &Gpu) -> Option<f64> {
        let came = *self.asked.as_ref()?.get()?;
        self.asked = None;
        if !came {
            return None;
        }
        let ticks: [u64; 2] = bytemuck::pod_read_unaligned(&self.back.get_mapped_range(..).ok()?);
        self.back.unmap();
        Some(ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9)
    }
}
