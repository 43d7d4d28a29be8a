//! The route graph: the nodes and curves of the world on the GPU, culled and sorted into draw lists
//! there.

mod records;

use bytemuck::{Pod, Zeroable};
use regatta_plugin::World;
use regatta_scene::Layers;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline,
    PrimitiveTopology, RenderPass, RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_group, bind_group_layout, slice_group};
use super::device::Gpu;
use super::pipeline::{
    DepthMode, PipelineDescriptor, TargetConfig, compute_pipeline, render_pipeline,
};
use super::resources::buffer;
use super::shaders::shader;
use records::{curve_instances, node_instances};

/// The number of draw lists, of which the last two are for picking only; the same as in graph.wgsl.
const LISTS: usize = 9;
const SHOWN: usize = 7;
/// The first list of bent curves; the lists before it have straight ones.
const BENT: usize = 2;
const ARROWS: usize = 5;
const NODES: usize = 6;
const HOT_FAR: usize = 7;
const HOT_NEAR: usize = 8;
/// The workgroup size of the sorting shaders.
const WORKGROUP: u32 = 64;

/// The arguments of an indirect draw.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct DrawArguments {
    vertices: u32,
    instances: u32,
    first_vertex: u32,
    first_instance: u32,
}

/// Draws the graph.
#[derive(Debug)]
pub struct Graph {
    records_layout: BindGroupLayout,
    lists_layout: BindGroupLayout,
    shown_layout: BindGroupLayout,
    sort_curves: ComputePipeline,
    sort_nodes: ComputePipeline,
    fill_lists: ComputePipeline,
    /// A pipeline for each list: curves by their curvature in the picture, arrows, nodes.
    draws: [RenderPipeline; SHOWN],
    edge_id_straight: RenderPipeline,
    edge_id: RenderPipeline,
    node_id: RenderPipeline,
    loaded: Option<Loaded>,
}

/// A graph on the GPU.
#[derive(Debug)]
struct Loaded {
    curves: u32,
    nodes: u32,
    records: BindGroup,
    sorting: BindGroup,
    /// Each list.
    lists: [BindGroup; LISTS],
    /// The draws of each list, for pictures and then for picking.
    draws: Buffer,
    /// A bit per curve: whether it is a ribbon of the heat map.
    hot: Buffer,
}

impl Graph {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let stages = ShaderStages::VERTEX | ShaderStages::COMPUTE;
        let records_layout = bind_group_layout(gpu, "graph", stages, &[Binding::Read; 2]);
        let bindings = [Binding::Write, Binding::Write, Binding::Write, Binding::Read];
        let lists_layout = bind_group_layout(gpu, "graph lists", ShaderStages::COMPUTE, &bindings);
        let shown_layout =
            bind_group_layout(gpu, "graph list", ShaderStages::VERTEX, &[Binding::Read]);
        let module = shader(gpu, "graph");
        let groups = [view, &records_layout, &shown_layout];
        let make = |target: TargetConfig, vertex, fragment, topology| {
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment,
                groups: &groups,
                buffers: &[],
                topology,
                depth: DepthMode::Ignored,
                blend: target != TargetConfig::IDS,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        let sort = |entry| {
            compute_pipeline(gpu, &module, entry, &[view, &records_layout, &lists_layout], &[])
        };
        let (lines, triangles, strip) = (
            PrimitiveTopology::LineList,
            PrimitiveTopology::TriangleList,
            PrimitiveTopology::TriangleStrip,
        );
        let ids = TargetConfig::IDS;
        Self {
            sort_curves: sort("sort_curves"),
            sort_nodes: sort("sort_nodes"),
            fill_lists: sort("fill_lists"),
            draws: [
                make(target, "edge_far", "ribbon_fill", lines),
                make(target, "edge_straight", "ribbon_fill", triangles),
                make(target, "edge_bent", "ribbon_fill", strip),
                make(target, "edge_curved", "ribbon_fill", strip),
                make(target, "edge_near", "ribbon_fill", strip),
                make(target, "arrow", "flat_fill", triangles),
                make(target, "node", "disc_fill", triangles),
            ],
            edge_id_straight: make(ids, "edge_id_straight", "ribbon_id", triangles),
            edge_id: make(ids, "edge_id", "ribbon_id", strip),
            node_id: make(ids, "node_id", "disc_id", triangles),
            records_layout,
            lists_layout,
            shown_layout,
            loaded: None,
        }
    }

