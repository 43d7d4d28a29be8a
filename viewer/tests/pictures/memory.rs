//! Drawing needs no more memory from picture to picture.

use std::process::Command;

use glam::{Vec2, Vec3};
use regatta_gpu::device::Gpu;
use regatta_plugin::world::StationRecord;
use regatta_scene::palette::{Colouring, Theme};
use regatta_scene::plans::{GoalMark, PlanReport};
use regatta_scene::route::RouteSegment;
use regatta_scene::{Light, Marked, Scene, Trails};
use regatta_viewer::plans::marks::arrows;

use crate::Test;
use crate::fleet::{TestRenderer, camera, graph, robots};

pub const TESTS: &[(&str, Test)] = &[(NAME, pictures_keep_no_memory)];

const NAME: &str = "pictures_keep_no_memory";
/// The scene that a child process draws, by its index.
const SCENE: &str = "REGATTA_TEST_SCENE";
/// Pictures until all buffers and shaders are there, and those after them.
const FIRST_PICTURES: usize = 40;
const PICTURES: usize = 120;
/// The most memory that a picture may keep, in kilobytes. Mesa's software driver (22.3) compiles a
/// shader that branches on a uniform alone anew for each picture, and keeps 200 kB or more of it.
const MOST_KB: usize = 20;

/// Other tests run in the same process, and so each scene has a process of its own.
fn pictures_keep_no_memory(gpu: &Gpu) {
    if let Ok(scene) = std::env::var(SCENE) {
        return draw(gpu, &scenes()[scene.parse::<usize>().expect("an index")].1);
    }
    for (index, (name, _)) in scenes().into_iter().enumerate() {
        let mut child = Command::new(std::env::current_exe().expect("a path"));
        let child = child.args(["--exact", NAME]).env(SCENE, index.to_string());
        let output = child.output().expect("a process");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{name}: {text}");
        assert!(text.contains("1 passed"), "{name}: {text}");
    }
}

/// Scenes that together have everything that is drawn.
fn scenes() -> Vec<(&'static str, Scene)> {
    let usual = Scene::default();
    let mut all = vec![
        ("selected robots", Scene { selected: vec![2, 9], ..usual.clone() }),
        ("trails", Scene { trails: Trails { points: 20, only_selected: false }, ..usual.clone() }),
        ("a marked edge", Scene { marked: Some(Marked::Edge(1)), ..usual.clone() }),
        ("a marked node", Scene { marked: Some(Marked::Node(1)), ..usual.clone() }),
        ("lamps", Scene { lights: lamps(), theme: Theme::Light, ..usual.clone() }),
        ("an offset", Scene { offset: Vec2::new(1.0, 2.0), ..usual.clone() }),
        ("types", Scene { colouring: Colouring::Type, ..usual.clone() }),
    ];
    let mut plans = usual;
    (plans.layers.plans, plans.layers.waits) = (true, true);
    all.push(("routes, goals and arrows", plans));
    all
}

fn lamps() -> Vec<Light> {
    vec![Light { position: Vec3::new(4.0, 2.0, 3.0), colour: Vec3::ONE }]
}

/// Draws pictures of a scene, and panics if they keep memory.
fn draw(gpu: &Gpu, scene: &Scene) {
    let mut renderer = TestRenderer::new(gpu);
    let mut world = graph();
    world.add_station(StationRecord { x: 4.0, y: 2.0, ..StationRecord::default() }, [0, 1]);
    renderer.inner.set_graph(&world.view(1, 1));
    renderer.inner.set_matches(Some(&[0b0101_0101_0101]));
    renderer.inner.set_plans(&PlanReport {
        lines: vec![RouteSegment { curve: 2, range: [0.5, 1.0], released: 1 }],
        goals: vec![GoalMark { node: 3, selected: 0 }],
        arrows: arrows(&[1.0, 2.0, f32::NAN, 4.0]),
        ..PlanReport::default()
    });
    let mut before = 0;
    for picture in 0..FIRST_PICTURES + PICTURES {
        if picture == FIRST_PICTURES {
            before = resident_kb();
        }
        renderer.push(&robots());
        renderer.render(&camera(), scene, 0.5);
    }
    let kept = resident_kb().saturating_sub(before) / PICTURES;
    assert!(kept <= MOST_KB, "each picture keeps {kept} kB");
}

/// The memory that the process has, in kilobytes.
fn resident_kb() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux has it");
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("a line");
    line.split_whitespace().nth(1).expect("a number").parse().expect("kilobytes")
}
