//! Tests of pictures against reference pictures.

use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use image::{DynamicImage, Rgb, RgbImage, RgbaImage};
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_gpu::floor::FloorPicture;
use regatta_interface::settings::MeshPlacement;
use regatta_plugin::world::{Role, StationRecord};
use regatta_scene::camera::{Bounds, Camera, Window};
use regatta_scene::palette::{Colouring, Theme};
use regatta_scene::plans::{GoalMark, PlanReport};
use regatta_scene::route::RouteSegment;
use regatta_scene::{Light, Marked, Scene, Trails};
use regatta_viewer::mesh_file;
use regatta_viewer::picture::FORMAT;
use regatta_viewer::plans::marks::arrows;

use crate::Test;
use crate::fleet::{Robot, SIZE, TestRenderer, bounds, camera, graph, robots, top};

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
    ("stations", stations),
    ("walls", walls),
    ("plans", plans),
    ("waits", waits),
    ("filter", filter),
    ("a_horizon_has_whole_dashes", a_horizon_has_whole_dashes),
    ("light_theme_from_the_top", light_theme_from_the_top),
    ("map_and_offset", map_and_offset),
    ("lamps", lamps),
    ("meshes_of_files_keep_the_data_colour", meshes_of_files),
    ("marked_edge", marked_edge),
    ("closed_edges", closed_edges),
    ("marked_node", marked_node),
    ("one_level", one_level),
    ("a_plan_has_footprints_of_true_size", plan_footprints),
    ("splats_are_like_triangles", splats_are_like_triangles),
];

/// The largest share of pixels that may differ from the reference. Versions of the adapter differ
/// in how they rasterize edges. A test checks that the tolerance still distinguishes references
/// that differ by a ring or a few robots' colours.
pub const TOLERANCE: f64 = 0.003;
/// The difference of a channel, of 255, above which a pixel differs.
const DIFFERENCE: u8 = 20;
/// The standard deviation in pixels by which pictures are blurred before the comparison, as eyes
/// blur thin lines.
const BLUR: f32 = 1.0;

fn path_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pictures/{name}.png"))
}

/// Returns the share of pixels that differ.
pub fn difference(one: &RgbImage, other: &RgbImage) -> f64 {
    assert_eq!(one.dimensions(), other.dimensions());
    let [one, other] = [one, other].map(|picture| image::imageops::blur(picture, BLUR));
    let differs =
        |(a, b): (&Rgb<u8>, &Rgb<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > DIFFERENCE);
    let count = one.pixels().zip(other.pixels()).filter(|pair| differs(*pair)).count();
    count as f64 / f64::from(one.width() * one.height())
}

/// Checks that references with visible differences differ by more than the tolerance.
pub fn references_are_told_apart() {
    let read = |name| image::open(path_of(name)).expect("a reference").into_rgb8();
    for (one, other) in [
        ("robots_by_state", "selection"),
        ("robots_by_state", "robots_by_type"),
        ("selection", "routes"),
        ("robots_by_state", "robots_by_collision"),
        ("robots_by_state", "lamps"),
        ("graph", "stations"),
        ("graph", "walls"),
        ("robots_by_state", "marked_edge"),
        ("robots_by_state", "closed_edges"),
        ("robots_by_state", "plans"),
        ("robots_by_state", "waits"),
        ("robots_by_state", "filter"),
        ("robots_by_state", "graph"),
        ("robots_by_state", "heat"),
        ("heat", "heat_light"),
        ("density", "density_off"),
    ] {
        let difference = difference(&read(one), &read(other));
        assert!(difference > 2.0 * TOLERANCE, "{one} and {other}: {difference:.4}");
    }
}

