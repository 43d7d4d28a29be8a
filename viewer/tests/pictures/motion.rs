//! Tests of interpolation between frames, and of changes of the fleet.

use std::f32::consts::PI;

use glam::Vec3;
use image::{DynamicImage, RgbaImage};
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_plugin::world::WorldData;
use regatta_scene::Scene;
use regatta_scene::camera::Camera;
use regatta_viewer::picture::FORMAT;

use crate::Test;
use crate::fleet::{Robot, SIZE, TestRenderer, camera, graph, robots, top};
use crate::references::{self, TOLERANCE};

pub const TESTS: &[(&str, Test)] = &[
    ("poses_are_interpolated_and_turn_by_the_smaller_angle", interpolation),
    ("a_teleport_is_not_interpolated", teleport),
    ("fleets_grow_and_shrink", fleets_grow_and_shrink),
    ("robots_without_a_position_are_not_drawn", without_a_position),
    ("a_kept_ground_is_like_a_drawn_one", kept_ground),
];

/// Renders a single frame.
fn still(gpu: &Gpu, robots: &[Robot]) -> RgbaImage {
    let mut renderer = TestRenderer::new(gpu);
    renderer.push(robots);
    renderer.render(&top(), &Scene::default(), 1.0)
}

fn interpolation(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    let robot = |x, theta| [Robot { x, y: 2.0, theta, ..Robot::default() }];
    renderer.push(&robot(2.0, PI - 0.2));
    renderer.push(&robot(6.0, 0.2 - PI));
    let between = renderer.render(&top(), &Scene::default(), 0.5);
    assert!(between == still(gpu, &robot(4.0, PI)), "the robot is half way");
    assert!(
        renderer.render(&top(), &Scene::default(), 1.0) == still(gpu, &robot(6.0, 0.2 - PI)),
        "the robot is at its newest pose"
    );
}

fn teleport(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    // The distance is more than half a second at 50 m/s.
    renderer.push(&[Robot { x: 80.0, y: 2.0, ..Robot::default() }]);
    let there = [Robot { x: 5.0, y: 2.0, ..Robot::default() }];
    renderer.push(&there);
    assert!(
        renderer.render(&top(), &Scene::default(), 0.5) == still(gpu, &there),
        "the robot is at its new position"
    );
}

fn fleets_grow_and_shrink(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    for count in [0, 12, 20_000, 3, 12] {
        let fleet: Vec<_> = robots().into_iter().cycle().take(count).collect();
        renderer.push(&fleet);
        renderer.render(&top(), &Scene::default(), 0.5);
    }
    assert!(
        renderer.render(&top(), &Scene::default(), 1.0) == still(gpu, &robots()),
        "the picture equals that of a fleet that never changed"
    );
}

fn without_a_position(gpu: &Gpu) {
    let [absent, lost, far] = [(1.0, 255), (f32::NAN, 0), (f32::INFINITY, 0)]
        .map(|(x, state)| Robot { x, y: 2.0, state, ..Robot::default() });
    assert!(still(gpu, &[absent, lost, far]) == still(gpu, &[]), "nothing is drawn");
}

/// While the camera stands still, the ground is copied from the third picture on. The robots go on,
/// and what is picked is what is seen.
fn kept_ground(gpu: &Gpu) {
    let scene = Scene::default();
    let draw = |renderer: &mut TestRenderer, camera: &Camera| renderer.render(camera, &scene, 1.0);
    for samples in [1, 4] {
        let target = TargetConfig::new(gpu, FORMAT, samples);
        let mut renderer = TestRenderer::with_target(gpu, target);
        renderer.inner.set_graph(&graph().view(1, 1));
        let mut fleet = robots();
        renderer.push(&fleet);
        let first = draw(&mut renderer, &camera());
        for number in 2..6 {
            let next = draw(&mut renderer, &camera());
            // The samples at the border of a robot are of the ground as it is kept: a pixel of it.
            let limit = if samples == 1 { 0.0 } else { TOLERANCE };
            assert!(difference(&next, &first) <= limit, "picture {number} with {samples} samples");
        }
        fleet[0].x -= 1.0;
        renderer.push(&fleet);
        renderer.push(&fleet);
        let moved = draw(&mut renderer, &camera());
        let mut other = TestRenderer::with_target(gpu, target);
        other.inner.set_graph(&graph().view(1, 1));
        other.push(&fleet);
        assert!(
            difference(&moved, &draw(&mut other, &camera())) <= TOLERANCE,
            "the robot has moved"
        );
        // From above, and back: the lists of the picture before are used up.
        draw(&mut renderer, &top());
        draw(&mut renderer, &camera());
        draw(&mut renderer, &camera());
        draw(&mut renderer, &camera());
        let node =
            camera().project(Vec3::new(8.0, 4.0, 0.0), SIZE.as_vec2()).expect("in the picture");
        assert!(renderer.inner.pick(node).is_some(), "what is picked is what was drawn");
        // Another graph is seen at once.
        renderer.inner.set_graph(&WorldData::default().view(2, 1));
        let without = draw(&mut renderer, &camera());
        assert!(difference(&without, &moved) > TOLERANCE, "the graph is gone");
    }
}

/// The share of pixels that differ.
pub fn difference(one: &RgbaImage, other: &RgbaImage) -> f64 {
    let [one, other] = [one, other].map(|picture| DynamicImage::from(picture.clone()).into_rgb8());
    if one == other { 0.0 } else { references::difference(&one, &other).max(f64::MIN_POSITIVE) }
}
