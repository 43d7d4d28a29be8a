//! The route graph: its records on the GPU as they are in the world, sorted and drawn from there.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::world::{EdgeRecord, NodeRecord};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, PrimitiveTopology, RenderPass,
    RenderPipeline, ShaderStages, VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::columns::buffer;
use super::device::Gpu;
use super::layout::{Draw, IDS, Kind, Layering, TargetKind, bind, bindings, compute, render, shader};
use crate::scene::Layers;

/// Lists of what is drawn; the same as in graph.wgsl.
const LISTS: usize = 7;
/// Edges from here on are bent.
const BENT: usize = 2;
const ARROWS: usize = 5;
const NODES: usize = 6;
/// Vertices of each list's instances: a line, strips of 2, 9, 33 and 129 points, two triangles, a strip of two triangles.
const VERTICES: [u32; LISTS] = [2, 4, 18, 66, 258, 6, 4];
/// Vertices of the widened strips that are picked.
const PICK_VERTICES: [u32; LISTS] = [4, 4, 66, 66, 66, 6, 4];
/// Threads of a group of the sorting shaders.
const GROUP: u32 = 64;

/// What an indirect draw takes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct DrawArguments {
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

/// All that draws the graph.
#[derive(Debug)]
pub struct Graph {
    records_layout: BindGroupLayout,
    lists_layout: BindGroupLayout,
    sort_edges: ComputePipeline,
    sort_nodes: ComputePipeline,
    /// Edges by how much they are bent, arrows, nodes.
    draws: [RenderPipeline; LISTS],
    edge_id_straight: RenderPipeline,
    edge_id: RenderPipeline,
    node_id: RenderPipeline,
    loaded: Option<Loaded>,
}

/// A graph on the GPU.
#[derive(Debug)]
struct Loaded {
    edges: u32,
    nodes: u32,
    records: BindGroup,
    sorting: BindGroup,
    lists: Buffer,
    draws: Buffer,
    blank_draws: Buffer,
    pick_draws: Buffer,
}

impl Graph {
    pub fn new(gpu: &Gpu, target: TargetKind, view: &BindGroupLayout) -> Self {
        let records_layout =
            bindings(gpu, "graph", ShaderStages::VERTEX | ShaderStages::COMPUTE, &[Kind::Read, Kind::Read]);
        let lists_layout = bindings(gpu, "graph lists", ShaderStages::COMPUTE, &[Kind::Write, Kind::Write]);
        let module = shader(gpu, "graph");
        let attributes = vertex_attr_array![0 => Uint32];
        let index =
            [VertexBufferLayout { array_stride: 4, step_mode: VertexStepMode::Instance, attributes: &attributes }];
        let groups = [view, &records_layout];
        let make = |target: TargetKind, vertex, fragment, topology| {
            let (buffers, layering, blend) = (&index, Layering::Ground, target.format != IDS);
            let groups = &groups;
            render(gpu, target, &Draw { module: &module, vertex, fragment, groups, buffers, topology, layering, blend })
        };
        let strip = PrimitiveTopology::TriangleStrip;
        let ids = TargetKind { format: IDS, samples: 1, splats_from: u32::MAX };
        Self {
            sort_edges: compute(gpu, &module, "sort_edges", &[view, &records_layout, &lists_layout]),
            sort_nodes: compute(gpu, &module, "sort_nodes", &[view, &records_layout, &lists_layout]),
            draws: [
                make(target, "edge_far", "ribbon_fill", PrimitiveTopology::LineList),
                make(target, "edge_straight", "ribbon_fill", strip),
                make(target, "edge_bent", "ribbon_fill", strip),
                make(target, "edge_curved", "ribbon_fill", strip),
                make(target, "edge_near", "ribbon_fill", strip),
                make(target, "arrow", "flat_fill", PrimitiveTopology::TriangleList),
                make(target, "node", "disc_fill", strip),
            ],
            edge_id_straight: make(ids, "edge_id_straight", "ribbon_id", strip),
            edge_id: make(ids, "edge_id", "ribbon_id", strip),
            node_id: make(ids, "node_id", "disc_id", strip),
            records_layout,
            lists_layout,
            loaded: None,
        }
    }

