//! The renderer: takes the fleet's data, and records the passes of a picture in order.

mod passes;
mod uniform;

use glam::UVec2;
use regatta_plugin::facility::FacilityState;
use regatta_plugin::world::RobotTypeRecord;
use regatta_plugin::{Frame, World};
use regatta_scene::camera::Camera;
use regatta_scene::facilities::bars;
use regatta_scene::heat::HeatMap;
use regatta_scene::palette::Legend;
use regatta_scene::plans::PlanReport;
use regatta_scene::route::RouteSegment;
use regatta_scene::{Layers, Scene};
use wgpu::{BindGroup, Buffer, BufferUsages, ShaderStages};

use super::attachments::Attachments;
use super::bindings::{Binding, bind_buffers, bind_group_layout};
use super::columns::{Columns, RobotTypeUniform};
use super::copy::Ground;
use super::density::ground_of;
use super::device::Gpu;
use super::floor::{Floor, FloorPicture};
use super::graph::Graph;
use super::heat::HeatRibbons;
use super::highlights::Highlights;
use super::marks::Marks;
use super::mesh::Mesh;
use super::pick::Pick;
use super::pipeline::TargetConfig;
use super::resources::buffer;
use super::robots::Robots;
use super::timer::Timer;
use super::view::ViewUniform;

/// The parameters of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The content and the style of the picture.
    pub scene: &'a Scene,
    /// The colours of the robots.
    pub legend: &'a Legend,
    /// Width and height in pixels.
    pub size: UVec2,
    /// The picture's top left corner in a larger target, and the size of that target; `None` if the
    /// picture fills it.
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
    ground_copy: Ground,
    floor: Floor,
    graph: Graph,
    heat: HeatRibbons,
    marks: Marks,
    robots: Robots,
    highlights: Highlights,
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
    /// The mesh's number in [`Robots`](crate::robots::Robots).
    mesh: usize,
    is_shown: bool,
}

