//! The route graph: the nodes and curves of the world on the GPU, culled and sorted into draw lists there.

use bytemuck::{Pod, Zeroable};
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, PrimitiveTopology, RenderPass,
    RenderPipeline, ShaderStages, VertexBufferLayout, VertexStepMode, vertex_attr_array,
};

use super::bindings::{Binding, bind_group, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, compute_pipeline, render_pipeline};
use super::resources::buffer;
use super::shaders::shader;
use crate::curves::{curve_length, middle};
use crate::scene::Layers;

/// The number of draw lists; the same as in graph.wgsl.
const LISTS: usize = 7;
/// The first list of bent curves; the lists before it have straight ones.
const BENT: usize = 2;
const ARROWS: usize = 5;
const NODES: usize = 6;
/// Vertices per instance of each list: a line; strips of 2, 9, 33 and 129 points; two triangles; a strip of two
/// triangles.
const VERTICES: [u32; LISTS] = [2, 4, 18, 66, 258, 6, 4];
/// Vertices per instance of the widened strips that picking draws.
const PICK_VERTICES: [u32; LISTS] = [4, 4, 66, 66, 66, 6, 4];
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
    backwards: f32,
    control_points: [[f32; 2]; 4],
    /// The parameter of the edge's arrow, or a negative number if the arrow is on another curve.
    arrow: f32,
    reserved: f32,
}

/// Returns the world's curves, at their indices in the world.
fn curve_instances(world: &World<'_>, level: Option<&str>) -> Vec<CurveInstance> {
    let unused = |curve: &CurveRecord| CurveInstance {
        edge: u32::MAX,
        control_points: curve.control_points,
        arrow: -1.0,
        ..CurveInstance::zeroed()
    };
    let mut instances: Vec<_> = world.all_curves().iter().map(unused).collect();
    let is_shown = |text: u32| level.is_none_or(|level| world.text(text) == level);
    for (index, edge) in (0..).zip(world.edges()).filter(|(_, edge)| is_shown(edge.level)) {
        let curves = world.curves(edge);
        let first = edge.first_curve as usize;
        if let Some(instances) = instances.get_mut(first..first + curves.len()) {
            assign(instances, (index, edge), curves);
        }
    }
    instances
}

/// Assigns curves to their edge.
fn assign(instances: &mut [CurveInstance], (index, edge): (u32, &EdgeRecord), curves: &[CurveRecord]) {
    let total: f32 = curves.iter().map(curve_length).sum();
    let scale = edge.length / total.max(1e-6);
    let (with_arrow, parameter) = middle(curves);
    for (number, (instance, curve)) in instances.iter_mut().zip(curves).enumerate() {
        instance.edge = index;
        instance.length = if curves.len() == 1 { edge.length } else { curve_length(curve) * scale };
        instance.edge_length = edge.length;
        instance.backwards = edge.velocity_backwards;
        instance.arrow = if number == with_arrow { parameter } else { -1.0 };
    }
}

/// A node. The same as `Node` in curves.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct NodeInstance {
    position: [f32; 2],
}

/// Draws the graph.
#[derive(Debug)]
pub struct Graph {
    records_layout: BindGroupLayout,
    lists_layout: BindGroupLayout,
    sort_curves: ComputePipeline,
    sort_nodes: ComputePipeline,
    /// A pipeline for each list: curves by their curvature in the picture, arrows, nodes.
    draws: [RenderPipeline; LISTS],
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
    lists: Buffer,
    draws: Buffer,
    /// The initial contents of `draws`, without instances.
    blank_draws: Buffer,
    pick_draws: Buffer,
}

