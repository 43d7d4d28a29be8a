//! Robots: a compute shader sorts them by their size in the picture into draw lists of meshes,
//! blocks and marks.

mod pipelines;

use glam::UVec2;
use wgpu::util::{BufferInitDescriptor, DeviceExt, DrawIndexedIndirectArgs};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, IndexFormat, RenderPass,
    RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_buffers, bind_group_layout};
use super::columns::Columns;
use super::density::Density;
use super::device::Gpu;
use super::pipeline::{Output, TargetConfig, dispatch};
use super::resources::buffer;
use super::splats::Splats;
use super::timer::Timer;
use crate::mesh::{Mesh, MeshBuffers};
use pipelines::{BODY_BYTES, CORNER_BYTES, Pipelines, Sorting};
pub use pipelines::{Dense, Variant};

/// The maximum number of meshes; the same as in sort.wgsl.
const MESHES: usize = 8;
/// The maximum number of robots that are drawn as one mesh; the same as in sort.wgsl.
const MESH_CAPACITY: usize = 8_192;
/// The maximum number of robots that are drawn as boxes, and of those drawn as round blocks; the
/// same as in sort.wgsl.
const BLOCK_CAPACITY: usize = 131_072;
/// The number of draw lists: one for each mesh, one each of boxes, round blocks, marks, and tiles
/// with marks.
const LISTS: usize = MESHES + 4;
const MARKS: usize = MESHES + 2;
const TILES: usize = MESHES + 3;
/// Draws robots.
#[derive(Debug)]
pub struct Robots {
    sorting: Sorting,
    lists: Option<BindGroup>,
    mark_ids_layout: BindGroupLayout,
    mark_ids_group: Option<BindGroup>,
    bodies: Buffer,
    /// Corners of the marks' triangles, three for each; with splats one entry per robot.
    corners: Buffer,
    /// The id of each mark's robot.
    mark_ids: Buffer,
    draws: Buffer,
    /// The initial contents of `draws`, before the robots are counted.
    blank_draws: Buffer,
    /// The draws of shadows, one for each mesh and block.
    shadow_draws: Buffer,
    meshes: Vec<MeshBuffers>,
    blocks: [MeshBuffers; 2],
    quad: Buffer,
    pipelines: Pipelines,
    any_round: bool,
    splats: Splats,
    /// From this number of robots on, marks are splatted.
    splats_from: u32,
    density: Density,
    /// The variant that sorted the last picture.
    variant: Variant,
}

