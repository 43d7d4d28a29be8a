//! Tests of picking at known positions.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::palette::Colouring;
use regatta_scene::{Item, Scene};
use regatta_viewer::picture::FORMAT;

use crate::Test;
use crate::fleet::{Robot, SIZE, TestRenderer, bounds, camera, graph, robots, top};

pub const TESTS: &[(&str, Test)] = &[
    ("robots_are_picked_at_their_positions", robots_are_picked),
    ("marks_are_picked_far_away_and_far_from_the_origin", marks_are_picked),
    ("nodes_and_edges_are_picked", nodes_and_edges),
    ("the_nearer_of_two_robots_is_picked", the_nearer),
    ("robots_are_picked_where_they_are_drawn_with_an_offset", with_an_offset),
    ("triangles_are_picked_after_splats", triangles_after_splats),
    ("the_visible_one_of_overlapping_marks_is_picked", overlapping_marks),
];

fn aspect() -> f32 {
    SIZE.x as f32 / SIZE.y as f32
}

fn pixel(camera: &Camera, point: Vec3) -> Vec2 {
    camera.project(point, SIZE.as_vec2()).expect("in the picture")
}

fn robots_are_picked(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    renderer.push(&robots());
    for camera in [camera(), top()] {
        renderer.render(&camera, &Scene::default(), 1.0);
        for (id, robot) in robots().iter().enumerate() {
            let at = pixel(&camera, Vec3::new(robot.x, robot.y, 0.2));
            assert_eq!(renderer.inner.pick(at), Some(Item::Robot(id as u32)), "{at}");
        }
        let beside = pixel(&camera, Vec3::new(4.0, 2.0, 0.0));
        assert_eq!(renderer.inner.pick(beside), None);
        assert_eq!(renderer.inner.pick(Vec2::splat(-50.0)), None, "outside of the picture");
    }
}

/// A hundred robots, a few pixels from each other, far from the origin.
fn marks_are_picked(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    let (low, side) = (Vec2::new(7000.0, -7500.0), 10);
    let fleet: Vec<_> = (0..side * side)
        .map(|i| Robot {
            x: low.x + (i % side) as f32 * 30.0,
            y: low.y + (i / side) as f32 * 30.0,
            ..Robot::default()
        })
        .collect();
    renderer.push(&fleet);
    let camera = Camera::top(Bounds { low, high: low + 270.0 }, aspect());
    renderer.render(&camera, &Scene::default(), 1.0);
    for id in [0, 7, 33, 58, 99] {
        let at = pixel(&camera, Vec3::new(fleet[id].x, fleet[id].y, 0.1));
        assert_eq!(renderer.inner.pick(at), Some(Item::Robot(id as u32)), "{at}");
    }
}

fn nodes_and_edges(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    renderer.inner.set_graph(&graph().view(1, 1));
    renderer.push(&[]);
    let camera = Camera::top(bounds(), aspect());
    renderer.render(&camera, &Scene::default(), 1.0);
    for (index, node) in graph().nodes.iter().enumerate() {
        let picked = renderer.inner.pick(pixel(&camera, Vec3::new(node.x, node.y, 0.0)));
        assert_eq!(picked, Some(Item::Node(index as u32)));
    }
    // The middles of the curves.
    for (index, middle) in
        [[4.0, 0.0], [10.25, 2.0], [4.0, 4.0], [-2.25, 2.0]].into_iter().enumerate()
    {
        let picked = renderer.inner.pick(pixel(&camera, Vec3::new(middle[0], middle[1], 0.0)));
        assert_eq!(picked, Some(Item::Edge(index as u32)));
    }
}

/// Two robots, one behind the other as seen from the camera.
fn the_nearer(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    renderer.push(&[Robot { x: 2.0, ..Robot::default() }, Robot { x: 1.2, ..Robot::default() }]);
    let camera = Camera::from_eye(Vec3::new(-2.0, 0.0, 0.25), 0.0, 0.01);
    renderer.render(&camera, &Scene::default(), 1.0);
    assert_eq!(
        renderer.inner.pick(pixel(&camera, Vec3::new(1.2, 0.0, 0.15))),
        Some(Item::Robot(1))
    );
}

