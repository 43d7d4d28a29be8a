//! Bind groups and their layouts.

use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntry, BindingType, Buffer,
    BufferBindingType, ShaderStages,
};

use super::device::Gpu;

/// The type of a shader's resource binding.
#[derive(Clone, Copy)]
pub enum Binding {
    /// A uniform buffer.
    Uniform,
    /// A read-only storage buffer.
    Read,
    /// A storage buffer that is read and written.
    Write,
    /// A 2D texture with filterable samples.
    Texture,
    /// A filtering sampler.
    Sampler,
    /// A 2D texture of 8-bit colours that is written.
    WriteTexture,
}

/// Creates a bind group layout whose bindings are numbered 0, 1, 2 …
pub fn bind_group_layout(
    gpu: &Gpu,
    label: &str,
    stages: ShaderStages,
    bindings: &[Binding],
) -> BindGroupLayout {
    let numbered: Vec<_> = (0..).zip(bindings.iter().copied()).collect();
    numbered_bind_group_layout(gpu, label, stages, &numbered)
}

/// Creates a bind group layout from pairs of binding number and type.
pub fn numbered_bind_group_layout(
    gpu: &Gpu,
    label: &str,
    stages: ShaderStages,
    bindings: &[(u32, Binding)],
) -> BindGroupLayout {
    let buffer = |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let entries: Vec<_> = bindings
        .iter()
        .map(|(number, binding)| BindGroupLayoutEntry {
            binding: *number,
            visibility: stages,
            ty: match binding {
                Binding::Uniform => buffer(BufferBindingType::Uniform),
                Binding::Read => buffer(BufferBindingType::Storage { read_only: true }),
                Binding::Write => buffer(BufferBindingType::Storage { read_only: false }),
                Binding::Texture => BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                Binding::WriteTexture => BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::WriteOnly,
                    format: wgpu::TextureFormat::Rgba8Unorm,
                    view_dimension: wgpu::TextureViewDimension::D2,
                },
                Binding::Sampler => BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            },
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

/// Binds whole buffers, each with its binding number.
pub fn bind_group(gpu: &Gpu, layout: &BindGroupLayout, buffers: &[(u32, &Buffer)]) -> BindGroup {
    let entries: Vec<_> = buffers
        .iter()
        .map(|(number, buffer)| BindGroupEntry {
            binding: *number,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

/// Binds a part of a buffer, in bytes, as binding 0.
pub fn slice_group(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    buffer: &Buffer,
    offset: usize,
    bytes: usize,
) -> BindGroup {
    let size = wgpu::BufferSize::new(bytes as u64);
    let slice = wgpu::BufferBinding { buffer, offset: offset as u64, size };
    let entries = [BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(slice) }];
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}
