//! Tests that what overlaps is drawn in the same order in every picture, so that films have the same bytes on every run.

use glam::{UVec2, Vec2, Vec3};
use image::RgbaImage;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_viewer::camera::{Bounds, Camera, Window};
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::palette::Colouring;
use regatta_viewer::scene::Scene;

use crate::Test;
use crate::fleet::{Robot, SIZE, TestRenderer};

pub const TESTS: &[(&str, Test)] = &[
    ("of_robots_at_one_place_the_first_is_in_front", robots_at_one_place),
    ("a_later_edge_is_drawn_over_an_earlier_one", edges_in_their_order),
];

/// The number of robots that are drawn in a fixed order: several workgroups of the shader that lists them.
const ROBOTS: usize = 64;
/// The workgroup size of the shader that sorts edges.
const WORKGROUP: u32 = 64;
/// Columns and rows of pairs of edges, and the distance between two, in metres.
const PAIRS: UVec2 = UVec2::new(32, 20);
const SPACING: f32 = 0.3;

fn aspect() -> f32 {
    SIZE.x as f32 / SIZE.y as f32
}

/// Robots at one place, of which the first drives and the others are faulted: as meshes and as blocks, in perspective and in a plan.
fn robots_at_one_place(gpu: &Gpu) {
    let mut scene = Scene { colouring: Colouring::State, ..Scene::default() };
    (scene.layers.shadows, scene.layers.density) = (false, false);
    let first = Robot { theta: 0.3, state: RobotState::Driving as u8, ..Robot::default() };
    let mut fleet = vec![Robot { state: RobotState::Faulted as u8, ..first }; ROBOTS];
    fleet[0] = first;
    for half_size in [1.0, 6.0] {
        let bounds = Bounds { low: Vec2::splat(-half_size), high: Vec2::splat(half_size) };
        for camera in [Camera::fit(bounds, aspect()), Camera::plan(bounds, Window::whole(aspect()))] {
            let draw = |fleet: &[Robot]| {
                let mut renderer = TestRenderer::new(gpu);
                renderer.push(fleet);
                renderer.render(&camera, &scene, 1.0)
            };
            let alone = draw(&fleet[..1]);
            assert!(draw(&fleet) == alone, "another robot than the first is in front: {half_size} m, {camera:?}");
        }
    }
}

/// Straight edges, a workgroup of one-way ones and a workgroup of two-way ones at the same places in turn.
fn pairs(with_first: bool) -> WorldData {
    let mut world = WorldData::default();
    let all = PAIRS.x * PAIRS.y;
    for first in (0..all).step_by(WORKGROUP as usize) {
        for (velocity_backwards, is_added) in [(0.0, with_first), (0.5, true)] {
            for pair in (first..(first + WORKGROUP).min(all)).filter(|_| is_added) {
                let at = place(pair);
                let origin = world.nodes.len() as u32;
                for x in [at.x, at.x + 0.8 * SPACING] {
                    world.nodes.push(NodeRecord { id: world.nodes.len() as u32, x, y: at.y, ..NodeRecord::default() });
                }
                let edge = EdgeRecord {
                    id: origin / 2,
                    origin,
                    destination: origin + 1,
                    length: 0.8 * SPACING,
                    velocity_forward: 1.0,
                    velocity_backwards,
                    ..EdgeRecord::default()
                };
                world.add_edge(edge, [CurveRecord::straight([at.x, at.y], [at.x + 0.8 * SPACING, at.y])]);
            }
        }
    }
    world
}

fn place(pair: u32) -> Vec2 {
    UVec2::new(pair % PAIRS.x, pair / PAIRS.x).as_vec2() * SPACING
}

fn edges_in_their_order(gpu: &Gpu) {
    let mut scene = Scene::default();
    (scene.layers.nodes, scene.layers.arrows, scene.layers.robots) = (false, false, false);
    let bounds = Bounds { low: Vec2::ZERO, high: PAIRS.as_vec2() * SPACING };
    let camera = Camera::plan(bounds, Window::whole(aspect()));
    let mut draw = |with_first| {
        let mut renderer = TestRenderer::new(gpu);
        renderer.inner.set_graph(&pairs(with_first).view(1, 1));
        renderer.render(&camera, &scene, 1.0)
    };
    let [later, both] = [false, true].map(&mut draw);
    let middle = |pair: u32| {
        let at = place(pair) + Vec2::new(0.4 * SPACING, 0.0);
        camera.project(at.extend(0.0), SIZE.as_vec2()).expect("in the picture")
    };
    let seen = (0..PAIRS.x * PAIRS.y).filter(|pair| difference(&later, &both, middle(*pair)) > 12.0).count();
    assert_eq!(seen, 0, "edges under others are seen");
    let all = draw(true);
    assert!(all == both, "two pictures of the same differ");
    assert!(difference(&later, &RgbaImage::new(SIZE.x, SIZE.y), middle(0)) > 12.0, "there are edges");
}

/// The difference of two pictures around a pixel, the mean of channels of 255.
fn difference(one: &RgbaImage, other: &RgbaImage, at: Vec2) -> f32 {
    let mean = |picture: &RgbaImage| {
        let mut sum = Vec3::ZERO;
        for (x, y) in (0..9).map(|i| (i % 3, i / 3)) {
            let [r, g, b, _] = picture.get_pixel(at.x as u32 + x - 1, at.y as u32 + y - 1).0.map(f32::from);
            sum += Vec3::new(r, g, b) / 9.0;
        }
        sum
    };
    (mean(one) - mean(other)).abs().element_sum() / 3.0
}
