//! The pipelines of robots: the sorting shader, and a pipeline for each level of detail.

use std::collections::BTreeMap;

use wgpu::{
    BindGroupLayout, ComputePipeline, PrimitiveTopology, RenderPipeline, ShaderModule,
    ShaderStages, VertexAttribute, VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use crate::bindings::{Binding, bind_group_layout};
use crate::device::Gpu;
use crate::mesh::Vertex;
use crate::pipeline::{
    DepthMode, PipelineDescriptor, TargetConfig, compute_pipeline, render_pipeline, shader,
};

/// The size of the shaders' `Body`.
pub const BODY_BYTES: u64 = 28;
/// The size of the shaders' `Corner`.
pub const CORNER_BYTES: usize = 16;

const BODY: [VertexAttribute; 6] = vertex_attr_array![
    0 => Float32x2, 1 => Snorm16x2, 2 => Unorm8x4, 3 => Float16x2, 4 => Float16x2, 5 => Uint32
];
const CORNER: [VertexAttribute; 2] = vertex_attr_array![0 => Float32x3, 1 => Unorm8x4];
const VERTEX: [VertexAttribute; 3] =
    vertex_attr_array![6 => Float32x3, 7 => Snorm8x4, 8 => Unorm8x4];

/// The pipelines of each level of detail, for colours and for ids.
#[derive(Debug)]
pub struct Pipelines {
    pub body: RenderPipeline,
    pub block: RenderPipeline,
    pub shadow: RenderPipeline,
    pub mark: RenderPipeline,
    pub round_mark: RenderPipeline,
    pub body_id: RenderPipeline,
    pub mark_id: RenderPipeline,
}

impl Pipelines {
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        mark_ids: &BindGroupLayout,
    ) -> Self {
        let module = shader(gpu, "robots");
        let body = [
            buffer_layout(BODY_BYTES, VertexStepMode::Instance, &BODY),
            buffer_layout(size_of::<Vertex>() as u64, VertexStepMode::Vertex, &VERTEX),
        ];
        let corner = [buffer_layout(CORNER_BYTES as u64, VertexStepMode::Vertex, &CORNER)];
        let (bodies, marks) = ((&[view][..], &body[..]), (&[view, mark_ids][..], &corner[..]));
        let ids = TargetConfig::IDS;
        let [body, block, body_id, mark, round_mark, mark_id] = [
            (target, "body", "shaded", bodies),
            (target, "block", "plain", bodies),
            (ids, "body_id", "id_of", bodies),
            (target, "mark", "mark_plain", marks),
            (target, "round_mark", "mark_round", marks),
            (ids, "mark_id", "id_of", marks),
        ]
        .map(|(target, vertex, fragment, (groups, buffers))| {
            let descriptor = PipelineDescriptor {
                buffers,
                topology: PrimitiveTopology::TriangleList,
                depth: DepthMode::Tested,
                blend: None,
                ..PipelineDescriptor::new(&module, vertex, fragment, groups)
            };
            render_pipeline(gpu, target, &descriptor)
        });
        let shadow = PipelineDescriptor {
            buffers: &bodies.1[..1],
            topology: PrimitiveTopology::TriangleList,
            ..PipelineDescriptor::new(&module, "shadow", "shadowed", bodies.0)
        };
        let shadow = render_pipeline(gpu, target, &shadow);
        Self { body, block, shadow, mark, round_mark, body_id, mark_id }
    }
}

fn buffer_layout(
    array_stride: u64,
    step_mode: VertexStepMode,
    attributes: &[VertexAttribute],
) -> VertexBufferLayout<'_> {
    VertexBufferLayout { array_stride, step_mode, attributes }
}

/// The robots that are drawn as their density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dense {
    /// None.
    #[default]
    None,
    /// Those that are small in the picture.
    Small,
    /// All: none in sight is large enough for a mark.
    All,
}

/// The decisions for all robots of a picture at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Variant {
    /// Whether marks are splatted.
    pub splats: bool,
    /// The robots that are drawn as their density.
    pub dense: Dense,
    /// The source of the robots' colours, as in the view.
    pub source: u32,
    /// Whether robots are dimmed and hidden, as in the view.
    pub filtered: u32,
    /// Whether a robot in sight may be large enough for a block or a mesh.
    pub bodies: bool,
}

/// The sorting shader. A variant is compiled when it is first needed.
#[derive(Debug)]
pub struct Sorting {
    module: ShaderModule,
    groups: [BindGroupLayout; 3],
    pipelines: BTreeMap<Variant, ComputePipeline>,
}

impl Sorting {
    pub fn new(gpu: &Gpu, view: &BindGroupLayout, columns: &BindGroupLayout) -> Self {
        let lists = bind_group_layout(gpu, "lists", ShaderStages::COMPUTE, &[Binding::Write; 5]);
        let groups = [view.clone(), columns.clone(), lists];
        Self { module: shader(gpu, "sort"), groups, pipelines: BTreeMap::new() }
    }

    /// The layout of the group of draw lists.
    pub fn lists_layout(&self) -> &BindGroupLayout {
        &self.groups[2]
    }

    /// Returns a variant.
    pub fn pipeline(&mut self, gpu: &Gpu, variant: Variant) -> &ComputePipeline {
        let Self { module, groups, pipelines } = self;
        pipelines.entry(variant).or_insert_with(|| {
            let Variant { splats, dense, source, filtered, bodies } = variant;
            let entry = if dense == Dense::All { "add_all" } else { "sort" };
            let constants = [
                ("SPLATS", f64::from(splats)),
                ("DENSITY", f64::from(dense != Dense::None)),
                ("SOURCE", f64::from(source)),
                ("FILTERED", f64::from(filtered)),
                ("BODIES", f64::from(bodies)),
            ];
            compute_pipeline(gpu, module, entry, &groups.each_ref(), &constants)
        })
    }
}