    /// Takes another graph.
    pub fn load(&mut self, gpu: &Gpu, nodes: &[NodeRecord], edges: &[EdgeRecord]) {
        self.loaded = None;
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        if size_of_val(edges) as u64 > limit || edges.is_empty() || nodes.is_empty() {
            if !edges.is_empty() {
                tracing::warn!("the graph of {} edges is too large for this adapter; it isn't drawn", edges.len());
            }
            return;
        }
        let upload = |label, bytes: &[u8], usage| {
            let made = buffer(gpu, label, bytes.len(), usage);
            gpu.queue.write_buffer(&made, 0, bytes);
            made
        };
        let edge_records = upload("edges", bytemuck::cast_slice(edges), BufferUsages::STORAGE);
        let node_records = upload("nodes", bytemuck::cast_slice(nodes), BufferUsages::STORAGE);
        let entries = NODES * edges.len() + nodes.len();
        let lists = buffer(gpu, "graph lists", entries * 4, BufferUsages::STORAGE | BufferUsages::VERTEX);
        let arguments = |vertices: [u32; LISTS]| {
            vertices.map(|vertices| DrawArguments { vertices, instances: 0, first_vertex: 0, first_instance: 0 })
        };
        let usage = BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        let draws = upload("graph draws", bytemuck::cast_slice(&arguments(VERTICES)), usage);
        let blank_draws = upload("blank", bytemuck::cast_slice(&arguments(VERTICES)), BufferUsages::COPY_SRC);
        let pick_draws = upload("pick", bytemuck::cast_slice(&arguments(PICK_VERTICES)), BufferUsages::INDIRECT);
        self.loaded = Some(Loaded {
            edges: edges.len() as u32,
            nodes: nodes.len() as u32,
            records: bind(gpu, &self.records_layout, &[(0, &edge_records), (1, &node_records)]),
            sorting: bind(gpu, &self.lists_layout, &[(0, &lists), (1, &draws)]),
            lists,
            draws,
            blank_draws,
            pick_draws,
        });
    }

    /// How its records are bound.
    pub fn records_layout(&self) -> &BindGroupLayout {
        &self.records_layout
    }

    /// Its records, if there is a graph.
    pub fn records(&self) -> Option<&BindGroup> {
        self.loaded.as_ref().map(|loaded| &loaded.records)
    }

    /// Works out what is seen of it.
    pub fn sort(&self, encoder: &mut CommandEncoder, view: &BindGroup) {
        let Some(loaded) = &self.loaded else { return };
        encoder.copy_buffer_to_buffer(&loaded.blank_draws, 0, &loaded.draws, 0, loaded.draws.size());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, view, &[]);
        pass.set_bind_group(1, &loaded.records, &[]);
        pass.set_bind_group(2, &loaded.sorting, &[]);
        for (pipeline, count) in [(&self.sort_edges, loaded.edges), (&self.sort_nodes, loaded.nodes)] {
            let needed = count.div_ceil(GROUP);
            let across = needed.clamp(1, 32_768);
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(across, needed.div_ceil(across), 1);
        }
    }

    /// Draws what was sorted last.
    pub fn draw(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        let shown = [layers.edges, layers.edges, layers.edges, layers.edges, layers.edges, layers.arrows, layers.nodes];
        pass.set_bind_group(1, &loaded.records, &[]);
        for (list, pipeline) in self.draws.iter().enumerate().filter(|(list, _)| shown[*list]) {
            pass.set_pipeline(pipeline);
            loaded.draw_list(pass, list, &loaded.draws);
        }
    }

    /// Draws the ids of what was sorted last.
    pub fn draw_ids(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        pass.set_bind_group(1, &loaded.records, &[]);
        if layers.edges {
            pass.set_pipeline(&self.edge_id_straight);
            (0..BENT).for_each(|list| loaded.draw_list(pass, list, &loaded.pick_draws));
            pass.set_pipeline(&self.edge_id);
            (BENT..ARROWS).for_each(|list| loaded.draw_list(pass, list, &loaded.pick_draws));
        }
        if layers.nodes {
            pass.set_pipeline(&self.node_id);
            loaded.draw_list(pass, NODES, &loaded.pick_draws);
        }
    }

    /// Before [`draw_ids`](Self::draw_ids): as many as were drawn.
    pub fn prepare_ids(&self, encoder: &mut CommandEncoder) {
        let Some(loaded) = &self.loaded else { return };
        for list in 0..LISTS as u64 {
            let count = list * size_of::<DrawArguments>() as u64 + 4;
            encoder.copy_buffer_to_buffer(&loaded.draws, count, &loaded.pick_draws, count, 4);
        }
    }
}

impl Loaded {
    fn draw_list(&self, pass: &mut RenderPass<'_>, list: usize, draws: &Buffer) {
        pass.set_vertex_buffer(0, self.lists.slice((list * self.edges as usize * 4) as u64..));
        pass.draw_indirect(draws, (list * size_of::<DrawArguments>()) as u64);
    }
}
