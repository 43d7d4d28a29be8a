//! Levels side by side, in a screenshot and as a window draws them.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::UVec2;
use image::RgbaImage;
use image::imageops::crop_imm;
use regatta_gpu::TargetConfig;
use regatta_gpu::copy::Insets;
use regatta_gpu::device::Gpu;
use regatta_gpu::renderer::Renderer;
use regatta_plugin::Participant;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::WorldData;
use regatta_scene::Scene;
use regatta_scene::heat::{HeatFacts, HeatMap, HotCurve};
use regatta_scene::palette::Colouring;
use regatta_scene::plans::{GoalMark, PlanReport, WaitArrow};
use regatta_scene::route::RouteSegment;
use regatta_viewer::feed::News;
use regatta_viewer::picture::{FORMAT, Offscreen};
use regatta_viewer::stage::Stage;

use crate::Test;
use crate::fleet::{SIZE, TestRenderer, camera, graph, robots};
use crate::live::LiveFleet;
use crate::motion::difference;
use crate::references::{TOLERANCE, coloured};

pub const TESTS: &[(&str, Test)] = &[
    ("levels_are_drawn_side_by_side", in_a_screenshot),
    ("levels_beside_each_other_are_as_alone", in_a_window),
    ("a_level_has_nothing_of_another_one", nothing_of_others),
    ("robots_of_a_level_that_do_not_match_are_dimmed", dimmed_on_a_level),
    ("a_plan_shows_one_level_and_fits_it", as_a_plan),
];

/// The levels, and the heights at which a picture of both has them.
const LEVELS: [(&str, u32); 2] = [("cellar", 0), ("ground", SIZE.y)];

/// A world of both levels.
pub fn two_levels() -> WorldData {
    let mut world = graph();
    let [cellar, ground] = LEVELS.map(|(name, _)| world.texts.add(name));
    world
        .edges
        .iter_mut()
        .zip([cellar, ground, ground, ground])
        .for_each(|(edge, level)| edge.level = level);
    world
}

/// A fleet whose robots are all in the cellar.
fn fleet(test: &str) -> LiveFleet {
    LiveFleet::start_in(test, two_levels())
}

/// Each part is as a picture of its level alone.
fn in_a_screenshot(_: &Gpu) {
    let live = fleet("levels");
    let path = live.path("levels.png");
    let view = |size: &str, args: &[&str]| {
        let common =
            ["--screenshot", &path, "--force", "--no-ids", "--no-legend", "--camera", "4,2,14"];
        live.try_view(size, &[&common[..], args].concat()).expect("a picture");
        image::open(Path::new(&path)).expect("a picture").into_rgba8()
    };
    let all = view("320x400", &["--levels"]);
    assert_eq!((all.width(), all.height()), (320, 400));
    let parts = LEVELS.map(|(name, top)| {
        let alone = view("320x200", &["--level", name, "--title", name]);
        let part = crop_imm(&all, 0, top, SIZE.x, SIZE.y).to_image();
        assert!(part == alone, "the part of {name}");
        part
    });
    assert!(parts[0] != parts[1], "they show different things");
    drop(live);
    let live = LiveFleet::start("one-level");
    let refused = live
        .try_view("320x200", &["--screenshot", &live.path("no.png"), "--levels"])
        .expect_err("no levels");
    assert!(refused.to_string().contains("leave --levels out"), "{refused}");
}

