//! Pictures as they should be.

use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use image::{DynamicImage, Rgb, RgbImage, RgbaImage};
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::floor_picture::FloorPicture;
use regatta_viewer::gpu::TargetKind;
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::palette::{Colouring, Theme};
use regatta_viewer::picture::FORMAT;
use regatta_viewer::route::Stretch;
use regatta_viewer::scene::{Light, Scene, Trails};

use crate::Test;
use crate::fleet::{Robot, SIZE, Studio, camera, graph, robots, top};

pub const TESTS: &[(&str, Test)] = &[
    ("graph", graph_alone),
    ("robots_by_state", robots_by_state),
    ("robots_by_speed", robots_by_speed),
    ("robots_by_type", robots_by_type),
    ("robots_by_collision", robots_by_collision),
    ("robots_without_the_column", robots_without_the_column),
    ("levels_of_detail", levels_of_detail),
    ("trails", trails),
    ("selection", selection),
    ("routes", routes),
    ("light_theme_from_the_top", light_theme_from_the_top),
    ("map_and_offset", map_and_offset),
    ("lamps", lamps),
    ("splats_are_like_triangles", splats_are_like_triangles),
];

/// Largest part of a picture that may differ from its reference. Another version of the adapter rounds edges a little
/// differently; a test holds this to telling references apart that differ by a ring or by a few robots' colours.
const TOLERANCE: f64 = 0.003;
/// Difference of a channel that counts, of 255.
const DIFFERENCE: u8 = 20;
/// Pixels over which colours are blurred before they are compared: the way eyes see thin lines.
const BLUR: f32 = 1.0;

fn path_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pictures/{name}.png"))
}

/// Part of the pixels that differ.
fn difference(one: &RgbImage, other: &RgbImage) -> f64 {
    assert_eq!(one.dimensions(), other.dimensions());
    let [one, other] = [one, other].map(|picture| image::imageops::blur(picture, BLUR));
    let differs = |(a, b): (&Rgb<u8>, &Rgb<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > DIFFERENCE);
    let count = one.pixels().zip(other.pixels()).filter(|pair| differs(*pair)).count();
    count as f64 / f64::from(one.width() * one.height())
}

/// The tolerance is none for what should be seen.
pub fn references_are_told_apart() {
    let read = |name| image::open(path_of(name)).expect("a reference").into_rgb8();
    for (one, other) in [
        ("robots_by_state", "selection"),
        ("robots_by_state", "robots_by_type"),
        ("selection", "routes"),
        ("robots_by_state", "robots_by_collision"),
        ("robots_by_state", "lamps"),
        ("robots_by_state", "graph"),
    ] {
        let difference = difference(&read(one), &read(other));
        assert!(difference > 2.0 * TOLERANCE, "{one} and {other}: {difference:.4}");
    }
}

