//! A whole picture: uploads, then the passes in order.

use glam::{UVec2, Vec2};
use regatta_plugin::world::{EdgeRecord, NodeRecord, RobotTypeRecord};
use regatta_plugin::{Frame, World};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, Color, CommandEncoder, LoadOp, Operations, RenderPass,
    ShaderStages, StoreOp, TextureUsages, TextureView,
};

use super::chosen::Chosen;
use super::columns::{Columns, TypeLook, buffer};
use super::device::Gpu;
use super::floor::Floor;
use super::graph::Graph;
use super::layout::{DEPTH, Kind, TargetKind, bind, bindings};
use super::pick::{Pick, Picked};
use super::robots::Robots;
use super::routes::Routes;
use super::timer::Timer;
use super::view::ViewUniform;
use crate::camera::Camera;
use crate::floor_picture::FloorPicture;
use crate::mesh::Mesh;
use crate::palette::Legend;
use crate::route::Stretch;
use crate::scene::{Layers, Scene};

/// Draws a fleet into any texture view.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    target: TargetKind,
    columns: Columns,
    view: Buffer,
    view_group: BindGroup,
    pick: Pick,
    pick_view: Buffer,
    pick_group: BindGroup,
    /// Of the last picture.
    drawn: Option<(ViewUniform, Layers)>,
    surfaces: Option<Surfaces>,
    floor: Floor,
    graph: Graph,
    routes: Routes,
    robots: Robots,
    chosen: Chosen,
    types: Vec<RobotTypeRecord>,
    models: Vec<Model>,
    timer: Option<Timer>,
}

/// A mesh of their own for robots of a type, or of all other types.
#[derive(Debug)]
struct Model {
    robot_type: Option<String>,
    /// Its number.
    mesh: usize,
    is_shown: bool,
}

/// What is needed beside the target, of its size.
#[derive(Debug)]
struct Surfaces {
    size: UVec2,
    depth: TextureView,
    /// Where there are several samples to a pixel.
    samples: Option<TextureView>,
}

impl Renderer {
    /// Prepares for targets of that kind.
    pub fn new(gpu: &Gpu, target: TargetKind) -> Self {
        let layout = view_layout(gpu);
        let [view, pick_view] =
            ["view", "pick view"].map(|label| buffer(gpu, label, size_of::<ViewUniform>(), BufferUsages::UNIFORM));
        let columns = Columns::new(gpu);
        let graph = Graph::new(gpu, target, &layout);
        Self {
            gpu: gpu.clone(),
            target,
            view_group: bind(gpu, &layout, &[(0, &view)]),
            view,
            pick: Pick::new(gpu),
            pick_group: bind(gpu, &layout, &[(0, &pick_view)]),
            pick_view,
            drawn: None,
            surfaces: None,
            floor: Floor::new(gpu, target, &layout),
            routes: Routes::new(gpu, target, &layout, graph.records_layout()),
            graph,
            robots: Robots::new(gpu, target, &layout, &columns),
            chosen: Chosen::new(gpu, target, &layout, &columns),
            columns,
            types: Vec::new(),
            models: Vec::new(),
            timer: None,
        }
    }

    /// Takes the time of each picture from now on, where the adapter can.
    pub fn time(&mut self) {
        self.timer = Timer::new(&self.gpu);
    }

    /// Waits for the picture that was submitted last, and gives the GPU's time for it in seconds.
    pub fn gpu_seconds(&mut self) -> Option<f64> {
        let timer = self.timer.as_mut()?;
        timer.ask();
        self.gpu.wait();
        timer.answer(&self.gpu)
    }

    /// The GPU's time in seconds for a picture that it has finished since, without waiting. To be called after each picture
    /// that was submitted; not all of them are timed.
    pub fn poll_gpu_seconds(&mut self) -> Option<f64> {
        let timer = self.timer.as_mut()?;
        if timer.is_free() {
            timer.ask();
        }
        self.gpu.poll();
        timer.answer(&self.gpu)
    }

    /// Most pixels of a texture in either direction.
    pub fn max_texture_size(&self) -> u32 {
        self.gpu.device.limits().max_texture_dimension_2d
    }

    /// Lays a picture on the floor, or takes it away.
    pub fn lay_picture(&mut self, picture: Option<&FloorPicture>) {
        self.floor.lay(&self.gpu, picture);
    }

