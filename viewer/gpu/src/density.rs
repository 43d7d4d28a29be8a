//! The density of robots from afar: sums by cells of the picture, which the sorting shader writes,
//! blurred and drawn as a field.

use std::ops::Range;

use glam::{UVec2, Vec2};
use regatta_plugin::World;
use regatta_scene::camera::Bounds;
use regatta_scene::curves::curve_point;
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, Buffer, BufferUsages, ComputePass,
    ComputePipeline, PrimitiveTopology, RenderPass, RenderPipeline, Sampler, ShaderStages,
    TextureFormat, TextureUsages,
};

use super::bindings::{Binding, bind_group, bind_group_layout, bind_texture};
use super::device::Gpu;
use super::pipeline::{
    PipelineDescriptor, TargetConfig, WORKGROUP, compute_pipeline, render_pipeline, shader,
};
use super::resources::{buffer, linear_sampler, texture, view_of};

/// The lengths in pixels between which robots fade from a field to marks.
pub const FADE: Range<f32> = 1.6..4.4;
/// The least number of robots per pixel of the picture at which marks are so many that they run
/// into each other: marks are larger than robots where there is room for that.
pub const CROWDED: f32 = 1.0 / 64.0;
/// Width and height of a cell in pixels; the same as in marks.wgsl.
const CELL: u32 = 4;

/// Columns and rows of the cells in which a graph's ground is counted.
const GROUND_CELLS: usize = 64;

/// Blurs and draws the field.
#[derive(Debug)]
pub struct Density {
    pack: ComputePipeline,
    /// As `pack`, with splatted marks before the cells.
    pack_after_splats: ComputePipeline,
    across: ComputePipeline,
    down: ComputePipeline,
    draw: RenderPipeline,
    blur_layout: BindGroupLayout,
    draw_layout: BindGroupLayout,
    sampler: Sampler,
    groups: Option<Groups>,
    cells: u32,
    size: UVec2,
}

#[derive(Debug)]
struct Groups {
    blur: BindGroup,
    draw: BindGroup,
}

impl Density {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let bindings = [Binding::Read, Binding::Write, Binding::Write, Binding::WriteTexture];
        let blur_layout = bind_group_layout(gpu, "density", ShaderStages::COMPUTE, &bindings);
        let drawn = [Binding::Texture, Binding::Sampler];
        let draw_layout = bind_group_layout(gpu, "field", ShaderStages::FRAGMENT, &drawn);
        let blur = shader(gpu, "density");
        let [pack, pack_after_splats, across, down] =
            [("pack", 0.0), ("pack", 1.0), ("across", 0.0), ("down", 0.0)].map(
                |(entry, splats)| {
                    let constants = [("SPLATS", splats)];
                    compute_pipeline(gpu, &blur, entry, &[view, &blur_layout], &constants)
                },
            );
        let (field, groups) = (shader(gpu, "field"), [view, &draw_layout]);
        let descriptor = PipelineDescriptor {
            topology: PrimitiveTopology::TriangleList,
            ..PipelineDescriptor::new(&field, "place", "fill", &groups)
        };
        Self {
            pack,
            pack_after_splats,
            across,
            down,
            draw: render_pipeline(gpu, target, &descriptor),
            sampler: linear_sampler(gpu),
            blur_layout,
            draw_layout,
            groups: None,
            cells: 1,
            size: UVec2::ZERO,
        }
    }

    /// The number of words that the sums take in a picture of `size` pixels.
    pub fn words(size: UVec2) -> u64 {
        4 * cells_of(size).as_u64vec2().element_product()
    }

    /// Makes room for a picture of `size` pixels, and binds the buffer with the sums, unless it is
    /// bound.
    pub fn fit(&mut self, gpu: &Gpu, size: UVec2, sums: &Buffer) {
        if self.size == size && self.groups.is_some() {
            return;
        }
        self.size = size;
        self.cells = cells_of(size).element_product();
        let [packed, across] = ["packed density", "blurred across"].map(|label| {
            buffer(gpu, label, self.cells as usize * 2 * size_of::<u32>(), BufferUsages::STORAGE)
        });
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
        let field = view_of(&texture(gpu, cells_of(size), TextureFormat::Rgba8Unorm, 1, usage));
        let [sums, packed, across] = [sums, &packed, &across].map(Buffer::as_entire_binding);
        let blurred = [sums, packed, across, BindingResource::TextureView(&field)];
        self.groups = Some(Groups {
            blur: bind_group(gpu, &self.blur_layout, &blurred),
            draw: bind_texture(gpu, &self.draw_layout, &field, &self.sampler),
        });
    }

    /// Forgets the buffer with the sums, which has been replaced.
    pub fn unbind(&mut self) {
        self.groups = None;
    }

    /// Blurs the sums. `are_splats` says whether marks were splatted.
    pub fn blur(&self, pass: &mut ComputePass<'_>, are_splats: bool) {
        let Some(Groups { blur, .. }) = &self.groups else { return };
        pass.set_bind_group(1, blur, &[]);
        let pack = if are_splats { &self.pack_after_splats } else { &self.pack };
        for pipeline in [pack, &self.across, &self.down] {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(self.cells.div_ceil(WORKGROUP), 1, 1);
        }
    }

    /// Draws the field over the ground.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        let Some(Groups { draw, .. }) = &self.groups else { return };
        pass.set_pipeline(&self.draw);
        pass.set_bind_group(1, draw, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Columns and rows of cells in a picture of `size` pixels.
fn cells_of(size: UVec2) -> UVec2 {
    UVec2::new(size.x.div_ceil(CELL), size.y.div_ceil(CELL))
}

/// Returns the ground that a graph's edges reach, in square metres, without the empty parts of a
/// site; `None` if there are no edges.
pub fn ground_of(world: &World<'_>) -> Option<f32> {
    let points = world
        .all_curves()
        .iter()
        .flat_map(|curve| [0.0, 0.25, 0.5, 0.75, 1.0].map(|at| curve_point(curve, at)));
    let bounds = Bounds::from_points(points.clone())?;
    // A single straight edge has no width of its own.
    let size = (bounds.high - bounds.low).max(Vec2::splat(1.0));
    let mut is_reached = vec![false; GROUND_CELLS * GROUND_CELLS];
    for point in points {
        let cell = ((point - bounds.low) / size * GROUND_CELLS as f32)
            .as_usizevec2()
            .min(glam::USizeVec2::splat(GROUND_CELLS - 1));
        is_reached[cell.y * GROUND_CELLS + cell.x] = true;
    }
    let reached = is_reached.iter().filter(|reached| **reached).count();
    Some(size.element_product() * reached as f32 / (GROUND_CELLS * GROUND_CELLS) as f32)
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

    use super::*;

    #[test]
    fn the_ground_of_a_graph_is_without_its_empty_parts() {
        assert_eq!(ground_of(&WorldData::default().view(1, 1)), None);
        let mut world = WorldData::default();
        // Two halls of 64 m by 64 m, 64 m apart.
        for row in 0..64 {
            for x in (0..64).chain(128..192) {
                let (x, y) = (x as f32, row as f32);
                world
                    .add_edge(EdgeRecord::default(), [CurveRecord::straight([x, y], [x + 1.0, y])]);
            }
        }
        let ground = ground_of(&world.view(1, 1)).expect("a ground");
        assert!((ground - 2.0 * 64.0 * 64.0).abs() < 500.0, "{ground}");
    }
}
