//! The floor with its grid and its picture, drawn over the whole target.

use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec2, Vec4};
use image::RgbaImage;
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, Buffer, BufferUsages, PrimitiveTopology,
    RenderPass, RenderPipeline, ShaderStages, TextureUsages,
};

use super::bindings::{Binding, bind_group, bind_group_layout};
use super::device::Gpu;
use super::pipeline::{PipelineDescriptor, TargetConfig, render_pipeline, shader};
use super::resources::{buffer, extent, linear_sampler, view_of};

/// The shaders' `Placement` of the picture.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Placement {
    corner: Vec4,
    size: Vec4,
}

/// A picture and its placement on the floor.
#[derive(Clone, Debug)]
pub struct FloorPicture {
    /// The pixels; the first row is farthest from the corner.
    pub pixels: RgbaImage,
    /// The lower left corner, in metres.
    pub corner: Vec2,
    /// Rotation about the corner, in radians counter-clockwise.
    pub turn: f32,
    /// Width and height in metres.
    pub size: Vec2,
}

/// Draws the floor, its grid and the sky.
#[derive(Debug)]
pub(super) struct Floor {
    plain: RenderPipeline,
    textured: RenderPipeline,
    layout: BindGroupLayout,
    picture: Option<LoadedPicture>,
}

/// A floor picture on the GPU.
#[derive(Debug)]
struct LoadedPicture {
    group: BindGroup,
    placement: Buffer,
    corner: Vec2,
    turn: f32,
    size: Vec2,
}

impl Floor {
    pub(super) fn new(gpu: &Gpu, target: TargetConfig, view: &BindGroupLayout) -> Self {
        let module = shader(gpu, "floor");
        let bindings = [Binding::Texture, Binding::Sampler, Binding::Uniform];
        let layout = bind_group_layout(gpu, "floor picture", ShaderStages::FRAGMENT, &bindings);
        let groups = [view, &layout];
        let [plain, textured] =
            [("plain", &groups[..1]), ("textured", &groups[..])].map(|(fragment, groups)| {
                PipelineDescriptor {
                    topology: PrimitiveTopology::TriangleList,
                    blend: None,
                    ..PipelineDescriptor::new(&module, "ray", fragment, groups)
                }
            });
        Self {
            plain: render_pipeline(gpu, target, &plain),
            textured: render_pipeline(gpu, target, &textured),
            layout,
            picture: None,
        }
    }

    /// Sets or removes the picture on the floor.
    pub(super) fn set_picture(&mut self, gpu: &Gpu, picture: Option<&FloorPicture>) {
        self.picture = picture.map(|picture| {
            let placement =
                buffer(gpu, "floor picture", size_of::<Placement>(), BufferUsages::UNIFORM);
            let view = view_of(&upload(gpu, &picture.pixels));
            let sampler = linear_sampler(gpu);
            let resources = [
                BindingResource::TextureView(&view),
                BindingResource::Sampler(&sampler),
                placement.as_entire_binding(),
            ];
            let group = bind_group(gpu, &self.layout, &resources);
            LoadedPicture {
                group,
                placement,
                corner: picture.corner,
                turn: picture.turn,
                size: picture.size,
            }
        });
    }

    /// Uploads the picture's placement for [`draw`](Self::draw). `origin` is the origin of local
    /// coordinates.
    pub(super) fn prepare(&self, gpu: &Gpu, origin: Vec2) {
        if let Some(picture) = &self.picture {
            let corner = picture.corner - origin;
            let placement = Placement {
                corner: Vec4::new(corner.x, corner.y, picture.turn.cos(), picture.turn.sin()),
                size: Vec4::new(1.0 / picture.size.x, 1.0 / picture.size.y, 1.0, 0.0),
            };
            gpu.queue.write_buffer(&picture.placement, 0, bytemuck::bytes_of(&placement));
        }
    }

    pub(super) fn draw(&self, pass: &mut RenderPass<'_>) {
        match &self.picture {
            Some(picture) => {
                pass.set_pipeline(&self.textured);
                pass.set_bind_group(1, &picture.group, &[]);
            }
            None => pass.set_pipeline(&self.plain),
        }
        pass.draw(0..3, 0..1);
    }
}

/// Uploads an image with all its mip levels.
fn upload(gpu: &Gpu, pixels: &RgbaImage) -> wgpu::Texture {
    let (width, height) = pixels.dimensions();
    let mip_level_count = width.max(height).ilog2() + 1;
    let (mut data, mut level) = (pixels.as_raw().clone(), pixels.clone());
    for _ in 1..mip_level_count {
        let (width, height) = level.dimensions();
        level = image::imageops::thumbnail(&level, (width / 2).max(1), (height / 2).max(1));
        data.extend_from_slice(&level);
    }
    let descriptor = wgpu::TextureDescriptor {
        label: Some("floor picture"),
        size: extent(UVec2::new(width, height)),
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::MipMajor, &data)
}