/// Compares a picture with the reference of a name, or updates the reference.
pub fn assert_like(name: &str, picture: &RgbaImage) {
    let path = path_of(name);
    if std::env::var_os("REGATTA_UPDATE_PICTURES").is_some() {
        return picture.save(&path).expect("the reference is written");
    }
    let reference = image::open(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .into_rgb8();
    let picture = DynamicImage::from(picture.clone()).into_rgb8();
    let difference = difference(&picture, &reference);
    if difference > TOLERANCE {
        let actual = std::env::temp_dir().join(format!("regatta-{name}.png"));
        picture.save(&actual).expect("the picture is written");
        let share = difference * 100.0;
        panic!(
            "{share:.2} % of the pixels differ from {}; see {}",
            path.display(),
            actual.display()
        );
    }
}

pub fn loop_renderer(gpu: &Gpu) -> TestRenderer {
    let mut renderer = TestRenderer::new(gpu);
    renderer.inner.set_graph(&graph().view(1, 1));
    renderer.push(&robots());
    renderer
}

pub fn coloured(colouring: Colouring) -> Scene {
    Scene { colouring, ..Scene::default() }
}

fn graph_alone(gpu: &Gpu) {
    let mut scene = Scene::default();
    scene.layers.robots = false;
    assert_like("graph", &loop_renderer(gpu).render(&camera(), &scene, 1.0));
}

fn robots_by_state(gpu: &Gpu) {
    assert_like(
        "robots_by_state",
        &loop_renderer(gpu).render(&camera(), &coloured(Colouring::State), 1.0),
    );
}

fn robots_by_speed(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let speeds: Vec<_> = robots().iter().map(|robot| robot.speed).collect();
    renderer.inner.set_values(Some(&speeds));
    assert_like("robots_by_speed", &renderer.render(&camera(), &coloured(Colouring::Speed), 1.0));
}

fn robots_by_type(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    renderer.inner.set_robot_type_column(&[0.0, 1.0].repeat(6));
    assert_like("robots_by_type", &renderer.render(&camera(), &coloured(Colouring::Type), 1.0));
}

fn robots_by_collision(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    renderer.inner.set_values(Some(&[0.0, 1.0, 2.0].repeat(4)));
    let scene = coloured(Colouring::collision());
    assert_like("robots_by_collision", &renderer.render(&camera(), &scene, 1.0));
}

fn robots_without_the_column(gpu: &Gpu) {
    assert_like(
        "robots_without_the_column",
        &loop_renderer(gpu).render(&camera(), &coloured(Colouring::collision()), 1.0),
    );
}

/// Two rows of robots from near to far: meshes, blocks, marks.
fn levels_of_detail(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    let rows = (0..160).map(|i| {
        let (x, y) = ((i / 2) as f32 * 1.5, (i % 2) as f32 * 2.0 - 1.0);
        crate::fleet::Robot { x, y, state: (i / 2 % 5) as u8, ..crate::fleet::Robot::default() }
    });
    renderer.push(&rows.collect::<Vec<_>>());
    renderer.inner.set_robot_type_column(&[0.0, 1.0].repeat(80));
    let camera = Camera::from_eye(Vec3::new(-3.0, 0.0, 3.0), 0.0, 0.35);
    assert_like("levels_of_detail", &renderer.render(&camera, &coloured(Colouring::State), 1.0));
}

fn trails(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let scene =
        Scene { trails: Trails { points: 8, only_selected: false }, ..coloured(Colouring::State) };
    let mut fleet = robots();
    for _ in 0..6 {
        fleet.iter_mut().for_each(|robot| {
            robot.theta += 0.25;
            robot.x += 0.4 * robot.theta.cos();
            robot.y += 0.4 * robot.theta.sin();
        });
        renderer.push(&fleet);
        renderer.render(&camera(), &scene, 1.0);
    }
    assert_like("trails", &renderer.render(&camera(), &scene, 0.5));
}

fn selection(gpu: &Gpu) {
    let scene = Scene { selected: vec![2, 9, 4_000_000], ..coloured(Colouring::State) };
    assert_like("selection", &loop_renderer(gpu).render(&camera(), &scene, 1.0));
}

/// A route from a robot's position: released up to the end of the bend, planned for the rest of the
/// loop.
fn routes(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let segment = |curve, range, released| RouteSegment { curve, range, released };
    let around = [segment(0, [0.4, 1.0], 1), segment(1, [0.0, 1.0], 1), segment(2, [0.0, 1.0], 0)];
    renderer.inner.set_routes(&[&around[..], &[segment(3, [0.0, 0.8], 0)]].concat());
    let scene = Scene { selected: vec![2], ..coloured(Colouring::State) };
    assert_like("routes", &renderer.render(&camera(), &scene, 1.0));
}

/// A node of each role, and badges that are too small to be drawn from farther away.
fn stations(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let mut world = graph();
    let roles = [Role::Pick, Role::Drop, Role::Park, Role::Charge];
    world.nodes.iter_mut().zip(roles).for_each(|(node, role)| node.role = role as u32);
    renderer.inner.set_graph(&world.view(1, 1));
    let mut scene = coloured(Colouring::State);
    scene.layers.robots = false;
    assert_like("stations", &renderer.render(&top(), &scene, 1.0));
    let far = Camera { distance: 300.0, ..camera() };
    let mut without = loop_renderer(gpu);
    let [with, without] = [&mut renderer, &mut without]
        .map(|renderer| DynamicImage::from(renderer.render(&far, &scene, 1.0)).into_rgb8());
    assert_eq!(difference(&with, &without), 0.0);
}

/// Walls around the graph, and a station that is served from two nodes.
fn walls(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let mut world = graph();
    let role = Role::Transfer as u32;
    let station = StationRecord { x: 4.0, y: 2.0, role, ..StationRecord::default() };
    world.add_station(station, [0, 1]);
    let corners = [[-2.8, -1.8], [10.8, -1.8], [10.8, 5.8], [-2.8, 5.8], [-2.8, -1.8]];
    assert!(world.add_background_line(0, corners));
    renderer.inner.set_graph(&world.view(1, 1));
    let mut scene = coloured(Colouring::State);
    scene.layers.robots = false;
    assert_like("walls", &renderer.render(&top(), &scene, 1.0));
    // From behind the camera, a wall leads into the picture.
    let camera = camera();
    let (target, eye) = (camera.target.truncate(), camera.eye().truncate());
    let [with, without] = [2.0, 0.0].map(|behind| {
        let mut world = graph();
        let start = eye + (eye - target) * behind;
        let end = if behind > 0.0 { target } else { start + (eye - target) };
        assert!(world.add_background_line(0, [start.to_array(), end.to_array()]));
        renderer.inner.set_graph(&world.view(1, 1));
        DynamicImage::from(renderer.render(&camera, &scene, 1.0)).into_rgb8()
    });
    assert!(difference(&with, &without) > 0.0);
}

/// The routes of several robots, the goals of two of them, and one of a selected robot.
fn plans(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let line = |curve, range, released| RouteSegment { curve, range, released };
    let goal = |node, selected| GoalMark { node, selected };
    renderer.inner.set_plans(&PlanReport {
        lines: vec![
            line(2, [0.5, 1.0], 0),
            line(3, [0.0, 1.0], 0),
            line(0, [0.2, 1.0], 1),
            line(1, [0.0, 1.0], 1),
            line(2, [0.0, 0.5], 1),
        ],
        goals: vec![goal(3, 0), goal(1, 0), goal(2, 1)],
        ..PlanReport::default()
    });
    let mut scene = coloured(Colouring::State);
    scene.layers.plans = true;
    assert_like("plans", &renderer.render(&camera(), &scene, 1.0));
}

/// In the first row, robots wait for the one before them; in the second one, three of them wait for
/// each other.
fn waits(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let nan = f32::NAN;
    let waits_for = [1.0, 2.0, nan, 4.0, nan, 11.0, 7.0, 9.0, nan, 6.0, 9.0, 3.0];
    renderer.inner.set_plans(&PlanReport { arrows: arrows(&waits_for), ..PlanReport::default() });
    let mut scene = coloured(Colouring::State);
    scene.layers.waits = true;
    assert_like("waits", &renderer.render(&camera(), &scene, 1.0));
    scene.layers.waits = false;
    assert_like("robots_by_state", &renderer.render(&camera(), &scene, 1.0));
}

/// Every other robot matches; without a filter all do.
fn filter(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    renderer.inner.set_matches(Some(&[0b0101_0101_0101]));
    assert_like("filter", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
    renderer.inner.set_matches(None);
    assert_like("robots_by_state", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
}

/// The straight edge of seven metres has six dashes of about 1.2 m: six gaps, and half a dash at
/// either end.
fn a_horizon_has_whole_dashes(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let mut scene = Scene::default();
    (scene.layers.robots, scene.layers.grid, scene.layers.arrows, scene.layers.nodes) =
        (false, false, false, false);
    scene.layers.plans = true;
    let mut render = |released| {
        let lines = vec![RouteSegment { curve: 0, range: [0.0, 1.0], released }];
        renderer.inner.set_plans(&PlanReport { lines, ..PlanReport::default() });
        renderer.render(&top(), &scene, 1.0)
    };
    let [horizon, base] = [render(0), render(1)];
    let pixel = |x: f32| {
        let at = top()
            .project(Vec3::new(x, 0.0, 0.0), SIZE.as_vec2())
            .expect("in the picture")
            .as_uvec2();
        let [dash, solid] = [&horizon, &base].map(|picture| picture.get_pixel(at.x, at.y));
        dash[0].abs_diff(solid[0]) < 30
    };
    let dashes: Vec<bool> = (5..155).map(|step| pixel(step as f32 * 0.05)).collect();
    let gaps = dashes.windows(2).filter(|pair| pair[0] && !pair[1]).count();
    assert_eq!(gaps, 6, "{dashes:?}");
    assert!(
        dashes[0] && dashes[dashes.len() - 1],
        "an edge begins and ends within a dash: {dashes:?}"
    );
}

fn light_theme_from_the_top(gpu: &Gpu) {
    let scene = Scene { theme: Theme::Light, ..coloured(Colouring::State) };
    assert_like("light_theme_from_the_top", &loop_renderer(gpu).render(&top(), &scene, 1.0));
}

/// A rotated chequerboard on the floor, and a fleet with an offset, which doesn't move the floor.
fn map_and_offset(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let light = image::Rgba([150, 170, 190, 255]);
    let pixels = RgbaImage::from_fn(6, 4, |x, y| {
        if (x + y) % 2 == 0 { light } else { image::Rgba([40, 90, 60, 255]) }
    });
    let picture =
        FloorPicture { pixels, corner: Vec2::new(1.0, 0.0), turn: 0.2, size: Vec2::new(6.0, 4.0) };
    renderer.inner.set_floor_picture(Some(&picture));
    let scene = Scene { offset: Vec2::new(1.0, -1.0), ..coloured(Colouring::State) };
    assert_like("map_and_offset", &renderer.render(&top(), &scene, 1.0));
}

fn lamps(gpu: &Gpu) {
    let lamp = |x, colour| Light { position: Vec3::new(x, 2.0, 2.0), colour };
    let lights = vec![lamp(0.0, Vec3::new(2.0, 1.0, 0.4)), lamp(8.0, Vec3::new(0.4, 1.0, 2.0))];
    assert_like(
        "lamps",
        &loop_renderer(gpu).render(&camera(), &Scene { lights, ..coloured(Colouring::State) }, 1.0),
    );
}

/// A red and white mesh from a file, whose robots are nevertheless in the colours of their data.
fn meshes_of_files(gpu: &Gpu) {
    let folder = std::env::temp_dir().join(format!("regatta-painted-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    std::fs::write(
        folder.join("cart.mtl"),
        "newmtl red\nKd 0.8 0.05 0.05\nnewmtl white\nKd 1 1 1\n",
    )
    .expect("written");
    let corners = "v -0.5 -0.3 0.3\nv 0 -0.3 0.3\nv 0 0.3 0.3\nv -0.5 0.3 0.3\nv 0.5 -0.3 0.3\nv 0.5 0.3 0.3\n";
    let faces = "mtllib cart.mtl\nusemtl red\nf 1 2 3 4\nusemtl white\nf 2 5 6 3\n";
    std::fs::write(folder.join("cart.obj"), [corners, faces].concat()).expect("written");
    let loaded =
        mesh_file::load(&folder.join("cart.obj"), MeshPlacement { scale: 1.0, z: 0.0, yaw: 0.0 });
    std::fs::remove_dir_all(&folder).expect("removed");
    let mut renderer = TestRenderer::new(gpu);
    assert!(renderer.inner.set_mesh(None, Some(&loaded.expect("a mesh"))));
    renderer.push(&robots());
    renderer.inner.set_values(Some(&[0.0, 1.0, 2.0].repeat(4)));
    let mut scene = coloured(Colouring::collision());
    scene.detail.mesh = 8.0;
    let picture = renderer.render(&top(), &scene, 1.0);
    assert_like("meshes_of_files", &picture);
    let legend = Colouring::collision().legend(Theme::Dark, &[], None);
    let palette = legend.scale.colours(Theme::Dark);
    for (row, robot) in robots().iter().enumerate() {
        for along in [-0.25, 0.25] {
            let place = Vec2::new(robot.x, robot.y) + Vec2::from_angle(robot.theta) * along;
            let at = top()
                .project(place.extend(0.3), SIZE.as_vec2())
                .expect("in the picture")
                .as_uvec2();
            let shown = picture.get_pixel(at.x, at.y).0.map(f32::from);
            let linear =
                Vec3::from_array([0, 1, 2].map(|part| (shown[part] / 255.0).powf(2.2))).normalize();
            let hue = palette[row % 3].linear().normalize();
            assert!(linear.dot(hue) > 0.985, "robot {row}: {shown:?} for {:?}", palette[row % 3]);
        }
    }
}

/// A selected edge has an outline that no route and no robot has.
fn marked_edge(gpu: &Gpu) {
    let scene = Scene { marked: Some(Marked::Edge(1)), ..coloured(Colouring::State) };
    assert_like("marked_edge", &loop_renderer(gpu).render(&camera(), &scene, 1.0));
}

/// Closed edges are dashed, and have a sign; a closed edge of another level isn't shown.
fn closed_edges(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let mut world = graph();
    renderer.inner.set_closed(&world.view(1, 1), &[0, 3]);
    assert_like("closed_edges", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
    let level = world.texts.add("ground");
    world.edges[1].level = level;
    renderer.inner.set_level(Some("ground"));
    renderer.inner.set_closed(&world.view(1, 1), &[0, 3]);
    assert_like("robots_by_state", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
}

fn marked_node(gpu: &Gpu) {
    let near = Camera { target: Vec3::new(8.0, 4.0, 0.0), distance: 7.0, ..camera() };
    let [marked, plain] = [Some(Marked::Node(2)), None].map(|marked| {
        let scene = Scene { marked, ..coloured(Colouring::State) };
        DynamicImage::from(loop_renderer(gpu).render(&near, &scene, 1.0))
    });
    assert_like("marked_node", &marked.to_rgba8());
    assert!(difference(&marked.into_rgb8(), &plain.into_rgb8()) > 2.0 * TOLERANCE);
    let scene = Scene { marked: Some(Marked::Node(99)), ..coloured(Colouring::State) };
    assert_like("robots_by_state", &loop_renderer(gpu).render(&camera(), &scene, 1.0));
}

/// Of two levels, one is shown: its edges and nodes, and its robots.
fn one_level(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    let mut world = graph();
    let [ground, first] = ["ground", "first"].map(|name| world.texts.add(name));
    world
        .edges
        .iter_mut()
        .zip([ground, first, first, first])
        .for_each(|(edge, level)| edge.level = level);
    world
        .nodes
        .iter_mut()
        .zip([ground, ground, first, first])
        .for_each(|(node, level)| node.level = level);
    renderer.inner.set_level(Some("ground"));
    renderer.inner.set_graph(&world.view(1, 1));
    renderer.push(&robots());
    renderer.inner.set_on_level(Some(&[0b0000_0011_1111]));
    assert_like("one_level", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
    renderer.inner.set_level(None);
    renderer.inner.set_on_level(None);
    renderer.inner.set_graph(&graph().view(1, 1));
    assert_like("robots_by_state", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
}

/// The pixels of a robot in a plan are as many as its outline covers, in the middle and at the side
/// of the picture.
fn plan_footprints(gpu: &Gpu) {
    let mut renderer = TestRenderer::new(gpu);
    let view = Camera::plan_around(Vec2::new(4.0, 0.0), 10.0);
    let (per_metre, mut scene) = (SIZE.y as f32 / 10.0, coloured(Colouring::State));
    (scene.layers.grid, scene.layers.shadows) = (false, true);
    for x in [4.0, -3.0, 11.0] {
        renderer.push(&[]);
        let empty = renderer.render(&view, &scene, 1.0);
        renderer.push(&[Robot { x, y: 1.3, theta: 0.7, state: 1, ..Robot::default() }]);
        let picture = renderer.render(&view, &scene, 1.0);
        let covered = picture.pixels().zip(empty.pixels()).filter(|(a, b)| a != b).count() as f32;
        let outline = 0.9 * 0.6 * per_metre * per_metre;
        // Pixels that are covered in part count as whole: half a pixel along the outline.
        let border = 2.0 * (0.9 + 0.6) * per_metre * 0.75;
        assert!(
            covered >= outline && covered <= outline + border,
            "at {x}: {covered} pixels of {outline}"
        );
    }
    let mut renderer = loop_renderer(gpu);
    let whole = Camera::plan(bounds(), Window::whole(SIZE.x as f32 / SIZE.y as f32));
    assert_like("plan", &renderer.render(&whole, &coloured(Colouring::State), 1.0));
}

/// Robots of both shapes from near, as meshes, to far, where the order of overlapping marks may
/// differ; and marks alone that don't overlap.
fn splats_are_like_triangles(gpu: &Gpu) {
    let fleet = |side: usize, distance: f32| -> Vec<_> {
        let place = |i: usize| [(i / side) as f32 * distance, (i % side) as f32 * distance];
        let robot = |i: usize| Robot {
            x: place(i)[0],
            y: place(i)[1],
            theta: i as f32,
            state: (i % 5) as u8,
            speed: 0.0,
        };
        (0..8 * side * side).map(robot).collect()
    };
    let robot_type = [0.0, 1.0].repeat(4000);
    let low = Camera::from_eye(Vec3::new(-4.0, -2.0, 4.0), 0.1, 0.25);
    let wide = Camera::fit(
        Bounds { low: Vec2::ZERO, high: Vec2::new(96.0, 12.0) },
        SIZE.x as f32 / SIZE.y as f32,
    );
    for (fleet, camera, tolerance) in
        [(fleet(16, 2.0), low, 2.0 * TOLERANCE), (fleet(5, 2.7), wide, TOLERANCE)]
    {
        let [triangles, splats] = [u32::MAX, 0].map(|splats_from| {
            let mut renderer = TestRenderer::with_target(
                gpu,
                TargetConfig { splats_from, ..TargetConfig::new(gpu, FORMAT, 1) },
            );
            let mut scene = coloured(Colouring::State);
            scene.layers.density = false;
            renderer.push(&fleet);
            renderer.inner.set_robot_type_column(&robot_type[..fleet.len()]);
            DynamicImage::from(renderer.render(&camera, &scene, 1.0)).into_rgb8()
        });
        let share = difference(&triangles, &splats);
        assert!(share <= tolerance, "{} robots: {share} of the pixels differ", fleet.len());
    }
}
