//! Windows in which much lies over the picture, or in which texts are long.

use std::sync::LazyLock;
use std::time::Duration;

use egui::Key;
use glam::Vec2;
use regatta_interface::camera_controller::CameraController;
use regatta_interface::jams::{Spot, Trend};
use regatta_interface::log::{AlarmChange, AlarmKey, Entry, Kind, LogReport, Place, Severity};
use regatta_interface::measure::End;
use regatta_interface::settings::LeftPanel;
use regatta_interface::view_model::{EngineState, Live, Timeline};
use regatta_plugin::contact::ContactHeader;
use regatta_plugin::history::FleetSample;
use regatta_plugin::recording::{MarkKind, RecordingMark};
use regatta_plugin::work::WorkFigures;
use regatta_scene::heat::HeatFacts;
use regatta_scene::palette::{Colouring, Theme};

use crate::checks::{check, check_panels, check_placed, check_texts};
use crate::fixture::{Fixture, USUAL, harness_of, windows};

/// The state before the first picture, the keys that are pressed then, and the elements over the
/// picture if there is room.
pub struct State {
    pub name: &'static str,
    pub prepare: fn(&mut Fixture),
    pub keys: &'static [Key],
    placed: &'static [&'static str],
}

pub const STATES: [State; 12] = [
    State { name: "warming up", prepare: warming_up, keys: &[], placed: &["warming up"] },
    State {
        name: "plots",
        prepare: plots,
        keys: &[],
        placed: &["legend", "view cube", "coordinates"],
    },
    State {
        name: "heat map",
        prepare: heat,
        keys: &[],
        placed: &["legend", "view cube", "coordinates"],
    },
    State {
        name: "plan",
        prepare: plan,
        keys: &[],
        placed: &["measurement", "legend", "scale bar", "north", "minimap", "coordinates"],
    },
    State {
        name: "minimap",
        prepare: minimap,
        keys: &[],
        placed: &["legend", "view cube", "minimap"],
    },
    State { name: "recording", prepare: recording, keys: &[], placed: &["legend", "view cube"] },
    State { name: "past", prepare: past, keys: &[Key::U], placed: &["legend", "view cube"] },
    State {
        name: "ended",
        prepare: ended,
        keys: &[],
        placed: &["ended", "messages", "legend", "coordinates"],
    },
    State { name: "hot spots", prepare: hot_spots, keys: &[], placed: &["legend"] },
    State { name: "log", prepare: log, keys: &[], placed: &["legend"] },
    State { name: "work", prepare: work, keys: &[], placed: &["legend", "view cube"] },
    State { name: "help", prepare: minimap, keys: &[Key::F1], placed: &[] },
];

fn warming_up(fixture: &mut Fixture) {
    fixture.engine = EngineState::WarmingUp(Duration::from_secs(86_399));
}

/// The figures of a fleet at work, with long numbers.
fn work(fixture: &mut Fixture) {
    let figures = WorkFigures {
        secs: 86_400.0,
        finished: 1_234_567,
        open: 12_345,
        orders_per_hour: 123_456.0,
        service_p50_secs: 123.0,
        service_p99_secs: 9_876.0,
        waiting: 0.333,
        busy: 12_345,
        robots: 100_000,
        ..WorkFigures::default()
    };
    fixture.work = Some((fixture.header.run_id, figures));
}

pub fn plots(fixture: &mut Fixture) {
    fixture.interface.settings.plots = true;
    let sample = |second: u32| FleetSample {
        secs: f64::from(second),
        activities: [0, 12_345 - second, 7, 8, second, 40, 2, 3, 4, 1_234, 12, 3, 5],
        touching: 1_234,
        throughput: 12_345.0,
        mean_speed: 0.75,
    };
    fixture.jams.series = (0..=800).map(sample).collect();
}

/// The longest legend.
fn heat(fixture: &mut Fixture) {
    fixture.legend = Colouring::State.legend(Theme::Dark, &[], None);
    let settings = &mut fixture.interface.settings;
    (settings.plans, settings.waits, settings.heat) = (true, true, true);
    settings.heat_of = "contacts:10min".parse().expect("a heat map");
    let heat = settings.heat_of;
    let (ends, has_contacts, has_routes) = ([0.0, 50.0], false, false);
    let facts = HeatFacts {
        heat,
        ends,
        is_exceeded: true,
        edges: 12,
        secs: 648.0,
        has_contacts,
        has_routes,
    };
    fixture.jams.heat = Some(facts);
}

fn plan(fixture: &mut Fixture) {
    let interface = &mut fixture.interface;
    interface.camera_controller = CameraController::plan();
    interface.settings.minimap = true;
    interface.measure_to(End::Place(Vec2::new(1.0, 2.0)));
    interface.measure_to(End::Place(Vec2::new(4.0, 6.0)));
}

fn minimap(fixture: &mut Fixture) {
    fixture.interface.settings.minimap = true;
}

