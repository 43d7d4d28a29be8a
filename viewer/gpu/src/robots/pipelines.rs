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
        let layout = |bytes, step_mode, attributes| VertexBufferLayout {
            array_stride: bytes,
            step_mode,
            attributes,
        };
        let body = [
            layout(BODY_BYTES, VertexStepMode::Instance, &BODY[..]),
            layout(size_of::<Vertex>() as u64, VertexStepMode::Vertex, &VERTEX[..]),
        ];
        let corner = [layout(CORNER_BYTES as u64, VertexStepMode::Vertex, &CORNER[..])];
        let descriptor = |vertex, fragment, groups, buffers| PipelineDescriptor {
            module: &module,
            vertex,
            fragment,
            groups,
            buffers,
            topology: PrimitiveTopology::TriangleList,
            depth: DepthMode::Tested,
            blend: false,
        };
        let make = |target, vertex, fragment, groups, buffers| {
            render_pipeline(gpu, target, &descriptor(vertex, fragment, groups, buffers))
        };
        let ids = TargetConfig::IDS;
        Self {
            body: make(target, "body", "shaded", &[view], &body),
            block: make(target, "block", "plain", &[view], &body),
            mark: make(target, "mark", "mark_plain", &[view, mark_ids], &corner),
            round_mark: make(target, "round_mark", "mark_round", &[view, mark_ids], &corner),
            body_id: make(ids, "body_id", "id_of", &[view], &body),
            mark_id: make(ids, "mark_id", "id_of", &[view, mark_ids], &corner),
            shadow: render_pipeline(
                gpu,
                target,
                &PipelineDescriptor {
                    depth: DepthMode::Ignored,
                    blend: true,
                    ..descriptor("shadow", "shadowed", &[view], &body[..1])
                },
            ),
        }
    }
}
