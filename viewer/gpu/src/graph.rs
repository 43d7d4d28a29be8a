//! The route graph: the nodes and curves of the world on the GPU, culled and sorted into draw lists
//! there.

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord};
use regatta_scene::curves::{curve_length, middle};
use regatta_scene::{Layers, is_on_level};
use wgpu::util::DrawIndirectArgs;
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, Buffer, BufferBinding, BufferSize, BufferUsages,
    CommandEncoder, ComputePipeline, PrimitiveTopology, RenderPass, RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_buffers, bind_group, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{
    PipelineDescriptor, TargetConfig, compute_pipeline, dispatch, render_pipeline, shader,
};
use super::resources::buffer;

/// The number of draw lists, of which the last two are for picking only; the same as in graph.wgsl.
const LISTS: usize = 9;
const SHOWN: usize = 7;
/// The first list of bent curves; the lists before it have straight ones.
const BENT: usize = 2;
const ARROWS: usize = 5;
const NODES: usize = 6;
const HOT_FAR: usize = 7;
const HOT_NEAR: usize = 8;
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
        let [lines, triangles, strip] = [
            PrimitiveTopology::LineList,
            PrimitiveTopology::TriangleList,
            PrimitiveTopology::TriangleStrip,
        ];
        let sorting = [view, &records_layout, &lists_layout];
        let [sort_curves, sort_nodes, fill_lists] = ["sort_curves", "sort_nodes", "fill_lists"]
            .map(|entry| compute_pipeline(gpu, &module, entry, &sorting, &[]));
        let draws = [
            ("edge_far", "ribbon_fill", lines),
            ("edge_straight", "ribbon_fill", triangles),
            ("edge_bent", "ribbon_fill", strip),
            ("edge_curved", "ribbon_fill", strip),
            ("edge_near", "ribbon_fill", strip),
            ("arrow", "flat_fill", triangles),
            ("node", "disc_fill", triangles),
        ]
        .map(|(vertex, fragment, topology)| PipelineDescriptor {
            topology,
            ..PipelineDescriptor::new(&module, vertex, fragment, &groups)
        });
        let ids = [
            ("edge_id_straight", "ribbon_id", triangles),
            ("edge_id", "ribbon_id", strip),
            ("node_id", "disc_id", triangles),
        ];
        let [edge_id_straight, edge_id, node_id] = ids.map(|(vertex, fragment, topology)| {
            let descriptor = PipelineDescriptor {
                topology,
                ..PipelineDescriptor::new(&module, vertex, fragment, &groups)
            };
            render_pipeline(gpu, TargetConfig::IDS, &descriptor)
        });
        Self {
            sort_curves,
            sort_nodes,
            fill_lists,
            draws: draws.map(|descriptor| render_pipeline(gpu, target, &descriptor)),
            edge_id_straight,
            edge_id,
            node_id,
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
        let storage = BufferUsages::STORAGE;
        let curve_records = buffer(gpu, "curves", size_of_val(&curves[..]), storage);
        gpu.queue.write_buffer(&curve_records, 0, bytemuck::cast_slice(&curves));
        let node_records = buffer(gpu, "nodes", size_of_val(&nodes[..]), storage);
        gpu.queue.write_buffer(&node_records, 0, bytemuck::cast_slice(&nodes));
        let word = size_of::<u32>();
        let lists = buffer(gpu, "graph lists", LISTS * list_bytes, storage);
        let masks = buffer(gpu, "graph masks", (curves.len() + nodes.len()) * word, storage);
        let hot = buffer(gpu, "hot curves", curves.len().div_ceil(32) * word, storage);
        let draw_bytes = 2 * LISTS * size_of::<DrawIndirectArgs>();
        let draws = buffer(gpu, "graph draws", draw_bytes, storage | BufferUsages::INDIRECT);
        let list_groups = std::array::from_fn(|list| {
            let (offset, size) = ((list * list_bytes) as u64, BufferSize::new(list_bytes as u64));
            let list = BufferBinding { buffer: &lists, offset, size };
            bind_group(gpu, &self.shown_layout, &[BindingResource::Buffer(list)])
        });
        self.loaded = Some(Loaded {
            curves: curves.len() as u32,
            nodes: nodes.len() as u32,
            records: bind_buffers(gpu, &self.records_layout, &[&curve_records, &node_records]),
            sorting: bind_buffers(gpu, &self.lists_layout, &[&lists, &masks, &draws, &hot]),
            lists: list_groups,
            draws,
            hot,
        });
    }

    /// Sets the curves that are ribbons of the heat map, and not drawn under them.
    pub fn set_hot(&self, gpu: &Gpu, curves: impl Iterator<Item = u32>) {
        let Some(loaded) = &self.loaded else { return };
        let mut bits = vec![0_u32; loaded.curves.div_ceil(32) as usize];
        for curve in curves {
            if let Some(word) = bits.get_mut(curve as usize / 32) {
                *word |= 1 << (curve % 32);
            }
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
            pass.set_pipeline(pipeline);
            dispatch(&mut pass, count);
        }
        pass.set_pipeline(&self.fill_lists);
        pass.dispatch_workgroups(1, 1, 1);
    }

    /// Draws the lists of the last [`sort`](Self::sort).
    pub fn draw(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        pass.set_bind_group(1, &loaded.records, &[]);
        for (list, pipeline) in self.draws.iter().enumerate() {
            let is_shown = match list {
                ARROWS => layers.arrows,
                NODES => layers.nodes,
                _ => layers.edges,
            };
            if is_shown {
                pass.set_pipeline(pipeline);
                loaded.draw_list(pass, list, 0);
            }
        }
    }

    /// Draws ids for the lists of the last [`sort`](Self::sort).
    pub fn draw_ids(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        pass.set_bind_group(1, &loaded.records, &[]);
        if layers.edges {
            pass.set_pipeline(&self.edge_id_straight);
            for list in (0..BENT).chain([HOT_FAR]) {
                loaded.draw_list(pass, list, LISTS);
            }
            pass.set_pipeline(&self.edge_id);
            for list in (BENT..ARROWS).chain([HOT_NEAR]) {
                loaded.draw_list(pass, list, LISTS);
            }
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
        pass.draw_indirect(&self.draws, ((draws + list) * size_of::<DrawIndirectArgs>()) as u64);
    }
}

