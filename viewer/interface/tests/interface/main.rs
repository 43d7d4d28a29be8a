//! The interface, driven as a user drives it: egui_kittest clicks, types and presses keys; the view
//! model is made up.

mod fleet;
mod jams;
mod levels;
mod log;
mod panels;
mod picture;
mod steering;
mod timeline;

use egui::{Key, Modifiers, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::Vec2;
use regatta_interface::Interface;
use regatta_interface::camera_controller::{CameraController, Follow};
use regatta_interface::commands::UserCommand;
use regatta_interface::jams::{EdgeFacts, JamFacts, Known, Presence, Spot, Trend};
use regatta_interface::labels::Labels;
use regatta_interface::log::{
    AlarmChange, AlarmKey, Entry, FleetLog, Kind, LogLosses, LogReport, MAX_ALARMS, Place, Severity,
};
use regatta_interface::orders::{NamedOrder, RobotOrder, Stop};
use regatta_interface::performance::Timing;
use regatta_interface::robot_filter::{Filter, MatchCounts, Matches, RobotSet};
use regatta_interface::rows::{RowQuery, Rows, SortBy};
use regatta_interface::settings::{LeftPanel, RightPanel, Settings};
use regatta_interface::view_model::{
    Action, Counts, EngineState, Item, Live, RunningUdp, Timeline, ViewModel,
};
use regatta_plugin::activity::Activity;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::control::{ControlKind, ControlResponse};
use regatta_plugin::frame::{
    ClockState, ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines,
};
use regatta_plugin::history::FleetSample as Sample;
use regatta_plugin::order::StopAction;
use regatta_plugin::recording::{MarkKind, RecordingMark};
use regatta_plugin::traffic::EdgeTraffic;
use regatta_plugin::work::WorkFigures;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, Role, StationRecord, WorldData};
use regatta_plugin::{Contacts, Frame};
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::heat::{Heat, HeatFacts};
use regatta_scene::palette::{Colouring, Legend, Theme};
use regatta_scene::plans::{Coverage, PlanFacts, Waiting};
use regatta_scene::route::{Remaining, RouteLength};

/// A fleet of robots in a row, and the interface that shows it.
struct Fixture {
    interface: Interface,
    header: FrameHeader,
    lines: Vec<Line>,
    world: WorldData,
    labels: Labels,
    pairs: Vec<ContactRecord>,
    route: Option<Remaining>,
    plans: PlanFacts,
    closed: Vec<u32>,
    jams: JamFacts,
    activities: Vec<f32>,
    values: Vec<(&'static str, f32)>,
    order: Option<RobotOrder>,
    named_order: Option<NamedOrder>,
    matches: Option<Matches>,
    rows: Option<Rows>,
    status: Option<ControlResponse>,
    engine: EngineState,
    work: Option<(u64, WorkFigures)>,
    timing: Timing,
    legend: Legend,
    actions: Vec<Action>,
    /// The place of the picture, in points.
    picture: egui::Rect,
    /// The marks of a recording of ten seconds, and its time, in seconds.
    recording: Option<(Vec<RecordingMark>, f64)>,
    is_past: bool,
}

/// The robots of a fleet that match a filter, none of which is on the filter's level if there is a
/// level.
fn matches(fixture: &Fixture, robots: &[u32], has_level: bool) -> Matches {
    let all = fixture.header.robots;
    let mut matching = RobotSet::new(all as usize);
    robots.iter().for_each(|robot| matching.insert(*robot));
    let number = robots.len() as u32;
    Matches {
        matching: Some(matching),
        on_level: has_level.then(|| RobotSet::new(all as usize)),
        counts: MatchCounts { matching: number, on_level: if has_level { 0 } else { number }, all },
    }
}

/// An edge between two nodes.
fn world() -> WorldData {
    let mut world = WorldData::default();
    let (name, level) = (world.texts.add("dock 1"), world.texts.add("ground floor"));
    world.nodes = vec![
        NodeRecord { id: 7, x: 1.0, y: 2.0, name, level, ..NodeRecord::default() },
        NodeRecord { id: 8, ..NodeRecord::default() },
    ];
    let edge =
        EdgeRecord { id: 34, origin: 0, destination: 1, length: 5.0, ..EdgeRecord::default() };
    world.add_edge(edge, [CurveRecord::straight([1.0, 2.0], [0.0, 0.0])]);
    world
}

impl Fixture {
    fn new(robots: usize) -> Self {
        let header = FrameHeader {
            run_id: 1,
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            speed: 1.0,
            sim_time_nanos: 83_456_000_000,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(robots)];
        let columns = ColumnsMut::split(&mut lines, robots);
        for i in 0..robots {
            (columns.x[i], columns.y[i], columns.theta[i]) = (i as f32, -(i as f32), 0.5);
            columns.state[i] =
                if i % 2 == 0 { RobotState::Driving as u8 } else { RobotState::Held as u8 };
        }
        Self {
            interface: Interface::new(
                Settings::default(),
                CameraController::new(Camera::default(), true),
            ),
            header,
            lines,
            world: world(),
            labels: Labels::default(),
            pairs: Vec::new(),
            route: None,
            plans: PlanFacts::default(),
            closed: Vec::new(),
            jams: JamFacts::default(),
            activities: Vec::new(),
            values: vec![("battery", 75.0)],
            order: None,
            named_order: None,
            matches: None,
            rows: None,
            status: Some(ControlResponse {
                robots: robots as u32,
                speed: 1.0,
                ..ControlResponse::default()
            }),
            engine: EngineState::Running,
            work: None,
            timing: Timing::new("an adapter".into()),
            legend: Colouring::collision().legend(Theme::Dark, &[], None),
            actions: Vec::new(),
            picture: egui::Rect::ZERO,
            recording: None,
            is_past: false,
        }
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let touching = self.pairs.len() as u32;
        let contact_header =
            ContactHeader { touching, touching_ever: 9, ..ContactHeader::default() };
        let values: Vec<_> = self
            .values
            .iter()
            .map(|(name, value)| (name.parse().expect("a name"), *value))
            .collect();
        let model = ViewModel {
            work: self.work,
            fleet: "test",
            engine: self.engine,
            status: self.status.as_ref(),
            frame: (!matches!(self.engine, EngineState::Awaited | EngineState::WarmingUp(_)))
                .then(|| Frame::new(&self.header, &self.lines).expect("a frame")),
            world: self.world.view(1, 1),
            labels: &self.labels,
            robot_type_column: None,
            activity_column: Some(&self.activities[..]).filter(|values| !values.is_empty()),
            contacts: Some(Contacts { header: &contact_header, pairs: &self.pairs, missed: 0 }),
            legend: &self.legend,
            columns: &["battery".parse().expect("a name")],
            values: &values,
            order: self.order,
            named_order: self.named_order.as_ref(),
            route: self.route,
            plans: self.plans,
            jams: &self.jams,
            density: None,
            closed: &self.closed,
            rows: self.rows.as_ref(),
            matches: self.matches.as_ref(),
            bounds: Bounds::default(),
            followed: None,
            timing: &self.timing,
            counts: Counts { read: 1234, skipped: 5 },
            lag: Some(0.001),
            trail_points: 0,
            udp: RunningUdp::default(),
            timeline: match &self.recording {
                Some((marks, now)) => Some(timeline(marks, *now)),
                None => Some(past(&self.header, self.is_past)),
            },
        };
        let (picture, actions) = self.interface.show(ui, &model);
        self.picture = picture;
        self.actions.extend(actions);
    }

