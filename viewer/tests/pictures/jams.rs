//! Tests of the layers that show where it jams: the heat map and the density from afar; and of
//! colours at all levels of detail.

use glam::{Vec2, Vec3};
use image::{DynamicImage, RgbaImage};
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_plugin::Traffic;
use regatta_plugin::traffic::{EdgeTraffic, TrafficHeader};
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::heat::HeatMap;
use regatta_scene::palette::{Colouring, Rgb, Scale, Theme};
use regatta_scene::{Item, Scene};
use regatta_viewer::picture::FORMAT;

use crate::Test;
use crate::fleet::{Robot, SIZE, TestRenderer, camera, graph, robots};
use crate::references::{TOLERANCE, assert_like, coloured, difference, loop_renderer};

pub const TESTS: &[(&str, Test)] = &[
    ("heat", heat),
    ("ribbons_in_pixels_are_like_triangles", ribbons_in_pixels_are_like_triangles),
    ("edges_are_picked_under_their_ribbons", edges_are_picked_under_their_ribbons),
    ("density", density),
    ("a_crowd_keeps_its_hue_from_near_to_far", a_crowd_keeps_its_hue_from_near_to_far),
    ("robots_have_the_colours_of_the_legend", robots_have_the_colours_of_the_legend),
];

/// Three of the four edges have waiting robots: little, more, and the most.
fn heat(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let edges = [5.0, 0.0, 45.0, 100.0]
        .map(|waiting_secs| EdgeTraffic { waiting_secs, ..EdgeTraffic::default() });
    let traffic = Traffic { header: &TrafficHeader::default(), periods: [&edges; 3], missed: 0 };
    let heat = "waiting:run".parse().expect("a heat map");
    let map = HeatMap::new(heat, &traffic, &graph().view(1, 1));
    renderer.inner.set_heat(Some(&map));
    let mut scene = Scene { heat: Some(heat), ..coloured(Colouring::State) };
    assert_like("heat", &renderer.render(&camera(), &scene, 1.0));
    scene.theme = Theme::Light;
    assert_like("heat_light", &renderer.render(&camera(), &scene, 1.0));
    assert_like("robots_by_state", &renderer.render(&camera(), &coloured(Colouring::State), 1.0));
}

/// A town of straight and bent streets in all directions, with more of them than from where ribbons
/// may be drawn into pixels.
fn town() -> WorldData {
    let mut world = WorldData::default();
    for i in 0..2_500 {
        let (x, y) = ((i % 50) as f32 * 9.0, (i / 50) as f32 * 9.0);
        world.nodes.push(NodeRecord { id: i, x, y, ..NodeRecord::default() });
        let turned = |along: f32, across: f32| {
            let (sin, cos) = (i as f32 * 0.37).sin_cos();
            [x + along * cos - across * sin, y + along * sin + across * cos]
        };
        let bend = if i % 3 == 0 { 3.0 } else { 0.0 };
        let curve = [turned(-4.0, 0.0), turned(-1.5, bend), turned(1.5, bend), turned(4.0, 0.0)];
        world.add_edge(
            EdgeRecord { id: i, length: 8.0, ..EdgeRecord::default() },
            [CurveRecord { control_points: curve }],
        );
    }
    world
}

