//! Robots: sorted by size in the picture, then drawn as meshes, blocks and marks.

use bytemuck::{Pod, Zeroable};
use glam::UVec2;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, IndexFormat, PrimitiveTopology,
    RenderPass, RenderPipeline, ShaderStages, VertexBufferLayout, VertexStepMode, util::DeviceExt, vertex_attr_array,
};

use super::columns::{Columns, buffer};
use super::device::Gpu;
use super::layout::{Draw, IDS, Kind, Layering, TargetKind, bind, bindings, compute_with, render, shader};
use super::splats::Splats;
use super::timer::Timer;
use crate::mesh::{Mesh, Vertex};

/// Meshes that robots can have; the same as in sort.wgsl.
pub const MESHES: usize = 8;
/// Robots that are drawn as each of them.
const MESH_CAPACITY: usize = 8_192;
/// Robots that are drawn as boxes, and as round blocks.
const BLOCK_CAPACITY: usize = 131_072;
/// Lists: one for each mesh, one of boxes, one of round blocks, one of marks, one of tiles with marks.
const LISTS: usize = MESHES + 4;
const MARKS: usize = MESHES + 2;
const TILES: usize = MESHES + 3;
/// Threads of a group of the sorting shader.
const GROUP: u32 = 64;
/// Bytes of the shaders' `Body` and `Corner`.
const INSTANCE_BYTES: u64 = 28;
const CORNER_BYTES: usize = 16;

/// What an indirect draw takes.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct DrawArguments {
    indices: u32,
    instances: u32,
    first_index: u32,
    base_vertex: i32,
    first_instance: u32,
}

/// A mesh on the GPU.
#[derive(Debug)]
struct MeshBuffers {
    vertices: Buffer,
    indices: Buffer,
    count: u32,
}

#[derive(Debug)]
struct Pipelines {
    body: RenderPipeline,
    block: RenderPipeline,
    shadow: RenderPipeline,
    mark: RenderPipeline,
    round_mark: RenderPipeline,
    body_id: RenderPipeline,
    mark_id: RenderPipeline,
}

/// All that draws robots.
#[derive(Debug)]
pub struct Robots {
    /// Without and with splats.
    sort: [ComputePipeline; 2],
    lists_layout: BindGroupLayout,
    lists: Option<BindGroup>,
    mark_ids_layout: BindGroupLayout,
    mark_ids_group: Option<BindGroup>,
    bodies: Buffer,
    /// Corners of the marks, three for each, and whose marks they are.
    corners: Buffer,
    mark_ids: Buffer,
    draws: Buffer,
    /// What `draws` is before the robots are counted.
    blank_draws: Buffer,
    /// Shadows: as many as there are meshes and blocks.
    shadow_draws: Buffer,
    meshes: Vec<MeshBuffers>,
    blocks: [MeshBuffers; 2],
    quad: Buffer,
    pipelines: Pipelines,
    any_round: bool,
    /// Marks as pixels rather than as triangles: for how many robots or more, and whether they are now.
    splats: Splats,
    splats_from: u32,
    are_splats: bool,
}

