//! How long the GPU takes for a picture, where it can tell.

use wgpu::{
    Buffer, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Features, QuerySet, RenderPassTimestampWrites,
};

use super::device::Gpu;

/// Takes the time between the first and the last command of a picture.
#[derive(Debug)]
pub struct Timer {
    queries: QuerySet,
    resolved: Buffer,
    back: Buffer,
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

    /// Waits for the picture that was submitted last, and gives its time in seconds.
    pub fn read(&self, gpu: &Gpu) -> Option<f64> {
        self.back.map_async(wgpu::MapMode::Read, .., |_| ());
        gpu.wait();
        let ticks: [u64; 2] = bytemuck::pod_read_unaligned(&self.back.get_mapped_range(..).ok()?);
        self.back.unmap();
        Some(ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9)
    }
}
