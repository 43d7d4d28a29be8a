//! The renderer: takes the fleet's data, and records the passes of a picture in order.

use glam::{UVec2, Vec2, Vec4};
use regatta_plugin::world::RobotTypeRecord;
use regatta_plugin::{Frame, World};
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ShaderStages, TextureView};

use super::attachments::Attachments;
use super::bindings::{Binding, bind_group, bind_group_layout};
use super::closures::ClosedEdges;
use super::columns::{Columns, RobotTypeUniform};
use super::device::Gpu;
use super::floor::Floor;
use super::graph::Graph;
use super::heat::HeatRibbons;
use super::highlights::Highlights;
use super::marked::MarkedPlace;
use super::pick::{Pick, Picked};
use super::pipeline::TargetConfig;
use super::plans::PlanMarks;
use super::resources::buffer;
use super::robots::{Dense, Robots, Variant};
use super::routes::Routes;
use super::stations::Stations;
use super::timer::Timer;
use super::view::ViewUniform;
use crate::camera::Camera;
use crate::density::{CROWDED, FADE, ground_of};
use crate::floor_picture::FloorPicture;
use crate::jams::heat::HeatMap;
use crate::mesh::Mesh;
use crate::palette::Legend;
use crate::plans::PlanReport;
use crate::route::RouteSegment;
use crate::scene::{Layers, Scene};

/// The parameters of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The content and the style of pictures.
    pub scene: &'a Scene,
    /// The colours of the robots.
    pub legend: &'a Legend,
    /// Width and height in pixels.
    pub size: UVec2,
    /// The picture's top left corner in a larger target, and the size of that target; `None` if the picture fills it.
    pub within: Option<(UVec2, UVec2)>,
    /// The moment to show, from the previous frame (0) to the newest (1).
    pub alpha: f32,
}

/// Draws a fleet into any texture view.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    target: TargetConfig,
    columns: Columns,
    view: Buffer,
    view_group: BindGroup,
    pick: Pick,
    pick_view: Buffer,
    pick_group: BindGroup,
    /// View and layers of the last picture, which picking draws again.
    drawn: Option<(ViewUniform, Layers)>,
    attachments: Option<Attachments>,
    floor: Floor,
    graph: Graph,
    heat: HeatRibbons,
    closed: ClosedEdges,
    routes: Routes,
    stations: Stations,
    marked: MarkedPlace,
    robots: Robots,
    highlights: Highlights,
    plan_marks: PlanMarks,
    /// The level that alone is shown.
    level: Option<String>,
    robot_types: Vec<RobotTypeRecord>,
    assignments: Vec<MeshAssignment>,
    timer: Option<Timer>,
    /// The ground on which robots are, in square metres, if it is known.
    ground: Option<f32>,
}

/// A mesh that replaces the built-in one for a robot type.
#[derive(Debug)]
struct MeshAssignment {
    /// Name of the type; `None` for all types without a mesh of their own.
    robot_type: Option<String>,
    /// The mesh's number in [`Robots`].
    mesh: usize,
    is_shown: bool,
}

impl Renderer {
    /// Creates the pipelines for a target.
    pub fn new(gpu: &Gpu, target: TargetConfig) -> Self {
        let stages = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let layout = bind_group_layout(gpu, "view", stages, &[Binding::Uniform]);
        let [view, pick_view] =
            ["view", "pick view"].map(|label| buffer(gpu, label, size_of::<ViewUniform>(), BufferUsages::UNIFORM));
        let columns = Columns::new(gpu);
        let graph = Graph::new(gpu, target, &layout);
        Self {
            gpu: gpu.clone(),
            target,
            view_group: bind_group(gpu, &layout, &[(0, &view)]),
            view,
            pick: Pick::new(gpu),
            pick_group: bind_group(gpu, &layout, &[(0, &pick_view)]),
            pick_view,
            drawn: None,
            attachments: None,
            floor: Floor::new(gpu, target, &layout),
            heat: HeatRibbons::new(gpu, target, &layout, graph.records_layout()),
            closed: ClosedEdges::new(gpu, target, &layout, graph.records_layout()),
            routes: Routes::new(gpu, target, &layout, graph.records_layout()),
            stations: Stations::new(gpu, target, &layout),
            marked: MarkedPlace::new(gpu, target, &layout, graph.records_layout()),
            graph,
            robots: Robots::new(gpu, target, &layout, &columns),
            highlights: Highlights::new(gpu, target, &layout, &columns),
            plan_marks: PlanMarks::new(gpu, target, &layout, &columns),
            columns,
            level: None,
            robot_types: Vec::new(),
            assignments: Vec::new(),
            timer: None,
            ground: None,
        }
    }

