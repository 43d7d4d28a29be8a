//! The renderer of the interface: draws egui's meshes over the fleet's picture.

use std::collections::HashMap;

use egui::epaint::{ImageData, ImageDelta, Primitive, Vertex};
use egui::{ClippedPrimitive, Rect, TextureId, TexturesDelta};
use glam::{UVec2, Vec4};
use wgpu::{
    BindGroup, BindGroupLayout, BlendState, Buffer, BufferUsages, ColorTargetState, ColorWrites,
    CommandEncoder, Extent3d, FragmentState, IndexFormat, LoadOp, MultisampleState, Operations,
    Origin3d, PipelineCompilationOptions, PrimitiveState, RenderPipeline, Sampler, ShaderStages,
    StoreOp, Texture, TextureFormat, TextureUsages, TextureView, VertexAttribute,
    VertexBufferLayout, VertexState, vertex_attr_array,
};

use super::bindings::{Binding, bind_group, bind_group_layout};
use super::device::Gpu;
use super::pipeline::pipeline_layout;
use super::resources::{texture, view_of};
use super::shaders::shader;

/// The attributes of egui's vertices: position, texture coordinates, colour.
const VERTEX: [VertexAttribute; 3] =
    vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4];
/// The initial size of the vertex and index buffers.
const MIN_BYTES: u64 = 1 << 16;

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
        let scale = buffer(gpu, size_of::<Vec4>() as u64, BufferUsages::UNIFORM);
        Self {
            pipeline: pipeline(gpu, format, &[&scale_layout, &image_layout]),
            scale_group: bind_group(gpu, &scale_layout, &[(0, &scale)]),
            scale,
            image_layout,
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
            images: HashMap::new(),
            vertices: buffer(gpu, MIN_BYTES, BufferUsages::VERTEX),
            indices: buffer(gpu, MIN_BYTES, BufferUsages::INDEX),
        }
    }

    /// Uploads the textures' changes. Call this even when nothing is drawn: egui reports each
    /// change once.
    pub fn upload(&mut self, gpu: &Gpu, changes: &TexturesDelta) {
        for (id, changes) in &changes.set {
            changes.iter().for_each(|change| self.upload_image(gpu, *id, change));
        }
    }

    fn upload_image(&mut self, gpu: &Gpu, id: TextureId, change: &ImageDelta) {
        let ImageData::Color(image) = &change.image;
        let [width, height] = image.size.map(|side| side as u32);
        let at = change.pos.unwrap_or([0; 2]).map(|at| at as u32);
        if change.pos.is_none() {
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let texture =
                texture(gpu, UVec2::new(width, height), TextureFormat::Rgba8Unorm, 1, usage);
            let group = self.image_group(gpu, &texture);
            self.images.insert(id, (texture, group));
        }
        let Some((texture, _)) = self.images.get(&id) else { return };
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: Origin3d { x: at[0], y: at[1], z: 0 },
                ..texture.as_image_copy()
            },
            image.as_raw(),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * 4),
                rows_per_image: None,
            },
            Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    fn image_group(&self, gpu: &Gpu, texture: &Texture) -> BindGroup {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.image_layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view_of(texture)),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&self.sampler),
                },
            ],
        })
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
        let meshes = drawing.triangles.iter().filter_map(|part| match &part.primitive {
            Primitive::Mesh(mesh) => Some((part.clip_rect, mesh)),
            // The interface uses no paint callbacks.
            Primitive::Callback(_) => None,
        });
        let (mut vertices, mut indices, mut parts) =
            (Vec::<Vertex>::new(), Vec::<u32>::new(), Vec::new());
        for (clip, mesh) in meshes {
            parts.push((
                clip,
                mesh.texture_id,
                vertices.len() as i32,
                indices.len() as u32,
                mesh.indices.len() as u32,
            ));
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
        }
        fill(gpu, &mut self.vertices, bytemuck::cast_slice(&vertices), BufferUsages::VERTEX);
        fill(gpu, &mut self.indices, bytemuck::cast_slice(&indices), BufferUsages::INDEX);
        let mut pass = begin(encoder, target, "interface");
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.scale_group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
        for (clip, image, first_vertex, first, count) in parts {
            let Some((_, group)) = self.images.get(&image) else { continue };
            let Some((at, size)) = scissor(clip, drawing) else { continue };
            pass.set_scissor_rect(at.x, at.y, size.x, size.y);
            pass.set_bind_group(1, group, &[]);
            pass.draw_indexed(first..first + count, first_vertex, 0..1);
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
    let module = shader(gpu, "interface");
    let vertices = VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &VERTEX,
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("interface"),
        layout: Some(&pipeline_layout(gpu, "interface", groups)),
        vertex: VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &[Some(vertices)],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: None,
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState {
            module: &module,
            entry_point: Some(if format.is_srgb() { "linear" } else { "encoded" }),
            compilation_options: PipelineCompilationOptions::default(),
            targets: &[Some(ColorTargetState {
                format,
                blend: Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Begins a pass that draws over a picture.
pub(crate) fn begin<'a>(
    encoder: &'a mut CommandEncoder,
    target: &TextureView,
    label: &str,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load: LoadOp::Load, store: StoreOp::Store },
        })],
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// Returns the scissor rectangle of a mesh in pixels, as corner and size; `None` if it is empty.
fn scissor(clip: Rect, drawing: &Drawing) -> Option<(UVec2, UVec2)> {
    let pixel = |at: egui::Pos2| {
        let at = glam::Vec2::new(at.x, at.y) * drawing.pixels_per_point;
        at.round().max(glam::Vec2::ZERO).as_uvec2().min(drawing.size)
    };
    let (low, high) = (pixel(clip.min), pixel(clip.max));
    (low.x < high.x && low.y < high.y).then(|| (low, high - low))
}

fn buffer(gpu: &Gpu, size: u64, usage: BufferUsages) -> Buffer {
    let usage = usage | BufferUsages::COPY_DST;
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// Writes to a buffer, which is replaced if it is too small.
fn fill(gpu: &Gpu, target: &mut Buffer, bytes: &[u8], usage: BufferUsages) {
    if (bytes.len() as u64) > target.size() {
        *target = buffer(gpu, (bytes.len() as u64).next_power_of_two(), usage);
    }
    gpu.queue.write_buffer(target, 0, bytes);
}
