//! Draws egui's triangles over the fleet's picture.

use std::collections::HashMap;

use egui::epaint::{ImageData, ImageDelta, Primitive, Vertex};
use egui::{ClippedPrimitive, Rect, TextureId, TexturesDelta};
use glam::{UVec2, Vec4};
use wgpu::{
    BindGroup, BindGroupLayout, BlendState, Buffer, BufferUsages, ColorTargetState, ColorWrites, CommandEncoder,
    Extent3d, FragmentState, IndexFormat, LoadOp, MultisampleState, Operations, Origin3d, PipelineCompilationOptions,
    PrimitiveState, RenderPipeline, Sampler, ShaderStages, StoreOp, Texture, TextureFormat, TextureUsages, TextureView,
    VertexAttribute, VertexBufferLayout, VertexState, vertex_attr_array,
};

use crate::gpu::device::Gpu;
use crate::gpu::frame::{texture, view_of};
use crate::gpu::layout::{Kind, bind, bindings, pipeline_layout, shader};

/// As egui has them: place, place in the texture, colour.
const VERTEX: [VertexAttribute; 3] = vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4];
/// Bytes of the smallest buffers.
const LEAST_BYTES: u64 = 1 << 16;

/// What draws egui's triangles.
#[derive(Debug)]
pub struct Painter {
    pipeline: RenderPipeline,
    scale: Buffer,
    scale_group: BindGroup,
    image_layout: BindGroupLayout,
    filtering: Sampler,
    images: HashMap<TextureId, (Texture, BindGroup)>,
    vertices: Buffer,
    indices: Buffer,
}

/// One picture of the interface.
#[derive(Debug)]
pub struct Drawing {
    /// Triangles, in points.
    pub triangles: Vec<ClippedPrimitive>,
    /// Pixels of a point.
    pub pixels_per_point: f32,
    /// Pixels of the surface.
    pub size: UVec2,
}

impl Painter {
    /// Prepares for a surface.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let scale_layout = bindings(gpu, "interface", ShaderStages::VERTEX, &[Kind::Uniform]);
        let image_layout = bindings(gpu, "interface image", ShaderStages::FRAGMENT, &[Kind::Texture, Kind::Sampler]);
        let scale = make(gpu, size_of::<Vec4>() as u64, BufferUsages::UNIFORM);
        Self {
            pipeline: pipeline(gpu, format, &[&scale_layout, &image_layout]),
            scale_group: bind(gpu, &scale_layout, &[(0, &scale)]),
            scale,
            image_layout,
            filtering: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
            images: HashMap::new(),
            vertices: make(gpu, LEAST_BYTES, BufferUsages::VERTEX),
            indices: make(gpu, LEAST_BYTES, BufferUsages::INDEX),
        }
    }

    /// Takes what changed of the textures. To be done even where nothing is drawn: changes come once.
    pub fn upload(&mut self, gpu: &Gpu, changes: &TexturesDelta) {
        for (id, changes) in &changes.set {
            changes.iter().for_each(|change| self.change(gpu, *id, change));
        }
    }

    fn change(&mut self, gpu: &Gpu, id: TextureId, change: &ImageDelta) {
        let ImageData::Color(image) = &change.image;
        let [width, height] = image.size.map(|side| side as u32);
        let at = change.pos.unwrap_or([0; 2]).map(|at| at as u32);
        if change.pos.is_none() {
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let made = texture(gpu, UVec2::new(width, height), TextureFormat::Rgba8Unorm, 1, usage);
            let group = self.image_group(gpu, &made);
            self.images.insert(id, (made, group));
        }
        let Some((texture, _)) = self.images.get(&id) else { return };
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin: Origin3d { x: at[0], y: at[1], z: 0 }, ..texture.as_image_copy() },
            image.as_raw(),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: None },
            Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    fn image_group(&self, gpu: &Gpu, texture: &Texture) -> BindGroup {
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.image_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view_of(texture)) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.filtering) },
            ],
        })
    }

    /// Draws over what is there.
    pub fn draw(&mut self, gpu: &Gpu, encoder: &mut CommandEncoder, target: &TextureView, drawing: &Drawing) {
        let points = drawing.size.as_vec2() / drawing.pixels_per_point;
        let scale = Vec4::new(2.0 / points.x, -2.0 / points.y, 0.0, 0.0);
        gpu.queue.write_buffer(&self.scale, 0, bytemuck::bytes_of(&scale));
        let meshes = drawing.triangles.iter().filter_map(|part| match &part.primitive {
            Primitive::Mesh(mesh) => Some((part.clip_rect, mesh)),
            // Nothing here paints by itself.
            Primitive::Callback(_) => None,
        });
        let (mut vertices, mut indices, mut parts) = (Vec::<Vertex>::new(), Vec::<u32>::new(), Vec::new());
        for (clip, mesh) in meshes {
            parts.push((clip, mesh.texture_id, vertices.len() as i32, indices.len() as u32, mesh.indices.len() as u32));
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
        }
        fill(gpu, &mut self.vertices, bytemuck::cast_slice(&vertices), BufferUsages::VERTEX);
        fill(gpu, &mut self.indices, bytemuck::cast_slice(&indices), BufferUsages::INDEX);
        let mut pass = begin(encoder, target);
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

    /// Forgets textures, after what drew with them was submitted.
    pub fn free(&mut self, changes: &TexturesDelta) {
        for id in &changes.free {
            self.images.remove(id);
        }
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
            entry_point: Some(if format.is_srgb() { "light" } else { "seen" }),
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

fn begin<'a>(encoder: &'a mut CommandEncoder, target: &TextureView) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("interface"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load: LoadOp::Load, store: StoreOp::Store },
        })],
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// The pixels that a part may draw on; `None` if there are none.
fn scissor(clip: Rect, drawing: &Drawing) -> Option<(UVec2, UVec2)> {
    let pixel = |at: egui::Pos2| {
        let at = glam::Vec2::new(at.x, at.y) * drawing.pixels_per_point;
        at.round().max(glam::Vec2::ZERO).as_uvec2().min(drawing.size)
    };
    let (low, high) = (pixel(clip.min), pixel(clip.max));
    (low.x < high.x && low.y < high.y).then(|| (low, high - low))
}

fn make(gpu: &Gpu, size: u64, usage: BufferUsages) -> Buffer {
    let usage = usage | BufferUsages::COPY_DST;
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}

/// Fills a buffer; one that is too small is replaced.
fn fill(gpu: &Gpu, buffer: &mut Buffer, bytes: &[u8], usage: BufferUsages) {
    if (bytes.len() as u64) > buffer.size() {
        *buffer = make(gpu, (bytes.len() as u64).next_power_of_two(), usage);
    }
    gpu.queue.write_buffer(buffer, 0, bytes);
}