    /// Measures the GPU time of pictures from now on, if the adapter has timestamp queries.
    pub fn enable_timer(&mut self) {
        self.timer = Timer::new(&self.gpu);
    }

    /// Waits for the picture that was submitted last, and returns its GPU time in seconds.
    pub fn gpu_seconds(&mut self) -> Option<f64> {
        let timer = self.timer.as_mut()?;
        timer.request();
        self.gpu.wait();
        timer.take_result(&self.gpu)
    }

    /// Returns the GPU time in seconds of a picture that was finished since the last call, without waiting. Call this
    /// after each submitted picture; not all of them are measured.
    pub fn poll_gpu_seconds(&mut self) -> Option<f64> {
        let timer = self.timer.as_mut()?;
        if timer.is_free() {
            timer.request();
        }
        self.gpu.poll();
        timer.take_result(&self.gpu)
    }

    /// The adapter's largest texture size, in pixels in either direction.
    pub fn max_texture_size(&self) -> u32 {
        self.gpu.device.limits().max_texture_dimension_2d
    }

    /// Sets or removes the picture on the floor. Returns false if the adapter's memory has no room for it; there is none then.
    pub fn set_floor_picture(&mut self, picture: Option<&FloorPicture>) -> bool {
        let Self { gpu, floor, .. } = self;
        let has_room = gpu.allocate(|| floor.set_picture(gpu, picture)).is_some();
        if !has_room {
            floor.set_picture(gpu, None);
        }
        has_room
    }

    /// Sets or removes the mesh of a robot type, or with `None` of all types that have no mesh of their own.
    /// Returns false if there are too many meshes.
    pub fn set_mesh(&mut self, robot_type: Option<&str>, mesh: Option<&Mesh>) -> bool {
        let existing = self.assignments.iter_mut().find(|assignment| assignment.robot_type.as_deref() == robot_type);
        match (existing, mesh) {
            (Some(assignment), Some(mesh)) => {
                self.robots.replace_mesh(&self.gpu, assignment.mesh, mesh);
                assignment.is_shown = true;
            }
            (Some(assignment), None) => assignment.is_shown = false,
            (None, Some(mesh)) => {
                let Some(mesh) = self.robots.add_mesh(&self.gpu, mesh) else { return false };
                self.assignments.push(MeshAssignment {
                    robot_type: robot_type.map(str::to_owned),
                    mesh,
                    is_shown: true,
                });
            }
            (None, None) => {}
        }
        self.upload_robot_types();
        true
    }

    /// Sets the graph and the robot types.
    pub fn set_world(&mut self, world: &World<'_>) {
        self.set_robot_types(world.robot_types());
        self.set_graph(world);
    }

    /// Shows one level of the graph only, from the next [`set_graph`](Self::set_graph) on, and hides the robots that don't match.
    pub fn set_level(&mut self, level: Option<&str>) {
        self.level = level.map(str::to_owned);
    }

    /// Sets the route graph.
    pub fn set_graph(&mut self, world: &World<'_>) {
        self.ground = ground_of(world);
        let level = self.level.as_deref();
        self.graph.load(&self.gpu, world, level);
        self.stations.load(&self.gpu, world, level);
        self.marked.load(world);
    }