    /// Returns the requests to the engine: kind, count and speed.
    fn requests(&self) -> Vec<(ControlKind, u64, f32)> {
        let requests = self.actions.iter().filter_map(|action| match action {
            Action::Control(request) => Some((request.kind()?, request.count, request.speed)),
            _ => None,
        });
        requests.collect()
    }
}

/// A recording of ten seconds.
fn timeline(marks: &[RecordingMark], now: f64) -> Timeline<'_> {
    Timeline {
        name: "morning.mcap",
        note: "",
        start: 0,
        end: 10_000_000_000,
        now: Some((now * 1e9) as u64),
        searched: u64::MAX,
        left_out: 0,
        marks,
        live: None,
    }
}

/// The kept part of a live run: ten seconds.
fn past(header: &FrameHeader, is_past: bool) -> Timeline<'static> {
    let now = header.sim_time_nanos;
    let live = Some(Live { bytes: 12 << 20, is_past });
    Timeline {
        name: "live",
        start: now - 10_000_000_000,
        end: now,
        now: Some(now),
        live,
        ..timeline(&[], 0.0)
    }
}

/// A fixture that shows a recording with a contact at 2 s and two faults at 6 s, at a time in
/// seconds.
fn replay(now: f64) -> Fixture {
    let mark = |time_nanos, kind: MarkKind, count| RecordingMark {
        time_nanos,
        kind: kind as u32,
        robot: 3,
        count,
        ..RecordingMark::default()
    };
    let marks =
        vec![mark(2_000_000_000, MarkKind::Contact, 1), mark(6_000_000_000, MarkKind::Fault, 2)];
    Fixture { recording: Some((marks, now)), ..Fixture::new(5) }
}

fn harness(fixture: Fixture) -> Harness<'static, Fixture> {
    harness_of([1280.0, 720.0], fixture)
}

fn harness_of(size: [f32; 2], fixture: Fixture) -> Harness<'static, Fixture> {
    let builder = Harness::builder().with_size(size).with_max_steps(64);
    let mut harness = builder.build_ui_state(|ui, fixture: &mut Fixture| fixture.show(ui), fixture);
    harness.run_ok();
    harness
}

/// Draws some pictures. Spinners and countdowns request pictures without end, so that there is no
/// last one.
fn settle(harness: &mut Harness<'_, Fixture>) {
    harness.run_steps(6);
}

fn press(harness: &mut Harness<'_, Fixture>, key: Key) {
    harness.key_press(key);
    settle(harness);
}

/// Checks that a place is in the middle of what is free between the panels, beside the legend.
fn is_between_the_panels(harness: &Harness<'_, Fixture>, place: Vec2) {
    let picture = harness.state().picture;
    let size = Vec2::new(picture.width(), picture.height());
    let at = harness
        .state()
        .interface
        .camera_controller
        .camera()
        .project(place.extend(0.25), size)
        .expect("in sight");
    // Two panels share the left side.
    let settings = &harness.state().interface.settings;
    let is_right_open = settings.right.is_some() && settings.left.is_none();
    let right = if is_right_open { 1000.0 } else { size.x };
    let legend = harness.state().interface.placed().iter().find(|(name, _)| *name == "legend");
    let left = legend.expect("room for a legend").1.right() + 10.0;
    let middle = Vec2::new((left + right) / 2.0, size.y / 2.0);
    assert!((at - middle).abs().max_element() < 20.0, "{at}, not at {middle}");
}