/// Compares with the reference of that name, or makes it.
fn assert_like(name: &str, picture: &RgbaImage) {
    let path = path_of(name);
    if std::env::var_os("REGATTA_UPDATE_PICTURES").is_some() {
        return picture.save(&path).expect("the reference is written");
    }
    let reference = image::open(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_rgb8();
    let picture = DynamicImage::from(picture.clone()).into_rgb8();
    let difference = difference(&picture, &reference);
    if difference > TOLERANCE {
        let seen = std::env::temp_dir().join(format!("regatta-{name}.png"));
        picture.save(&seen).expect("the picture is written");
        panic!("{difference:.4} of it differ from {}; see {}", path.display(), seen.display());
    }
}

fn studio(gpu: &Gpu) -> Studio {
    let mut studio = Studio::new(gpu);
    let (nodes, edges) = graph();
    studio.renderer.set_graph(&nodes, &edges);
    studio.push(&robots());
    studio
}

fn coloured(colouring: Colouring) -> Scene {
    Scene { colouring, ..Scene::default() }
}

fn graph_alone(gpu: &Gpu) {
    let mut scene = Scene::default();
    scene.layers.robots = false;
    assert_like("graph", &studio(gpu).shoot(&camera(), &scene, 1.0));
}

fn robots_by_state(gpu: &Gpu) {
    assert_like("robots_by_state", &studio(gpu).shoot(&camera(), &coloured(Colouring::State), 1.0));
}

fn robots_by_speed(gpu: &Gpu) {
    let mut studio = studio(gpu);
    let speeds: Vec<_> = robots().iter().map(|robot| robot.speed).collect();
    studio.renderer.set_values(Some(&speeds));
    assert_like("robots_by_speed", &studio.shoot(&camera(), &coloured(Colouring::Speed), 1.0));
}

fn robots_by_type(gpu: &Gpu) {
    let mut studio = studio(gpu);
    studio.renderer.set_kinds(&[0.0, 1.0].repeat(6));
    assert_like("robots_by_type", &studio.shoot(&camera(), &coloured(Colouring::Type), 1.0));
}

fn robots_by_collision(gpu: &Gpu) {
    let mut studio = studio(gpu);
    studio.renderer.set_values(Some(&[0.0, 1.0, 2.0].repeat(4)));
    assert_like("robots_by_collision", &studio.shoot(&camera(), &Scene::default(), 1.0));
}

fn robots_without_the_column(gpu: &Gpu) {
    assert_like("robots_without_the_column", &studio(gpu).shoot(&camera(), &Scene::default(), 1.0));
}

/// Two lanes from near to far: meshes, blocks, marks.
fn levels_of_detail(gpu: &Gpu) {
    let mut studio = Studio::new(gpu);
    let lanes = (0..160).map(|i| {
        let (x, y) = ((i / 2) as f32 * 1.5, (i % 2) as f32 * 2.0 - 1.0);
        crate::fleet::Robot { x, y, state: (i / 2 % 5) as u8, ..crate::fleet::Robot::default() }
    });
    studio.push(&lanes.collect::<Vec<_>>());
    studio.renderer.set_kinds(&[0.0, 1.0].repeat(80));
    let camera = Camera::at(Vec3::new(-3.0, 0.0, 3.0), 0.0, 0.35);
    assert_like("levels_of_detail", &studio.shoot(&camera, &coloured(Colouring::State), 1.0));
}

fn trails(gpu: &Gpu) {
    let mut studio = studio(gpu);
    let scene = Scene { trails: Trails { points: 8, only_selected: false }, ..coloured(Colouring::State) };
    let mut fleet = robots();
    for _ in 0..6 {
        fleet.iter_mut().for_each(|robot| {
            robot.theta += 0.25;
            robot.x += 0.4 * robot.theta.cos();
            robot.y += 0.4 * robot.theta.sin();
        });
        studio.push(&fleet);
        studio.shoot(&camera(), &scene, 1.0);
    }
    assert_like("trails", &studio.shoot(&camera(), &scene, 0.5));
}

fn selection(gpu: &Gpu) {
    let scene = Scene { selected: vec![2, 9, 4_000_000], ..coloured(Colouring::State) };
    assert_like("selection", &studio(gpu).shoot(&camera(), &scene, 1.0));
}

/// From where a robot is to the end of the bend it may drive now; the rest of the way around is planned.
fn routes(gpu: &Gpu) {
    let mut studio = studio(gpu);
    let stretch = |edge, part, released| Stretch { edge, part, released };
    let around = [stretch(0, [0.4, 1.0], 1), stretch(1, [0.0, 1.0], 1), stretch(2, [0.0, 1.0], 0)];
    studio.renderer.set_routes(&[&around[..], &[stretch(3, [0.0, 0.8], 0)]].concat());
    let scene = Scene { selected: vec![2], ..coloured(Colouring::State) };
    assert_like("routes", &studio.shoot(&camera(), &scene, 1.0));
}

fn light_theme_from_the_top(gpu: &Gpu) {
    let scene = Scene { theme: Theme::Light, ..coloured(Colouring::State) };
    assert_like("light_theme_from_the_top", &studio(gpu).shoot(&top(), &scene, 1.0));
}

/// A chequered picture that is turned, and a fleet moved by an offset: the floor stays.
fn map_and_offset(gpu: &Gpu) {
    let mut studio = studio(gpu);
    let light = image::Rgba([150, 170, 190, 255]);
    let pixels = RgbaImage::from_fn(6, 4, |x, y| if (x + y) % 2 == 0 { light } else { image::Rgba([40, 90, 60, 255]) });
    let picture = FloorPicture { pixels, corner: Vec2::new(1.0, 0.0), turn: 0.2, size: Vec2::new(6.0, 4.0) };
    studio.renderer.lay_picture(Some(&picture));
    let scene = Scene { offset: Vec2::new(1.0, -1.0), ..coloured(Colouring::State) };
    assert_like("map_and_offset", &studio.shoot(&top(), &scene, 1.0));
}

fn lamps(gpu: &Gpu) {
    let lamp = |x, colour| Light { position: Vec3::new(x, 2.0, 2.0), colour };
    let lights = vec![lamp(0.0, Vec3::new(1.0, 0.5, 0.2)), lamp(8.0, Vec3::new(0.2, 0.5, 1.0))];
    assert_like("lamps", &studio(gpu).shoot(&camera(), &Scene { lights, ..coloured(Colouring::State) }, 1.0));
}

/// Robots of both shapes: from close by, where they are meshes, to far away, where who of many is in front may differ;
/// and marks alone that don't overlap.
fn splats_are_like_triangles(gpu: &Gpu) {
    let fleet = |side: usize, distance: f32| -> Vec<_> {
        let place = |i: usize| [(i / side) as f32 * distance, (i % side) as f32 * distance];
        let robot =
            |i: usize| Robot { x: place(i)[0], y: place(i)[1], theta: i as f32, state: (i % 5) as u8, speed: 0.0 };
        (0..8 * side * side).map(robot).collect()
    };
    let kinds = [0.0, 1.0].repeat(4000);
    let low = Camera::at(Vec3::new(-4.0, -2.0, 4.0), 0.1, 0.25);
    let wide = Camera::fit(Bounds { low: Vec2::ZERO, high: Vec2::new(96.0, 12.0) }, SIZE.x as f32 / SIZE.y as f32);
    for (fleet, camera, tolerance) in [(fleet(16, 2.0), low, 2.0 * TOLERANCE), (fleet(5, 2.7), wide, TOLERANCE)] {
        let [triangles, splats] = [u32::MAX, 0].map(|splats_from| {
            let mut studio = Studio::drawing_into(gpu, TargetKind { splats_from, ..TargetKind::new(gpu, FORMAT, 1) });
            studio.push(&fleet);
            studio.renderer.set_kinds(&kinds[..fleet.len()]);
            DynamicImage::from(studio.shoot(&camera, &coloured(Colouring::State), 1.0)).into_rgb8()
        });
        let part = difference(&triangles, &splats);
        assert!(part <= tolerance, "{} robots: {part}", fleet.len());
    }
}
