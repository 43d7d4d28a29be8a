//! Recordings in the viewer: the timeline in its window, and films in simulated time.

use std::path::{Path, PathBuf};
use std::time::Duration;

use regatta_plugin::{Control, FleetName};
use rustix::process::Signal;
use tempfile::TempDir;

use crate::fleet::{Fleet, Process, eventually, graphs, regatta, unique};
use crate::screen::Screen;
use crate::{close, screen};

/// Records this many ticks of thirty robots for a test, and returns the file.
pub fn record(test: &str, folder: &TempDir, ticks: u32) -> PathBuf {
    let (file, fleet) = (folder.path().join("run.mcap"), unique(test).to_string());
    let mut engine = regatta();
    engine.arg("engine").arg(graphs("thirty.yaml")).args(["--fleet", &fleet, "--speed", "max"]);
    engine.args(["--lockstep", "recorder", "--ticks", &ticks.to_string()]);
    let mut recorder = regatta();
    recorder.args(["record", "--fleet", &fleet, "--name", "recorder", "-o"]).arg(&file);
    let (engine, recorder) = (Process::start(&mut engine), Process::start(&mut recorder));
    assert!(engine.finish().status.success());
    assert!(recorder.interrupt().status.success());
    file
}

/// Films the second from 0.5 s on into a folder, and returns the pictures' files.
fn film(recording: &Path, folder: &Path) -> Vec<Vec<u8>> {
    let mut command = regatta();
    command.arg("viewer").arg(recording).arg("--film").arg(folder);
    command.args(["--fps", "10", "--from", "500ms", "--to", "1500ms", "--size", "480x270"]);
    command.args(["--plans", "--waits", "--title", "Thirty", "--clock", "--scale"]);
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut files: Vec<_> =
        folder.read_dir().expect("a folder").map(|entry| entry.expect("a file").path()).collect();
    files.sort();
    files.into_iter().map(|file| std::fs::read(file).expect("readable")).collect()
}

pub fn a_film_shows_every_step_once_and_has_the_same_bytes_each_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = record("film", &folder, 200);
    let first = film(&file, &folder.path().join("first"));
    assert_eq!(first.len(), 11, "ten steps of a tenth of a second");
    assert!(first.windows(2).all(|pair| pair[0] != pair[1]), "no picture is repeated");
    assert!(first == film(&file, &folder.path().join("second")), "the same bytes");
}

pub fn a_picture_at_a_time_between_two_frames_is_that_of_the_frame_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = record("between-frames", &folder, 200);
    let picture = |at: &str| {
        let path = folder.path().join(format!("{at}.png"));
        let mut command = regatta();
        command
            .arg("viewer")
            .arg(&file)
            .args(["--headless", "--size", "480x270", "--at", at, "--screenshot"])
            .arg(&path);
        (command.output().expect("it starts"), path)
    };
    let pictures = ["1s", "1003ms"].map(|at| {
        let (output, path) = picture(at);
        assert!(output.status.success(), "{at}: {}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(path).expect("a picture")
    });
    assert!(pictures[0] == pictures[1], "the same frame");
    let (late, _) = picture("1h");
    assert!(!late.status.success(), "the recording ends before");
}

/// Waiting until then would take twice as long as a test may.
pub fn a_plan_of_a_late_time_is_there_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = record("plan-at", &folder, 12_001);
    let plan = folder.path().join("plan.svg");
    let mut command = regatta();
    command.arg("viewer").arg(&file).args(["--at", "2min", "--svg"]).arg(&plan);
    let output = Process::start(&mut command).finish();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(plan).expect("a plan");
    assert!(text.contains("<title>run.mcap, 120.00 s, 30 robots</title>"), "{}", &text[..400]);
}

