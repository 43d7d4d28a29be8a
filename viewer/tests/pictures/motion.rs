//! Tests of interpolation between frames, and of changes of the fleet.

use std::f32::consts::PI;

use image::RgbaImage;
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::scene::Scene;

use crate::Test;
use crate::fleet::{Robot, TestRenderer, robots, top};

pub const TESTS: &[(&str, Test)] = &[
    ("poses_are_interpolated_and_turn_by_the_smaller_angle", interpolation),
    ("a_teleport_is_not_interpolated", teleport),
    ("fleets_grow_and_shrink", fleets_grow_and_shrink),
    ("robots_without_a_position_are_not_drawn", without_a_position),
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
    assert!(renderer.render(&top(), &Scene::default(), 0.5) == still(gpu, &there), "the robot is at its new position");
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
    let [absent, lost, far] = [(1.0, 255), (f32::NAN, 0), (f32::INFINITY, 0)].map(|(x, state)| Robot {
        x,
        y: 2.0,
        state,
        ..Robot::default()
    });
    assert!(still(gpu, &[absent, lost, far]) == still(gpu, &[]), "nothing is drawn");
}
