//! The layers of the window besides robots: the heat map, panels in a narrow window, and levels
//! side by side.

use regatta_viewer::scene::palette::{Rgb, Theme, heat_ramp};

use crate::fleet::{Fleet, Process, eventually, regatta};
use crate::recording::record;
use crate::screen::{SIZE, Screen};
use crate::{close, viewer};

/// Red, green and blue.
fn bytes(colour: Rgb) -> [u8; 3] {
    let [_, rgb @ ..] = colour.0.to_be_bytes();
    rgb
}

pub fn a_heat_map_is_shown_and_hidden() {
    let screen = Screen::start();
    let fleet = Fleet::start("heat-window", "thirty.yaml", &["--speed", "5"]);
    let traffic = fleet.plugin("traffic");
    let viewer = viewer(&screen, &fleet.name, &["--heat", "occupancy"]);
    screen.window(&format!("Regatta: {}", fleet.name));
    let ramp = heat_ramp(Theme::Dark).map(bytes);
    // Beside the legend, which has the ramp, too.
    let hot = || screen.screenshot().like(&ramp, 220..SIZE.0, 60..640);
    for _ in 0..2 {
        eventually("edges have the colours of the heat map", || (hot() > 1_000).then_some(()));
        screen.xdotool(&["key", "shift+h"]);
        eventually("edges have their own colours", || (hot() < 100).then_some(()));
        screen.xdotool(&["key", "shift+h"]);
    }
    eventually("edges have the colours of the heat map", || (hot() > 1_000).then_some(()));
    traffic.interrupt();
    eventually("without figures, edges have their own colours", || (hot() < 100).then_some(()));
    close(&screen, viewer);
}

pub fn a_recording_has_a_heat_map_without_another_program() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = record("heat-recording", &folder, 400);
    let ramp = heat_ramp(Theme::Dark).map(bytes);
    // Pictures: of what is before them, and each time the same.
    let picture = |name: &str, args: &[&str]| {
        let path = folder.path().join(name);
        let mut command = regatta();
        command.arg("viewer").arg(&file).args([
            "--headless",
            "--no-legend",
            "--at",
            "3s",
            "--size",
            "640x360",
        ]);
        let output = command.args(args).arg("--screenshot").arg(&path).output().expect("it starts");
        let messages = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !messages.contains("nobody publishes"), "{messages}");
        std::fs::read(path).expect("readable")
    };
    let hot = picture("hot.png", &["--heat", "occupancy:minute"]);
    assert!(picture("again.png", &["--heat", "occupancy:minute"]) == hot, "the same bytes");
    assert!(picture("cold.png", &[]) != hot, "edges without a heat map");

    // The window: of what is played.
    let screen = Screen::start();
    let mut command = regatta();
    command.arg("viewer").arg(&file).args(["--heat", "occupancy"]);
    screen.configure(&mut command);
    let viewer = Process::start(&mut command);
    screen.window("Regatta: run.mcap");
    let hot = || screen.screenshot().like(&ramp, 220..SIZE.0, 60..600);
    eventually("edges have the colours of the heat map", || (hot() > 1_000).then_some(()));
    close(&screen, viewer);
}

pub fn a_narrow_window_has_one_panel() {
    let screen = Screen::start();
    let fleet = Fleet::start("narrow", "thirty.yaml", &[]);
    fleet.control(&["pause"]);
    let viewer = viewer(&screen, &fleet.name, &[]);
    let window = screen.window(&format!("Regatta: {}", fleet.name));
    eventually("the fleet is drawn", || (screen.screenshot().colours() > 100).then_some(()));
    screen.xdotool(&["windowsize", &window, "640", "400"]);
    screen.stable_screenshot();
    let panel = [[0x10, 0x15, 0x1b]];
    let is_covered = |[from, to]: [usize; 2]| {
        screen.screenshot().like(&panel, from..to, 60..280) > 100 * (to - from)
    };
    let (left, right) = ([10, 200], [440, 630]);
    assert!(!is_covered(left) && !is_covered(right), "no panel is open");
    screen.xdotool(&["key", "1"]);
    eventually("a panel opens on the left", || {
        (is_covered(left) && !is_covered(right)).then_some(())
    });
    screen.xdotool(&["key", "4"]);
    eventually("one on the right takes its place", || {
        (!is_covered(left) && is_covered(right)).then_some(())
    });
    close(&screen, viewer);
    let settings = screen.settings().expect("settings are stored");
    assert_eq!((&settings["left"], &settings["right"]), (&serde_json::Value::Null, &"view".into()));
}

pub fn a_click_goes_on_in_another_level() {
    let screen = Screen::start();
    let fleet =
        Fleet::start("levels-window", "imported/open-rmf/hotel.building.yaml", &["--robots", "20"]);
    let viewer = viewer(&screen, &fleet.name, &["--levels"]);
    screen.window(&format!("Regatta: {}", fleet.name));
    // The left edge of the frame round the current one of three levels side by side.
    let accent = [[0x56, 0xb4, 0xe9]];
    let left_edge = || {
        let picture = screen.screenshot();
        (0..SIZE.0 - 2).find(|x| picture.like(&accent, *x..x + 2, 100..600) > 400)
    };
    let first = eventually("the first level is the current one", left_edge);
    let at_third = (SIZE.0 - 200).to_string();
    screen.xdotool(&["mousemove", &at_third, "300", "click", "1"]);
    eventually("the third one is", || left_edge().filter(|x| *x > first + SIZE.0 / 2));
    close(&screen, viewer);
}