impl Graph {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let stages = ShaderStages::VERTEX | ShaderStages::COMPUTE;
        let records_layout = bind_group_layout(gpu, "graph", stages, &[Binding::Read; 2]);
        let lists_layout = bind_group_layout(gpu, "graph lists", ShaderStages::COMPUTE, &[Binding::Write; 2]);
        let module = shader(gpu, "graph");
        let attributes = vertex_attr_array![0 => Uint32];
        let index =
            [VertexBufferLayout { array_stride: 4, step_mode: VertexStepMode::Instance, attributes: &attributes }];
        let groups = [view, &records_layout];
        let make = |target: TargetConfig, vertex, fragment, topology| {
            let descriptor = PipelineDescriptor {
                module: &module,
                vertex,
                fragment,
                groups: &groups,
                buffers: &index,
                topology,
                depth: DepthMode::Ignored,
                blend: target != TargetConfig::IDS,
            };
            render_pipeline(gpu, target, &descriptor)
        };
        let sort = |entry| compute_pipeline(gpu, &module, entry, &[view, &records_layout, &lists_layout], &[]);
        let strip = PrimitiveTopology::TriangleStrip;
        let ids = TargetConfig::IDS;
        Self {
            sort_curves: sort("sort_curves"),
            sort_nodes: sort("sort_nodes"),
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

    /// Uploads a graph, which replaces the one before; of one level only if it is given.
    pub fn load(&mut self, gpu: &Gpu, world: &World<'_>, level: Option<&str>) {
        self.loaded = None;
        let curves = curve_instances(world, level);
        // A node without a place is not in sight.
        let is_shown = |node: &NodeRecord| level.is_none_or(|level| world.text(node.level) == level);
        let place = |node: &NodeRecord| NodeInstance {
            position: if is_shown(node) { [node.x, node.y] } else { [f32::NAN; 2] },
        };
        let nodes: Vec<_> = world.nodes().iter().map(place).collect();
        if curves.is_empty() || nodes.is_empty() {
            return;
        }
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        let bytes = size_of_val(&curves[..]).max((NODES * curves.len() + nodes.len()) * 4);
        if bytes as u64 > limit {
            tracing::warn!("the graph of {} curves is too large for this adapter and is not drawn", curves.len());
            return;
        }
        let upload = |label, bytes: &[u8], usage| {
            let buffer = buffer(gpu, label, bytes.len(), usage);
            gpu.queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let curve_records = upload("curves", bytemuck::cast_slice(&curves), BufferUsages::STORAGE);
        let node_records = upload("nodes", bytemuck::cast_slice(&nodes), BufferUsages::STORAGE);
        let entries = NODES * curves.len() + nodes.len();
        let lists = buffer(gpu, "graph lists", entries * 4, BufferUsages::STORAGE | BufferUsages::VERTEX);
        let arguments = |vertices: [u32; LISTS]| {
            vertices.map(|vertices| DrawArguments { vertices, instances: 0, first_vertex: 0, first_instance: 0 })
        };
        let usage = BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        let draws = upload("graph draws", bytemuck::cast_slice(&arguments(VERTICES)), usage);
        let blank_draws = upload("blank", bytemuck::cast_slice(&arguments(VERTICES)), BufferUsages::COPY_SRC);
        let pick_draws = upload("pick", bytemuck::cast_slice(&arguments(PICK_VERTICES)), BufferUsages::INDIRECT);
        self.loaded = Some(Loaded {
            curves: curves.len() as u32,
            nodes: nodes.len() as u32,
            records: bind_group(gpu, &self.records_layout, &[(0, &curve_records), (1, &node_records)]),
            sorting: bind_group(gpu, &self.lists_layout, &[(0, &lists), (1, &draws)]),
            lists,
            draws,
            blank_draws,
            pick_draws,
        });
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
        encoder.copy_buffer_to_buffer(&loaded.blank_draws, 0, &loaded.draws, 0, loaded.draws.size());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, view, &[]);
        pass.set_bind_group(1, &loaded.records, &[]);
        pass.set_bind_group(2, &loaded.sorting, &[]);
        for (pipeline, count) in [(&self.sort_curves, loaded.curves), (&self.sort_nodes, loaded.nodes)] {
            let needed = count.div_ceil(WORKGROUP);
            let across = needed.clamp(1, 32_768);
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(across, needed.div_ceil(across), 1);
        }
    }

    /// Draws the lists of the last [`sort`](Self::sort).
    pub fn draw(&self, pass: &mut RenderPass<'_>, layers: Layers) {
        let Some(loaded) = &self.loaded else { return };
        let shown = [layers.edges, layers.edges, layers.edges, layers.edges, layers.edges, layers.arrows, layers.nodes];
        pass.set_bind_group(1, &loaded.records, &[]);
        for (list, pipeline) in self.draws.iter().enumerate().filter(|(list, _)| shown[*list]) {
            pass.set_pipeline(pipeline);
            loaded.draw_list(pass, list, &loaded.draws);
        }
    }

    /// Draws ids for the lists of the last [`sort`](Self::sort).
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

    /// Copies the instance counts of the last picture for [`draw_ids`](Self::draw_ids).
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
        pass.set_vertex_buffer(0, self.lists.slice((list * self.curves as usize * 4) as u64..));
        pass.draw_indirect(draws, (list * size_of::<DrawArguments>()) as u64);
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::WorldData;

    use super::*;

    #[test]
    fn every_curve_knows_its_edge_and_one_has_the_arrow() {
        let line = CurveRecord::straight;
        let mut world = WorldData::default();
        let edge = |length| EdgeRecord { length, velocity_backwards: 0.5, ..EdgeRecord::default() };
        world.add_edge(edge(2.0), [line([0.0, 0.0], [2.0, 0.0])]);
        world.add_edge(edge(8.0), [line([2.0, 0.0], [2.0, 2.0]), line([2.0, 2.0], [8.0, 2.0])]);
        world.curves.push(line([0.0, 0.0], [1.0, 1.0]));
        let instances = curve_instances(&world.view(1, 1), None);
        assert_eq!(instances.iter().map(|instance| instance.edge).collect::<Vec<_>>(), [0, 1, 1, u32::MAX]);
        let near =
            |numbers: [f32; 4], expected: [f32; 4]| numbers.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3);
        let column = |of: fn(&CurveInstance) -> f32| [0, 1, 2, 3].map(|index| of(&instances[index]));
        assert!(near(column(|instance| instance.length), [2.0, 2.0, 6.0, 0.0]));
        assert!(near(column(|instance| instance.arrow), [0.5, -1.0, 1.0 / 3.0, -1.0]), "{instances:?}");
        assert!(near(column(|instance| instance.edge_length), [2.0, 8.0, 8.0, 0.0]));
        assert_eq!(instances[2].control_points, world.curves[2].control_points);
    }
}
