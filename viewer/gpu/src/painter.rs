//! The renderer of the interface: draws egui's meshes over the fleet's picture.

use std::collections::HashMap;
use std::ops::Range;

use egui::epaint::{ImageData, ImageDelta, Primitive, Vertex};
use egui::{ClippedPrimitive, Rect, TextureId, TexturesDelta};
use glam::{UVec2, Vec2, Vec4};
use wgpu::{
    BindGroup, BindGroupLayout, BlendState, Buffer, BufferUsages, CommandEncoder, IndexFormat,
    LoadOp, Origin3d, PrimitiveTopology, RenderPipeline, Sampler, ShaderStages, Texture,
    TextureFormat, TextureUsages, TextureView, VertexAttribute, VertexBufferLayout,
    vertex_attr_array,
};

use super::bindings::{Binding, bind_buffers, bind_group_layout, bind_texture};
use super::device::Gpu;
use super::pipeline::{DepthMode, PipelineDescriptor, TargetConfig, render_pipeline, shader};
use super::resources::{begin_pass, buffer, extent, linear_sampler, texture, view_of};

/// The attributes of egui's vertices: position, texture coordinates, colour.
const VERTEX: [VertexAttribute; 3] =
    vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4];
/// The initial size of the vertex and index buffers.
const MIN_BYTES: usize = 1 << 16;

/// Draws egui's meshes.
#[derive(Debug)]
pub struct Painter {
    pipeline: RenderPipeline,
    scale: Buffer,
    scale_group: BindGroup,
    image_layout: BindGroupLayout,
    sampler: Sampler,
    images: HashMap<TextureId, (Texture, BindGroup)>,
    vertices: Buffer,
    indices: Buffer,
}

/// A mesh within the buffers, to be drawn with an image within a rectangle.
struct Part {
    clip: Rect,
    image: TextureId,
    first_vertex: i32,
    indices: Range<u32>,
}

/// A picture of the interface.
#[derive(Debug)]
pub struct Drawing {
    /// Tessellated shapes, in points.
    pub triangles: Vec<ClippedPrimitive>,
    /// Pixels per point.
    pub pixels_per_point: f32,
    /// Width and height of the surface in pixels.
    pub size: UVec2,
}