impl Robots {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout, columns: &Columns) -> Self {
        let mark_ids_layout =
            bind_group_layout(gpu, "mark ids", ShaderStages::VERTEX, &[Binding::Read]);
        let lists = BufferUsages::STORAGE | BufferUsages::VERTEX;
        let draws = BufferUsages::STORAGE | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        let body_bytes = (MESHES * MESH_CAPACITY + 2 * BLOCK_CAPACITY) * BODY_BYTES as usize;
        let draw_bytes = LISTS * size_of::<DrawIndexedIndirectArgs>();
        let mut robots = Self {
            sorting: Sorting::new(gpu, view, columns.layout()),
            lists: None,
            mark_ids_group: None,
            bodies: buffer(gpu, "bodies", body_bytes, lists),
            corners: buffer(gpu, "corners", 3 * CORNER_BYTES, lists),
            mark_ids: buffer(gpu, "mark ids", size_of::<u32>(), BufferUsages::STORAGE),
            draws: buffer(gpu, "draws", draw_bytes, draws),
            blank_draws: buffer(gpu, "blank draws", draw_bytes, BufferUsages::COPY_SRC),
            shadow_draws: buffer(gpu, "shadow draws", draw_bytes, BufferUsages::INDIRECT),
            meshes: [Mesh::amr(), Mesh::round_amr()]
                .map(|mesh| MeshBuffers::new(gpu, &mesh))
                .into(),
            blocks: [Mesh::block(), Mesh::round_block()].map(|mesh| MeshBuffers::new(gpu, &mesh)),
            quad: gpu.device.create_buffer_init(&BufferInitDescriptor {
                label: Some("quad"),
                contents: bytemuck::cast_slice(&[0_u32, 1, 2, 2, 1, 3]),
                usage: BufferUsages::INDEX,
            }),
            pipelines: Pipelines::new(gpu, target, view, &mark_ids_layout),
            mark_ids_layout,
            any_round: false,
            splats: Splats::new(gpu, target, view),
            splats_from: target.splats_from,
            density: Density::new(gpu, target, view),
            variant: Variant::default(),
        };
        robots.write_draws(gpu);
        robots
    }

    /// Adds a mesh. Returns its number, or `None` if there are too many.
    pub fn add_mesh(&mut self, gpu: &Gpu, mesh: &Mesh) -> Option<usize> {
        if self.meshes.len() == MESHES {
            return None;
        }
        self.meshes.push(MeshBuffers::new(gpu, mesh));
        self.write_draws(gpu);
        Some(self.meshes.len() - 1)
    }

    /// Replaces the mesh with a number that [`add_mesh`](Self::add_mesh) returned.
    pub fn replace_mesh(&mut self, gpu: &Gpu, number: usize, mesh: &Mesh) {
        self.meshes[number] = MeshBuffers::new(gpu, mesh);
        self.write_draws(gpu);
    }

    /// Sets whether any robot's mark is a circle.
    pub fn set_any_round(&mut self, any_round: bool) {
        self.any_round = any_round;
    }

    fn write_draws(&mut self, gpu: &Gpu) {
        let mut draws = [DrawIndexedIndirectArgs::default(); LISTS];
        for (list, mesh) in self.body_lists() {
            draws[list].index_count = mesh.count;
        }
        // These draws are not indexed: the shader counts vertices, which all belong to one
        // instance.
        (draws[MARKS].instance_count, draws[TILES].instance_count) = (1, 1);
        gpu.queue.write_buffer(&self.blank_draws, 0, bytemuck::cast_slice(&draws));
        let shadows = draws.map(|draw| DrawIndexedIndirectArgs { index_count: 6, ..draw });
        gpu.queue.write_buffer(&self.shadow_draws, 0, bytemuck::cast_slice(&shadows));
    }

    /// Decides whether to splat, and makes room for a mark per robot, as far as the adapter's
    /// limits allow.
    fn fit(&mut self, gpu: &Gpu, columns: &Columns, size: UVec2) {
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        let triangle_bytes = 3 * CORNER_BYTES;
        let has_room = (columns.rows() * triangle_bytes) as u64 <= limit;
        let may_splat = columns.robots() >= self.splats_from || !has_room;
        self.variant.splats = may_splat && Splats::fits(size, limit);
        let mark_bytes = if self.variant.splats { CORNER_BYTES } else { triangle_bytes };
        let marks = columns.rows().min(limit as usize / mark_bytes);
        if !Splats::fits(size, limit) {
            self.variant.dense = Dense::None;
        }
        let is_dense = self.variant.dense != Dense::None;
        let mut is_replaced = self.splats.fit(gpu, size, self.variant.splats, is_dense);
        if is_replaced {
            self.density.unbind();
        }
        if is_dense {
            self.density.fit(gpu, size, self.splats.pixels());
        }
        let ids = if self.variant.splats { 1 } else { marks };
        let sizes = [marks * mark_bytes, ids * size_of::<u32>()];
        if [self.corners.size(), self.mark_ids.size()] != sizes.map(|bytes| bytes as u64) {
            let corners = BufferUsages::STORAGE | BufferUsages::VERTEX;
            self.corners = buffer(gpu, "corners", marks * mark_bytes, corners);
            self.mark_ids = buffer(gpu, "mark ids", ids * size_of::<u32>(), BufferUsages::STORAGE);
            is_replaced = true;
        }
        if is_replaced {
            self.lists = None;
            self.mark_ids_group = None;
            self.splats.bind(gpu, &self.corners);
        }
    }

    /// Sets the variant that sorts the next picture, except whether marks are splatted.
    pub fn set_variant(&mut self, variant: Variant) {
        self.variant = variant;
    }

    fn has_marks(&self) -> bool {
        self.variant.dense != Dense::All
    }

    /// Sorts the robots of a picture of `size` pixels into the draw lists.
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
        if self.variant.splats || self.variant.dense != Dense::None {
            self.splats.clear(encoder, !self.has_marks());
        }
        let pixels = self.splats.pixels();
        let buffers = [&self.bodies, &self.corners, &self.mark_ids, &self.draws, pixels];
        let lists = self
            .lists
            .get_or_insert_with(|| bind_buffers(gpu, self.sorting.lists_layout(), &buffers))
            .clone();
        self.mark_ids_group
            .get_or_insert_with(|| bind_buffers(gpu, &self.mark_ids_layout, &[&self.mark_ids]));
        let poses = columns.group(gpu);
        encoder.copy_buffer_to_buffer(&self.blank_draws, 0, &self.draws, 0, self.draws.size());
        {
            let timestamp_writes = timer.map(Timer::start);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("sort"),
                timestamp_writes,
            });
            pass.set_pipeline(self.sorting.pipeline(gpu, self.variant));
            pass.set_bind_group(0, view, &[]);
            pass.set_bind_group(1, &poses, &[]);
            pass.set_bind_group(2, &lists, &[]);
            dispatch(&mut pass, columns.robots());
            if self.variant.dense != Dense::None {
                self.density.blur(&mut pass, self.variant.splats);
            }
        }
        if !self.has_marks() {
            return;
        }
        let stride = size_of::<DrawIndexedIndirectArgs>() as u64;
        for list in 0..MARKS as u64 {
            let count = list * stride + 4;
            encoder.copy_buffer_to_buffer(&self.draws, count, &self.shadow_draws, count, 4);
        }
    }

    /// Draws the density of small robots over the ground.
    pub fn draw_density(&self, pass: &mut RenderPass<'_>) {
        if self.variant.dense != Dense::None {
            self.density.draw(pass);
        }
    }

    /// Draws the shadows of meshes and blocks on the ground.
    pub fn draw_shadows(&self, pass: &mut RenderPass<'_>) {
        if !self.has_marks() {
            return;
        }
        pass.set_pipeline(&self.pipelines.shadow);
        pass.set_index_buffer(self.quad.slice(..), IndexFormat::Uint32);
        for (list, _) in self.body_lists() {
            pass.set_vertex_buffer(0, self.body_slice(list));
            pass.draw_indexed_indirect(&self.shadow_draws, draw_offset(list));
        }
    }

    /// Draws the robots, or their ids, for the lists of the last [`sort`](Self::sort).
    pub fn draw(&self, pass: &mut RenderPass<'_>, output: Output) {
        if !self.has_marks() {
            return;
        }
        let Pipelines { body, block, body_id, mark, round_mark, mark_id, .. } = &self.pipelines;
        let (body, block, mark) = match output {
            Output::Colours if self.any_round => (body, block, round_mark),
            Output::Colours => (body, block, mark),
            Output::Ids => (body_id, body_id, mark_id),
        };
        self.draw_bodies(pass, body, block);
        if self.variant.splats {
            self.splats.draw(pass, output, &self.draws, draw_offset(TILES));
        } else {
            self.draw_marks(pass, mark);
        }
    }

    fn draw_bodies(
        &self,
        pass: &mut RenderPass<'_>,
        body: &RenderPipeline,
        block: &RenderPipeline,
    ) {
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
        pass.draw_indirect(&self.draws, draw_offset(MARKS));
    }

    fn draw_list(&self, pass: &mut RenderPass<'_>, list: usize, mesh: &MeshBuffers) {
        pass.set_vertex_buffer(0, self.body_slice(list));
        pass.set_vertex_buffer(1, mesh.vertices.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), IndexFormat::Uint32);
        pass.draw_indexed_indirect(&self.draws, draw_offset(list));
    }

    /// The lists of meshes and blocks that are in use, with their meshes.
    fn body_lists(&self) -> impl Iterator<Item = (usize, &MeshBuffers)> {
        self.meshes.iter().enumerate().chain((MESHES..).zip(&self.blocks))
    }

    fn body_slice(&self, list: usize) -> wgpu::BufferSlice<'_> {
        let start = list.min(MESHES) * MESH_CAPACITY + list.saturating_sub(MESHES) * BLOCK_CAPACITY;
        self.bodies.slice(start as u64 * BODY_BYTES..)
    }
}

fn draw_offset(list: usize) -> u64 {
    (list * size_of::<DrawIndexedIndirectArgs>()) as u64
}
