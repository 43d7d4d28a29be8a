//! Between two frames, and from one fleet to another.

use std::f32::consts::PI;

use image::RgbaImage;
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::scene::Scene;

use crate::Test;
use crate::fleet::{Robot, Studio, robots, top};

pub const TESTS: &[(&str, Test)] = &[
    ("half_way_is_in_the_middle_and_turned_the_short_way", half_way),
    ("a_jump_is_not_driven", a_jump),
    ("fleets_grow_and_shrink", fleets_grow_and_shrink),
    ("robots_nowhere_are_not_drawn", nowhere),
];

/// A picture of one frame alone.
fn still(gpu: &Gpu, robots: &[Robot]) -> RgbaImage {
    let mut studio = Studio::new(gpu);
    studio.push(robots);
    studio.shoot(&top(), &Scene::default(), 1.0)
}

fn half_way(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    let robot = |x, theta| [Robot { x, y: 2.0, theta, ..Robot::default() }];
    studio.push(&robot(2.0, PI - 0.2));
    studio.push(&robot(6.0, 0.2 - PI));
    let between = studio.shoot(&top(), &Scene::default(), 0.5);
    assert!(between == still(gpu, &robot(4.0, PI)), "not half way");
    assert!(studio.shoot(&top(), &Scene::default(), 1.0) == still(gpu, &robot(6.0, 0.2 - PI)), "not there");
}

fn a_jump(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    // Half a second at 50 m/s is less than this.
    studio.push(&[Robot { x: 80.0, y: 2.0, ..Robot::default() }]);
    let there = [Robot { x: 5.0, y: 2.0, ..Robot::default() }];
    studio.push(&there);
    assert!(studio.shoot(&top(), &Scene::default(), 0.5) == still(gpu, &there), "it isn't where it jumped to");
}

fn fleets_grow_and_shrink(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    for count in [0, 12, 20_000, 3, 12] {
        let fleet: Vec<_> = robots().into_iter().cycle().take(count).collect();
        studio.push(&fleet);
        studio.shoot(&top(), &Scene::default(), 0.5);
    }
    assert!(studio.shoot(&top(), &Scene::default(), 1.0) == still(gpu, &robots()), "not as a fleet that never changed");
}

fn nowhere(gpu: &Gpu) {
    let [absent, lost, far] = [(1.0, 255), (f32::NAN, 0), (f32::INFINITY, 0)].map(|(x, state)| Robot {
        x,
        y: 2.0,
        state,
        ..Robot::default()
    });
    assert!(still(gpu, &[absent, lost, far]) == still(gpu, &[]), "something is drawn");
}