    /// Sets the ground on which the robots of a fleet without a graph are, in square metres.
    pub fn set_ground(&mut self, ground: f32) {
        self.ground = Some(ground);
    }

    /// The density of half the strength, in robots per square metre: the mean over the ground.
    pub fn mean_density(&self) -> Option<f32> {
        self.ground.map(|ground| self.columns.robots()[0] as f32 / ground.max(1.0))
    }

    /// Returns the density of half the strength, in robots per hectare, if robots around the camera's target are drawn as their
    /// density.
    pub fn shown_density(&self, picture: &Picture<'_>) -> Option<f32> {
        let camera = picture.camera;
        let pixels_per_metre = camera.pixels_per_radian(picture.size.y as f32) / camera.distance;
        let density = self.density(picture);
        // Nearer than that, marks are stronger than the field.
        let is_shown = picture.scene.layers.robots && density.w * pixels_per_metre < 0.5 * (FADE[0] + FADE[1]);
        (is_shown && density.z > 0.0).then_some(self.mean_density()? * 1e4)
    }

    /// Replaces the closed edges of the world, by index.
    pub fn set_closed(&mut self, world: &World<'_>, closed: &[u32]) {
        self.closed.set(&self.gpu, world, closed, self.level.as_deref());
    }

    /// Replaces the routes of selected robots, which are drawn along the graph.
    pub fn set_routes(&mut self, segments: &[RouteSegment]) {
        self.routes.set(&self.gpu, segments);
    }

    /// Replaces what is drawn of plans: the routes of all robots, goals, and who waits for whom.
    pub fn set_plans(&mut self, plans: &PlanReport) {
        self.routes.set_all(&self.gpu, &plans.lines);
        self.plan_marks.set_goals(&self.gpu, &plans.goals);
        self.plan_marks.set_arrows(&self.gpu, &plans.arrows);
    }

    /// Replaces the heat map, or removes it.
    pub fn set_heat(&mut self, map: Option<&HeatMap>) {
        self.heat.set(&self.gpu, map);
        let hot = map.into_iter().flat_map(|map| map.straight.iter().chain(&map.bent));
        self.graph.set_hot(&self.gpu, hot.map(|hot| hot.curve));
    }

    /// Sets the records of the robot types.
    pub fn set_robot_types(&mut self, robot_types: &[RobotTypeRecord]) {
        self.robot_types = robot_types.to_vec();
        self.upload_robot_types();
    }

    fn upload_robot_types(&mut self) {
        let find = |name: Option<&str>| {
            self.assignments.iter().find(|assignment| assignment.is_shown && assignment.robot_type.as_deref() == name)
        };
        let uniform = |record: &RobotTypeRecord| {
            let assignment = find(Some(record.name())).or_else(|| find(None));
            let uniform = RobotTypeUniform::new(record);
            assignment.map_or(uniform, |assignment| uniform.with_mesh(assignment.mesh))
        };
        let uniforms: Vec<_> = self.robot_types.iter().map(uniform).collect();
        self.robots.set_any_round(uniforms.iter().any(|uniform| uniform.is_round()));
        self.columns.set_robot_types(&self.gpu, &uniforms);
    }

    /// Uploads a new frame; the newest one so far becomes the previous one.
    pub fn push_frame(&mut self, frame: &Frame<'_>) {
        self.columns.push(&self.gpu, frame);
        self.highlights.push(frame.run_id(), frame.header().sim_time_nanos);
    }

    /// Uploads the column of robot types: each robot's index into the records.
    pub fn set_robot_type_column(&mut self, robot_type: &[f32]) {
        self.columns.set_robot_type_column(&self.gpu, robot_type);
    }

    /// Points of each trail: as many as requested, or fewer if the adapter lacks the memory.
    pub fn trail_points(&self) -> u32 {
        self.highlights.trail_points()
    }