/// The heat map of a town from afar and near the ground, where some ribbons are short and others
/// long.
fn ribbons_in_pixels_are_like_triangles(gpu: &Gpu) {
    let (world, heat) = (town(), "waiting:run".parse().expect("a heat map"));
    let waiting = |edge: usize| EdgeTraffic {
        waiting_secs: (edge * 31 % 97) as f32,
        ..EdgeTraffic::default()
    };
    let edges: Vec<_> = (0..world.edges.len()).map(waiting).collect();
    let traffic = Traffic { header: &TrafficHeader::default(), periods: [&edges; 3], missed: 0 };
    let map = HeatMap::new(heat, &traffic, &world.view(1, 1));
    let far = Camera {
        target: Vec3::new(220.0, 220.0, 0.0),
        distance: 150.0,
        pitch: 1.0,
        ..Camera::default()
    };
    let low = Camera { distance: 25.0, pitch: 0.3, ..far };
    for camera in [far, low] {
        let [triangles, pixels] = [u32::MAX, 0].map(|splats_from| {
            let target = TargetConfig { splats_from, ..TargetConfig::new(gpu, FORMAT, 1) };
            let mut renderer = TestRenderer::with_target(gpu, target);
            renderer.push(&[]);
            renderer.inner.set_graph(&world.view(1, 1));
            renderer.inner.set_heat(Some(&map));
            let scene = Scene { heat: Some(heat), ..coloured(Colouring::State) };
            DynamicImage::from(renderer.render(&camera, &scene, 1.0)).into_rgb8()
        });
        let share = difference(&triangles, &pixels);
        // Ends are smoothed in pixels only, and there are thousands of them.
        assert!(share <= 10.0 * TOLERANCE, "{share} of the pixels differ");
        let hot = pixels.pixels().filter(|pixel| pixel.0[0] > 120).count();
        assert!(hot > pixels.pixels().len() / 20, "there are ribbons");
    }
}

fn edges_are_picked_under_their_ribbons(gpu: &Gpu) {
    let mut renderer = loop_renderer(gpu);
    let edges = [EdgeTraffic { waiting_secs: 9.0, ..EdgeTraffic::default() }; 4];
    let traffic = Traffic { header: &TrafficHeader::default(), periods: [&edges; 3], missed: 0 };
    let heat = "waiting:run".parse().expect("a heat map");
    renderer.inner.set_heat(Some(&HeatMap::new(heat, &traffic, &graph().view(1, 1))));
    renderer.push(&[]);
    for distance in [20.0, 60.0] {
        let camera =
            Camera { target: Vec3::new(4.0, 2.0, 0.0), distance, pitch: 1.57, ..Camera::default() };
        renderer.render(&camera, &Scene { heat: Some(heat), ..coloured(Colouring::State) }, 1.0);
        for (index, middle) in
            [[3.4, 0.0], [10.25, 2.0], [4.6, 4.0], [-2.25, 2.0]].into_iter().enumerate()
        {
            let at = camera
                .project(Vec3::new(middle[0], middle[1], 0.0), SIZE.as_vec2())
                .expect("in the picture");
            assert_eq!(
                renderer.inner.pick(at),
                Some(Item::Edge(index as u32)),
                "{distance} m away"
            );
        }
    }
}

/// A crowd on streets, with two that are jammed. One in ten robots waits; in the jams all do.
fn crowd() -> Vec<Robot> {
    let mut all = Vec::new();
    for street in 0..20 {
        for i in 0..100 {
            let (along, across) = (i as f32 * 2.0, street as f32 * 10.0);
            let state = if i % 10 == 0 { 2 } else { 1 };
            all.push(Robot { x: along, y: across, state, ..Robot::default() });
            all.push(Robot { x: across, y: along, theta: 1.57, state, ..Robot::default() });
        }
    }
    for i in 0..600 {
        let jam = [Vec2::new(60.0, 80.0), Vec2::new(140.0, 120.0)][i % 2];
        let (x, y) = (jam.x + (i / 2 % 20) as f32 * 1.2, jam.y + (i / 40) as f32 * 1.2);
        all.push(Robot { x, y, state: 2, ..Robot::default() });
    }
    all
}

fn crowd_renderer(gpu: &Gpu) -> TestRenderer {
    let mut renderer = TestRenderer::new(gpu);
    renderer.push(&crowd());
    renderer.inner.set_ground(200.0 * 200.0);
    renderer
}

fn fit(side: f32) -> Camera {
    let half = Vec2::splat(side / 2.0);
    Camera::fit(
        Bounds { low: Vec2::splat(100.0) - half, high: Vec2::splat(100.0) + half },
        SIZE.x as f32 / SIZE.y as f32,
    )
}