    /// Draws robots of the type of that name, or of all types that have no mesh of their own, as this mesh; or no longer.
    /// False if there are too many meshes.
    pub fn set_model(&mut self, robot_type: Option<&str>, mesh: Option<&Mesh>) -> bool {
        let known = self.models.iter_mut().find(|model| model.robot_type.as_deref() == robot_type);
        match (known, mesh) {
            (Some(model), Some(mesh)) => {
                self.robots.replace_mesh(&self.gpu, model.mesh, mesh);
                model.is_shown = true;
            }
            (Some(model), None) => model.is_shown = false,
            (None, Some(mesh)) => {
                let Some(mesh) = self.robots.add_mesh(&self.gpu, mesh) else { return false };
                self.models.push(Model { robot_type: robot_type.map(str::to_owned), mesh, is_shown: true });
            }
            (None, None) => {}
        }
        self.dress_types();
        true
    }

    /// Takes a world: the graph and the robot types.
    pub fn set_world(&mut self, world: &World<'_>) {
        self.set_types(world.robot_types());
        self.set_graph(world.nodes(), world.edges());
    }

    /// Takes the route graph.
    pub fn set_graph(&mut self, nodes: &[NodeRecord], edges: &[EdgeRecord]) {
        self.graph.load(&self.gpu, nodes, edges);
    }

    /// Takes routes to draw along the graph, in place of those before.
    pub fn set_routes(&mut self, stretches: &[Stretch]) {
        self.routes.set(&self.gpu, stretches);
    }

    /// Takes the robot types.
    pub fn set_types(&mut self, types: &[RobotTypeRecord]) {
        self.types = types.to_vec();
        self.dress_types();
    }

    fn dress_types(&mut self) {
        let model =
            |name: Option<&str>| self.models.iter().find(|model| model.is_shown && model.robot_type.as_deref() == name);
        let look = |record: &RobotTypeRecord| {
            let model = model(Some(record.name())).or_else(|| model(None));
            model.map_or(TypeLook::of(record), |model| TypeLook::of(record).with_mesh(model.mesh))
        };
        let looks: Vec<_> = self.types.iter().map(look).collect();
        self.robots.set_any_round(looks.iter().any(|look| look.look & 1 != 0));
        self.columns.set_types(&self.gpu, &looks);
    }

    /// Takes a new frame; what was the newest is kept as the previous one.
    pub fn push_frame(&mut self, frame: &Frame<'_>) {
        self.columns.push(&self.gpu, frame);
        self.chosen.push(frame.run_id(), frame.header().sim_time_nanos);
    }

    /// Takes each robot's type.
    pub fn set_kinds(&mut self, kinds: &[f32]) {
        self.columns.set_kinds(&self.gpu, kinds);
    }

    /// Points of the longest trail that the adapter has room for, of those that were asked for.
    pub fn trail_points(&self) -> u32 {
        self.chosen.trail_points()
    }

    /// Whether the robots' types are not, or no longer, known: there were too many robots for the buffers.
    pub fn lacks_kinds(&self) -> bool {
        self.columns.lacks_kinds()
    }

    /// Whether no robot's value is known.
    pub fn lacks_values(&self) -> bool {
        self.columns.known() == 0
    }

    /// Takes the values that robots are coloured by, or none.
    pub fn set_values(&mut self, values: Option<&[f32]>) {
        match values {
            Some(values) => self.columns.set_values(&self.gpu, values),
            None => self.columns.forget_values(),
        }
    }

    /// Draws a picture of `size` pixels into `target`: `alpha` of the way from the previous frame to the newest.
    pub fn draw(&mut self, encoder: &mut CommandEncoder, target: &TextureView, picture: &Picture<'_>) {
        let view = self.view_uniform(picture);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        self.floor.prepare(&self.gpu, Vec2::new(view.origin.z, view.origin.w));
        self.drawn = Some((view, picture.scene.layers));
        self.fit_surfaces(picture.within.map_or(picture.size, |(_, target)| target));
        let timer = self.timer.as_ref().filter(|timer| timer.is_free());
        self.robots.sort(&self.gpu, encoder, picture.size, &self.view_group, &mut self.columns, timer);
        let (trails, selected) = (picture.scene.trails, &picture.scene.selected);
        self.chosen.update(&self.gpu, encoder, &self.view_group, &mut self.columns, trails, selected);
        let (poses, robots) = (self.columns.group(&self.gpu), view.robots);
        let layers = picture.scene.layers;
        if layers.edges || layers.arrows || layers.nodes {
            self.graph.sort(encoder, &self.view_group);
        }
        let Some(surfaces) = &self.surfaces else { return };
        let mut pass = begin(encoder, surfaces, target, view.sky, timer);
        if let Some((at, _)) = picture.within {
            let (at, size) = (at.as_vec2(), picture.size.as_vec2());
            pass.set_viewport(at.x, at.y, size.x, size.y, 0.0, 1.0);
        }
        pass.set_bind_group(0, &self.view_group, &[]);
        self.floor.draw(&mut pass);
        self.graph.draw(&mut pass, layers);
        if let Some(records) = self.graph.records().filter(|_| layers.edges) {
            self.routes.draw(&mut pass, records);
        }
        if layers.trails {
            self.chosen.draw_trails(&mut pass, &poses, robots, trails);
        }
        self.chosen.draw_rings(&mut pass, &poses);
        if layers.robots && layers.shadows {
            self.robots.draw_shadows(&mut pass);
        }
        if layers.robots {
            self.robots.draw(&mut pass);
        }
        drop(pass);
        if let Some(timer) = timer {
            timer.finish(encoder);
        }
    }