impl Robots {
    pub fn new(gpu: &Gpu, target: TargetKind, view: &BindGroupLayout, columns: &Columns) -> Self {
        let lists_layout = bindings(gpu, "lists", ShaderStages::COMPUTE, &[Kind::Write; 5]);
        let mark_ids_layout = bindings(gpu, "mark ids", ShaderStages::VERTEX, &[Kind::Read]);
        let sorting = shader(gpu, "sort");
        let lists = BufferUsages::STORAGE | BufferUsages::VERTEX;
        let draws = BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        let bytes = LISTS * size_of::<DrawArguments>();
        let index = BufferUsages::INDEX;
        let ids = TargetKind { format: IDS, samples: 1, splats_from: u32::MAX };
        let mut robots = Self {
            sort: [0.0, 1.0].map(|splats| {
                let groups = [view, columns.layout(), &lists_layout];
                compute_with(gpu, &sorting, "sort", &groups, &[("SPLATS", splats)])
            }),
            lists_layout,
            lists: None,
            mark_ids_group: None,
            bodies: buffer(
                gpu,
                "bodies",
                (MESHES * MESH_CAPACITY + 2 * BLOCK_CAPACITY) * INSTANCE_BYTES as usize,
                lists,
            ),
            corners: buffer(gpu, "corners", 3 * CORNER_BYTES, lists),
            mark_ids: buffer(gpu, "mark ids", size_of::<u32>(), BufferUsages::STORAGE),
            draws: buffer(gpu, "draws", bytes, draws),
            blank_draws: buffer(gpu, "blank draws", bytes, BufferUsages::COPY_SRC),
            shadow_draws: buffer(gpu, "shadow draws", bytes, BufferUsages::INDIRECT),
            meshes: [Mesh::amr(), Mesh::round_amr()].iter().map(|mesh| upload(gpu, mesh)).collect(),
            blocks: [Mesh::block(), Mesh::round_block()].map(|mesh| upload(gpu, &mesh)),
            quad: init(gpu, bytemuck::cast_slice(&[0_u32, 1, 2, 2, 1, 3]), index),
            pipelines: Pipelines::new(gpu, [target, ids], view, &mark_ids_layout),
            mark_ids_layout,
            any_round: false,
            splats: Splats::new(gpu, [target, ids], view),
            splats_from: target.splats_from,
            are_splats: false,
        };
        robots.write_draws(gpu);
        robots
    }

    /// Adds a mesh from a file; gives its number, or `None` if there are too many.
    pub fn add_mesh(&mut self, gpu: &Gpu, mesh: &Mesh) -> Option<usize> {
        if self.meshes.len() == MESHES {
            return None;
        }
        self.meshes.push(upload(gpu, mesh));
        self.write_draws(gpu);
        Some(self.meshes.len() - 1)
    }

    /// Another mesh under a number that `add_mesh` gave.
    pub fn replace_mesh(&mut self, gpu: &Gpu, number: usize, mesh: &Mesh) {
        self.meshes[number] = upload(gpu, mesh);
        self.write_draws(gpu);
    }

    /// Whether any robot's mark is a circle.
    pub fn set_any_round(&mut self, any_round: bool) {
        self.any_round = any_round;
    }

    fn write_draws(&mut self, gpu: &Gpu) {
        let mut draws = [DrawArguments::default(); LISTS];
        for (list, mesh) in self.lists_of_bodies() {
            draws[list].indices = mesh.count;
        }
        // Not indexed, no instances: corners alone.
        (draws[MARKS].instances, draws[TILES].instances) = (1, 1);
        gpu.queue.write_buffer(&self.blank_draws, 0, bytemuck::cast_slice(&draws));
        let shadows = draws.map(|draw| DrawArguments { indices: 6, ..draw });
        gpu.queue.write_buffer(&self.shadow_draws, 0, bytemuck::cast_slice(&shadows));
    }

    /// Makes room for as many marks as there may be robots, or as the adapter has room for.
    fn fit(&mut self, gpu: &Gpu, columns: &Columns, size: UVec2) {
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        let triangles = 3 * CORNER_BYTES;
        let has_room = (columns.rows() * triangles) as u64 <= limit;
        let may_splat = columns.robots()[0] >= self.splats_from || !has_room;
        self.are_splats = may_splat && Splats::fits(size, limit);
        let of_a_robot = if self.are_splats { CORNER_BYTES } else { triangles };
        let marks = columns.rows().min(limit as usize / of_a_robot);
        let mut renewed = self.are_splats && self.splats.fit(gpu, size);
        let ids = if self.are_splats { 1 } else { marks };
        let sizes = [marks * of_a_robot, ids * size_of::<u32>()];
        if [self.corners.size(), self.mark_ids.size()] != sizes.map(|bytes| bytes as u64) {
            let corners = BufferUsages::STORAGE | BufferUsages::VERTEX;
            self.corners = buffer(gpu, "corners", marks * of_a_robot, corners);
            self.mark_ids = buffer(gpu, "mark ids", ids * size_of::<u32>(), BufferUsages::STORAGE);
            renewed = true;
        }
        if renewed {
            self.lists = None;
            self.mark_ids_group = None;
            self.splats.bind(gpu, &self.corners);
        }
    }