fn density(gpu: &Gpu) {
    let mut scene = coloured(Colouring::State);
    assert_like("density", &crowd_renderer(gpu).render(&fit(230.0), &scene, 1.0));
    scene.layers.density = false;
    assert_like("density_off", &crowd_renderer(gpu).render(&fit(230.0), &scene, 1.0));
}

/// The mean linear colour of the middle of a picture.
fn mean(picture: &RgbaImage) -> Vec3 {
    let middle = picture
        .enumerate_pixels()
        .filter(|(x, y, _)| (110..210).contains(x) && (70..130).contains(y));
    let (sum, count) = middle.fold((Vec3::ZERO, 0.0_f32), |(sum, count), (_, _, pixel)| {
        let [red, green, blue, _] = pixel.0.map(u32::from);
        (sum + Rgb(red << 16 | green << 8 | blue).linear(), count + 1.0)
    });
    sum / count
}

/// An even crowd of one state, as the camera moves away by 5 % from picture to picture: no jump of
/// brightness, and the hue of the crowd against the floor stays.
fn a_crowd_keeps_its_hue_from_near_to_far(gpu: &Gpu) {
    let even = |i: usize| Robot {
        x: (i % 200) as f32 * 1.5,
        y: (i / 200) as f32 * 1.5,
        state: 1,
        ..Robot::default()
    };
    let mut renderer = TestRenderer::new(gpu);
    renderer.push(&(0..40_000).map(even).collect::<Vec<_>>());
    renderer.inner.set_ground(300.0 * 300.0);
    let mut scene = coloured(Colouring::State);
    (scene.layers.grid, scene.layers.shadows) = (false, false);
    let floor = scene.theme.colours().floor.linear();
    let target = Vec3::new(150.0, 150.0, 0.0);
    let distances: Vec<f32> = (0..40).map(|step| 40.0 * 1.05_f32.powi(step)).collect();
    let colours: Vec<Vec3> = distances
        .iter()
        .map(|distance| {
            let camera = Camera { target, distance: *distance, pitch: 1.5, ..Camera::default() };
            mean(&renderer.render(&camera, &scene, 1.0))
        })
        .collect();
    for (pair, distance) in colours.windows(2).zip(&distances) {
        let [before, after] = [pair[0] - floor, pair[1] - floor];
        let step = after.length() / before.length();
        assert!(
            (0.88..1.24).contains(&step),
            "at {distance} m the brightness changes by {step}: {colours:?}"
        );
        let hue = before.normalize().dot(after.normalize());
        assert!(hue > 0.999, "at {distance} m the hue changes: {hue}");
    }
}

/// A robot from straight above, at sizes at which it is a block and a mark: its middle has the
/// colour of the legend.
fn robots_have_the_colours_of_the_legend(gpu: &Gpu) {
    for theme in [Theme::Dark, Theme::Light] {
        let mut scene = Scene { theme, ..coloured(Colouring::State) };
        scene.layers.shadows = false;
        let Scale::Categories(legend) = scene.colouring.legend(theme, &[], None).scale else {
            panic!("categories")
        };
        for distance in [38.0, 60.0, 110.0] {
            let mut renderer = TestRenderer::new(gpu);
            renderer.push(&[Robot { state: 1, ..robots()[0] }]);
            let camera = Camera {
                target: Vec3::new(-0.08, 0.0, 0.0),
                distance,
                pitch: 1.57,
                ..Camera::default()
            };
            let picture = renderer.render(&camera, &scene, 1.0);
            let [red, green, blue, _] = picture.get_pixel(SIZE.x / 2, SIZE.y / 2).0.map(u32::from);
            let found = Rgb(red << 16 | green << 8 | blue).linear();
            let wanted = legend[1].1.linear();
            let ratio = found.length() / wanted.length();
            let hue = found.normalize().dot(wanted.normalize());
            assert!(
                (0.88..1.12).contains(&ratio) && hue > 0.995,
                "{theme:?} at {distance} m: {found} for {wanted}"
            );
        }
    }
}
