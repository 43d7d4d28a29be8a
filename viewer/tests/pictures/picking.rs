//! Picking: what is under the pointer, against where it is known to be.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::gpu::TargetKind;
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::gpu::pick::Picked;
use regatta_viewer::palette::Colouring;
use regatta_viewer::picture::FORMAT;
use regatta_viewer::scene::Scene;

use crate::Test;
use crate::fleet::{Robot, SIZE, Studio, bounds, camera, graph, robots, top};

pub const TESTS: &[(&str, Test)] = &[
    ("robots_are_picked_where_they_are", robots_are_picked),
    ("marks_are_picked_far_away_and_far_from_the_origin", marks_are_picked),
    ("nodes_and_edges_are_picked", nodes_and_edges),
    ("the_nearer_of_two_robots_is_picked", the_nearer),
    ("with_an_offset_what_is_seen_is_picked", with_an_offset),
    ("triangles_are_picked_after_splats", triangles_after_splats),
    ("of_many_marks_in_a_place_the_one_that_is_seen_is_picked", of_many_marks),
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

/// Robots of two types, so many that their marks cover each other, as triangles and as splats.
fn of_many_marks(gpu: &Gpu) {
    let robot = |i: usize| {
        let place = |factor: f32, span: f32| (i as f32 * factor).fract() * span;
        Robot { x: place(0.618, 60.0), y: place(0.414, 40.0), theta: i as f32, ..Robot::default() }
    };
    let fleet: Vec<_> = (0..1500).map(robot).collect();
    let camera = Camera::fit(Bounds { low: Vec2::ZERO, high: Vec2::new(60.0, 40.0) }, aspect());
    let scene = Scene { colouring: Colouring::Type, ..Scene::default() };
    for splats_from in [u32::MAX, 0] {
        let mut studio = Studio::drawing_into(gpu, TargetKind { splats_from, ..TargetKind::new(gpu, FORMAT, 1) });
        studio.push(&fleet);
        studio.renderer.set_kinds(&[0.0, 1.0].repeat(750));
        let picture = studio.shoot(&camera, &scene, 1.0);
        let mut types = BTreeMap::new();
        let pixels = (20..180).step_by(3).flat_map(|y| (20..300).step_by(7).map(move |x| (x, y)));
        for (x, y) in pixels {
            let colour = picture.get_pixel(x, y).0;
            // The floor is dark; what is near is picked there.
            let is_robot = colour[..3].iter().any(|part| *part > 120);
            let picked = studio.renderer.pick(Vec2::new(x as f32, y as f32) + 0.5);
            if let Some(Picked::Robot(id)) = picked.filter(|_| is_robot) {
                types.entry(colour).or_insert_with(Vec::new).push(id % 2);
            }
        }
        assert!(types.values().map(Vec::len).sum::<usize>() > 20, "{types:?}");
        let is_one = |ids: &Vec<u32>| ids.iter().all(|id| *id == ids[0]);
        assert!(types.values().all(is_one), "{types:?}");
    }
}

/// A fleet shrinks, so that its marks' triangles take just the room that its splats had.
fn triangles_after_splats(gpu: &Gpu) {
    let target = TargetKind { splats_from: 600, ..TargetKind::new(gpu, FORMAT, 1) };
    let mut studio = Studio::drawing_into(gpu, target);
    let row = |count: u32| -> Vec<_> { (0..count).map(|i| Robot { x: i as f32 * 20.0, ..Robot::default() }).collect() };
    let camera = Camera::top(Bounds { low: Vec2::new(0.0, -20.0), high: Vec2::new(280.0, 20.0) }, aspect());
    for robots in [650, 15] {
        studio.push(&row(robots));
        studio.shoot(&camera, &Scene::default(), 1.0);
        for id in [1, 7, 12] {
            let at = pixel(&camera, Vec3::new(id as f32 * 20.0, 0.0, 0.1));
            assert_eq!(studio.renderer.pick(at), Some(Picked::Robot(id)), "of {robots}");
        }
    }
}