impl Renderer {
    /// Creates the pipelines for a target.
    pub fn new(gpu: &Gpu, target: TargetConfig) -> Self {
        let stages = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let layout = bind_group_layout(gpu, "view", stages, &[Binding::Uniform]);
        let [view, pick_view] = ["view", "pick view"]
            .map(|label| buffer(gpu, label, size_of::<ViewUniform>(), BufferUsages::UNIFORM));
        let columns = Columns::new(gpu);
        let graph = Graph::new(gpu, target, &layout);
        Self {
            gpu: gpu.clone(),
            target,
            view_group: bind_buffers(gpu, &layout, &[&view]),
            view,
            pick: Pick::new(gpu),
            pick_group: bind_buffers(gpu, &layout, &[&pick_view]),
            pick_view,
            drawn: None,
            attachments: None,
            ground_copy: Ground::new(gpu, target),
            floor: Floor::new(gpu, target, &layout),
            heat: HeatRibbons::new(gpu, target, &layout, graph.records_layout()),
            marks: Marks::new(gpu, target, &layout, graph.records_layout(), columns.layout()),
            graph,
            robots: Robots::new(gpu, target, &layout, &columns),
            highlights: Highlights::new(gpu, target, &layout, &columns),
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

    /// Returns the GPU time in seconds of a picture that was finished since the last call, without
    /// waiting. Call this after each submitted picture; not all of them are measured.
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

    /// Sets or removes the picture on the floor. Returns false if the adapter's memory has no room
    /// for it; there is none then.
    pub fn set_floor_picture(&mut self, picture: Option<&FloorPicture>) -> bool {
        self.ground_copy.forget();
        let Self { gpu, floor, .. } = self;
        let has_room = gpu.allocate(|| floor.set_picture(gpu, picture)).is_some();
        if !has_room {
            floor.set_picture(gpu, None);
        }
        has_room
    }

    /// Sets the graph and the robot types.
    pub fn set_world(&mut self, world: &World<'_>) {
        self.set_robot_types(world.robot_types());
        self.set_graph(world);
    }

    /// Shows one level of the graph only, from the next [`set_graph`](Self::set_graph) on. Robots
    /// of other levels are hidden by [`set_on_level`](Self::set_on_level).
    pub fn set_level(&mut self, level: Option<&str>) {
        self.level = level.map(str::to_owned);
    }

    /// Sets the route graph.
    pub fn set_graph(&mut self, world: &World<'_>) {
        self.ground_copy.forget();
        self.ground = ground_of(world);
        let level = self.level.as_deref();
        self.graph.load(&self.gpu, world, level);
        self.marks.set_world(&self.gpu, world, level);
    }

    /// Sets the ground on which the robots of a fleet without a graph are, in square metres.
    pub fn set_ground(&mut self, ground: f32) {
        self.ground = Some(ground);
    }

    /// Replaces the closed edges of the world, by index.
    pub fn set_closed(&mut self, world: &World<'_>, closed: &[u32]) {
        self.marks.set_closed(&self.gpu, world, closed, self.level.as_deref());
    }

    /// Replaces the doors and lifts of the world, by their states at a tick.
    pub fn set_facilities(&mut self, world: &World<'_>, states: &[FacilityState], tick: u64) {
        let bars = bars(world, states, tick, self.level.as_deref());
        self.marks.set_facilities(&self.gpu, &bars);
    }

    /// Replaces the routes of selected robots, which are drawn along the graph.
    pub fn set_routes(&mut self, segments: &[RouteSegment]) {
        self.marks.set_routes(&self.gpu, segments);
    }

    /// Replaces the routes of all robots, the goals, and the arrows from robots that wait.
    pub fn set_plans(&mut self, plans: &PlanReport) {
        self.marks.set_plans(&self.gpu, plans);
    }

    /// Replaces the heat map, or removes it.
    pub fn set_heat(&mut self, map: Option<&HeatMap>) {
        self.ground_copy.forget();
        self.heat.set(&self.gpu, map);
        let hot = map.into_iter().flat_map(|map| map.straight.iter().chain(&map.bent));
        self.graph.set_hot(&self.gpu, hot.map(|hot| hot.curve));
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

    /// Whether the column of robot types has to be uploaded, at first or after the buffers were
    /// replaced.
    pub fn lacks_robot_type_column(&self) -> bool {
        self.columns.lacks_robot_type_column()
    }

    /// Whether no robot has a value.
    pub fn lacks_values(&self) -> bool {
        self.columns.values() == 0
    }

    /// Sets or removes the values that robots are coloured by.
    pub fn set_values(&mut self, values: Option<&[f32]>) {
        self.columns.set_values(&self.gpu, values);
    }

    /// Dims the robots whose bit is not set, 32 to a word; with `None` no robot.
    pub fn set_matches(&mut self, matches: Option<&[u32]>) {
        self.columns.set_matches(&self.gpu, matches);
    }

    /// Hides the robots whose bit is not set, 32 to a word; with `None` no robot.
    pub fn set_on_level(&mut self, on_level: Option<&[u32]>) {
        self.columns.set_on_level(&self.gpu, on_level);
    }

    /// Sets or removes the mesh of a robot type, or with `None` of all types that have no mesh of
    /// their own. Returns false if there are too many meshes.
    pub fn set_mesh(&mut self, robot_type: Option<&str>, mesh: Option<&Mesh>) -> bool {
        let existing = self
            .assignments
            .iter_mut()
            .find(|assignment| assignment.robot_type.as_deref() == robot_type);
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

    /// Sets the records of the robot types.
    pub fn set_robot_types(&mut self, robot_types: &[RobotTypeRecord]) {
        self.robot_types = robot_types.to_vec();
        self.upload_robot_types();
    }

    fn upload_robot_types(&mut self) {
        let mut uniforms = Vec::with_capacity(self.robot_types.len());
        for record in &self.robot_types {
            let uniform = RobotTypeUniform::new(record);
            let mesh = self.mesh_of(Some(record.name())).or_else(|| self.mesh_of(None));
            uniforms.push(mesh.map_or(uniform, |mesh| uniform.with_mesh(mesh)));
        }
        self.robots.set_any_round(uniforms.iter().any(RobotTypeUniform::is_round));
        self.columns.set_robot_types(&self.gpu, &uniforms);
    }

    /// The number of the mesh that is assigned to a robot type, or with `None` to all others.
    fn mesh_of(&self, robot_type: Option<&str>) -> Option<usize> {
        let mut shown = self.assignments.iter().filter(|assignment| assignment.is_shown);
        shown.find(|other| other.robot_type.as_deref() == robot_type).map(|found| found.mesh)
    }
}
