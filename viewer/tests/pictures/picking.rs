//! Picking: what is under the pointer, against where it is known to be.

use glam::{Vec2, Vec3};
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::gpu::pick::Picked;
use regatta_viewer::scene::Scene;

use crate::Test;
use crate::fleet::{Robot, SIZE, Studio, bounds, camera, graph, robots, top};

pub const TESTS: &[(&str, Test)] = &[
    ("robots_are_picked_where_they_are", robots_are_picked),
    ("marks_are_picked_far_away_and_far_from_the_origin", marks_are_picked),
    ("nodes_and_edges_are_picked", nodes_and_edges),
    ("the_nearer_of_two_robots_is_picked", the_nearer),
    ("with_an_offset_what_is_seen_is_picked", with_an_offset),
];

fn aspect() -> f32 {
    SIZE.x as f32 / SIZE.y as f32
}

fn pixel(camera: &Camera, point: Vec3) -> Vec2 {
    camera.project(point, SIZE.as_vec2()).expect("in the picture")
}

fn robots_are_picked(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    studio.push(&robots());
    for camera in [camera(), top()] {
        studio.shoot(&camera, &Scene::default(), 1.0);
        for (id, robot) in robots().iter().enumerate() {
            let at = pixel(&camera, Vec3::new(robot.x, robot.y, 0.2));
            assert_eq!(studio.renderer.pick(at), Some(Picked::Robot(id as u32)), "{at}");
        }
        let beside = pixel(&camera, Vec3::new(4.0, 2.0, 0.0));
        assert_eq!(studio.renderer.pick(beside), None);
        assert_eq!(studio.renderer.pick(Vec2::splat(-50.0)), None, "outside of the picture");
    }
}

/// Ten thousand robots, a few pixels from each other.
fn marks_are_picked(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    let (low, side) = (Vec2::new(7000.0, -7500.0), 10);
    let fleet: Vec<_> = (0..side * side)
        .map(|i| Robot { x: low.x + (i % side) as f32 * 30.0, y: low.y + (i / side) as f32 * 30.0, ..Robot::default() })
        .collect();
    studio.push(&fleet);
    let camera = Camera::top(Bounds { low, high: low + 270.0 }, aspect());
    studio.shoot(&camera, &Scene::default(), 1.0);
    for id in [0, 7, 33, 58, 99] {
        let at = pixel(&camera, Vec3::new(fleet[id].x, fleet[id].y, 0.1));
        assert_eq!(studio.renderer.pick(at), Some(Picked::Robot(id as u32)), "{at}");
    }
}

fn nodes_and_edges(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    let (nodes, edges) = graph();
    studio.renderer.set_graph(&nodes, &edges);
    studio.push(&[]);
    let camera = Camera::top(bounds(), aspect());
    studio.shoot(&camera, &Scene::default(), 1.0);
    for (index, node) in nodes.iter().enumerate() {
        let picked = studio.renderer.pick(pixel(&camera, Vec3::new(node.x, node.y, 0.0)));
        assert_eq!(picked, Some(Picked::Node(index as u32)));
    }
    // The middles of the curves.
    for (index, middle) in [[4.0, 0.0], [10.25, 2.0], [4.0, 4.0], [-2.25, 2.0]].into_iter().enumerate() {
        let picked = studio.renderer.pick(pixel(&camera, Vec3::new(middle[0], middle[1], 0.0)));
        assert_eq!(picked, Some(Picked::Edge(index as u32)));
    }
}

/// One stands behind the other, as the camera sees it.
fn the_nearer(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    studio.push(&[Robot { x: 2.0, ..Robot::default() }, Robot { x: 1.2, ..Robot::default() }]);
    let camera = Camera::at(Vec3::new(-2.0, 0.0, 0.25), 0.0, 0.01);
    studio.shoot(&camera, &Scene::default(), 1.0);
    assert_eq!(studio.renderer.pick(pixel(&camera, Vec3::new(1.2, 0.0, 0.15))), Some(Picked::Robot(1)));
}

fn with_an_offset(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    studio.push(&[Robot { x: 3.0, y: 1.0, ..Robot::default() }]);
    let scene = Scene { offset: Vec2::new(2.0, 1.5), ..Scene::default() };
    studio.shoot(&top(), &scene, 1.0);
    assert_eq!(studio.renderer.pick(pixel(&top(), Vec3::new(5.0, 2.5, 0.2))), Some(Picked::Robot(0)));
    assert_eq!(studio.renderer.pick(pixel(&top(), Vec3::new(3.0, 1.0, 0.2))), None);
}