static MARKS: LazyLock<Vec<RecordingMark>> = LazyLock::new(|| {
    let mark = |kind: MarkKind| RecordingMark {
        time_nanos: 9,
        kind: kind as u32,
        count: 1,
        ..RecordingMark::default()
    };
    vec![mark(MarkKind::Contact), mark(MarkKind::Note)]
});

pub fn recording(fixture: &mut Fixture) {
    fixture.timeline = Some(Timeline {
        name: "the-morning-shift-of-the-first-day-of-the-trial.mcap",
        note: "here two of them meet at the dock, and neither can go on",
        start: 0,
        end: 36_000_000_000_000,
        now: Some(18_000_000_000_000),
        searched: 20_000_000_000_000,
        left_out: 12_345,
        marks: &MARKS,
        live: None,
    });
}

/// The past of a live run, which goes on.
pub fn past(fixture: &mut Fixture) {
    recording(fixture);
    let live = Some(Live { bytes: 200 << 20, is_past: true });
    fixture.timeline =
        fixture.timeline.map(|timeline| Timeline { marks: &[], note: "", live, ..timeline });
}

fn ended(fixture: &mut Fixture) {
    fixture.engine = EngineState::Gone;
    fixture.header.sim_time_nanos = 36_123_000_000_000;
    fixture.interface.notify("the plan is in regatta-a-fleet-with-a-long-name-36123.00s.svg");
}

fn hot_spots(fixture: &mut Fixture) {
    fixture.interface.settings.left = Some(LeftPanel::Spots);
    let spot = |number: u32| Spot {
        place: Vec2::new(number as f32, 3.0),
        contact_secs: 1_234_567.0,
        standing_secs: 10.0,
        seen: [36_000.0, 90_000.0],
        edges: vec![0],
        trend: Trend::Growing,
    };
    fixture.jams.spots = (0..120).map(spot).collect();
}

/// Forty alarms, the texts of which are longer than a row.
pub fn log(fixture: &mut Fixture) {
    log_of(fixture, 40);
}

/// Some such alarms.
pub fn log_of(fixture: &mut Fixture, alarms: u32) {
    let alarm = |robot: u32| {
        let text =
            format!("robot {robot} broke down far away from everything that is near to anybody");
        let entry = Entry {
            time_nanos: 1,
            kind: Kind::Fault,
            severity: Severity::Alarm,
            robot: Some(robot),
            place: Place::None,
            text,
        };
        (entry, AlarmChange::Begins(AlarmKey::Robot(robot)))
    };
    fixture.interface.settings.left = Some(LeftPanel::Log);
    fixture
        .interface
        .log()
        .take(LogReport { news: (0..alarms).map(alarm).collect(), ..LogReport::default() });
}

#[test]
fn nothing_lies_over_anything_else_in_any_state() {
    for State { name, prepare, keys, placed } in STATES {
        for (size, scale) in windows() {
            let mut harness = harness_of(size, scale, prepare);
            keys.iter().for_each(|key| harness.key_press(*key));
            harness.run_steps(6);
            let what = format!("{name}, {size:?} at {scale}");
            check_placed(&harness, &what);
            check_texts(&harness, &what);
            match harness.state().interface.settings.left {
                Some(_) => _ = check_panels(&harness, size, &what),
                None => check(&harness, size, &what),
            }
            // A large window has room for all.
            let is_large = (size, scale) == (USUAL, 1.0) || size[0] > USUAL[0];
            let shown: Vec<_> =
                harness.state().interface.placed().iter().map(|(name, _)| *name).collect();
            assert!(
                !is_large || placed.iter().all(|name| shown.contains(name)),
                "{what}: {shown:?}"
            );
        }
    }
}

#[test]
fn the_least_important_elements_are_left_out_where_there_is_no_room() {
    let small = harness_of([640.0, 400.0], 1.5, |fixture| {
        ended(fixture);
        plan(fixture);
        plots(fixture);
    });
    let shown: Vec<_> = small.state().interface.placed().iter().map(|(name, _)| *name).collect();
    assert!(!shown.contains(&"legend") && !shown.contains(&"minimap"), "{shown:?}");
    let window = harness_of([640.0, 400.0], 1.0, |fixture| {
        ended(fixture);
        plan(fixture);
    });
    let shown: Vec<_> = window.state().interface.placed().iter().map(|(name, _)| *name).collect();
    assert!(shown.starts_with(&["ended", "messages", "measurement"]), "{shown:?}");
}

#[test]
fn large_numbers_are_not_broken_in_panels() {
    for (size, scale) in windows() {
        let harness = harness_of(size, scale, |fixture| {
            fixture.interface.settings.left = Some(LeftPanel::Collisions);
            let [touching_ever, possible_ever] = [1_234_567_890; 2];
            fixture.contacts =
                Some(ContactHeader { touching_ever, possible_ever, ..ContactHeader::default() });
        });
        check_texts(&harness, &format!("collisions, {size:?} at {scale}"));
    }
}
