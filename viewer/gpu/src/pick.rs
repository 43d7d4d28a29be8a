//! Picking: the ids of items around the pointer are drawn into a target of a few pixels, and read
//! back.

use glam::{UVec2, Vec2, Vec4};
use regatta_scene::Item;
use wgpu::{Color, CommandEncoder, LoadOp, TextureUsages, TextureView};

use super::device::Gpu;
use super::pipeline::{DEPTH_FORMAT, ID_FORMAT};
use super::resources::{Readback, far_depth, stored, texture, view_of};

/// The target's width and height in pixels: odd, so that one pixel is in the middle.
const PIXELS: u32 = 9;
/// The id of pixels where nothing was drawn.
const NOTHING: u32 = u32::MAX;
/// The bit that tags an edge's index; the same as in graph.wgsl.
const EDGE: u32 = 1 << 30;
/// The bit that tags a node's index; the same as in graph.wgsl.
const NODE: u32 = 1 << 31;

/// The target that ids are drawn into, and the buffer that they are read back through.
#[derive(Debug)]
pub struct Pick {
    ids: wgpu::Texture,
    ids_view: TextureView,
    depth: TextureView,
    readback: Readback,
}

impl Pick {
    /// Creates the target.
    pub fn new(gpu: &Gpu) -> Self {
        let size = UVec2::splat(PIXELS);
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let ids = texture(gpu, size, ID_FORMAT, 1, usage);
        Self {
            ids_view: view_of(&ids),
            ids,
            depth: view_of(&texture(gpu, size, DEPTH_FORMAT, 1, TextureUsages::RENDER_ATTACHMENT)),
            readback: Readback::new(gpu, size),
        }
    }

    /// Returns the crop of a picture of `size` pixels to the target's pixels around `pixel`:
    /// factors (x, y) and offsets (z, w) of clip coordinates.
    pub fn crop(pixel: Vec2, size: Vec2) -> Vec4 {
        let centre = (pixel / size * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
        let scale = size / PIXELS as f32;
        let offset = -centre * scale;
        Vec4::new(scale.x, scale.y, offset.x, offset.y)
    }

    /// Begins the render pass that draws ids into the target.
    pub fn begin_pass<'a>(&self, encoder: &'a mut CommandEncoder) -> wgpu::RenderPass<'a> {
        let nothing = Color { r: f64::from(NOTHING), g: 0.0, b: 0.0, a: 0.0 };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("pick"),
            color_attachments: &[Some(stored(&self.ids_view, LoadOp::Clear(nothing)))],
            depth_stencil_attachment: Some(far_depth(&self.depth)),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    /// Submits the commands that draw into the target, waits for them, and returns the object
    /// nearest to the middle. Robots are preferred to nodes, and nodes to edges.
    pub fn read(&self, gpu: &Gpu, encoder: CommandEncoder) -> Option<Item> {
        let texels = self.readback.read(gpu, encoder, &self.ids).ok()?;
        let ids: Vec<u32> = texels.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
        nearest(&ids)
    }
}

/// Returns the object nearest to the middle, of the ids of the target's pixels row by row.
fn nearest(ids: &[u32]) -> Option<Item> {
    let drawn = (0..).zip(ids).filter(|(_, id)| **id != NOTHING);
    let (_, id) = drawn.min_by_key(|(pixel, id)| {
        let (x, y) = (pixel % PIXELS, pixel / PIXELS);
        (rank(**id), x.abs_diff(PIXELS / 2).pow(2) + y.abs_diff(PIXELS / 2).pow(2))
    })?;
    Some(match rank(*id) {
        0 => Item::Robot(*id),
        1 => Item::Node(id & !NODE),
        _ => Item::Edge(id & !EDGE),
    })
}

/// Returns the preference of an id: lower ranks are picked first.
fn rank(id: u32) -> u32 {
    match id {
        id if id & NODE != 0 => 1,
        id if id & EDGE != 0 => 2,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_preferred_to_nodes_and_edges_and_near_objects_to_far_ones() {
        let mut ids = [[NOTHING; PIXELS as usize]; PIXELS as usize];
        assert_eq!(nearest(ids.as_flattened()), None);
        ids[4][4] = EDGE | 7;
        assert_eq!(nearest(ids.as_flattened()), Some(Item::Edge(7)));
        ids[0][0] = NODE | 5;
        assert_eq!(nearest(ids.as_flattened()), Some(Item::Node(5)));
        ids[8][8] = 3;
        ids[3][4] = 9;
        assert_eq!(nearest(ids.as_flattened()), Some(Item::Robot(9)));
    }

    #[test]
    fn the_crop_is_centred_on_the_pixel() {
        let size = Vec2::new(800.0, 600.0);
        let crop = Pick::crop(Vec2::new(200.0, 450.0), size);
        let clip = Vec2::new(-0.5, -0.5);
        let cropped = clip * Vec2::new(crop.x, crop.y) + Vec2::new(crop.z, crop.w);
        assert!(cropped.length() < 1e-4, "{cropped}");
    }
}
