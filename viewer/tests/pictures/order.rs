//! Tests that what overlaps is drawn in the same order in every picture, so that films have the
//! same bytes on every run.

use glam::{UVec2, Vec2, Vec3};
use image::RgbaImage;
use regatta_gpu::device::Gpu;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_scene::Scene;
use regatta_scene::camera::{Bounds, Camera, Window};
use regatta_scene::palette::Colouring;

use crate::Test;
use crate::fleet::{Robot, SIZE, TestRenderer};

pub const TESTS: &[(&str, Test)] = &[
    ("of_robots_at_one_place_the_first_is_in_front", robots_at_one_place),
    ("a_later_edge_is_drawn_over_an_earlier_one", edges_in_their_order),
];

/// The number of robots that are drawn in a fixed order: several workgroups of the shader that
/// lists them.
const ROBOTS: usize = 64;
/// The workgroup size of the shader that sorts edges.
const WORKGROUP: u32 = 64;
/// Columns and rows of pairs of edges, and the distance between two, in metres.
const PAIRS: UVec2 = UVec2::new(32, 20);
const SPACING: f32 = 0.3;

fn aspect() -> f32 {
    SIZE.x as f32 / SIZE.y as f32
}

/// Robots at one place, of which the first drives and the others are faulted: as meshes and as
/// blocks, in perspective and in a plan.
fn robots_at_one_place(gpu: &Gpu) {
    let mut scene = Scene { colouring: Colouring::State, ..Scene::default() };
    (scene.layers.shadows, scene.layers.density) = (false, false);
    let first = Robot { theta: 0.3, state: RobotState::Driving as u8, ..Robot::default() };
    let mut fleet = vec![Robot { state: RobotState::Faulted as u8, ..first }; ROBOTS];
    fleet[0] = first;
    for half_size in [1.0, 6.0] {
        let bounds = Bounds { low: Vec2::splat(-half_size), high: Vec2::splat(half_size) };
        for camera in [Camera::fit(bounds, aspect()), Camera::plan(bounds, Window::whole(aspect()))]
        {
            let draw = |fleet: &[Robot]| {
                let mut renderer = TestRenderer::new(gpu);
                renderer.push(fleet);
                renderer.render(&camera, &scene, 1.0)
            };
            let alone = draw(&fleet[..1]);
            assert!(
                draw(&fleet) == alone,
                "another robot than the first is in front: {half_size} m, {camera:?}"
            );
        }
    }
}

/// Straight edges of the directions that are listed, a workgroup of one after a workgroup of the
/// other at the same places.
fn pairs(are_two_way: &[bool]) -> WorldData {
    let mut world = WorldData::default();
    let all = PAIRS.x * PAIRS.y;
    for first in (0..all).step_by(WORKGROUP as usize) {
        for is_two_way in are_two_way {
            (first..(first + WORKGROUP).min(all))
                .for_each(|pair| add_edge(&mut world, place(pair), *is_two_way));
        }
    }
    world
}

/// Adds an edge to the right of a place.
fn add_edge(world: &mut WorldData, at: Vec2, is_two_way: bool) {
    let (origin, length) = (world.nodes.len() as u32, 0.8 * SPACING);
    for (id, x) in [(origin, at.x), (origin + 1, at.x + length)] {
        world.nodes.push(NodeRecord { id, x, y: at.y, ..NodeRecord::default() });
    }
    let edge = EdgeRecord {
        id: origin / 2,
        origin,
        destination: origin + 1,
        length,
        speed: 1.0,
        reverse_speed: if is_two_way { 0.5 } else { 0.0 },
        ..EdgeRecord::default()
    };
    world.add_edge(edge, [CurveRecord::straight([at.x, at.y], [at.x + length, at.y])]);
}

fn place(pair: u32) -> Vec2 {
    UVec2::new(pair % PAIRS.x, pair / PAIRS.x).as_vec2() * SPACING
}

fn edges_in_their_order(gpu: &Gpu) {
    let mut scene = Scene::default();
    (scene.layers.nodes, scene.layers.arrows, scene.layers.robots) = (false, false, false);
    let bounds = Bounds { low: Vec2::ZERO, high: PAIRS.as_vec2() * SPACING };
    let camera = Camera::plan(bounds, Window::whole(aspect()));
    let draw = |are_two_way: &[bool]| {
        let mut renderer = TestRenderer::new(gpu);
        renderer.inner.set_graph(&pairs(are_two_way).view(1, 1));
        renderer.render(&camera, &scene, 1.0)
    };
    // Lines are translucent: both colours of a pair are seen, but more of the upper one.
    let [upper, both, swapped] = [&[true][..], &[false, true], &[true, false]].map(draw);
    for pair in 0..PAIRS.x * PAIRS.y {
        let at = place(pair) + Vec2::new(0.4 * SPACING, 0.0);
        let middle = camera.project(at.extend(0.0), SIZE.as_vec2()).expect("in the picture");
        let [near, far] = [&both, &swapped].map(|picture| difference(&upper, picture, middle));
        assert!(near < far, "of pair {pair}, the earlier edge is above: {near}, {far}");
    }
    assert!(draw(&[false, true]) == both, "two pictures of the same differ");
}

/// The difference of two pictures around a pixel, the mean of channels of 255.
fn difference(one: &RgbaImage, other: &RgbaImage, at: Vec2) -> f32 {
    let mean = |picture: &RgbaImage| {
        let mut sum = Vec3::ZERO;
        for (x, y) in (0..9).map(|i| (i % 3, i / 3)) {
            let [r, g, b, _] =
                picture.get_pixel(at.x as u32 + x - 1, at.y as u32 + y - 1).0.map(f32::from);
            sum += Vec3::new(r, g, b) / 9.0;
        }
        sum
    };
    (mean(one) - mean(other)).abs().element_sum() / 3.0
}