    /// Takes a point of the trails when nothing is drawn. Drawing takes them too.
    pub fn collect_trails(&mut self, picture: &Picture<'_>) {
        let view = self.view_uniform(picture);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (trails, selected) = (picture.scene.trails, &picture.scene.selected);
        self.chosen.update(&self.gpu, &mut encoder, &self.view_group, &mut self.columns, trails, selected);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// What the last picture shows at a pixel, counted from its top left. Waits for the GPU.
    pub fn pick(&self, pixel: Vec2) -> Option<Picked> {
        let (mut view, layers) = self.drawn?;
        view.window = Pick::window(pixel, Vec2::new(view.viewport.x, view.viewport.y));
        self.gpu.queue.write_buffer(&self.pick_view, 0, bytemuck::bytes_of(&view));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.graph.prepare_ids(&mut encoder);
        let mut pass = self.pick.begin(&mut encoder);
        pass.set_bind_group(0, &self.pick_group, &[]);
        self.graph.draw_ids(&mut pass, layers);
        if layers.robots {
            self.robots.draw_ids(&mut pass);
        }
        drop(pass);
        self.pick.read(&self.gpu, encoder)
    }

    fn view_uniform(&self, picture: &Picture<'_>) -> ViewUniform {
        let mut view = ViewUniform::new(picture.camera, picture.scene, picture.legend, picture.size);
        [view.robots, view.previous_robots] = self.columns.robots();
        view.alpha = picture.alpha;
        view.jump = self.columns.jump();
        // A small fleet has room for larger marks.
        let room = (picture.size.as_vec2().element_product() / view.robots.max(1) as f32).sqrt() * 0.25;
        view.detail.z = room.clamp(view.detail.z, view.detail.z * 3.2);
        view.detail.w = self.columns.known() as f32;
        view
    }

    fn fit_surfaces(&mut self, size: UVec2) {
        if self.surfaces.as_ref().is_none_or(|surfaces| surfaces.size != size) {
            let make = |format, samples| texture(&self.gpu, size, format, samples, TextureUsages::RENDER_ATTACHMENT);
            let samples = self.target.samples;
            self.surfaces = Some(Surfaces {
                size,
                depth: view_of(&make(DEPTH, samples)),
                samples: (samples > 1).then(|| view_of(&make(self.target.format, samples))),
            });
        }
    }
}

/// What a picture shows.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// From where.
    pub camera: &'a Camera,
    /// What, and how.
    pub scene: &'a Scene,
    /// What the robots' colours are.
    pub legend: &'a Legend,
    /// Width and height in pixels.
    pub size: UVec2,
    /// Where it is in a larger target: its top left there, and the target's size.
    pub within: Option<(UVec2, UVec2)>,
    /// How far from the previous frame (0) to the newest (1).
    pub alpha: f32,
}

fn view_layout(gpu: &Gpu) -> BindGroupLayout {
    bindings(gpu, "view", ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE, &[Kind::Uniform])
}

fn begin<'a>(
    encoder: &'a mut CommandEncoder,
    surfaces: &Surfaces,
    target: &TextureView,
    sky: glam::Vec4,
    timer: Option<&Timer>,
) -> RenderPass<'a> {
    let [r, g, b, a] = sky.to_array().map(f64::from);
    let (view, resolve_target, store) = match &surfaces.samples {
        Some(samples) => (samples, Some(target), StoreOp::Discard),
        None => (target, None, StoreOp::Store),
    };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("fleet"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: Operations { load: LoadOp::Clear(Color { r, g, b, a }), store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &surfaces.depth,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        }),
        timestamp_writes: timer.map(Timer::end),
        ..wgpu::RenderPassDescriptor::default()
    })
}

/// A texture of one level.
pub fn texture(
    gpu: &Gpu,
    size: UVec2,
    format: wgpu::TextureFormat,
    samples: u32,
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: size.x.max(1), height: size.y.max(1), depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// All of a texture.
pub fn view_of(texture: &wgpu::Texture) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
