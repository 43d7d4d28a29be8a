//! A small hand-written fleet, and a renderer of pictures of it.

use glam::{UVec2, Vec2};
use image::RgbaImage;
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_gpu::renderer::{Picture, Renderer};
use regatta_plugin::Frame;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines};
use regatta_plugin::world::{
    CurveRecord, EdgeRecord, NodeRecord, RobotTypeRecord, Shape, WorldData,
};
use regatta_scene::Scene;
use regatta_scene::camera::{Bounds, Camera};
use regatta_viewer::picture::{FORMAT, Offscreen};

pub const SIZE: UVec2 = UVec2::new(320, 200);

/// A robot's row in a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Robot {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub speed: f32,
    pub state: u8,
}

/// Renders scenes into pictures.
pub struct TestRenderer {
    gpu: Gpu,
    pub inner: Renderer,
    offscreen: Offscreen,
    tick: u64,
}

impl TestRenderer {
    pub fn new(gpu: &Gpu) -> Self {
        Self::with_target(gpu, TargetConfig::new(gpu, FORMAT, 4))
    }

    pub fn with_target(gpu: &Gpu, target: TargetConfig) -> Self {
        let mut renderer = Renderer::new(gpu, target);
        renderer.set_robot_types(&robot_types());
        Self {
            gpu: gpu.clone(),
            inner: renderer,
            offscreen: Offscreen::new(gpu, SIZE, target).expect("a small target"),
            tick: 0,
        }
    }

    /// Uploads a frame, half a simulated second after the previous one.
    pub fn push(&mut self, robots: &[Robot]) {
        let mut lines = vec![Line::default(); frame_lines(robots.len())];
        let columns = ColumnsMut::split(&mut lines, robots.len());
        for (i, robot) in robots.iter().enumerate() {
            (columns.x[i], columns.y[i], columns.theta[i]) = (robot.x, robot.y, robot.theta);
            (columns.speed[i], columns.edge[i], columns.state[i]) =
                (robot.speed, NO_EDGE, robot.state);
        }
        self.tick += 1;
        let header = FrameHeader {
            run_id: 1,
            tick: self.tick,
            sim_time_nanos: self.tick * 500_000_000,
            robots: robots.len() as u32,
            stride_lines: stride_lines(robots.len()) as u32,
            ..FrameHeader::default()
        };
        self.inner.push_frame(&Frame::new(&header, &lines).expect("a complete frame"));
    }

    pub fn render(&mut self, camera: &Camera, scene: &Scene, alpha: f32) -> RgbaImage {
        let robot_types = ["cart".to_owned(), "puck".to_owned()];
        let legend = scene.colouring.legend(scene.theme, &robot_types, Some((0.0, 2.0)));
        let mut encoder = self.gpu.encoder();
        let picture = Picture { camera, scene, legend: &legend, size: SIZE, within: None, alpha };
        self.inner.draw(&mut encoder, &self.offscreen.view, &picture);
        self.offscreen.read(encoder).expect("a picture")
    }
}

/// Returns two robot types: a rectangular cart and a round puck.
pub fn robot_types() -> [RobotTypeRecord; 2] {
    let record = |name, shape, length, width| RobotTypeRecord {
        shape: shape as u32,
        max_speed: 2.0,
        max_acceleration: 1.0,
        ..RobotTypeRecord::new(name, length, width)
    };
    [record("cart", Shape::Rectangle, 0.9, 0.6), record("puck", Shape::Circle, 0.7, 0.7)]
}

/// Returns a loop of two straight edges and two bends. The second straight edge is two-way.
pub fn graph() -> WorldData {
    let places = [[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [0.0, 4.0]];
    let nodes = (0..)
        .zip(places)
        .map(|(id, [x, y])| NodeRecord { id, x, y, ..NodeRecord::default() })
        .collect();
    let mut world = WorldData { nodes, ..WorldData::default() };
    let mut edge = |id: u32, control_points, backwards| {
        let (origin, destination, length) = (id, (id + 1) % 4, 7.0);
        let (speed, reverse_speed) = (1.0, backwards);
        let edge = EdgeRecord {
            id,
            origin,
            destination,
            length,
            speed,
            reverse_speed,
            ..EdgeRecord::default()
        };
        world.add_edge(edge, [CurveRecord { control_points }]);
    };
    edge(0, [[0.0, 0.0], [3.0, 0.0], [5.0, 0.0], [8.0, 0.0]], 0.0);
    edge(1, [[8.0, 0.0], [11.0, 0.0], [11.0, 4.0], [8.0, 4.0]], 0.0);
    edge(2, [[8.0, 4.0], [5.0, 4.0], [3.0, 4.0], [0.0, 4.0]], 0.5);
    edge(3, [[0.0, 4.0], [-3.0, 4.0], [-3.0, 0.0], [0.0, 0.0]], 0.0);
    world
}

/// Returns two rows of six robots in all states, at speeds from 0 to 2 m/s.
pub fn robots() -> Vec<Robot> {
    (0..12)
        .map(|i| Robot {
            x: (i % 6) as f32 * 1.6,
            y: (i / 6) as f32 * 4.0,
            theta: if i < 6 { 0.0 } else { 2.6 },
            speed: i as f32 * 2.0 / 11.0,
            state: (i % 5) as u8,
        })
        .collect()
}

/// The bounds of the graph and the robots.
pub fn bounds() -> Bounds {
    Bounds { low: Vec2::new(-2.5, -0.8), high: Vec2::new(10.5, 4.8) }
}

pub fn camera() -> Camera {
    Camera::fit(bounds(), SIZE.x as f32 / SIZE.y as f32)
}

pub fn top() -> Camera {
    Camera::top(bounds(), SIZE.x as f32 / SIZE.y as f32)
}