    /// Whether the column of robot types has to be uploaded, at first or after the buffers were replaced.
    pub fn lacks_robot_type_column(&self) -> bool {
        self.columns.lacks_robot_type_column()
    }

    /// Whether no robot has a value.
    pub fn lacks_values(&self) -> bool {
        self.columns.values() == 0
    }

    /// Sets or removes the values that robots are coloured by.
    pub fn set_values(&mut self, values: Option<&[f32]>) {
        match values {
            Some(values) => self.columns.set_values(&self.gpu, values),
            None => self.columns.clear_values(),
        }
    }

    /// Dims the robots whose bit is not set, 32 to a word; with `None` no robot.
    pub fn set_matches(&mut self, matches: Option<&[u32]>) {
        self.columns.set_matches(&self.gpu, matches);
    }

    /// Records the commands that draw a picture into `target`.
    pub fn draw(&mut self, encoder: &mut CommandEncoder, target: &TextureView, picture: &Picture<'_>) {
        let view = self.view_uniform(picture);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        self.floor.prepare(&self.gpu, Vec2::new(view.origin.z, view.origin.w));
        self.drawn = Some((view, picture.scene.layers));
        self.fit_attachments(picture.within.map_or(picture.size, |(_, target)| target));
        let timer = self.timer.as_ref().filter(|timer| timer.is_free());
        self.marked.update(&self.gpu, picture.scene.marked);
        self.robots.set_variant(self.variant(&view, picture.scene));
        self.robots.sort(&self.gpu, encoder, picture.size, &self.view_group, &mut self.columns, timer);
        let (trails, selected) = (picture.scene.trails, &picture.scene.selected);
        self.highlights.update(&self.gpu, encoder, &self.view_group, &mut self.columns, trails, selected);
        let (poses, robots) = (self.columns.group(&self.gpu), view.robots);
        let layers = picture.scene.layers;
        if layers.edges || layers.arrows || layers.nodes {
            self.graph.sort(encoder, &self.view_group);
        }
        if let Some(records) = self.graph.records().filter(|_| picture.scene.heat.is_some()) {
            let (groups, theme) = ((&self.view_group, records), picture.scene.theme);
            self.heat.sort(&self.gpu, encoder, groups, picture.size, theme);
        }
        let Some(attachments) = &self.attachments else { return };
        let mut pass = attachments.begin_pass(encoder, target, view.sky, timer);
        if let Some((at, _)) = picture.within {
            let (at, size) = (at.as_vec2(), picture.size.as_vec2());
            pass.set_viewport(at.x, at.y, size.x, size.y, 0.0, 1.0);
        }
        pass.set_bind_group(0, &self.view_group, &[]);
        self.floor.draw(&mut pass);
        self.graph.draw(&mut pass, Layers { arrows: false, nodes: false, ..layers });
        if let Some(records) = self.graph.records().filter(|_| picture.scene.heat.is_some()) {
            self.heat.draw(&mut pass, records);
        }
        self.graph.draw(&mut pass, Layers { edges: false, ..layers });
        if let Some(records) = self.graph.records().filter(|_| layers.edges) {
            self.routes.draw(&mut pass, records, layers.plans);
            self.closed.draw(&mut pass, records);
        }
        if layers.nodes {
            self.stations.draw(&mut pass);
        }
        if let Some(records) = self.graph.records() {
            self.marked.draw(&mut pass, records);
        }
        if layers.trails {
            self.highlights.draw_trails(&mut pass, &poses, robots, trails);
        }
        self.highlights.draw_halos(&mut pass, &poses);
        if layers.robots {
            self.robots.draw_density(&mut pass);
        }
        if layers.robots && layers.shadows && !picture.camera.is_plan() {
            self.robots.draw_shadows(&mut pass);
        }
        if layers.robots {
            self.robots.draw(&mut pass);
        }
        self.plan_marks.draw(&mut pass, &poses, layers.waits);
        drop(pass);
        if let Some(timer) = timer {
            timer.finish(encoder);
        }
    }

