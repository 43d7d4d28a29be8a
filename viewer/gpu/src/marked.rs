//! The mark of the selected edge or node.

use regatta_plugin::World;
use regatta_scene::Marked;
use wgpu::{
    BindGroup, BindGroupLayout, PrimitiveTopology, RenderPass, RenderPipeline, VertexBufferLayout,
    VertexStepMode, vertex_attr_array,
};

use super::device::Gpu;
use super::instances::Instances;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline};
use super::shaders::shader;

/// Vertices of an edge's strip, which has 64 parts as in marked.wgsl.
const EDGE_VERTICES: u32 = 2 * (64 + 1);

/// Draws the mark.
#[derive(Debug)]
pub struct MarkedPlace {
    edge: RenderPipeline,
    node: RenderPipeline,
    /// The indices of the marked edge's curves, or of the marked node.
    instances: Instances<u32>,
    shown: Option<Marked>,
    /// The first curve of each edge, and the number of its curves.
    edges: Vec<[u32; 2]>,
    nodes: u32,
}

impl MarkedPlace {
    /// Creates the pipelines. `records` is the layout of the graph's records.
    pub fn new(
        gpu: &Gpu,
        target: TargetConfig,
        view: &BindGroupLayout,
        records: &BindGroupLayout,
    ) -> Self {
        let attributes = vertex_attr_array![0 => Uint32];
        let index = [VertexBufferLayout {
            array_stride: 4,
            step_mode: VertexStepMode::Instance,
            attributes: &attributes,
        }];
        let module = shader(gpu, "marked");
        let make = |vertex, fragment| {
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment,
                groups: &[view, records],
                buffers: &index,
                topology: PrimitiveTopology::TriangleStrip,
                depth: DepthMode::Ignored,
                blend: true,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        Self {
            edge: make("edge", "edge_fill"),
            node: make("node", "node_fill"),
            instances: Instances::new(gpu, "marked"),
            shown: None,
            edges: Vec::new(),
            nodes: 0,
        }
    }

    /// Takes the graph of a world, in which nothing is marked yet.
    pub fn load(&mut self, world: &World<'_>) {
        let curves = world.all_curves().len();
        let range = |first: u32, count: usize| {
            [first, count.min(curves.saturating_sub(first as usize)) as u32]
        };
        self.edges = world
            .edges()
            .iter()
            .map(|edge| range(edge.first_curve, world.curves(edge).len()))
            .collect();
        self.nodes = world.nodes().len() as u32;
        self.shown = None;
    }

    /// Uploads what is marked if that has changed.
    pub fn update(&mut self, gpu: &Gpu, marked: Option<Marked>) {
        if self.shown == marked {
            return;
        }
        self.shown = marked;
        let indices: Vec<u32> = match marked {
            Some(Marked::Edge(index)) => {
                let range = self.edges.get(index as usize);
                range.map(|[first, count]| (*first..first + count).collect()).unwrap_or_default()
            }
            Some(Marked::Node(index)) if index < self.nodes => vec![index],
            _ => Vec::new(),
        };
        self.instances.set(gpu, &indices);
    }

    /// Draws the mark over the graph.
    pub fn draw(&self, pass: &mut RenderPass<'_>, records: &BindGroup) {
        let (pipeline, vertices) = match self.shown {
            Some(Marked::Edge(_)) => (&self.edge, EDGE_VERTICES),
            Some(Marked::Node(_)) => (&self.node, 4),
            None => return,
        };
        if self.instances.count() > 0 {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, records, &[]);
            self.instances.draw(pass, vertices);
        }
    }
}
