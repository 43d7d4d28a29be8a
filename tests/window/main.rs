//! The viewer's real window, on a screen in memory: Xvfb shows it, xdotool is the hands. Where these or a graphics
//! driver are missing, each test is named as ignored.

#[path = "../processes/fleet.rs"]
#[expect(dead_code, reason = "shared with other tests, which use more of it")]
mod fleet;
mod screen;

use std::process::{Command, ExitCode, Stdio};

use fleet::{Fleet, Process, eventually, graphs, regatta, unique};
use glam::{Vec2, Vec3};
use libtest_mimic::{Arguments, Trial};
use regatta_viewer::camera::Camera;
use regatta_viewer::gpu::device::Gpu;
use rustix::process::Signal;
use screen::{Look, Screen};

const TESTS: &[(&str, fn())] = &[
    ("a_window_is_turned_zoomed_resized_and_closed", a_window_is_turned_zoomed_resized_and_closed),
    ("a_click_picks_the_robot_that_is_there", a_click_picks_the_robot_that_is_there),
    ("a_viewer_outlives_its_engine_and_finds_the_next", a_viewer_outlives_its_engine_and_finds_the_next),
    ("a_run_starts_a_viewer_and_goes_on_when_it_is_closed", a_run_starts_a_viewer_and_goes_on_when_it_is_closed),
    ("a_run_that_insists_on_a_viewer_fails_without_a_display", a_run_that_insists_on_a_viewer_fails_without_a_display),
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let there = |program: &str| {
        Command::new(program).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
    };
    let able = there("Xvfb") && there("xdotool") && Gpu::offscreen().is_ok();
    let trial = |(name, test): &(&str, fn())| {
        let test = *test;
        let run = move || {
            test();
            Ok(())
        };
        Trial::test(*name, run).with_ignored_flag(!able).with_kind("needs Xvfb, xdotool and a graphics driver")
    };
    libtest_mimic::run(&arguments, TESTS.iter().map(trial).collect()).exit_code()
}

fn viewer(screen: &Screen, fleet: &regatta_plugin::FleetName, args: &[&str]) -> Process {
    let mut command = regatta();
    command.args(["viewer", "--fleet", &fleet.to_string()]).args(args);
    screen.dress(&mut command);
    Process::start(&mut command)
}

/// Closes the window by its key; the program must end well and without a word of panic.
fn close(screen: &Screen, viewer: Process) {
    screen.must(&["key", "ctrl+q"]);
    let output = viewer.finish();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !stderr.contains("panicked"), "{}: {stderr}", output.status);
}

fn a_window_is_turned_zoomed_resized_and_closed() {
    let screen = Screen::start();
    let fleet = Fleet::start("window", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let viewer = viewer(&screen, &fleet.name, &[]);
    let window = screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.look().colours() > 100).then_some(()));

    let changed = |what: &str, before: &Look| {
        eventually(what, || {
            let now = screen.still();
            (now.differing(before, 300..1000, 60..560) > 3000).then_some(now)
        })
    };
    let before = screen.still();
    screen.drag("1", (500, 400), (620, 340));
    let turned = changed("a left drag turns", &before);
    screen.must(&["mousemove", "700", "300"]);
    (0..5).for_each(|_| screen.must(&["click", "4"]));
    let zoomed = changed("the wheel zooms", &turned);
    screen.drag("3", (500, 400), (560, 300));
    let moved = changed("a right drag moves", &zoomed);
    screen.must(&["key", "Home"]);
    changed("Home shows all", &moved);

    // To nothing and back, and smaller: it goes on.
    for (width, height) in [("1", "1"), ("1100", "600"), ("321", "201"), ("900", "560")] {
        screen.must(&["windowsize", &window, width, height]);
        std::thread::sleep(std::time::Duration::from_millis(200));
    }
    screen.must(&["windowunmap", &window]);
    screen.must(&["windowmap", &window]);
    screen.must(&["windowfocus", &window]);
    eventually("it draws again", || (screen.look().colours() > 100).then_some(()));
    screen.must(&["key", "l"]);
    eventually("the light theme", || {
        let middle = screen.look();
        (middle.differing(&zoomed, 300..600, 100..400) > 50_000).then_some(())
    });
    close(&screen, viewer);
    let settings = screen.settings().expect("settings are kept");
    assert_eq!((settings["window"][0].as_f64(), settings["window"][1].as_f64()), (Some(900.0), Some(560.0)));
    assert_eq!(settings["light"], true);
}