/// A curve of an edge, or of none. The same as `Curve` in curves.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct CurveInstance {
    /// Index of the edge in the world.
    edge: u32,
    /// Metres.
    length: f32,
    /// Metres; 0 if the curve belongs to no edge, and isn't drawn.
    edge_length: f32,
    /// The edge's speed in reverse gear in metres per second; 0 if that isn't allowed.
    reverse_speed: f32,
    control_points: [Vec2; 4],
    /// The parameter of the edge's arrow, or a negative number if the arrow is on another curve.
    arrow: f32,
    reserved: f32,
}

impl CurveInstance {
    /// A curve of no edge.
    fn unused(curve: &CurveRecord) -> Self {
        Self {
            edge: u32::MAX,
            control_points: curve.control_points.map(Vec2::from),
            arrow: -1.0,
            ..Self::zeroed()
        }
    }
}

/// Returns the world's curves, at their indices in the world.
fn curve_instances(world: &World<'_>, level: Option<&str>) -> Vec<CurveInstance> {
    let mut instances: Vec<_> = world.all_curves().iter().map(CurveInstance::unused).collect();
    for (index, edge) in (0..).zip(world.edges()) {
        if !is_on_level(world, edge.level, level) {
            continue;
        }
        let curves = world.curves(edge);
        let first = edge.first_curve as usize;
        if let Some(instances) = instances.get_mut(first..first + curves.len()) {
            assign(instances, (index, edge), curves);
        }
    }
    instances
}

/// Assigns curves to their edge.
fn assign(
    instances: &mut [CurveInstance],
    (index, edge): (u32, &EdgeRecord),
    curves: &[CurveRecord],
) {
    let total: f32 = curves.iter().map(curve_length).sum();
    let scale = edge.length / total.max(1e-6);
    let (with_arrow, parameter) = middle(curves);
    for (number, (instance, curve)) in instances.iter_mut().zip(curves).enumerate() {
        instance.edge = index;
        instance.length = if curves.len() == 1 { edge.length } else { curve_length(curve) * scale };
        instance.edge_length = edge.length;
        instance.reverse_speed = edge.reverse_speed;
        instance.arrow = if number == with_arrow { parameter } else { -1.0 };
    }
}

/// Returns the positions of the world's nodes, at their indices in the world. Those of other levels
/// are not a number, and never in sight.
fn node_instances(world: &World<'_>, level: Option<&str>) -> Vec<Vec2> {
    let mut positions = Vec::with_capacity(world.nodes().len());
    for node in world.nodes() {
        let is_shown = is_on_level(world, node.level, level);
        positions.push(if is_shown { Vec2::new(node.x, node.y) } else { Vec2::NAN });
    }
    positions
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;

    #[test]
    fn every_curve_knows_its_edge_and_one_has_the_arrow() {
        let line = CurveRecord::straight;
        let mut world = WorldData::default();
        let edge = |length| EdgeRecord { length, reverse_speed: 0.5, ..EdgeRecord::default() };
        world.add_edge(edge(2.0), [line([0.0, 0.0], [2.0, 0.0])]);
        world.add_edge(edge(8.0), [line([2.0, 0.0], [2.0, 2.0]), line([2.0, 2.0], [8.0, 2.0])]);
        world.curves.push(line([0.0, 0.0], [1.0, 1.0]));
        let instances = curve_instances(&world.view(1, 1), None);
        assert_eq!(
            instances.iter().map(|instance| instance.edge).collect::<Vec<_>>(),
            [0, 1, 1, u32::MAX]
        );
        let near = |numbers: [f32; 4], expected: [f32; 4]| {
            numbers.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3)
        };
        let column =
            |of: fn(&CurveInstance) -> f32| [0, 1, 2, 3].map(|index| of(&instances[index]));
        assert!(near(column(|instance| instance.length), [2.0, 2.0, 6.0, 0.0]));
        assert!(
            near(column(|instance| instance.arrow), [0.5, -1.0, 1.0 / 3.0, -1.0]),
            "{instances:?}"
        );
        assert!(near(column(|instance| instance.edge_length), [2.0, 8.0, 8.0, 0.0]));
        assert_eq!(instances[2].control_points, world.curves[2].control_points.map(Vec2::from));
    }
}
