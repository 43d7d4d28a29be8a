//! The WGSL sources of all shaders, render and compute pipelines of them, and the formats that they
//! draw into.

use wgpu::{
    BindGroupLayout, BlendState, ColorTargetState, ColorWrites, CompareFunction, ComputePass,
    ComputePipeline, DepthStencilState, FragmentState, PrimitiveTopology, RenderPipeline,
    ShaderModule, TextureFormat, VertexBufferLayout, VertexState,
};

use super::device::Gpu;

/// The format of the depth buffer. Depth is reversed: 1 is near.
pub const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// The format of the id buffer that picking draws into.
pub const ID_FORMAT: TextureFormat = TextureFormat::R32Uint;

/// The workgroup size of compute shaders.
pub const WORKGROUP: u32 = 64;

/// The properties of a render target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetConfig {
    /// Format of the colours.
    pub format: TextureFormat,
    /// Samples per pixel.
    pub samples: u32,
    /// From this number of robots on, marks are splatted into pixels one by one rather than drawn
    /// as triangles. Their edges are not smoothed.
    pub splats_from: u32,
}

impl TargetConfig {
    /// The id buffer of picking.
    pub const IDS: Self = Self { format: ID_FORMAT, samples: 1, splats_from: u32::MAX };

    /// Chooses whether to splat, by which is faster on the adapter.
    pub fn new(gpu: &Gpu, format: TextureFormat, samples: u32) -> Self {
        // A software adapter splats on all SIMD lanes of all cores but sets up triangles on a
        // single core. Splatting costs a pass over all pixels, so it pays off only for many robots.
        let splats_from = if gpu.is_software() && samples == 1 { 30_000 } else { u32::MAX };
        Self { format, samples, splats_from }
    }
}

/// The values that are drawn into a target.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// Colours, for a picture.
    Colours,
    /// Ids, for picking.
    Ids,
}

/// The use of the depth buffer by a pipeline.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum DepthMode {
    /// The pass has no depth buffer.
    Absent,
    /// No depth test, no depth write: draws over everything drawn earlier. For things that lie on
    /// the ground.
    Ignored,
    /// Depth test and depth write: the nearest fragment wins.
    Tested,
}

/// The properties in which the viewer's render pipelines differ.
pub struct PipelineDescriptor<'a> {
    /// The shader module.
    pub module: &'a ShaderModule,
    /// Entry point of the vertex shader.
    pub vertex: &'a str,
    /// Entry point of the fragment shader.
    pub fragment: &'a str,
    /// Bind group layouts by group number.
    pub groups: &'a [&'a BindGroupLayout],
    /// Vertex buffer layouts by slot.
    pub buffers: &'a [VertexBufferLayout<'a>],
    /// The primitives that the vertices form.
    pub topology: PrimitiveTopology,
    /// The use of the depth buffer.
    pub depth: DepthMode,
    /// The blending of fragments with the target; `None` to replace it. Ids are never blended.
    pub blend: Option<BlendState>,
}

impl<'a> PipelineDescriptor<'a> {
    /// Describes a strip of triangles without vertex buffers that is alpha-blended over everything
    /// drawn earlier.
    pub fn new(
        module: &'a ShaderModule,
        vertex: &'a str,
        fragment: &'a str,
        groups: &'a [&'a BindGroupLayout],
    ) -> Self {
        Self {
            module,
            vertex,
            fragment,
            groups,
            buffers: &[],
            topology: PrimitiveTopology::TriangleStrip,
            depth: DepthMode::Ignored,
            blend: Some(BlendState::ALPHA_BLENDING),
        }
    }
}

/// Creates a render pipeline.
pub fn render_pipeline(
    gpu: &Gpu,
    target: TargetConfig,
    descriptor: &PipelineDescriptor<'_>,
) -> RenderPipeline {
    let buffers: Vec<_> = descriptor.buffers.iter().cloned().map(Some).collect();
    let primitive =
        wgpu::PrimitiveState { topology: descriptor.topology, ..wgpu::PrimitiveState::default() };
    let multisample =
        wgpu::MultisampleState { count: target.samples, ..wgpu::MultisampleState::default() };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(descriptor.vertex),
        layout: Some(&pipeline_layout(gpu, descriptor.vertex, descriptor.groups)),
        vertex: VertexState {
            module: descriptor.module,
            entry_point: Some(descriptor.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive,
        depth_stencil: descriptor.depth.state(),
        multisample,
        fragment: Some(FragmentState {
            module: descriptor.module,
            entry_point: Some(descriptor.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(ColorTargetState {
                format: target.format,
                blend: descriptor.blend.filter(|_| target.format != ID_FORMAT),
                write_mask: ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

impl DepthMode {
    fn state(self) -> Option<DepthStencilState> {
        let (depth_write_enabled, depth_compare) = match self {
            Self::Absent => return None,
            Self::Ignored => (Some(false), Some(CompareFunction::Always)),
            Self::Tested => (Some(true), Some(CompareFunction::GreaterEqual)),
        };
        Some(DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled,
            depth_compare,
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        })
    }
}

/// Creates a compute pipeline. `constants` are the values of the shader's `override` declarations.
pub fn compute_pipeline(
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

/// Dispatches an invocation per item, for shaders with [`WORKGROUP`] invocations in a workgroup.
/// WebGPU limits each dimension of a dispatch to 65,535 workgroups, so there are two.
pub fn dispatch(pass: &mut ComputePass<'_>, items: u32) {
    let needed = items.div_ceil(WORKGROUP);
    let across = needed.clamp(1, 32_768);
    pass.dispatch_workgroups(across, needed.div_ceil(across).max(1), 1);
}

/// Creates the layout of a pipeline from its bind group layouts.
fn pipeline_layout(gpu: &Gpu, label: &str, groups: &[&BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    let descriptor = wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    };
    gpu.device.create_pipeline_layout(&descriptor)
}

/// Concatenates WGSL files.
macro_rules! wgsl {
    ($($file:literal)+) => {
        concat!($(include_str!(concat!("shaders/", $file, ".wgsl"))),+)
    };
}

/// The source of each shader by name. Shared parts come before the shader's own part, as WGSL has
/// no imports.
pub const SHADERS: [(&str, &str); 18] = [
    ("floor", wgsl!("view" "floor")),
    ("graph", wgsl!("view" "curves" "graph")),
    ("routes", wgsl!("view" "curves" "routes")),
    ("closures", wgsl!("view" "curves" "closures")),
    ("marked", wgsl!("view" "curves" "marked")),
    ("heat", wgsl!("view" "triangle" "curves" "heat")),
    ("copy", wgsl!("triangle" "copy")),
    ("robots", wgsl!("view" "robots")),
    ("sort", wgsl!("view" "poses" "marks" "sort")),
    ("splats", wgsl!("view" "marks" "splats")),
    ("highlights", wgsl!("view" "poses" "highlights")),
    ("density", wgsl!("view" "marks" "density")),
    ("field", wgsl!("view" "triangle" "marks" "field")),
    ("goals", wgsl!("view" "curves" "goals")),
    ("stations", wgsl!("view" "stations")),
    ("facilities", wgsl!("view" "facilities")),
    ("waits", wgsl!("view" "poses" "waits")),
    ("interface", wgsl!("interface")),
];

/// Compiles one of [`SHADERS`].
///
/// # Panics
/// If no shader has this name.
pub fn shader(gpu: &Gpu, name: &str) -> ShaderModule {
    let (_, text) = SHADERS.iter().find(|(listed, _)| *listed == name).expect("a shader's name");
    let source = wgpu::ShaderSource::Wgsl((*text).into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}
