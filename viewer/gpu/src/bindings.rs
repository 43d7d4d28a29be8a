//! Bind groups and their layouts.

use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntry, BindingResource, BindingType,
    Buffer, BufferBindingType, Sampler, ShaderStages, TextureView,
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
    let entries: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, kind)| BindGroupLayoutEntry {
            binding,
            visibility: stages,
            ty: kind.binding_type(),
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

impl Binding {
    fn binding_type(self) -> BindingType {
        match self {
            Self::Uniform => buffer_type(BufferBindingType::Uniform),
            Self::Read => buffer_type(BufferBindingType::Storage { read_only: true }),
            Self::Write => buffer_type(BufferBindingType::Storage { read_only: false }),
            Self::Texture => BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            Self::WriteTexture => BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: wgpu::TextureFormat::Rgba8Unorm,
                view_dimension: wgpu::TextureViewDimension::D2,
            },
            Self::Sampler => BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        }
    }
}

fn buffer_type(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// Binds resources, numbered 0, 1, 2 …
pub fn bind_group(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    resources: &[BindingResource<'_>],
) -> BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
    gpu.device.create_bind_group(&descriptor)
}

/// Binds whole buffers, numbered 0, 1, 2 …
pub fn bind_buffers(gpu: &Gpu, layout: &BindGroupLayout, buffers: &[&Buffer]) -> BindGroup {
    let resources: Vec<_> = buffers.iter().map(|buffer| buffer.as_entire_binding()).collect();
    bind_group(gpu, layout, &resources)
}

/// Binds a texture as binding 0 and its sampler as binding 1.
pub fn bind_texture(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    view: &TextureView,
    sampler: &Sampler,
) -> BindGroup {
    let resources = [BindingResource::TextureView(view), BindingResource::Sampler(sampler)];
    bind_group(gpu, layout, &resources)
}