    /// Sorts the robots of a picture of a size into lists.
    pub fn sort(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        size: UVec2,
        view: &BindGroup,
        columns: &mut Columns,
        timer: Option<&Timer>,
    ) {
        self.fit(gpu, columns, size);
        if self.are_splats {
            self.splats.clear(encoder);
        }
        let (marks, pixels) = (&self.corners, self.splats.pixels());
        let buffers = [(0, &self.bodies), (1, marks), (2, &self.mark_ids), (3, &self.draws), (4, pixels)];
        let lists = self.lists.get_or_insert_with(|| bind(gpu, &self.lists_layout, &buffers)).clone();
        let ids = [(0, &self.mark_ids)];
        self.mark_ids_group.get_or_insert_with(|| bind(gpu, &self.mark_ids_layout, &ids));
        let poses = columns.group(gpu);
        encoder.copy_buffer_to_buffer(&self.blank_draws, 0, &self.draws, 0, self.draws.size());
        {
            let timestamp_writes = timer.map(Timer::start);
            let mut pass =
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sort"), timestamp_writes });
            pass.set_pipeline(&self.sort[usize::from(self.are_splats)]);
            pass.set_bind_group(0, view, &[]);
            pass.set_bind_group(1, &poses, &[]);
            pass.set_bind_group(2, &lists, &[]);
            let needed = columns.robots()[0].div_ceil(GROUP);
            // No side of the grid may be longer than this.
            let across = needed.clamp(1, 32_768);
            pass.dispatch_workgroups(across, needed.div_ceil(across).max(1), 1);
        }
        let stride = size_of::<DrawArguments>() as u64;
        for list in 0..MARKS as u64 {
            let count = list * stride + 4;
            encoder.copy_buffer_to_buffer(&self.draws, count, &self.shadow_draws, count, 4);
        }
    }

    /// Draws shadows on the ground.
    pub fn draw_shadows(&self, pass: &mut RenderPass<'_>) {
        pass.set_pipeline(&self.pipelines.shadow);
        pass.set_index_buffer(self.quad.slice(..), IndexFormat::Uint32);
        for (list, _) in self.lists_of_bodies() {
            pass.set_vertex_buffer(0, self.bodies_of(list));
            pass.draw_indexed_indirect(&self.shadow_draws, draw_at(list));
        }
    }

    /// Draws the robots.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        self.draw_bodies(pass, &self.pipelines.body, &self.pipelines.block);
        if self.are_splats {
            self.splats.draw(pass, &self.draws, draw_at(TILES));
        } else {
            self.draw_marks(pass, if self.any_round { &self.pipelines.round_mark } else { &self.pipelines.mark });
        }
    }

    /// Draws the robots' ids, as they were sorted last.
    pub fn draw_ids(&self, pass: &mut RenderPass<'_>) {
        self.draw_bodies(pass, &self.pipelines.body_id, &self.pipelines.body_id);
        if self.are_splats {
            self.splats.draw_ids(pass, &self.draws, draw_at(TILES));
        } else {
            self.draw_marks(pass, &self.pipelines.mark_id);
        }
    }

    fn draw_bodies(&self, pass: &mut RenderPass<'_>, body: &RenderPipeline, block: &RenderPipeline) {
        pass.set_pipeline(body);
        for (list, mesh) in self.meshes.iter().enumerate() {
            self.draw_list(pass, list, mesh);
        }
        pass.set_pipeline(block);
        for (list, mesh) in (MESHES..).zip(&self.blocks) {
            self.draw_list(pass, list, mesh);
        }
    }

    fn draw_marks(&self, pass: &mut RenderPass<'_>, mark: &RenderPipeline) {
        pass.set_pipeline(mark);
        pass.set_bind_group(1, &self.mark_ids_group, &[]);
        pass.set_vertex_buffer(0, self.corners.slice(..));
        pass.draw_indirect(&self.draws, draw_at(MARKS));
    }

    fn draw_list(&self, pass: &mut RenderPass<'_>, list: usize, mesh: &MeshBuffers) {
        pass.set_vertex_buffer(0, self.bodies_of(list));
        pass.set_vertex_buffer(1, mesh.vertices.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), IndexFormat::Uint32);
        pass.draw_indexed_indirect(&self.draws, draw_at(list));
    }

    /// The lists that are used, and what stands in each.
    fn lists_of_bodies(&self) -> impl Iterator<Item = (usize, &MeshBuffers)> {
        self.meshes.iter().enumerate().chain((MESHES..).zip(&self.blocks))
    }

    fn bodies_of(&self, list: usize) -> wgpu::BufferSlice<'_> {
        let start = list.min(MESHES) * MESH_CAPACITY + list.saturating_sub(MESHES) * BLOCK_CAPACITY;
        self.bodies.slice(start as u64 * INSTANCE_BYTES..)
    }
}