    /// Uploads a graph, which replaces the one before; of one level only if it is given.
    pub fn load(&mut self, gpu: &Gpu, world: &World<'_>, level: Option<&str>) {
        self.loaded = None;
        let (curves, nodes) = (curve_instances(world, level), node_instances(world, level));
        if curves.is_empty() || nodes.is_empty() {
            return;
        }
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        // Each list is bound by itself, which has to begin at a multiple of 256 bytes.
        let list_bytes = curves.len().max(nodes.len()).next_multiple_of(64) * size_of::<u32>();
        if size_of_val(&curves[..]).max(LISTS * list_bytes) as u64 > limit {
            tracing::warn!(
                "the graph of {} curves is too large for this adapter and is not drawn",
                curves.len()
            );
            return;
        }
        let upload = |label, bytes: &[u8]| {
            let buffer = buffer(gpu, label, bytes.len(), BufferUsages::STORAGE);
            gpu.queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let curve_records = upload("curves", bytemuck::cast_slice(&curves));
        let node_records = upload("nodes", bytemuck::cast_slice(&nodes));
        let storage =
            |label, bytes, usage| buffer(gpu, label, bytes, BufferUsages::STORAGE | usage);
        let none = BufferUsages::empty();
        let lists = storage("graph lists", LISTS * list_bytes, none);
        let masks = storage("graph masks", (curves.len() + nodes.len()) * size_of::<u32>(), none);
        let draws =
            storage("graph draws", 2 * LISTS * size_of::<DrawArguments>(), BufferUsages::INDIRECT);
        let hot = storage("hot curves", curves.len().div_ceil(32) * size_of::<u32>(), none);
        let list = |list: usize| {
            slice_group(gpu, &self.shown_layout, &lists, list * list_bytes, list_bytes)
        };
        self.loaded = Some(Loaded {
            curves: curves.len() as u32,
            nodes: nodes.len() as u32,
            records: bind_group(
                gpu,
                &self.records_layout,
                &[(0, &curve_records), (1, &node_records)],
            ),
            sorting: bind_group(
                gpu,
                &self.lists_layout,
                &[(0, &lists), (1, &masks), (2, &draws), (3, &hot)],
            ),
            lists: std::array::from_fn(list),
            draws,
            hot,
        });
    }

    /// Sets the curves that are ribbons of the heat map, and not drawn under them.
    pub fn set_hot(&self, gpu: &Gpu, curves: impl Iterator<Item = u32>) {
        let Some(loaded) = &self.loaded else { return };
        let mut bits = vec![0_u32; loaded.curves.div_ceil(32) as usize];
        for curve in curves {
            bits.get_mut(curve as usize / 32)
                .into_iter()
                .for_each(|word| *word |= 1 << (curve % 32));
        }
        gpu.queue.write_buffer(&loaded.hot, 0, bytemuck::cast_slice(&bits));
    }

    /// The layout of the records' bind group.
    pub fn records_layout(&self) -> &BindGroupLayout {
        &self.records_layout
    }

    /// The bind group of the records, if there is a graph.
    pub fn records(&self) -> Option<&BindGroup> {
        self.loaded.as_ref().map(|loaded| &loaded.records)
    }

    /// Sorts the visible curves, arrows and nodes into the draw lists.
    pub fn sort(&self, encoder: &mut CommandEncoder, view: &BindGroup) {
        let Some(loaded) = &self.loaded else { return };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, view, &[]);
        pass.set_bind_group(1, &loaded.records, &[]);
        pass.set_bind_group(2, &loaded.sorting, &[]);
        for (pipeline, count) in
            [(&self.sort_curves, loaded.curves), (&self.sort_nodes, loaded.nodes)]
        {
            let needed = count.div_ceil(WORKGROUP);
            let across = needed.clamp(1, 32_768);
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(across, needed.div_ceil(across), 1);
        }
        pass.set_pipeline(&self.fill_lists);
        pass.dispatch_workgroups(1, 1, 1);
    }

    /// Draws the lists of the last [`sort`](Self::sort).
    pub fn draw(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        let shown = [
            layers.edges,
            layers.edges,
            layers.edges,
            layers.edges,
            layers.edges,
            layers.arrows,
            layers.nodes,
        ];
        pass.set_bind_group(1, &loaded.records, &[]);
        for (list, pipeline) in self.draws.iter().enumerate().filter(|(list, _)| shown[*list]) {
            pass.set_pipeline(pipeline);
            loaded.draw_list(pass, list, 0);
        }
    }

    /// Draws ids for the lists of the last [`sort`](Self::sort).
    pub fn draw_ids(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        pass.set_bind_group(1, &loaded.records, &[]);
        if layers.edges {
            pass.set_pipeline(&self.edge_id_straight);
            (0..BENT).chain([HOT_FAR]).for_each(|list| loaded.draw_list(pass, list, LISTS));
            pass.set_pipeline(&self.edge_id);
            (BENT..ARROWS).chain([HOT_NEAR]).for_each(|list| loaded.draw_list(pass, list, LISTS));
        }
        if layers.nodes {
            pass.set_pipeline(&self.node_id);
            loaded.draw_list(pass, NODES, LISTS);
        }
    }
}

impl Loaded {
    /// Draws a list, with the arguments at `draws` and after.
    fn draw_list(&self, pass: &mut RenderPass<'_>, list: usize, draws: usize) {
        pass.set_bind_group(2, &self.lists[list], &[]);
        pass.draw_indirect(&self.draws, ((draws + list) * size_of::<DrawArguments>()) as u64);
    }
}
