//! Headless rendering of a fleet in shared memory, by the command line, into files.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use clap::{Args, FromArgMatches};
use glam::{UVec2, Vec3};
use image::RgbaImage;
use image::imageops::crop_imm;
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_gpu::resources::{texture, view_of};
use regatta_plugin::column::COLLISION;
use regatta_plugin::world::WorldData;
use regatta_plugin::{FleetName, ProducerPorts};
use regatta_scene::camera::Camera;
use regatta_scene::palette::Colouring;
use regatta_viewer::Options;
use regatta_viewer::picture::{FORMAT, Offscreen, PictureError};
use wgpu::{TextureFormat, TextureUsages};

use crate::Test;
use crate::fleet::{SIZE, TestRenderer, graph, robot_types, robots};
use crate::levels::two_levels;
use crate::references::coloured;

pub const TESTS: &[(&str, Test)] = &[
    ("a_live_fleet_is_drawn_into_a_screenshot", a_screenshot),
    ("a_legend_covers_nothing", a_legend),
    ("a_live_fleet_is_recorded", a_recording),
    ("what_a_picture_cannot_show_is_refused", what_cannot_be_shown),
    ("a_picture_without_room_is_refused_with_the_largest_size", a_picture_without_room),
    ("a_full_memory_is_an_error", a_full_memory),
];

/// A producer of a stationary fleet, which publishes until it is dropped.
pub struct LiveFleet {
    pub name: FleetName,
    folder: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl LiveFleet {
    pub fn start(test: &str) -> Self {
        Self::start_in(test, graph())
    }

    pub fn start_in(test: &str, world: WorldData) -> Self {
        let name: FleetName =
            format!("test-viewer-{test}-{}", std::process::id()).parse().expect("a name");
        let folder = std::env::temp_dir().join(name.to_string());
        std::fs::create_dir_all(&folder).expect("a folder");
        let stop = Arc::new(AtomicBool::new(false));
        let (fleet, flag) = (name.clone(), Arc::clone(&stop));
        let thread = std::thread::spawn(move || publish(&fleet, world, &flag));
        Self { name, folder, stop, thread: Some(thread) }
    }

    fn view(&self, args: &[&str]) {
        self.try_view("320x200", args).expect("pictures are written");
    }

    pub fn try_view(&self, size: &str, args: &[&str]) -> Result<(), regatta_plugin::Error> {
        let command = Options::augment_args(clap::Command::new("viewer").no_binary_name(true));
        let fleet = self.name.to_string();
        let common = ["--headless", "--fleet", &fleet, "--size", size];
        let matches = command.try_get_matches_from(common.iter().chain(args)).expect("arguments");
        regatta_viewer::run(&Options::from_arg_matches(&matches).expect("options"))
    }

    pub fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }
}

impl Drop for LiveFleet {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        std::fs::remove_dir_all(&self.folder).expect("removed");
        if !std::thread::panicking() {
            ended.expect("a thread").expect("the producer ends without an error");
        }
    }
}