fn draw_at(list: usize) -> u64 {
    (list * size_of::<DrawArguments>()) as u64
}

fn init(gpu: &Gpu, contents: &[u8], usage: BufferUsages) -> Buffer {
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

fn upload(gpu: &Gpu, mesh: &Mesh) -> MeshBuffers {
    MeshBuffers {
        vertices: init(gpu, bytemuck::cast_slice(&mesh.vertices), BufferUsages::VERTEX),
        indices: init(gpu, bytemuck::cast_slice(&mesh.indices), BufferUsages::INDEX),
        count: mesh.indices.len() as u32,
    }
}

impl Pipelines {
    fn new(gpu: &Gpu, [target, ids]: [TargetKind; 2], view: &BindGroupLayout, mark_ids: &BindGroupLayout) -> Self {
        let module = shader(gpu, "robots");
        let instance = |attributes| VertexBufferLayout {
            array_stride: INSTANCE_BYTES,
            step_mode: VertexStepMode::Instance,
            attributes,
        };
        let body_attributes = vertex_attr_array![
            0 => Float32x2, 1 => Snorm16x2, 2 => Unorm8x4, 3 => Float16x2, 4 => Float16x2, 5 => Uint32
        ];
        let corner_attributes = vertex_attr_array![0 => Float32x3, 1 => Unorm8x4];
        let vertex_attributes = vertex_attr_array![6 => Float32x3, 7 => Snorm8x4, 8 => Unorm8x4];
        let vertices = VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attributes,
        };
        let body = [instance(&body_attributes[..]), vertices];
        let corner = [VertexBufferLayout {
            array_stride: CORNER_BYTES as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &corner_attributes,
        }];
        let standing = |target, vertex, fragment, groups, buffers| {
            let topology = PrimitiveTopology::TriangleList;
            let (layering, blend) = (Layering::Standing, false);
            render(gpu, target, &Draw { module: &module, vertex, fragment, groups, buffers, topology, layering, blend })
        };
        Self {
            body: standing(target, "body", "shaded", &[view], &body),
            block: standing(target, "block", "plain", &[view], &body),
            mark: standing(target, "mark", "mark_plain", &[view, mark_ids], &corner),
            round_mark: standing(target, "round_mark", "mark_round", &[view, mark_ids], &corner),
            body_id: standing(ids, "body_id", "id_of", &[view], &body),
            mark_id: standing(ids, "mark_id", "id_of", &[view, mark_ids], &corner),
            shadow: render(
                gpu,
                target,
                &Draw {
                    module: &module,
                    vertex: "shadow",
                    fragment: "shadowed",
                    groups: &[view],
                    buffers: &body[..1],
                    topology: PrimitiveTopology::TriangleList,
                    layering: Layering::Ground,
                    blend: true,
                },
            ),
        }
    }
}