pub fn a_recording_is_scrubbed_stepped_and_greyed_after_its_replay() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = record("scrubbed", &folder, 1000);
    std::fs::write(folder.path().join("run.mcap.notes"), "2.5 half way\nnonsense\n")
        .expect("written");
    let screen = Screen::start();
    let mut command = regatta();
    command.arg("viewer").arg(&file);
    screen.configure(&mut command);
    let viewer = Process::start(&mut command);
    screen.window("Regatta: run.mcap");
    let fleet: FleetName = format!("recording-{}", viewer.0.id()).parse().expect("a name");
    let mut control = eventually("the replay answers", || {
        let mut control = Control::open(&fleet).ok()?;
        control.status().ok().map(|_| control)
    });
    screen.xdotool(&["key", "space"]);
    eventually("the replay stands", || control.status().ok().filter(|status| status.clock == 1));
    // The bar goes from 12 points after the left edge to as many before the right one.
    let (left, right, y) = (12.0, screen::SIZE.0 as f64 - 12.0, "650");
    for (part, seconds) in [(0.8, 8.0), (0.25, 2.5), (0.5, 5.0)] {
        let x = (left + (right - left) * part) as u32;
        let before = screen.screenshot();
        // A click before the bar is drawn goes to the scene: so there may be several.
        eventually("the replay is there", || {
            screen.xdotool(&["mousemove", &x.to_string(), y, "click", "1", "sleep", "0.3"]);
            let status = control.status().ok()?;
            let found = Duration::from_nanos(status.sim_time_nanos).as_secs_f64();
            ((found - seconds).abs() < 0.02).then_some(())
        });
        eventually("another picture", || {
            (screen.screenshot().differing(&before, 100..1200, 60..600) > 100).then_some(())
        });
    }
    let tick = control.status().expect("it answers").tick;
    screen.xdotool(&["key", "comma"]);
    eventually("one back", || control.status().ok().filter(|status| status.tick == tick - 1));
    screen.xdotool(&["key", "period"]);
    eventually("one on", || control.status().ok().filter(|status| status.tick == tick));
    screen.xdotool(&["key", "z"]);
    eventually("the note", || {
        control.status().ok().filter(|status| status.sim_time_nanos == 2_500_000_000)
    });
    // A note at the shown time, which is a mark from then on.
    screen.xdotool(&["key", "period", "sleep", "0.3"]);
    let noted = control.status().expect("it answers").sim_time_nanos;
    screen.xdotool(&["key", "shift+n", "sleep", "0.5", "type", "--delay", "80", "jam here"]);
    screen.xdotool(&["sleep", "0.3", "key", "Return"]);
    let text = eventually("the note is in the file", || {
        let text = std::fs::read_to_string(folder.path().join("run.mcap.notes")).ok()?;
        text.contains("jam here").then_some(text)
    });
    assert!(text.starts_with("2.5 half way\n") && text.ends_with(" jam here\n"), "{text}");
    screen.xdotool(&["sleep", "1", "key", "z"]);
    eventually("the mark before", || {
        control.status().ok().filter(|status| status.sim_time_nanos == 2_500_000_000)
    });
    screen.xdotool(&["key", "x"]);
    eventually("the new mark", || {
        control.status().ok().filter(|status| status.sim_time_nanos == noted)
    });
    let before = screen.stable_screenshot();
    let replay = control.status().expect("it answers").pid;
    let replay = rustix::process::Pid::from_raw(replay as i32).expect("an id");
    rustix::process::kill_process(replay, Signal::TERM).expect("it runs");
    eventually("the scene is greyed", || {
        (screen.screenshot().differing(&before, 100..1200, 60..600) > 400_000).then_some(())
    });
    let messages = close(&screen, viewer);
    assert!(messages.contains("run.mcap.notes:2: not a note"), "{messages}");
}

pub fn the_past_of_a_run_is_looked_at_while_it_goes_on() {
    let screen = Screen::start();
    let fleet = Fleet::start("past", "thirty.yaml", &[]);
    let viewer = crate::viewer(&screen, &fleet.name, &[]);
    screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
    let scene = (100..1200, 60..560);
    let moves = || {
        let before = screen.screenshot();
        fleet.let_ticks_pass(100);
        screen.screenshot().differing(&before, scene.0.clone(), scene.1.clone()) > 20
    };
    assert!(moves(), "the robots move");
    screen.xdotool(&["key", "u"]);
    // Labels and the hint at the pointer may need some pictures; then the past stands, and the run
    // doesn't.
    eventually("the past stands", || {
        screen.xdotool(&["mousemove", "200", "655", "click", "1", "sleep", "0.3"]);
        (!moves()).then_some(())
    });
    screen.xdotool(&["key", "u"]);
    eventually("the robots move again", || moves().then_some(()));
    close(&screen, viewer);
}