    /// Appends a point to each trail without drawing. [`draw`](Self::draw) appends points too.
    pub fn collect_trails(&mut self, picture: &Picture<'_>) {
        let view = self.view_uniform(picture);
        self.gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (trails, selected) = (picture.scene.trails, &picture.scene.selected);
        self.highlights.update(&self.gpu, &mut encoder, &self.view_group, &mut self.columns, trails, selected);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Width and height of the last picture in pixels.
    pub fn drawn_size(&self) -> Vec2 {
        self.drawn.map_or(Vec2::ONE, |(view, _)| Vec2::new(view.viewport.x, view.viewport.y))
    }

    /// Returns what the last picture shows at a pixel, counted from its top left. Waits for the GPU.
    pub fn pick(&self, pixel: Vec2) -> Option<Picked> {
        let (mut view, layers) = self.drawn?;
        view.crop = Pick::crop(pixel, Vec2::new(view.viewport.x, view.viewport.y));
        self.gpu.queue.write_buffer(&self.pick_view, 0, bytemuck::bytes_of(&view));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = self.pick.begin_pass(&mut encoder);
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
        view.teleport_distance = self.columns.teleport_distance();
        view.density = self.density(picture);
        // A small fleet leaves room for larger marks.
        let room = (picture.size.as_vec2().element_product() / view.robots.max(1) as f32).sqrt() * 0.25;
        if !picture.camera.is_plan() {
            view.detail.z = room.clamp(view.detail.z, view.detail.z * 3.2);
        }
        view.heated = u32::from(picture.scene.heat.is_some());
        view.detail.w = self.columns.values() as f32;
        view.filtered = u32::from(self.columns.is_filtered()) * if self.level.is_some() { 2 } else { 1 };
        view
    }

    /// What is decided for all robots of a picture at once.
    fn variant(&self, view: &ViewUniform, scene: &Scene) -> Variant {
        let sizes = self.robot_types.iter().map(RobotTypeUniform::new).map(|size| size.length.max(size.width));
        let ends = sizes.map(|size| [size; 2]).reduce(|[low, high], [size, _]| [low.min(size), high.max(size)]);
        let [smallest, largest] = ends.unwrap_or([RobotTypeUniform::default().length; 2]);
        // The greatest and the least length of a robot in the picture. A body may lean into it whose middle is outside.
        let [near, far] = view.ground_distances();
        let [pixels, least] = [1.1 * largest * view.eye.w / near, smallest * view.eye.w / far];
        let dense = match scene.layers.robots && view.density.z > 0.0 && least < view.density.y {
            false => Dense::None,
            true if pixels < view.density.x => Dense::All,
            true => Dense::Small,
        };
        let bodies = pixels >= view.detail.y.max(view.detail.z);
        Variant { splats: false, dense, source: view.source, filtered: view.filtered, bodies }
    }

    /// The ends of the fade in pixels, the reciprocal of the density of half the strength (0 if all robots are marked), and the
    /// length of robots in metres.
    fn density(&self, picture: &Picture<'_>) -> Vec4 {
        let lengths = self.robot_types.iter().map(|record| RobotTypeUniform::new(record).length);
        let length = lengths.reduce(f32::max).unwrap_or(RobotTypeUniform::default().length);
        let robots = self.columns.robots()[0] as f32;
        let is_crowded = robots > picture.size.as_vec2().element_product() * CROWDED;
        let mean = self.mean_density().filter(|mean| picture.scene.layers.density && is_crowded && *mean > 0.0);
        Vec4::new(FADE[0], FADE[1], mean.map_or(0.0, f32::recip), length)
    }

    fn fit_attachments(&mut self, size: UVec2) {
        if self.attachments.as_ref().is_none_or(|attachments| attachments.size() != size) {
            self.attachments = Some(Attachments::new(&self.gpu, self.target, size));
        }
    }
}
