//! The render pipelines of robots.

use wgpu::{
    BindGroupLayout, PrimitiveTopology, RenderPipeline, VertexAttribute, VertexBufferLayout,
    VertexStepMode, vertex_attr_array,
};

use crate::device::Gpu;
use crate::mesh::Vertex;
use crate::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use crate::shaders::shader;

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