/// Robots that don't match a filter are dimmed with a level too; only those of other levels are
/// hidden.
fn dimmed_on_a_level(gpu: &Gpu) {
    let draw = |present: u32, matches: u32| {
        let mut renderer = TestRenderer::new(gpu);
        renderer.inner.set_level(Some("cellar"));
        renderer.inner.set_graph(&two_levels().view(1, 1));
        let mut fleet = robots();
        let absent = fleet.iter_mut().zip(0..).filter(|(_, id)| present >> id & 1 == 0);
        absent.for_each(|(robot, _)| robot.state = RobotState::Absent as u8);
        renderer.push(&fleet);
        renderer.inner.set_on_level(Some(&[0b11_1111]));
        renderer.inner.set_matches(Some(&[matches]));
        renderer.render(&camera(), &coloured(Colouring::State), 1.0)
    };
    let brightness = |one: &RgbaImage, other: &RgbaImage| -> u64 {
        one.as_raw().iter().zip(other.as_raw()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum()
    };
    let all = 0b1111_1111_1111;
    // Of the robots that match, robot 6 is on the other level.
    let (lit, dimmed, alone) = (draw(all, all), draw(all, 0b0100_0001), draw(1, all));
    let [lit, rest] = [&lit, &dimmed].map(|picture| brightness(picture, &alone));
    assert!(rest > lit / 20 && rest < lit / 2, "the others have {rest} of {lit}");
    assert!(dimmed == draw(0b11_1111, 1), "something of the other level is in the picture");
}

/// Each level is drawn at the scale of its own size, and together both have all edges.
fn as_a_plan(_: &Gpu) {
    let live = fleet("plan");
    let path = live.path("plan.svg");
    let plan = |args: &[&str]| {
        live.try_view(
            "320x200",
            &[&["--svg", &path, "--force", "--svg-scale", "100"], args].concat(),
        )
        .expect("a plan");
        std::fs::read_to_string(&path).expect("a plan")
    };
    let count = |text: &str, id: &str| text.matches(&format!(" id=\"{id}")).count();
    let all = plan(&[]);
    let [cellar, ground] = LEVELS.map(|(level, _)| plan(&["--level", level]));
    let edges = [&cellar, &ground, &all].map(|text| count(text, "e") - count(text, "edges"));
    assert_eq!(edges, [1, 3, 4]);
    let robots = [&cellar, &ground, &all].map(|text| count(text, "robot-"));
    assert!(robots[0] > 0 && robots[0] == robots[2] && robots[1] == 0, "{robots:?}");
    let size = |text: &str| {
        text.split("viewBox=\"0 0 ")
            .nth(1)
            .and_then(|rest| rest.split('"').next())
            .map(str::to_owned)
    };
    assert!(size(&cellar) != size(&all), "a level that is smaller than all has a smaller sheet");
    let refused = live
        .try_view("320x200", &["--svg", &path, "--force", "--level", "attic"])
        .expect_err("no such level");
    assert!(refused.to_string().contains("there is no level 'attic'"), "{refused}");
}

/// A stage that has a fleet's world, frame and column.
fn stage(live: &LiveFleet, gpu: &Gpu, target: TargetConfig) -> Stage {
    let participant = Participant::join(&live.name, "test").expect("joined");
    let scene = Scene { level: Some("ground".to_owned()), ..coloured(Colouring::collision()) };
    let mut stage = Stage::new(&participant, Renderer::new(gpu, target), scene).expect("a stage");
    let until = Instant::now() + Duration::from_secs(20);
    while stage.feed.world().is_none()
        || stage.feed.frame().is_none()
        || stage.feed.value().is_none()
    {
        assert!(Instant::now() < until, "no fleet");
        stage.update(Instant::now()).expect("an update");
        std::thread::sleep(Duration::from_millis(5));
    }
    stage
}

/// Makes a level the scene's.
fn show(stage: &mut Stage, level: &str) {
    stage.scene.level = Some(level.to_owned());
    stage.apply(News::default(), Instant::now()).expect("applied");
    stage.hide_other_levels();
}

/// A level is the same beside another one as alone, whichever of both is the scene's, with one
/// sample per pixel and with several.
fn in_a_window(gpu: &Gpu) {
    let live = fleet("beside");
    for samples in [1, 4] {
        let target = TargetConfig::new(gpu, FORMAT, samples);
        let mut stage = stage(&live, gpu, target);
        let offscreen = Offscreen::new(gpu, SIZE, target).expect("room");
        let alone = LEVELS.map(|(level, _)| {
            show(&mut stage, level);
            let mut encoder = gpu.encoder();
            stage.draw(&mut encoder, &offscreen.view, &camera(), SIZE, 1.0);
            offscreen.read(encoder).expect("a picture")
        });
        assert!(alone[0] != alone[1], "they show different things");
        let both = Offscreen::new(gpu, UVec2::new(SIZE.x, 2 * SIZE.y), target).expect("room");
        let mut insets = Insets::new(gpu, FORMAT);
        for (round, current) in [1, 0, 1, 1].into_iter().enumerate() {
            let (level, at) = LEVELS[current];
            show(&mut stage, level);
            let (other, below) = LEVELS[1 - current];
            let is_new = stage.show_beside(&[other], || Renderer::new(gpu, target));
            assert_eq!(is_new, round == 0, "the levels change places");
            stage.update(Instant::now()).expect("the columns");
            let mut encoder = gpu.encoder();
            let within = Some((UVec2::new(0, at), both.size()));
            stage.draw_within(&mut encoder, &both.view, within, &camera(), SIZE, 1.0);
            for view in insets.make_room(1, SIZE) {
                stage.draw_beside(&mut encoder, view, other, &camera(), SIZE, 1.0);
            }
            insets.copy(&mut encoder, &both.view, &[UVec2::new(0, below)]);
            let picture: RgbaImage = both.read(encoder).expect("a picture");
            for ((name, top), alone) in LEVELS.iter().zip(&alone) {
                let part = crop_imm(&picture, 0, *top, SIZE.x, SIZE.y).to_image();
                // At the border of a robot, some samples are of the ground as it is kept: a pixel
                // of it.
                let limit = if samples == 1 { 0.0 } else { TOLERANCE };
                assert!(
                    difference(&part, alone) <= limit,
                    "{name} in round {round}, with {samples} samples"
                );
            }
        }
        assert!(!stage.show_beside(&[], || unreachable!("nothing is to be shown beside")));
    }
}

/// Of the heat map, routes, goals, arrows, halos and trails, a picture of a level has what is on
/// that level: it equals the one of a fleet that has nothing else.
fn nothing_of_others(gpu: &Gpu) {
    let mut world = graph();
    let levels = ["cellar", "ground"].map(|name| world.texts.add(name));
    let level_of = |index: usize| levels[usize::from(index > 1)];
    world.edges.iter_mut().enumerate().for_each(|(index, edge)| edge.level = level_of(index));
    world.nodes.iter_mut().enumerate().for_each(|(index, node)| node.level = level_of(index));
    // The first row of robots is in the cellar.
    let in_cellar = |robot: u32| robot < 6;
    let heat = "waiting:run".parse().expect("a heat map");
    let draw = |is_on_level: [bool; 2]| {
        let mut renderer = TestRenderer::new(gpu);
        renderer.inner.set_level(Some("cellar"));
        renderer.inner.set_graph(&world.view(1, 1));
        let is_there = |index: u32| is_on_level[usize::from(index > 1)];
        let hot =
            (0..4).filter(|curve| is_there(*curve)).map(|curve| HotCurve { curve, level: 0.8 });
        let (straight, bent) = hot.partition(|hot| hot.curve % 2 == 0);
        let facts = HeatFacts {
            heat,
            ends: [0.0, 10.0],
            is_exceeded: false,
            edges: 4,
            secs: 60.0,
            has_contacts: true,
            has_routes: true,
        };
        renderer.inner.set_heat(Some(&HeatMap { straight, bent, hottest: Vec::new(), facts }));
        let line = |curve| RouteSegment { curve, range: [0.0, 1.0], released: curve % 2 };
        let all: Vec<_> = (0..4).filter(|index| is_there(*index)).collect();
        let robots_there = |robot: u32| in_cellar(robot) || is_on_level[1];
        let waits = [(0, 3), (7, 10), (8, 2)].map(|(from, to)| WaitArrow { from, to, in_ring: 0 });
        renderer.inner.set_routes(&all.iter().map(|curve| line(*curve)).collect::<Vec<_>>());
        renderer.inner.set_plans(&PlanReport {
            lines: all.iter().map(|curve| line(*curve)).collect(),
            goals: all.iter().map(|node| GoalMark { node: *node, selected: node % 2 }).collect(),
            arrows: waits
                .into_iter()
                .filter(|wait| robots_there(wait.from) && robots_there(wait.to))
                .collect(),
            ..PlanReport::default()
        });
        let mut fleet = robots();
        fleet
            .iter_mut()
            .zip(0..)
            .filter(|(_, id)| !robots_there(*id))
            .for_each(|(robot, _)| robot.state = RobotState::Absent as u8);
        let mut scene =
            Scene { selected: vec![1, 8], heat: Some(heat), ..coloured(Colouring::State) };
        (scene.layers.plans, scene.layers.waits, scene.layers.trails, scene.trails.points) =
            (true, true, true, 8);
        for step in 0..3 {
            fleet.iter_mut().for_each(|robot| robot.x += 0.4 * step as f32);
            renderer.push(&fleet);
            renderer.inner.set_on_level(Some(&[0b11_1111]));
            renderer.render(&camera(), &scene, 1.0);
        }
        renderer.render(&camera(), &scene, 1.0)
    };
    let (all, alone) = (draw([true, true]), draw([true, false]));
    assert!(all == alone, "something of the other level is in the picture");
    assert!(draw([false, true]) != alone, "the picture has something of its own level");
}
