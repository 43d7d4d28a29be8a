//! The floor, over the whole picture.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec4};
use image::RgbaImage;
use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindingResource, Buffer, BufferUsages, FilterMode, PrimitiveTopology,
    RenderPass, RenderPipeline, ShaderStages, TextureUsages,
};

use super::columns::buffer;
use super::device::Gpu;
use super::layout::{Draw, Kind, Layering, TargetKind, bindings, render, shader};
use crate::floor_picture::FloorPicture;

/// How the picture lies: the shaders' `Lie`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Lie {
    corner: Vec4,
    size: Vec4,
}

/// Draws the floor, its grid and what lies beyond it.
#[derive(Debug)]
pub struct Floor {
    plain: RenderPipeline,
    textured: RenderPipeline,
    layout: BindGroupLayout,
    picture: Option<Laid>,
}

/// A picture on the floor.
#[derive(Debug)]
struct Laid {
    group: BindGroup,
    lie: Buffer,
    corner: Vec2,
    turn: f32,
    size: Vec2,
}

impl Floor {
    pub fn new(gpu: &Gpu, target: TargetKind, view: &BindGroupLayout) -> Self {
        let module = shader(gpu, "floor");
        let layout =
            bindings(gpu, "floor picture", ShaderStages::FRAGMENT, &[Kind::Texture, Kind::Sampler, Kind::Uniform]);
        let draw = |fragment, groups| Draw {
            module: &module,
            vertex: "ray",
            fragment,
            groups,
            buffers: &[],
            topology: PrimitiveTopology::TriangleList,
            layering: Layering::Ground,
            blend: false,
        };
        Self {
            plain: render(gpu, target, &draw("plain", &[view])),
            textured: render(gpu, target, &draw("textured", &[view, &layout])),
            layout,
            picture: None,
        }
    }

    /// Lays a picture on the floor, or takes it away.
    pub fn lay(&mut self, gpu: &Gpu, picture: Option<&FloorPicture>) {
        self.picture = picture.map(|picture| {
            let lie = buffer(gpu, "floor picture", size_of::<Lie>(), BufferUsages::UNIFORM);
            let view = upload(gpu, &picture.pixels).create_view(&wgpu::TextureViewDescriptor::default());
            let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            });
            let entries = [
                BindGroupEntry { binding: 0, resource: BindingResource::TextureView(&view) },
                BindGroupEntry { binding: 1, resource: BindingResource::Sampler(&sampler) },
                BindGroupEntry { binding: 2, resource: lie.as_entire_binding() },
            ];
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &self.layout, entries: &entries };
            let group = gpu.device.create_bind_group(&descriptor);
            Laid { group, lie, corner: picture.corner, turn: picture.turn, size: picture.size }
        });
    }

    /// Before [`draw`](Self::draw): `origin` is where local coordinates count from.
    pub fn prepare(&self, gpu: &Gpu, origin: Vec2) {
        if let Some(laid) = &self.picture {
            let corner = laid.corner - origin;
            let lie = Lie {
                corner: Vec4::new(corner.x, corner.y, laid.turn.cos(), laid.turn.sin()),
                size: Vec4::new(1.0 / laid.size.x, 1.0 / laid.size.y, 1.0, 0.0),
            };
            gpu.queue.write_buffer(&laid.lie, 0, bytemuck::bytes_of(&lie));
        }
    }

    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        match &self.picture {
            Some(laid) => {
                pass.set_pipeline(&self.textured);
                pass.set_bind_group(1, &laid.group, &[]);
            }
            None => pass.set_pipeline(&self.plain),
        }
        pass.draw(0..3, 0..1);
    }
}

/// A texture with all its smaller levels.
fn upload(gpu: &Gpu, pixels: &RgbaImage) -> wgpu::Texture {
    let (width, height) = pixels.dimensions();
    let levels = width.max(height).ilog2() + 1;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("floor picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let mut level = pixels.clone();
    for mip_level in 0..levels {
        let (width, height) = level.dimensions();
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: Some(height) };
        let place = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        gpu.queue.write_texture(place, &level, layout, size);
        level = image::imageops::thumbnail(&level, (width / 2).max(1), (height / 2).max(1));
    }
    texture
}