impl Painter {
    /// Creates the pipeline for surfaces of a format.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let scale_layout =
            bind_group_layout(gpu, "interface", ShaderStages::VERTEX, &[Binding::Uniform]);
        let image_bindings = [Binding::Texture, Binding::Sampler];
        let image_layout =
            bind_group_layout(gpu, "interface image", ShaderStages::FRAGMENT, &image_bindings);
        let scale = buffer(gpu, "interface scale", size_of::<Vec4>(), BufferUsages::UNIFORM);
        Self {
            pipeline: pipeline(gpu, format, &[&scale_layout, &image_layout]),
            scale_group: bind_buffers(gpu, &scale_layout, &[&scale]),
            scale,
            image_layout,
            sampler: linear_sampler(gpu),
            images: HashMap::new(),
            vertices: buffer(gpu, "vertices", MIN_BYTES, BufferUsages::VERTEX),
            indices: buffer(gpu, "indices", MIN_BYTES, BufferUsages::INDEX),
        }
    }

    /// Uploads the textures' changes. Call this even when nothing is drawn: egui reports each
    /// change once.
    pub fn upload(&mut self, gpu: &Gpu, changes: &TexturesDelta) {
        for (id, changes) in &changes.set {
            for change in changes {
                self.upload_image(gpu, *id, change);
            }
        }
    }

    fn upload_image(&mut self, gpu: &Gpu, id: TextureId, change: &ImageDelta) {
        let ImageData::Color(image) = &change.image;
        let size = UVec2::from(image.size.map(|side| side as u32));
        let [x, y] = change.pos.unwrap_or_default().map(|at| at as u32);
        if change.pos.is_none() {
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let texture = texture(gpu, size, TextureFormat::Rgba8Unorm, 1, usage);
            let group = bind_texture(gpu, &self.image_layout, &view_of(&texture), &self.sampler);
            self.images.insert(id, (texture, group));
        }
        let Some((texture, _)) = self.images.get(&id) else { return };
        let origin = Origin3d { x, y, z: 0 };
        let target = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(size.x * 4),
            rows_per_image: None,
        };
        gpu.queue.write_texture(target, image.as_raw(), layout, extent(size));
    }

    /// Draws the interface over the target's contents.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        target: &TextureView,
        drawing: &Drawing,
    ) {
        let points = drawing.size.as_vec2() / drawing.pixels_per_point;
        let scale = Vec4::new(2.0 / points.x, -2.0 / points.y, 0.0, 0.0);
        gpu.queue.write_buffer(&self.scale, 0, bytemuck::bytes_of(&scale));
        let (mut vertices, mut indices, mut parts) =
            (Vec::<Vertex>::new(), Vec::<u32>::new(), Vec::new());
        for part in &drawing.triangles {
            // The interface uses no paint callbacks.
            let Primitive::Mesh(mesh) = &part.primitive else { continue };
            let first = indices.len() as u32;
            parts.push(Part {
                clip: part.clip_rect,
                image: mesh.texture_id,
                first_vertex: vertices.len() as i32,
                indices: first..first + mesh.indices.len() as u32,
            });
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
        }
        fill(gpu, &mut self.vertices, bytemuck::cast_slice(&vertices), BufferUsages::VERTEX);
        fill(gpu, &mut self.indices, bytemuck::cast_slice(&indices), BufferUsages::INDEX);
        let mut pass = begin_pass(encoder, "interface", target, LoadOp::Load);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.scale_group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
        for Part { clip, image, first_vertex, indices } in parts {
            let Some((_, group)) = self.images.get(&image) else { continue };
            let Some((at, size)) = scissor(clip, drawing) else { continue };
            pass.set_scissor_rect(at.x, at.y, size.x, size.y);
            pass.set_bind_group(1, group, &[]);
            pass.draw_indexed(indices, first_vertex, 0..1);
        }
    }

    /// Frees textures. Call this after the commands that use them were submitted.
    pub fn free(&mut self, mut changes: TexturesDelta) {
        for id in &changes.free {
            self.images.remove(id);
        }
        // egui's debug builds panic if changes are dropped before they were cleared.
        changes.clear();
    }
}

fn pipeline(gpu: &Gpu, format: TextureFormat, groups: &[&BindGroupLayout]) -> RenderPipeline {
    let vertices = VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &VERTEX,
    };
    let module = shader(gpu, "interface");
    let fragment = if format.is_srgb() { "linear" } else { "encoded" };
    let descriptor = PipelineDescriptor {
        buffers: &[vertices],
        topology: PrimitiveTopology::TriangleList,
        depth: DepthMode::Absent,
        blend: Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
        ..PipelineDescriptor::new(&module, "corner", fragment, groups)
    };
    let target = TargetConfig { format, samples: 1, splats_from: u32::MAX };
    render_pipeline(gpu, target, &descriptor)
}

/// Returns the scissor rectangle of a mesh in pixels, as corner and size; `None` if it is empty.
fn scissor(clip: Rect, drawing: &Drawing) -> Option<(UVec2, UVec2)> {
    let [low, high] = [clip.min, clip.max].map(|at| {
        let at = Vec2::new(at.x, at.y) * drawing.pixels_per_point;
        at.round().max(Vec2::ZERO).as_uvec2().min(drawing.size)
    });
    low.cmplt(high).all().then(|| (low, high - low))
}

/// Writes to a buffer, which is replaced if it is too small.
fn fill(gpu: &Gpu, target: &mut Buffer, bytes: &[u8], usage: BufferUsages) {
    if (bytes.len() as u64) > target.size() {
        *target = buffer(gpu, "interface", bytes.len().next_power_of_two(), usage);
    }
    gpu.queue.write_buffer(target, 0, bytes);
}
