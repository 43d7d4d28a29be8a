//! Marks of far robots as pixels: the sorting shader puts them into a buffer, which is then drawn over the picture.

use glam::UVec2;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, PrimitiveTopology, RenderPass, RenderPipeline,
    ShaderStages,
};

use super::columns::buffer;
use super::device::Gpu;
use super::layout::{Draw, Kind, Layering, TargetKind, bind, bindings, render, shader};

/// Pixels across of a tile, the same as in marks.wgsl.
const TILE: u32 = 32;

/// The pixels, and what draws them.
#[derive(Debug)]
pub struct Splats {
    /// A word for each pixel of the picture, in rows; then one for each tile, and the numbers of those with marks.
    pixels: Buffer,
    size: UVec2,
    layout: BindGroupLayout,
    group: Option<BindGroup>,
    colours: RenderPipeline,
    ids: RenderPipeline,
}

impl Splats {
    pub fn new(gpu: &Gpu, targets: [TargetKind; 2], view: &BindGroupLayout) -> Self {
        let layout = bindings(gpu, "splats", ShaderStages::VERTEX_FRAGMENT, &[Kind::Read; 2]);
        let module = shader(gpu, "splats");
        let draw = |target, fragment| {
            let (vertex, groups, buffers) = ("tile", &[view, &layout][..], &[][..]);
            let (topology, layering, blend) = (PrimitiveTopology::TriangleList, Layering::Standing, false);
            render(gpu, target, &Draw { module: &module, vertex, fragment, groups, buffers, topology, layering, blend })
        };
        Self {
            colours: draw(targets[0], "splat"),
            ids: draw(targets[1], "splat_id"),
            pixels: words(gpu, UVec2::ZERO),
            size: UVec2::ZERO,
            group: None,
            layout,
        }
    }

    /// The words, for the shader that writes them.
    pub fn pixels(&self) -> &Buffer {
        &self.pixels
    }

    /// Whether a picture of a size fits into buffers of so many bytes.
    pub fn fits(size: UVec2, limit: u64) -> bool {
        words_of(size) * size_of::<u32>() as u64 <= limit
    }

    /// Makes room for a picture of a size. Whether there is another buffer now.
    pub fn fit(&mut self, gpu: &Gpu, size: UVec2) -> bool {
        let grows = words_of(size) * size_of::<u32>() as u64 > self.pixels.size();
        self.size = size;
        if grows {
            self.pixels = words(gpu, size);
        }
        grows
    }

    /// Takes each robot's mark: to be called after either buffer is another.
    pub fn bind(&mut self, gpu: &Gpu, marks: &Buffer) {
        self.group = Some(bind(gpu, &self.layout, &[(0, &self.pixels), (1, marks)]));
    }

    /// Before a picture: no marks.
    pub fn clear(&self, encoder: &mut CommandEncoder) {
        encoder.clear_buffer(&self.pixels, 0, Some(words_of(self.size) * size_of::<u32>() as u64));
    }

    /// Draws the marks: as many tiles as the sorting shader has counted.
    pub fn draw(&self, pass: &mut RenderPass<'_>, draws: &Buffer, at: u64) {
        self.draw_with(&self.colours, pass, draws, at);
    }

    /// Draws the robots' ids.
    pub fn draw_ids(&self, pass: &mut RenderPass<'_>, draws: &Buffer, at: u64) {
        self.draw_with(&self.ids, pass, draws, at);
    }

    fn draw_with(&self, pipeline: &RenderPipeline, pass: &mut RenderPass<'_>, draws: &Buffer, at: u64) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, &self.group, &[]);
        pass.draw_indirect(draws, at);
    }
}

fn words_of(size: UVec2) -> u64 {
    let product = |size: UVec2| u64::from(size.x) * u64::from(size.y);
    let tiles = UVec2::new(size.x.div_ceil(TILE), size.y.div_ceil(TILE));
    (product(size) + 2 * product(tiles)).max(1)
}

fn words(gpu: &Gpu, size: UVec2) -> Buffer {
    buffer(gpu, "splats", words_of(size) as usize * size_of::<u32>(), BufferUsages::STORAGE)
}