fn publish(fleet: &FleetName, world: WorldData, stop: &AtomicBool) {
    let rows = robots();
    let mut producer = ProducerPorts::create(fleet, rows.len()).expect("a producer");
    let world = WorldData { robot_types: robot_types().to_vec(), ..world };
    producer.publish_world(&world).expect("a world");
    for tick in 0.. {
        if stop.load(Ordering::Relaxed) {
            return;
        }
        producer.publish_column(COLLISION.name(), tick, &collisions()).expect("a column");
        let mut frame = producer.loan(rows.len()).expect("a frame");
        frame.header_mut().tick = tick;
        frame.header_mut().sim_time_nanos = tick * 10_000_000;
        let columns = frame.columns_mut();
        for (i, row) in rows.iter().enumerate() {
            (columns.x[i], columns.y[i], columns.theta[i]) = (row.x, row.y, row.theta);
            (columns.speed[i], columns.edge[i], columns.state[i], columns.s[i]) =
                (row.speed, 0, row.state, 0.0);
        }
        frame.send().expect("sent");
        producer.notify();
        producer.update();
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn collisions() -> Vec<f32> {
    [0.0, 1.0, 2.0].repeat(4)
}

fn a_screenshot(gpu: &Gpu) {
    let live = LiveFleet::start("shot");
    let path = live.path("shot.png");
    let screenshot = |hidden: &[&str]| {
        let camera = ["--camera", "4,-4,6,1.5,0.9", "--samples", "4"];
        live.view(&[&["--screenshot", &path, "--force"][..], &camera, hidden].concat());
        image::open(Path::new(&path)).expect("a picture").into_rgba8()
    };
    let actual = screenshot(&["--no-ids", "--no-legend"]);
    let mut renderer = TestRenderer::new(gpu);
    renderer.inner.set_graph(&graph().view(1, 1));
    renderer.push(&robots());
    renderer.inner.set_values(Some(&collisions()));
    let expected = renderer.render(
        &Camera::from_eye(Vec3::new(4.0, -4.0, 6.0), 1.5, 0.9),
        &coloured(Colouring::collision()),
        1.0,
    );
    assert!(actual == expected, "the picture equals one rendered without shared memory");
    assert!(
        screenshot(&["--no-ids"]) == expected,
        "a picture without room for the legend has none"
    );
    let ids = differing(&expected, &screenshot(&["--no-legend"])).len();
    assert!(ids > 100, "ids are drawn beside nodes and edges: {ids} pixels");
}

/// The legend lies in its corner, and of a picture of all levels in a strip beside them; a small
/// picture of them has none.
fn a_legend(_: &Gpu) {
    let live = LiveFleet::start_in("legend", two_levels());
    let path = live.path("shot.png");
    let screenshot = |size: &str, args: &[&str]| {
        let common = ["--screenshot", &path, "--force", "--no-ids", "--camera", "4,-4,6,1.5,0.9"];
        live.try_view(size, &[&common[..], args].concat()).expect("a picture");
        image::open(Path::new(&path)).expect("a picture").into_rgba8()
    };
    let without = screenshot("640x400", &["--no-legend"]);
    let legend = differing(&without, &screenshot("640x400", &[]));
    let is_in_corner = legend.iter().all(|(x, y)| (10..210).contains(x) && (100..391).contains(y));
    assert!(legend.len() > 2_000 && is_in_corner, "{} pixels", legend.len());
    let levels = screenshot("640x400", &["--levels"]);
    let strip = crop_imm(&levels, 0, 0, 210, 400).to_image();
    let parts = crop_imm(&levels, 210, 0, 430, 400).to_image();
    let alone = screenshot("430x400", &["--levels", "--no-legend"]);
    assert!(parts == alone, "the legend covers nothing of the levels");
    assert!(strip.pixels().any(|pixel| pixel != strip.get_pixel(0, 0)), "it is beside them");
    let [with, without] =
        [&["--levels"][..], &["--levels", "--no-legend"]].map(|args| screenshot("320x200", args));
    assert!(with == without, "a small picture has no legend");
}

/// The places of the pixels that differ.
fn differing(one: &RgbaImage, other: &RgbaImage) -> Vec<(u32, u32)> {
    let pixels = one.enumerate_pixels().zip(other.pixels());
    pixels.filter(|((_, _, a), b)| a != b).map(|((x, y, _), _)| (x, y)).collect()
}

fn a_recording(_: &Gpu) {
    let live = LiveFleet::start("recording");
    let folder = live.path("recording");
    let record = ["--record", &folder, "--fps", "10", "--for", "500ms"];
    live.view(&record);
    let error = live.try_view("320x200", &record).expect_err("a folder with pictures").to_string();
    assert!(error.ends_with("this exists; --force replaces it"), "{error}");
    for number in 0..5 {
        let picture =
            image::open(Path::new(&folder).join(format!("{number:06}.png"))).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (SIZE.x, SIZE.y));
    }
    assert_eq!(std::fs::read_dir(&folder).expect("the folder").count(), 5);
}

fn what_cannot_be_shown(_: &Gpu) {
    let live = LiveFleet::start("refused");
    let picture = live.path("refused.png");
    // Afterwards the fleet is past its first tick.
    live.view(&["--screenshot", &live.path("first.png")]);
    std::thread::sleep(Duration::from_millis(50));
    let refused = |args: &[&str]| {
        let error = live.try_view("320x200", args).expect_err("it is refused").to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    };
    let screenshot = |args: &[&str]| refused(&[&["--screenshot", &picture], args].concat());
    assert!(screenshot(&["--at", "0ms"]).contains("after --at"));
    assert!(screenshot(&["--follow", "12"]).contains("there is no robot 12"));
    assert!(screenshot(&["--select", "3,4000"]).contains("there is no robot 4000"));
    assert!(screenshot(&["--colour", "nobodys"]).contains("nobody publishes the column 'nobodys'"));
    for name in ["film.gif", "film.mkv", "film.MOV"] {
        let path = live.path(name);
        assert!(refused(&["--record", &path]).contains("ends in .mp4, or a folder"), "{name}");
        assert!(!Path::new(&path).exists());
    }
    assert!(refused(&["--screenshot", &live.path("shot.jpg")]).contains("ends in .png"));
    let command = Options::augment_args(clap::Command::new("viewer").no_binary_name(true));
    let absent =
        ["--headless", "--fleet", "nobody", "--screenshot", &picture, "--timeout", "200ms"];
    let options =
        Options::from_arg_matches(&command.try_get_matches_from(absent).expect("arguments"));
    let error = regatta_viewer::run(&options.expect("options")).expect_err("no fleet").to_string();
    assert!(error.contains("no frame of fleet 'nobody' within 200ms"), "{error}");
    assert!(!Path::new(&picture).exists());
}

fn a_full_memory(_: &Gpu) {
    // A device of its own, because others can't be used afterwards.
    let gpu = Gpu::software().expect("an adapter");
    let huge = || {
        texture(
            &gpu,
            UVec2::splat(16384),
            TextureFormat::Depth32Float,
            4,
            TextureUsages::RENDER_ATTACHMENT,
        )
    };
    assert!(gpu.allocate(huge).is_none());
    gpu.check_memory().expect("what was refused leaves the rest usable");
    // Neither the allocation nor the use of what it returns panics.
    drop(view_of(&huge()));
    let error = gpu.check_memory().expect_err("it is full").to_string();
    assert!(error.contains(&gpu.info.name) && !error.contains('\n'), "{error}");
}

fn a_picture_without_room(gpu: &Gpu) {
    let live = LiveFleet::start("room");
    let path = live.path("shot.png");
    let limit = gpu.device.limits().max_texture_dimension_2d;
    // With four samples per pixel this takes 11 GB, and its depth alone more than one allocation
    // may have.
    let error = live
        .try_view("16384x16384", &["--screenshot", &path, "--samples", "4"])
        .expect_err("no room");
    let message = error.to_string();
    assert!(
        message.contains("16384x16384") && message.contains("largest") && !message.contains('\n'),
        "{message}"
    );
    assert!(!Path::new(&path).exists());
    let target = TargetConfig::new(gpu, FORMAT, 4);
    let largest = match Offscreen::new(gpu, UVec2::splat(16384), target) {
        Err(PictureError::TooLarge { largest, .. }) => largest,
        other => panic!("{other:?}"),
    };
    assert!(
        largest.x == largest.y && message.contains(&format!("{0}x{0}", largest.x)),
        "{message}"
    );
    assert!(largest.x > 1000 && Offscreen::new(gpu, largest, target).is_ok(), "{largest}");
    let error =
        live.try_view("32768x8", &["--screenshot", &path]).expect_err("too wide").to_string();
    assert!(error.contains(&format!("{limit}x{}", limit * 8 / 32768)), "{error}");
}
