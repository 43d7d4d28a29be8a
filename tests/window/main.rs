//! The viewer's real window on a virtual display: Xvfb shows it, and xdotool sends the input. Where
//! these programs or a graphics driver are missing, each test is reported as ignored.

#[path = "../processes/fleet.rs"]
#[expect(dead_code, reason = "shared with other tests, which use more of it")]
mod fleet;
mod layers;
mod recording;
mod screen;
mod steering;

use std::process::{Command, ExitCode, Stdio};

use fleet::{Fleet, Process, eventually, graphs, regatta, unique};
use glam::{Vec2, Vec3};
use libtest_mimic::{Arguments, Trial};
use regatta_viewer::gpu::device::Gpu;
use regatta_viewer::scene::camera::Camera;
use rustix::process::Signal;
use screen::{Screen, Screenshot};

const TESTS: &[(&str, fn())] = &[
    ("a_window_is_turned_zoomed_resized_and_closed", a_window_is_turned_zoomed_resized_and_closed),
    ("a_click_selects_the_robot_under_the_pointer", a_click_selects_the_robot_under_the_pointer),
    (
        "a_second_robot_is_added_and_measured_after_a_panel_has_opened",
        a_second_robot_is_added_and_measured,
    ),
    (
        "a_viewer_survives_its_engine_and_finds_the_next",
        a_viewer_survives_its_engine_and_finds_the_next,
    ),
    (
        "a_file_that_cannot_be_loaded_is_reported_and_forgotten",
        a_file_that_cannot_be_loaded_is_reported_and_forgotten,
    ),
    (
        "a_film_shows_every_step_once_and_has_the_same_bytes_each_time",
        recording::a_film_shows_every_step_once_and_has_the_same_bytes_each_time,
    ),
    (
        "a_picture_at_a_time_between_two_frames_is_that_of_the_frame_before",
        recording::a_picture_at_a_time_between_two_frames_is_that_of_the_frame_before,
    ),
    ("a_plan_of_a_late_time_is_there_at_once", recording::a_plan_of_a_late_time_is_there_at_once),
    (
        "a_recording_is_scrubbed_stepped_and_greyed_after_its_replay",
        recording::a_recording_is_scrubbed_stepped_and_greyed_after_its_replay,
    ),
    (
        "an_edge_is_closed_and_a_robot_sent_broken_and_held_by_the_menu",
        steering::an_edge_is_closed_and_a_robot_sent_broken_and_held_by_the_menu,
    ),
    (
        "a_picture_is_saved_while_the_search_field_has_the_focus",
        a_picture_is_saved_while_the_search_field_has_the_focus,
    ),
    ("a_heat_map_is_shown_and_hidden", layers::a_heat_map_is_shown_and_hidden),
    (
        "a_recording_has_a_heat_map_without_another_program",
        layers::a_recording_has_a_heat_map_without_another_program,
    ),
    ("a_narrow_window_has_one_panel", layers::a_narrow_window_has_one_panel),
    ("a_click_goes_on_in_another_level", layers::a_click_goes_on_in_another_level),
    (
        "the_past_of_a_run_is_looked_at_while_it_goes_on",
        recording::the_past_of_a_run_is_looked_at_while_it_goes_on,
    ),
    ("the_end_of_the_display_is_one_line", the_end_of_the_display_is_one_line),
    (
        "a_run_opens_a_viewer_and_continues_without_it",
        a_run_opens_a_viewer_and_continues_without_it,
    ),
    (
        "a_run_that_requires_a_viewer_fails_without_a_display",
        a_run_that_requires_a_viewer_fails_without_a_display,
    ),
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let can_run = is_installed("Xvfb") && is_installed("xdotool") && Gpu::offscreen().is_ok();
    let mut trials = Vec::new();
    for &(name, test) in TESTS {
        let trial = Trial::test(name, move || {
            test();
            Ok(())
        });
        let needs = "needs Xvfb, xdotool and a graphics driver";
        trials.push(trial.with_ignored_flag(!can_run).with_kind(needs));
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn is_installed(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

fn viewer(screen: &Screen, fleet: &regatta_plugin::FleetName, args: &[&str]) -> Process {
    let mut command = regatta();
    command.args(["viewer", "--fleet", &fleet.to_string()]).args(args);
    screen.configure(&mut command);
    Process::start(&mut command)
}

/// Closes the window by its shortcut. The program must end successfully and without a panic.
/// Returns its messages.
fn close(screen: &Screen, viewer: Process) -> String {
    screen.xdotool(&["key", "ctrl+q"]);
    let output = viewer.finish();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !stderr.contains("panicked"), "{}: {stderr}", output.status);
    stderr
}

fn a_picture_is_saved_while_the_search_field_has_the_focus() {
    let screen = Screen::start();
    let fleet = Fleet::start("window-saved", "thirty.yaml", &[]);
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = regatta();
    command.args(["viewer", "--fleet", fleet.name.as_str()]).current_dir(folder.path());
    screen.configure(&mut command);
    let viewer = Process::start(&mut command);
    screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
    screen.xdotool(&["key", "ctrl+f"]);
    screen.xdotool(&["type", "robot"]);
    screen.xdotool(&["key", "ctrl+s"]);
    eventually("the picture is saved", || {
        let mut files = std::fs::read_dir(folder.path()).ok()?.filter_map(Result::ok);
        files.any(|file| file.path().extension().is_some_and(|end| end == "png")).then_some(())
    });
    close(&screen, viewer);
}

fn a_window_is_turned_zoomed_resized_and_closed() {
    let screen = Screen::start();
    let fleet = Fleet::start("window", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let viewer = viewer(&screen, &fleet.name, &[]);
    let window = screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));

    let changed = |what: &str, before: &Screenshot| {
        eventually(what, || {
            let now = screen.stable_screenshot();
            (now.differing(before, 300..1000, 60..560) > 3000).then_some(now)
        })
    };
    let before = screen.stable_screenshot();
    screen.drag("1", (500, 400), (620, 340));
    let turned = changed("a left drag orbits", &before);
    screen.xdotool(&["mousemove", "700", "300"]);
    (0..5).for_each(|_| screen.xdotool(&["click", "4"]));
    let zoomed = changed("the wheel zooms", &turned);
    screen.drag("3", (500, 400), (560, 300));
    let moved = changed("a right drag pans", &zoomed);
    screen.xdotool(&["key", "Home"]);
    changed("Home fits everything", &moved);

    // The window shrinks to almost nothing, and grows again.
    for (width, height) in [("1", "1"), ("1100", "600"), ("321", "201"), ("900", "560")] {
        screen.xdotool(&["windowsize", &window, width, height]);
        std::thread::sleep(std::time::Duration::from_millis(200));
    }
    screen.xdotool(&["windowunmap", &window]);
    screen.xdotool(&["windowmap", &window]);
    screen.xdotool(&["windowfocus", &window]);
    eventually("the fleet is drawn again", || (screen.screenshot().colours() > 100).then_some(()));
    screen.xdotool(&["key", "l"]);
    eventually("the light theme", || {
        let now = screen.screenshot();
        (now.differing(&zoomed, 300..600, 100..400) > 50_000).then_some(())
    });
    close(&screen, viewer);
    let settings = screen.settings().expect("settings are stored");
    assert_eq!(
        (settings["window"][0].as_f64(), settings["window"][1].as_f64()),
        (Some(900.0), Some(560.0))
    );
    assert_eq!(settings["light"], true);
}

fn a_click_selects_the_robot_under_the_pointer() {
    let screen = Screen::start();
    std::fs::create_dir_all(screen.settings_path().parent().expect("a folder"))
        .expect("it is made");
    std::fs::write(screen.settings_path(), "{ no settings").expect("it is written");
    let fleet = Fleet::start("pick", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let mut subscriber = fleet.subscriber();
    let pose = eventually("a frame", || {
        let frame = subscriber.latest().ok()??;
        Some(Vec2::new(frame.x()[11], frame.y()[11]))
    });
    // Seen from the south, twelve metres up. The settings file is broken, so that the defaults
    // hold: no panel is open.
    let eye = (pose - Vec2::new(0.0, 9.0)).extend(12.0);
    let (yaw, pitch) = (core::f32::consts::FRAC_PI_2, 0.9);
    let camera = Camera::from_eye(eye, yaw, pitch);
    let text = format!("{},{},{},{yaw},{pitch}", eye.x, eye.y, eye.z);
    let viewer = viewer(&screen, &fleet.name, &["--camera", &text]);
    screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
    screen.stable_screenshot();
    let (top, bottom) = (42.0, 48.0);
    let size = Vec2::new(screen::SIZE.0 as f32, screen::SIZE.1 as f32 - top - bottom);
    let at = camera.project(Vec3::new(pose.x, pose.y, 0.15), size).expect("it is in sight")
        + Vec2::new(0.0, top);
    screen.xdotool(&[
        "mousemove",
        &(at.x.round() as i32).to_string(),
        &(at.y.round() as i32).to_string(),
    ]);
    screen.xdotool(&["click", "1"]);
    let title = format!("{}, robot 11", fleet.name);
    eventually("the title names the robot", || screen.try_xdotool(&["search", "--name", &title]));
    close(&screen, viewer);
    assert_eq!(
        screen.settings().expect("valid settings replace the broken ones")["right"],
        "selection"
    );
}

/// The panel that the first click opens doesn't move the picture, so that a Ctrl-click on another
/// robot hits it.
fn a_second_robot_is_added_and_measured() {
    let screen = Screen::start();
    let fleet = Fleet::start("measure", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let mut subscriber = fleet.subscriber();
    let places = eventually("a frame", || {
        let frame = subscriber.latest().ok()??;
        Some(frame.x().iter().zip(frame.y()).map(|(x, y)| Vec2::new(*x, *y)).collect::<Vec<_>>())
    });
    let first = places[11];
    let others = (0..places.len()).filter(|robot| *robot != 11);
    let second =
        others.min_by(|a, b| places[*a].distance(first).total_cmp(&places[*b].distance(first)));
    let second = second.expect("another robot");
    let (middle, height) =
        ((first + places[second]) / 2.0, (places[second].distance(first) * 3.0).max(10.0));
    let view = format!("{},{},{height}", middle.x, middle.y);
    let viewer = viewer(&screen, &fleet.name, &["--camera", &view]);
    screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
    screen.stable_screenshot();
    let size = Vec2::new(screen::SIZE.0 as f32, screen::SIZE.1 as f32 - 42.0 - 48.0);
    let camera = Camera::plan_around(middle, height);
    let pixel = |place: Vec2| {
        camera.project(place.extend(0.0), size).expect("in sight") + Vec2::new(0.0, 42.0)
    };
    let move_to = |place: Vec2| {
        let at = pixel(place).round().as_ivec2();
        screen.xdotool(&["mousemove", &at.x.to_string(), &at.y.to_string()]);
    };
    let titled = |robot: usize| {
        let title = format!("{}, robot {robot}$", fleet.name);
        eventually("the title names the robot", || {
            screen.try_xdotool(&["search", "--name", &title])
        });
    };
    move_to(first);
    screen.xdotool(&["click", "1"]);
    titled(11);
    screen.stable_screenshot();
    move_to(places[second]);
    screen.xdotool(&["keydown", "ctrl", "click", "1", "keyup", "ctrl"]);
    titled(second);
    // The measured line is drawn between the two robots.
    screen.xdotool(&["key", "m"]);
    let before = screen.stable_screenshot();
    for place in [first, places[second]] {
        move_to(place);
        screen.xdotool(&["click", "1"]);
        screen.stable_screenshot();
    }
    let at = pixel(middle).as_uvec2();
    let (x, y) = (at.x as usize, at.y as usize);
    let changed = screen.screenshot().differing(&before, x - 30..x + 30, y - 30..y + 30);
    assert!(changed > 100, "{changed} pixels between the robots");
    close(&screen, viewer);
}

/// While pictures are drawn, and while the window waits for events.
fn the_end_of_the_display_is_one_line() {
    for (test, is_paused) in [("gone", false), ("gone-paused", true)] {
        let mut screen = Screen::start();
        let fleet = Fleet::start(test, "thirty.yaml", &[]);
        if is_paused {
            fleet.control(&["pause"]);
        }
        let viewer = viewer(&screen, &fleet.name, &[]);
        screen.window(&format!("Regatta: {}", fleet.name));
        eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
        if is_paused {
            screen.stable_screenshot();
        }
        let process = viewer.0.id();
        screen.kill();
        let output = viewer.finish();
        let messages = String::from_utf8_lossy(&output.stderr).into_owned();
        let told: Vec<_> = messages.lines().filter(|line| line.starts_with("regatta: ")).collect();
        assert_eq!(output.status.code(), Some(1), "{messages}");
        assert_eq!(
            told,
            ["regatta: the display has gone; --headless draws pictures without one"],
            "{messages}"
        );
        assert!(!messages.contains("panicked"), "{messages}");
        let doctor = regatta().arg("doctor").output().expect("it starts");
        let doctor = String::from_utf8_lossy(&doctor.stdout).into_owned();
        assert!(
            !doctor.contains(&format!("(regatta {process},")),
            "it leaves nothing behind: {doctor}"
        );
    }
}

fn a_viewer_survives_its_engine_and_finds_the_next() {
    let screen = Screen::start();
    let name = unique("again");
    let viewer = viewer(&screen, &name, &[]);
    screen.window(&format!("Regatta: {name}"));
    eventually("the viewer waits", || (screen.screenshot().colours() > 5).then_some(()));
    let fleet = Fleet::restart(name.clone(), "thirty.yaml", &[]);
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
    fleet.engine.signal(Signal::KILL);
    drop(fleet);
    let fleet = Fleet::restart(name, "warehouse-1000.yaml", &["--robots", "10"]);
    let before = screen.screenshot();
    eventually("the next fleet moves", || {
        (screen.screenshot().differing(&before, 100..1200, 60..640) > 20).then_some(())
    });
    screen.xdotool(&["key", "space"]);
    eventually("the engine is paused", || (fleet.status()["clock"] == "paused").then_some(()));
    close(&screen, viewer);
    assert!(fleet.status()["robots"] == 10);
}

fn a_file_that_cannot_be_loaded_is_reported_and_forgotten() {
    let screen = Screen::start();
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.display().to_string()
    };
    // Its one primitive names an accessor that doesn't exist.
    let broken = file(
        "broken.gltf",
        r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":3}}]}]}"#,
    );
    let good = file("good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let store = |mesh: &str| {
        std::fs::create_dir_all(screen.settings_path().parent().expect("a folder")).expect("made");
        let settings = serde_json::json!({
            "light": true, "floor_image": "/no/such/map.yaml", "mesh": { "file": mesh, "scale": 1.0, "z": 0.0 }
        });
        std::fs::write(screen.settings_path(), settings.to_string()).expect("written");
    };
    let fleet = Fleet::start("broken", "thirty.yaml", &[]);
    let show = |args: &[&str]| {
        let viewer = viewer(&screen, &fleet.name, args);
        screen.window(&format!("Regatta: {}", fleet.name));
        eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
        let messages = close(&screen, viewer);
        (messages, screen.settings().expect("settings are stored"))
    };
    store(&broken);
    let (messages, settings) = show(&[]);
    assert!(messages.contains(&broken) && messages.contains("/no/such/map.yaml"), "{messages}");
    let kept = (&settings["light"], &settings["mesh"], &settings["floor_image"]);
    assert_eq!(kept, (&true.into(), &serde_json::Value::Null, &"".into()));
    // The settings file keeps what is good, whatever is on the command line.
    store(&good);
    let (messages, settings) = show(&["--mesh", &broken]);
    assert!(messages.contains(&broken), "{messages}");
    assert_eq!(settings["mesh"]["file"], good.as_str());
}

fn a_run_opens_a_viewer_and_continues_without_it() {
    let screen = Screen::start();
    let name = unique("run-viewer");
    let mut command = regatta();
    command.arg("run").arg(graphs("thirty.yaml")).args(["--fleet", &name.to_string()]);
    screen.configure(&mut command);
    let run = Process::start(&mut command);
    let window = screen.window(&format!("Regatta: {name}"));
    screen.xdotool(&["key", "ctrl+q"]);
    eventually("the window closes", || {
        screen.try_xdotool(&["getwindowname", &window]).is_none().then_some(())
    });
    let engine_answers = || {
        let output = regatta().args(["status", "--fleet", &name.to_string()]).output().ok()?;
        output.status.success().then_some(())
    };
    eventually("the engine still answers", engine_answers);
    let output = run.interrupt();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn a_run_that_requires_a_viewer_fails_without_a_display() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = folder.path().join("requires.yaml");
    let text = format!(
        "graph: {}\nrobots: [{{count: 1, routes: random}}]\nviewer: on\n",
        graphs("square.yaml").display()
    );
    std::fs::write(&scenario, text).expect("it is written");
    let name = unique("requires");
    let output = regatta()
        .arg("run")
        .arg(&scenario)
        .args(["--fleet", &name.to_string()])
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && stderr.contains("no display"), "{stderr}");
}