fn with_an_offset(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    renderer.push(&[Robot { x: 3.0, y: 1.0, ..Robot::default() }]);
    let scene = Scene { offset: Vec2::new(2.0, 1.5), ..Scene::default() };
    renderer.render(&top(), &scene, 1.0);
    assert_eq!(renderer.inner.pick(pixel(&top(), Vec3::new(5.0, 2.5, 0.2))), Some(Item::Robot(0)));
    assert_eq!(renderer.inner.pick(pixel(&top(), Vec3::new(3.0, 1.0, 0.2))), None);
}

/// Enough robots of two types that their marks overlap, as triangles and as splats.
fn overlapping_marks(gpu: &Gpu) {
    let robot = |i: usize| {
        let place = |factor: f32, span: f32| (i as f32 * factor).fract() * span;
        Robot { x: place(0.618, 60.0), y: place(0.414, 40.0), theta: i as f32, ..Robot::default() }
    };
    let fleet: Vec<_> = (0..1500).map(robot).collect();
    let camera = Camera::fit(Bounds { low: Vec2::ZERO, high: Vec2::new(60.0, 40.0) }, aspect());
    let scene = Scene { colouring: Colouring::Type, ..Scene::default() };
    for splats_from in [u32::MAX, 0] {
        let mut renderer = TestRenderer::with_target(
            gpu,
            TargetConfig { splats_from, ..TargetConfig::new(gpu, FORMAT, 1) },
        );
        renderer.push(&fleet);
        renderer.inner.set_robot_type_column(&[0.0, 1.0].repeat(750));
        let picture = renderer.render(&camera, &scene, 1.0);
        let mut types = BTreeMap::new();
        let pixels = (20..180).step_by(3).flat_map(|y| (20..300).step_by(7).map(move |x| (x, y)));
        for (x, y) in pixels {
            let colour = picture.get_pixel(x, y).0;
            // Picking tolerates a few pixels, so it may find a robot beside a pixel of the dark
            // floor.
            let is_robot = colour[..3].iter().any(|part| *part > 120);
            let picked = renderer.inner.pick(Vec2::new(x as f32, y as f32) + 0.5);
            if let Some(Item::Robot(id)) = picked.filter(|_| is_robot) {
                types.entry(colour).or_insert_with(Vec::new).push(id % 2);
            }
        }
        assert!(types.values().map(Vec::len).sum::<usize>() > 20, "{types:?}");
        let is_one = |ids: &Vec<u32>| ids.iter().all(|id| *id == ids[0]);
        assert!(types.values().all(is_one), "{types:?}");
    }
}

/// A fleet that shrinks so far that its marks' triangles need exactly the buffer size that its
/// splats had.
fn triangles_after_splats(gpu: &Gpu) {
    let target = TargetConfig { splats_from: 600, ..TargetConfig::new(gpu, FORMAT, 1) };
    let mut renderer = TestRenderer::with_target(gpu, target);
    let row = |count: u32| -> Vec<_> {
        (0..count).map(|i| Robot { x: i as f32 * 20.0, ..Robot::default() }).collect()
    };
    let camera =
        Camera::top(Bounds { low: Vec2::new(0.0, -20.0), high: Vec2::new(280.0, 20.0) }, aspect());
    for robots in [650, 15] {
        renderer.push(&row(robots));
        renderer.render(&camera, &Scene::default(), 1.0);
        for id in [1, 7, 12] {
            let at = pixel(&camera, Vec3::new(id as f32 * 20.0, 0.0, 0.1));
            assert_eq!(renderer.inner.pick(at), Some(Item::Robot(id)), "a fleet of {robots}");
        }
    }
}
