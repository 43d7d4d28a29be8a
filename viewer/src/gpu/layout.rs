//! Making pipelines and bind groups with few words.

use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindGroupLayoutEntry, BindingType, BlendState, Buffer,
    BufferBindingType, ColorTargetState, ColorWrites, CompareFunction, ComputePipeline, DepthStencilState,
    FragmentState, PrimitiveTopology, RenderPipeline, ShaderModule, ShaderStages, TextureFormat, VertexBufferLayout,
    VertexState,
};

use super::device::Gpu;

/// Of the depth buffer. Depth is reversed: 1 is near.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Of the ids of things under the pointer.
pub const IDS: TextureFormat = TextureFormat::R32Uint;

/// The shaders by name, each with all that it needs before it.
pub const SHADERS: [(&str, &str); 8] = [
    ("floor", concat!(include_str!("shaders/view.wgsl"), include_str!("shaders/floor.wgsl"))),
    (
        "graph",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/graph.wgsl")
        ),
    ),
    (
        "routes",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/curves.wgsl"),
            include_str!("shaders/routes.wgsl")
        ),
    ),
    ("robots", concat!(include_str!("shaders/view.wgsl"), include_str!("shaders/robots.wgsl"))),
    (
        "sort",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/poses.wgsl"),
            include_str!("shaders/marks.wgsl"),
            include_str!("shaders/sort.wgsl")
        ),
    ),
    (
        "splats",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/marks.wgsl"),
            include_str!("shaders/splats.wgsl")
        ),
    ),
    (
        "chosen",
        concat!(
            include_str!("shaders/view.wgsl"),
            include_str!("shaders/poses.wgsl"),
            include_str!("shaders/chosen.wgsl")
        ),
    ),
    ("interface", include_str!("shaders/interface.wgsl")),
];

/// One of [`SHADERS`].
///
/// # Panics
/// If there is none of that name.
pub fn shader(gpu: &Gpu, name: &str) -> ShaderModule {
    let (_, text) = SHADERS.iter().find(|(known, _)| *known == name).expect("a shader's name");
    let source = wgpu::ShaderSource::Wgsl((*text).into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}

/// What a binding is.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A few bytes that are the same for all.
    Uniform,
    /// A buffer that is read.
    Read,
    /// A buffer that is read and written.
    Write,
    /// A picture.
    Texture,
    /// How a picture is read between its pixels.
    Sampler,
}

/// A layout with bindings 0, 1, 2 …
pub fn bindings(gpu: &Gpu, label: &str, stages: ShaderStages, kinds: &[Kind]) -> BindGroupLayout {
    let numbered: Vec<_> = (0..).zip(kinds.iter().copied()).collect();
    layout_of(gpu, label, stages, &numbered)
}

/// A layout with numbered bindings.
pub fn layout_of(gpu: &Gpu, label: &str, stages: ShaderStages, kinds: &[(u32, Kind)]) -> BindGroupLayout {
    let buffer = |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let entries: Vec<_> = kinds
        .iter()
        .map(|(binding, kind)| BindGroupLayoutEntry {
            binding: *binding,
            visibility: stages,
            ty: match kind {
                Kind::Uniform => buffer(BufferBindingType::Uniform),
                Kind::Read => buffer(BufferBindingType::Storage { read_only: true }),
                Kind::Write => buffer(BufferBindingType::Storage { read_only: false }),
                Kind::Texture => BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                Kind::Sampler => BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            },
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

/// Buffers as numbered bindings.
pub fn bind(gpu: &Gpu, layout: &BindGroupLayout, buffers: &[(u32, &Buffer)]) -> BindGroup {
    let entries: Vec<_> = buffers
        .iter()
        .map(|(binding, buffer)| BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// A compute pipeline.
pub fn compute(gpu: &Gpu, module: &ShaderModule, entry: &str, groups: &[&BindGroupLayout]) -> ComputePipeline {
    compute_with(gpu, module, entry, groups, &[])
}

/// A compute pipeline with values for what its shader leaves open.
pub fn compute_with(
    gpu: &Gpu,
    module: &ShaderModule,
    entry: &str,
    groups: &[&BindGroupLayout],
    constants: &[(&str, f64)],
) -> ComputePipeline {
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&pipeline_layout(gpu, entry, groups)),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

/// The layout of a pipeline with these groups of bindings.
pub fn pipeline_layout(gpu: &Gpu, label: &str, groups: &[&BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    let descriptor =
        wgpu::PipelineLayoutDescriptor { label: Some(label), bind_group_layouts: &groups, immediate_size: 0 };
    gpu.device.create_pipeline_layout(&descriptor)
}

/// Where pictures are drawn to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetKind {
    /// Of the colours.
    pub format: TextureFormat,
    /// Samples of a pixel.
    pub samples: u32,
    /// For so many robots or more, marks are put into pixels one by one rather than drawn as triangles. Their edges are
    /// not smoothed.
    pub splats_from: u32,
}

impl TargetKind {
    /// As suits an adapter.
    pub fn new(gpu: &Gpu, format: TextureFormat, samples: u32) -> Self {
        // A processor puts marks into pixels with all its lanes, and makes triangles with one; but then has to go through
        // all pixels.
        let splats_from = if gpu.is_software() && samples == 1 { 30_000 } else { u32::MAX };
        Self { format, samples, splats_from }
    }
}

/// How a draw meets what is there.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Layering {
    /// On the ground: over what was drawn before, under all that stands.
    Ground,
    /// The nearest wins.
    Standing,
}

/// What makes one render pipeline differ from another.
pub struct Draw<'a> {
    /// Its shaders.
    pub module: &'a ShaderModule,
    /// Entry point of the vertex shader.
    pub vertex: &'a str,
    /// Entry point of the fragment shader.
    pub fragment: &'a str,
    /// Groups of bindings, by number.
    pub groups: &'a [&'a BindGroupLayout],
    /// Buffers of vertices, by slot.
    pub buffers: &'a [VertexBufferLayout<'a>],
    /// What the vertices make up.
    pub topology: PrimitiveTopology,
    /// How it meets what is there.
    pub layering: Layering,
    /// Whether it is mixed with what is there, by its alpha.
    pub blend: bool,
}

/// A render pipeline.
pub fn render(gpu: &Gpu, target: TargetKind, draw: &Draw<'_>) -> RenderPipeline {
    let buffers: Vec<_> = draw.buffers.iter().cloned().map(Some).collect();
    let standing = draw.layering == Layering::Standing;
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(draw.vertex),
        layout: Some(&pipeline_layout(gpu, draw.vertex, draw.groups)),
        vertex: VertexState {
            module: draw.module,
            entry_point: Some(draw.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState { topology: draw.topology, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(standing),
            depth_compare: Some(if standing { CompareFunction::GreaterEqual } else { CompareFunction::Always }),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: target.samples, ..wgpu::MultisampleState::default() },
        fragment: Some(FragmentState {
            module: draw.module,
            entry_point: Some(draw.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(ColorTargetState {
                format: target.format,
                blend: draw.blend.then_some(BlendState::ALPHA_BLENDING),
                write_mask: ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
