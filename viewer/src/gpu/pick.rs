//! What is under the pointer: the ids of what was drawn there, drawn into a target of a few pixels.

use glam::{UVec2, Vec2, Vec4};
use wgpu::{Buffer, BufferUsages, Color, CommandEncoder, LoadOp, Operations, StoreOp, TextureUsages, TextureView};

use super::device::Gpu;
use super::frame::{texture, view_of};
use super::layout::{DEPTH, IDS};

/// Pixels across of the target: an odd number, so that one is in the middle.
const PIXELS: u32 = 9;
/// Nothing was drawn there.
const NOTHING: u32 = u32::MAX;
const EDGE: u32 = 1 << 30;
const NODE: u32 = 1 << 31;

/// Something under the pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picked {
    /// A robot, by its id.
    Robot(u32),
    /// An edge, by its index in the world.
    Edge(u32),
    /// A node, by its index in the world.
    Node(u32),
}

/// The target and the way back from it.
#[derive(Debug)]
pub struct Pick {
    ids: wgpu::Texture,
    ids_view: TextureView,
    depth: TextureView,
    back: Buffer,
}

/// Rows in a buffer begin at multiples of 256 bytes.
const ROW_BYTES: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

impl Pick {
    /// Makes the target.
    pub fn new(gpu: &Gpu) -> Self {
        let size = UVec2::splat(PIXELS);
        let ids = texture(gpu, size, IDS, 1, TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC);
        Self {
            ids_view: view_of(&ids),
            ids,
            depth: view_of(&texture(gpu, size, DEPTH, 1, TextureUsages::RENDER_ATTACHMENT)),
            back: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picked"),
                size: u64::from(ROW_BYTES * PIXELS),
                usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                mapped_at_creation: false,
            }),
        }
    }

    /// The part of a picture of `size` pixels that lies around a pixel: factors and offsets of clip coordinates.
    pub fn window(pixel: Vec2, size: Vec2) -> Vec4 {
        let centre = (pixel / size * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
        let scale = size / PIXELS as f32;
        let offset = -centre * scale;
        Vec4::new(scale.x, scale.y, offset.x, offset.y)
    }

    /// A pass that draws into the target.
    pub fn begin<'a>(&self, encoder: &'a mut CommandEncoder) -> wgpu::RenderPass<'a> {
        let nothing = Color { r: f64::from(NOTHING), g: 0.0, b: 0.0, a: 0.0 };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("pick"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.ids_view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(nothing), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    /// Submits what draws into the target, waits for it, and gives what is nearest to the middle: a robot before a
    /// node before an edge.
    pub fn read(&self, gpu: &Gpu, mut encoder: CommandEncoder) -> Option<Picked> {
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(ROW_BYTES), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.ids.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.back, layout },
            self.ids.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        self.back.map_async(wgpu::MapMode::Read, .., |_| ());
        gpu.wait();
        let mapped = self.back.get_mapped_range(..).ok()?;
        let rows: Vec<Vec<u32>> = mapped
            .chunks(ROW_BYTES as usize)
            .map(|row| row[..PIXELS as usize * 4].chunks(4).map(bytemuck::pod_read_unaligned).collect())
            .collect();
        drop(mapped);
        self.back.unmap();
        nearest(&rows)
    }
}

fn nearest(rows: &[Vec<u32>]) -> Option<Picked> {
    let middle = PIXELS as usize / 2;
    let away = |x: usize, y: usize| x.abs_diff(middle).pow(2) + y.abs_diff(middle).pow(2);
    let pixels =
        rows.iter().enumerate().flat_map(|(y, row)| row.iter().enumerate().map(move |(x, id)| (*id, away(x, y))));
    let (id, _) = pixels.filter(|(id, _)| *id != NOTHING).min_by_key(|(id, away)| (rank(*id), *away))?;
    Some(match rank(id) {
        0 => Picked::Robot(id),
        1 => Picked::Node(id & !NODE),
        _ => Picked::Edge(id & !EDGE),
    })
}

/// What people mean first.
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
    fn robots_come_before_nodes_and_edges_and_near_before_far() {
        let empty = vec![vec![NOTHING; PIXELS as usize]; PIXELS as usize];
        assert_eq!(nearest(&empty), None);
        let mut rows = empty;
        rows[4][4] = EDGE | 7;
        assert_eq!(nearest(&rows), Some(Picked::Edge(7)));
        rows[0][0] = NODE | 5;
        assert_eq!(nearest(&rows), Some(Picked::Node(5)));
        rows[8][8] = 3;
        rows[3][4] = 9;
        assert_eq!(nearest(&rows), Some(Picked::Robot(9)));
    }

    #[test]
    fn the_window_s_middle_is_the_pixel() {
        let size = Vec2::new(800.0, 600.0);
        let window = Pick::window(Vec2::new(200.0, 450.0), size);
        let clip = Vec2::new(-0.5, -0.5);
        let framed = clip * Vec2::new(window.x, window.y) + Vec2::new(window.z, window.w);
        assert!(framed.length() < 1e-4, "{framed}");
    }
}
