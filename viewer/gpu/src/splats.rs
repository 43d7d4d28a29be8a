//! Splatting: the sorting shader writes the marks of far robots into a buffer of pixels, which is
//! then drawn tile by tile.

use glam::UVec2;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, PrimitiveTopology,
    RenderPass, RenderPipeline, ShaderStages,
};

use super::bindings::{Binding, bind_buffers, bind_group_layout};
use super::density::Density;
use super::device::Gpu;
use super::pipeline::{
    DepthMode, Output, PipelineDescriptor, TargetConfig, render_pipeline, shader,
};
use super::resources::buffer;

/// Width and height of a tile in pixels; the same as in marks.wgsl.
const TILE: u32 = 32;

/// The buffer of splatted marks, and the pipelines that draw it.
#[derive(Debug)]
pub struct Splats {
    /// A word per pixel of the picture, row by row; then a flag per tile; then the numbers of the
    /// tiles with marks. Then the sums of the density, if robots are drawn so; without splats there
    /// is nothing before these.
    pixels: Buffer,
    /// Words in use, and those among them before the sums.
    words: u64,
    marks: u64,
    layout: BindGroupLayout,
    group: Option<BindGroup>,
    colours: RenderPipeline,
    ids: RenderPipeline,
}

impl Splats {
    pub fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let layout =
            bind_group_layout(gpu, "splats", ShaderStages::VERTEX_FRAGMENT, &[Binding::Read; 2]);
        let module = shader(gpu, "splats");
        let groups = [view, &layout];
        let [colours, ids] = ["splat", "splat_id"].map(|fragment| PipelineDescriptor {
            topology: PrimitiveTopology::TriangleList,
            depth: DepthMode::Tested,
            blend: None,
            ..PipelineDescriptor::new(&module, "tile", fragment, &groups)
        });
        Self {
            colours: render_pipeline(gpu, target, &colours),
            ids: render_pipeline(gpu, TargetConfig::IDS, &ids),
            pixels: words(gpu, 1),
            words: 1,
            marks: 0,
            group: None,
            layout,
        }
    }

    /// The buffer that the sorting shader writes.
    pub fn pixels(&self) -> &Buffer {
        &self.pixels
    }

    /// Whether the buffer for a picture of `size` pixels stays within `limit` bytes.
    pub fn fits(size: UVec2, limit: u64) -> bool {
        (words_of(size) + Density::words(size)) * size_of::<u32>() as u64 <= limit
    }

    /// Makes room for a picture of `size` pixels: for splatted marks, and for the density. Returns
    /// true if the buffer was replaced.
    pub fn fit(&mut self, gpu: &Gpu, size: UVec2, marks: bool, density: bool) -> bool {
        self.marks = if marks { words_of(size) } else { 0 };
        self.words = (self.marks + if density { Density::words(size) } else { 0 }).max(1);
        let grows = self.words * size_of::<u32>() as u64 > self.pixels.size();
        if grows {
            self.pixels = words(gpu, self.words);
        }
        grows
    }

    /// Binds the pixels and each robot's mark. Call this after either buffer was replaced.
    pub fn bind(&mut self, gpu: &Gpu, marks: &Buffer) {
        self.group = Some(bind_buffers(gpu, &self.layout, &[&self.pixels, marks]));
    }

    /// Clears all marks and sums before a picture, or the sums only.
    pub fn clear(&self, encoder: &mut CommandEncoder, only_sums: bool) {
        let word = size_of::<u32>() as u64;
        let from = if only_sums { self.marks } else { 0 };
        encoder.clear_buffer(&self.pixels, from * word, Some((self.words - from) * word));
    }

    /// Draws the marks, or the robots' ids in the same way. The indirect arguments at offset `at`
    /// of `draws` hold the number of tiles with marks.
    pub fn draw(&self, pass: &mut RenderPass<'_>, output: Output, draws: &Buffer, at: u64) {
        pass.set_pipeline(match output {
            Output::Colours => &self.colours,
            Output::Ids => &self.ids,
        });
        pass.set_bind_group(1, &self.group, &[]);
        pass.draw_indirect(draws, at);
    }
}

fn words_of(size: UVec2) -> u64 {
    let tiles = UVec2::new(size.x.div_ceil(TILE), size.y.div_ceil(TILE));
    let [pixels, tiles] = [size, tiles].map(|size| size.as_u64vec2().element_product());
    (pixels + 2 * tiles).max(1)
}

fn words(gpu: &Gpu, words: u64) -> Buffer {
    buffer(gpu, "splats", words as usize * size_of::<u32>(), BufferUsages::STORAGE)
}