fn a_click_picks_the_robot_that_is_there() {
    let screen = Screen::start();
    std::fs::create_dir_all(screen.settings_path().parent().expect("a folder")).expect("it is made");
    std::fs::write(screen.settings_path(), "{ no settings").expect("it is written");
    let fleet = Fleet::start("pick", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let mut subscriber = fleet.subscriber();
    let pose = eventually("a frame", || {
        let frame = subscriber.latest().ok()??;
        Some(Vec2::new(frame.x()[11], frame.y()[11]))
    });
    // From the south, twelve metres up; with settings that are broken, so that the usual ones hold: no panel is open.
    let eye = (pose - Vec2::new(0.0, 9.0)).extend(12.0);
    let (yaw, pitch) = (core::f32::consts::FRAC_PI_2, 0.9);
    let camera = Camera::at(eye, yaw, pitch);
    let text = format!("{},{},{},{yaw},{pitch}", eye.x, eye.y, eye.z);
    let viewer = viewer(&screen, &fleet.name, &["--camera", &text]);
    screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.look().colours() > 100).then_some(()));
    screen.still();
    let (top, bottom) = (42.0, 48.0);
    let size = Vec2::new(screen::SIZE.0 as f32, screen::SIZE.1 as f32 - top - bottom);
    let at = camera.project(Vec3::new(pose.x, pose.y, 0.15), size).expect("it is in sight") + Vec2::new(0.0, top);
    screen.must(&["mousemove", &(at.x.round() as i32).to_string(), &(at.y.round() as i32).to_string()]);
    screen.must(&["click", "1"]);
    let title = format!("{}, robot 11", fleet.name);
    eventually("the title names the robot", || screen.hand(&["search", "--name", &title]));
    close(&screen, viewer);
    assert_eq!(screen.settings().expect("good settings in place of the broken ones")["right"], "selection");
}

fn a_viewer_outlives_its_engine_and_finds_the_next() {
    let screen = Screen::start();
    let name = unique("again");
    let viewer = viewer(&screen, &name, &[]);
    screen.window(&format!("Regatta: {name}"));
    eventually("it waits", || (screen.look().colours() > 5).then_some(()));
    let fleet = Fleet::restart(name.clone(), "thirty.yaml", &[]);
    eventually("the fleet is drawn", || (screen.look().colours() > 100).then_some(()));
    fleet.engine.signal(Signal::KILL);
    drop(fleet);
    let fleet = Fleet::restart(name, "warehouse-1000.yaml", &["--robots", "10"]);
    let before = screen.look();
    eventually("the next fleet moves", || (screen.look().differing(&before, 100..1200, 60..640) > 20).then_some(()));
    screen.must(&["key", "space"]);
    eventually("the engine hears of it", || (fleet.status()["clock"] == "paused").then_some(()));
    close(&screen, viewer);
    assert!(fleet.status()["robots"] == 10);
}

fn a_run_starts_a_viewer_and_goes_on_when_it_is_closed() {
    let screen = Screen::start();
    let name = unique("run-viewer");
    let mut command = regatta();
    command.arg("run").arg(graphs("thirty.yaml")).args(["--fleet", &name.to_string()]);
    screen.dress(&mut command);
    let run = Process::start(&mut command);
    let window = screen.window(&format!("Regatta: {name}"));
    screen.must(&["key", "ctrl+q"]);
    eventually("the window closes", || screen.hand(&["getwindowname", &window]).is_none().then_some(()));
    let fleet_goes_on = || {
        let output = regatta().args(["status", "--fleet", &name.to_string()]).output().ok()?;
        output.status.success().then_some(())
    };
    eventually("the engine still answers", fleet_goes_on);
    let output = run.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn a_run_that_insists_on_a_viewer_fails_without_a_display() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = folder.path().join("insists.yaml");
    let text =
        format!("graph: {}\nrobots: [{{count: 1, routes: random}}]\nviewer: on\n", graphs("square.yaml").display());
    std::fs::write(&scenario, text).expect("it is written");
    let name = unique("insists");
    let output = regatta().arg("run").arg(&scenario).args(["--fleet", &name.to_string()]).output().expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && stderr.contains("no display"), "{stderr}");
}
