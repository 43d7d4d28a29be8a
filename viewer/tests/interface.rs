//! The interface, driven as a user drives it: egui_kittest clicks, types and presses keys; the view model is made up.

use egui::{Key, Modifiers, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::Vec2;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::control::{ControlKind, ControlResponse};
use regatta_plugin::frame::{ClockState, ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines};
use regatta_plugin::history::FleetSample as Sample;
use regatta_plugin::recording::{MarkKind, RecordingMark};
use regatta_plugin::task::StopAction;
use regatta_plugin::traffic::EdgeTraffic;
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_plugin::{Contacts, Frame};
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::feed::Counts;
use regatta_viewer::filter::Filter;
use regatta_viewer::interface::Interface;
use regatta_viewer::interface::camera_controller::{CameraController, Follow};
use regatta_viewer::interface::labels::Labels;
use regatta_viewer::interface::rows::{Rows, SortBy};
use regatta_viewer::interface::settings::{LeftPanel, RightPanel, Settings};
use regatta_viewer::interface::timing::Timing;
use regatta_viewer::interface::view_model::{Action, EngineState, Item, Live, Timeline, ViewModel};
use regatta_viewer::jams::heat::{Heat, HeatFacts};
use regatta_viewer::jams::presence::Presence;
use regatta_viewer::jams::spots::{Spot, Trend};
use regatta_viewer::jams::{EdgeFacts, JamFacts, Since};
use regatta_viewer::log::{AlarmChange, AlarmKey, Entry, Kind, LogReport, Place, Severity};
use regatta_viewer::orders::UserOrder;
use regatta_viewer::palette::{Colouring, Legend, Theme};
use regatta_viewer::plans::{Coverage, PlanFacts};
use regatta_viewer::route::{Remaining, RouteLength};
use regatta_viewer::tasks::{RobotTask, Stop};

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
    values: Vec<(&'static str, f32)>,
    task: Option<RobotTask>,
    matches: Option<[u32; 2]>,
    rows: Option<Rows>,
    status: Option<ControlResponse>,
    engine: EngineState,
    timing: Timing,
    legend: Legend,
    actions: Vec<Action>,
    /// Where the picture is, in points.
    picture: egui::Rect,
    /// The marks of a recording of ten seconds, and its time, in seconds.
    recording: Option<(Vec<RecordingMark>, f64)>,
    is_past: bool,
}

/// An edge between two nodes.
fn world() -> WorldData {
    let mut world = WorldData::default();
    let (name, level) = (world.texts.add("dock 1"), world.texts.add("ground floor"));
    world.nodes = vec![
        NodeRecord { id: 7, x: 1.0, y: 2.0, name, level, ..NodeRecord::default() },
        NodeRecord { id: 8, ..NodeRecord::default() },
    ];
    let edge = EdgeRecord { id: 34, origin: 0, destination: 1, length: 5.0, ..EdgeRecord::default() };
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
            columns.state[i] = if i % 2 == 0 { RobotState::Driving as u8 } else { RobotState::Held as u8 };
        }
        Self {
            interface: Interface::new(Settings::default(), CameraController::new(Camera::default(), true)),
            header,
            lines,
            world: world(),
            labels: Labels::default(),
            pairs: Vec::new(),
            route: None,
            plans: PlanFacts::default(),
            closed: Vec::new(),
            jams: JamFacts::default(),
            values: vec![("battery", 75.0)],
            task: None,
            matches: None,
            rows: None,
            status: Some(ControlResponse { robots: robots as u32, speed: 1.0, ..ControlResponse::default() }),
            engine: EngineState::Running,
            timing: Timing::new("an adapter".into()),
            legend: Colouring::default().legend(Theme::Dark, &[], None),
            actions: Vec::new(),
            picture: egui::Rect::ZERO,
            recording: None,
            is_past: false,
        }
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let touching = self.pairs.len() as u32;
        let contact_header = ContactHeader { touching, touching_ever: 9, ..ContactHeader::default() };
        let values: Vec<_> = self.values.iter().map(|(name, value)| (name.parse().expect("a name"), *value)).collect();
        let model = ViewModel {
            fleet: "test",
            engine: self.engine,
            status: self.status.as_ref(),
            frame: (self.engine != EngineState::Awaited)
                .then(|| Frame::new(&self.header, &self.lines).expect("a frame")),
            world: self.world.view(1, 1),
            labels: &self.labels,
            robot_type_column: None,
            contacts: Some(Contacts { header: &contact_header, pairs: &self.pairs, missed: 0 }),
            legend: &self.legend,
            columns: &["battery".parse().expect("a name")],
            values: &values,
            task: self.task,
            route: self.route,
            plans: self.plans,
            jams: &self.jams,
            density: None,
            closed: &self.closed,
            rows: self.rows.as_ref(),
            matches: self.matches,
            bounds: Bounds::default(),
            followed: None,
            timing: &self.timing,
            counts: Counts { read: 1234, skipped: 5 },
            lag: Some(0.001),
            trail_points: 0,
            udp: [false, false],
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

/// What is kept of a live run: ten seconds.
fn past(header: &FrameHeader, is_past: bool) -> Timeline<'static> {
    let now = header.sim_time_nanos;
    let live = Some(Live { bytes: 12 << 20, is_past });
    Timeline { name: "live", start: now - 10_000_000_000, end: now, now: Some(now), live, ..timeline(&[], 0.0) }
}

/// A fixture that shows a recording with a contact at 2 s and two faults at 6 s, at a time in seconds.
fn replay(now: f64) -> Fixture {
    let mark = |time_nanos, kind: MarkKind, count| RecordingMark {
        time_nanos,
        kind: kind as u32,
        robot: 3,
        count,
        ..RecordingMark::default()
    };
    let marks = vec![mark(2_000_000_000, MarkKind::Contact, 1), mark(6_000_000_000, MarkKind::Fault, 2)];
    Fixture { recording: Some((marks, now)), ..Fixture::new(5) }
}

fn harness(fixture: Fixture) -> Harness<'static, Fixture> {
    let builder = Harness::builder().with_size([1280.0, 720.0]).with_max_steps(64);
    let mut harness = builder.build_ui_state(|ui, fixture: &mut Fixture| fixture.show(ui), fixture);
    harness.run_ok();
    harness
}

/// Draws some pictures. Spinners and countdowns request pictures without end, so that there is no last one.
fn settle(harness: &mut Harness<'_, Fixture>) {
    harness.run_steps(6);
}

fn press(harness: &mut Harness<'_, Fixture>, key: Key) {
    harness.key_press(key);
    settle(harness);
}

#[test]
fn the_clock_is_paused_stepped_and_resumed() {
    let mut harness = harness(Fixture::new(5));
    harness.get_by_label("Pause").click();
    settle(&mut harness);
    assert_eq!(harness.state().requests(), [(ControlKind::Pause, 0, 0.0)]);
    harness.state_mut().actions.clear();
    harness.state_mut().header.clock = ClockState::Paused as u32;
    settle(&mut harness);
    harness.get_by_label("Step").click();
    settle(&mut harness);
    harness.get_by_label("Resume").click();
    settle(&mut harness);
    assert_eq!(harness.state().requests(), [(ControlKind::Step, 1, 0.0), (ControlKind::Resume, 0, 0.0)]);
}

#[test]
fn keys_send_the_same_requests_as_buttons() {
    let mut harness = harness(Fixture::new(5));
    for key in [Key::Space, Key::CloseBracket, Key::OpenBracket, Key::I] {
        press(&mut harness, key);
    }
    let requests = harness.state().requests();
    let wanted = [
        (ControlKind::Pause, 0, 0.0),
        (ControlKind::Speed, 0, 2.0),
        (ControlKind::Speed, 0, 0.5),
        (ControlKind::Robots, 6, 0.0),
    ];
    assert_eq!(requests, wanted);
}

#[test]
fn the_interface_waits_for_an_engine_and_sends_no_requests() {
    let mut fixture = Fixture::new(5);
    (fixture.engine, fixture.status) = (EngineState::Awaited, None);
    let mut harness = harness(fixture);
    settle(&mut harness);
    harness.get_by_label("Waiting for fleet 'test'");
    harness.get_by_label("Pause").click();
    settle(&mut harness);
    assert!(harness.state().requests().is_empty());
}

#[test]
fn a_robot_is_found_by_its_id_and_flown_to() {
    let mut harness = harness(Fixture::new(500));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.left, Some(LeftPanel::Fleet));
    harness.event(egui::Event::Text("321".into()));
    settle(&mut harness);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(321)));
    harness.run_steps(120);
    let target = harness.state().interface.camera_controller.camera().target;
    assert!(target.truncate().distance(Vec2::new(321.0, -321.0)) < 0.01, "{target}");
    harness.get_by_label("Robot 321");
    assert!(harness.state().requests().is_empty(), "digits typed into a field trigger no shortcuts");
}

#[test]
fn the_list_of_a_million_robots_shows_the_rows_in_sight() {
    let mut fixture = Fixture::new(1_000_000);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    harness.get_by_label("robot 0");
    assert!(harness.query_by_label("robot 100").is_none());
    harness.get_by_label("sort by id").click();
    settle(&mut harness);
    harness.get_by_label("robot 999999").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(999_999)));
    for _ in 0..3 {
        press(&mut harness, Key::PageDown);
    }
    assert!(harness.query_by_label("robot 999999").is_none(), "three pages further");
    harness.get_by_label("sort by x").click();
    settle(&mut harness);
    let requested = harness.state().actions.iter().rev().find_map(|action| match action {
        Action::Rows(query) => Some(query.clone()),
        _ => None,
    });
    let query = requested.expect("rows are requested");
    assert_eq!((query.sort, query.descending), (SortBy::X, false));
    harness.state_mut().rows = Some(Rows { query, ids: vec![42, 17, 4] });
    settle(&mut harness);
    harness.get_by_label("robot 17");
    assert!(harness.query_by_label("robot 1").is_none());
}

#[test]
fn a_click_on_a_collision_flies_to_it() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Collisions);
    fixture.pairs = vec![ContactRecord { robots: [3, 9], level: 2, x: 30.0, y: -12.0, ..ContactRecord::default() }];
    let mut harness = harness(fixture);
    harness.get_by_label("1");
    harness.get_by_label("robots 3 and 9 touching").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(3)));
    assert_eq!(harness.state().interface.robots(), [3, 9]);
    harness.run_steps(120);
    let target = harness.state().interface.camera_controller.camera().target;
    assert!(target.truncate().distance(Vec2::new(30.0, -12.0)) < 0.01, "{target}");
    harness.get_by_label("robot 9").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(9)), "the other robot of the pair");
}

#[test]
fn the_picture_is_dragged_zoomed_and_picked() {
    let mut harness = harness(Fixture::new(5));
    let before = harness.state().interface.camera_controller.camera();
    let at = pos2(640.0, 360.0);
    harness.hover_at(at);
    harness.run_steps(2);
    harness.drag_at(at);
    harness.run_steps(2);
    for i in 1..=10_u8 {
        harness.hover_at(at + egui::vec2(0.0, f32::from(i) * 6.0));
        harness.run_steps(1);
    }
    harness.drop_at(at + egui::vec2(0.0, 60.0));
    harness.run_steps(2);
    let turned = harness.state().interface.camera_controller.camera();
    assert!(turned.pitch > before.pitch + 0.1 && (turned.yaw - before.yaw).abs() < 1e-5, "{before:?} {turned:?}");
    // In kittest, the pointer leaves the window after a drop.
    harness.hover_at(at);
    harness.run_steps(2);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(2);
    let zoomed = harness.state().interface.camera_controller.camera();
    assert!(zoomed.distance < turned.distance * 0.7, "{turned:?} {zoomed:?}");
    assert!(
        !harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })),
        "a drag is not a click"
    );
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(2);
    assert!(harness.state().actions.iter().any(|action| matches!(action, Action::Pick { extend: false, .. })));
}

#[test]
fn a_whole_drag_between_two_pictures_is_handled() {
    let mut harness = harness(Fixture::new(5));
    let before = harness.state().interface.camera_controller.camera();
    let at = pos2(640.0, 360.0);
    let button = |pos, pressed| {
        let (button, modifiers) = (egui::PointerButton::Secondary, Modifiers::NONE);
        egui::Event::PointerButton { pos, button, pressed, modifiers }
    };
    let to = at + egui::vec2(90.0, 0.0);
    harness.event(egui::Event::PointerMoved(at));
    harness.event(button(at, true));
    harness.event(egui::Event::PointerMoved(to));
    harness.event(button(to, false));
    harness.event(egui::Event::PointerMoved(at));
    harness.run_steps(2);
    let moved = harness.state().interface.camera_controller.camera();
    assert!(moved.target.distance(before.target) > 0.1, "{before:?} {moved:?}");
    assert_eq!((moved.yaw, moved.pitch), (before.yaw, before.pitch));
}

#[test]
fn held_keys_move_the_camera() {
    let mut harness = harness(Fixture::new(5));
    let before = harness.state().interface.camera_controller.camera();
    harness.key_down(Key::W);
    harness.run_steps(10);
    harness.key_up(Key::W);
    harness.run_steps(2);
    let after = harness.state().interface.camera_controller.camera();
    let step = (after.target - before.target).truncate();
    assert!(step.dot(Vec2::from_angle(before.yaw)) > 0.1, "{step}");
    harness.run_steps(10);
    assert_eq!(
        harness.state().interface.camera_controller.camera(),
        after,
        "the camera stops when the key is released"
    );
}

#[test]
fn one_key_cycles_through_the_ways_of_following() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::N);
    let mut modes = Vec::new();
    for _ in 0..3 {
        press(&mut harness, Key::F);
        modes.push(harness.state().interface.camera_controller.followed());
    }
    assert_eq!(modes, [Some((0, Follow::Behind)), Some((0, Follow::Above)), None]);
    press(&mut harness, Key::Escape);
    assert_eq!(harness.state().interface.selected, None);
}

#[test]
fn panels_themes_and_colourings_have_keys_that_the_help_lists() {
    let mut harness = harness(Fixture::new(5));
    for (key, panel) in [
        (Key::Num3, RightPanel::Selection),
        (Key::Num4, RightPanel::View),
        (Key::Num5, RightPanel::Performance),
        (Key::Num6, RightPanel::Connection),
    ] {
        press(&mut harness, key);
        assert_eq!(harness.state().interface.settings.right, Some(panel));
    }
    press(&mut harness, Key::L);
    assert!(harness.state().interface.settings.light);
    let mut colours = Vec::new();
    for _ in 0..5 {
        press(&mut harness, Key::C);
        colours.push(harness.state().interface.settings.colour.clone());
    }
    assert_eq!(colours, ["state", "speed", "type", "battery", "collision"]);
    press(&mut harness, Key::F1);
    harness.get_by_label("pause, resume");
    press(&mut harness, Key::Escape);
    assert!(harness.query_by_label("pause, resume").is_none());
}

#[test]
fn plans_of_all_robots_are_switched_on_and_say_what_they_lack() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.right = Some(RightPanel::View);
    let mut harness = harness(fixture);
    harness.get_by_label("routes and goals of all robots").click();
    settle(&mut harness);
    assert!(harness.state().interface.settings.plans);
    harness.get_by_label("nothing known yet");
    harness.get_by_label("goals: not published");
    let routes = Coverage { known: 640, under_way: 990, round_secs: f32::INFINITY };
    harness.state_mut().plans = PlanFacts { routes: Some(routes), has_goals: true, waiting: None };
    settle(&mut harness);
    harness.get_by_label("routes of 640 of 990 robots under way so far");
    harness.get_by_label("routes of 640 of 990 robots");
    harness.get_by_label("planned");
    let routes = Coverage { known: 985, under_way: 990, round_secs: 1.25 };
    harness.state_mut().plans = PlanFacts { routes: Some(routes), has_goals: true, waiting: None };
    settle(&mut harness);
    harness.get_by_label("routes of 985 of 990 robots under way, at most 1.2 s old");
    assert!(harness.query_by_label("routes of 985 of 990 robots").is_none(), "nothing notable is missing");
    press(&mut harness, Key::H);
    assert!(!harness.state().interface.settings.plans);
    assert!(harness.query_by_label("planned").is_none());
}

#[test]
fn who_waits_is_switched_on_and_counted() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::B);
    assert!(harness.state().interface.settings.waits);
    harness.get_by_label("who waits: not published");
    harness.state_mut().plans = PlanFacts { waiting: Some([17, 4]), ..PlanFacts::default() };
    settle(&mut harness);
    harness.get_by_label("waits for (17)");
    harness.get_by_label("ring of waiting (4)");
    press(&mut harness, Key::Num4);
    harness.get_by_label("17 wait, 4 of them in rings");
}

#[test]
fn the_panel_tells_a_robots_work() {
    let mut fixture = Fixture::new(5);
    fixture.values = vec![("activity", 4.0), ("battery", 74.6), ("goal", 7.0), ("load", 1.5), ("waits-for", 3.0)];
    let next = Some(Stop { node: 8, action: StopAction::Pick });
    fixture.task = Some(RobotTask { task: 312, stop: [1, 2], next, is_handling: false });
    let mut harness = harness(fixture);
    harness.state_mut().interface.select(Some(Item::Robot(1)));
    settle(&mut harness);
    for text in ["waiting", "312", "to pick at node 8", "75 %", "1.500"] {
        harness.get_by_label(text);
    }
    harness.get_by_label("robot 3").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(3)));
    harness.get_by_label("dock 1").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Node(0)));
}

#[test]
fn a_robot_without_work_waits_for_nobody() {
    let mut fixture = Fixture::new(5);
    fixture.values = vec![("activity", 0.0), ("goal", f32::NAN), ("waits-for", f32::NAN)];
    let mut harness = harness(fixture);
    harness.state_mut().interface.select(Some(Item::Robot(1)));
    settle(&mut harness);
    assert_eq!(harness.query_all_by_label("none").count(), 2);
    harness.state_mut().values.clear();
    settle(&mut harness);
    assert!(harness.query_by_label("WORK").is_none(), "no fleet manager");
}

#[test]
fn robots_are_filtered_and_those_that_match_are_counted() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    harness.get_by_label("filter: state").click();
    settle(&mut harness);
    harness.get_by_label("held").click();
    settle(&mut harness);
    let wanted = Filter { state: Some(RobotState::Held), ..Filter::default() };
    let filters = |actions: &[Action]| -> Vec<Filter> {
        let filters = actions.iter().filter_map(|action| match action {
            Action::Filter(filter) => Some(filter.clone()),
            _ => None,
        });
        filters.collect()
    };
    assert_eq!(filters(&harness.state().actions), std::slice::from_ref(&wanted));
    harness.get_by_label("counting …");
    harness.state_mut().matches = Some([2, 5]);
    settle(&mut harness);
    harness.get_by_label("2 of 5 robots match");
    harness.get_by_label("show all").click();
    settle(&mut harness);
    assert_eq!(filters(&harness.state().actions), [wanted, Filter::default()]);
    assert!(harness.query_by_label("2 of 5 robots match").is_none());
}

#[test]
fn an_edge_and_its_nodes_link_to_each_other() {
    let mut harness = harness(Fixture::new(5));
    harness.state_mut().interface.select(Some(Item::Edge(0)));
    settle(&mut harness);
    harness.get_by_label("Edge 34");
    harness.get_by_label("node 7").click();
    settle(&mut harness);
    harness.get_by_label("Node 7");
    harness.get_by_label("edge 34").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Edge(0)));
}

#[test]
fn the_heat_map_is_chosen_and_says_what_it_lacks() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.right = Some(RightPanel::View);
    let mut harness = harness(fixture);
    assert!(harness.query_by_label("no figures: regatta plugin traffic").is_none());
    harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    settle(&mut harness);
    harness.get_by_label("no figures: regatta plugin traffic");
    harness.get_by_label("regatta plugin traffic --fleet test");
    harness.get_by_label("heat map: figure").click();
    settle(&mut harness);
    harness.get_by_role_and_label(egui::accesskit::Role::Button, "speed").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.heat_of.to_string(), "speed:10min");
    harness.key_press_modifiers(Modifiers::SHIFT, Key::G);
    settle(&mut harness);
    let heat: Heat = "waiting".parse().expect("a heat map");
    assert!(harness.state().interface.settings.heat && harness.state().interface.settings.heat_of == heat);
    let (ends, has_contacts, has_routes) = ([0.0, 50.0], true, false);
    let facts = HeatFacts { heat, ends, is_exceeded: true, edges: 12, secs: 240.0, has_contacts, has_routes };
    harness.state_mut().jams.heat = Some(facts);
    settle(&mut harness);
    harness.get_by_label("last ten minutes (4 min)");
    harness.get_by_label("12 edges have a value");
    harness.state_mut().interface.settings.heat_of = "routes".parse().expect("a heat map");
    let routes = HeatFacts { heat: "routes".parse().expect("a heat map"), edges: 0, ..facts };
    harness.state_mut().jams.heat = Some(routes);
    settle(&mut harness);
    harness.get_by_label("no routes are known: none in lockstep, none of recordings");
    harness.state_mut().jams.heat = Some(HeatFacts { has_routes: true, ..routes });
    settle(&mut harness);
    assert!(harness.query_by_label("no routes are known: none in lockstep, none of recordings").is_none());
    harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
    settle(&mut harness);
    assert!(!harness.state().interface.settings.heat);
}

#[test]
fn an_edge_tells_its_robots_and_its_traffic() {
    let mut harness = harness(Fixture::new(5));
    harness.state_mut().interface.select(Some(Item::Edge(0)));
    let present = Presence { robots: 3, waiting: 1, listed: vec![0, 2, 4] };
    let mut facts = EdgeFacts { edge: 0, present, traffic: None };
    harness.state_mut().jams.edges = vec![facts.clone()];
    settle(&mut harness);
    harness.get_by_label("regatta plugin traffic --fleet test");
    facts.traffic = Some([EdgeTraffic { entered_per_hour: 1234.0, waiting_secs: 56.5, ..EdgeTraffic::default() }; 3]);
    harness.state_mut().jams.edges = vec![facts];
    settle(&mut harness);
    assert_eq!(harness.query_all_by_label("1234").count(), 3);
    assert_eq!(harness.query_all_by_label("56.5").count(), 3);
    harness.get_by_label("robot 4").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(4)));
}

/// The place of a point of the ground in the window.
fn on_screen(harness: &Harness<'_, Fixture>, at: Vec2) -> egui::Pos2 {
    let (camera, picture) = (harness.state().interface.camera_controller.camera(), harness.state().picture);
    let at = camera.project(at.extend(0.0), Vec2::new(picture.width(), picture.height())).expect("in sight");
    pos2(picture.left() + at.x, picture.top() + at.y)
}

#[test]
fn the_edge_under_the_pointer_tells_its_figures() {
    let mut harness = harness(Fixture::new(5));
    let (edge, beside) = (on_screen(&harness, Vec2::new(0.5, 1.0)), on_screen(&harness, Vec2::new(3.0, -3.0)));
    harness.hover_at(edge);
    settle(&mut harness);
    harness.get_by_label("edge 34");
    assert_eq!(harness.state().interface.watched_places(), (vec![0], None), "another thread counts its robots");
    let figures = EdgeTraffic { occupancy: 1.5, entered_per_hour: 321.0, waiting_secs: 56.5, ..EdgeTraffic::default() };
    let present = Presence { robots: 7, waiting: 4, listed: vec![0] };
    let facts = EdgeFacts { edge: 0, present, traffic: None };
    harness.state_mut().jams.edges = vec![facts.clone()];
    settle(&mut harness);
    harness.get_by_label("more with: regatta plugin traffic");
    harness.get_by_label("7");
    harness.state_mut().jams.edges = vec![EdgeFacts { traffic: Some([figures; 3]), ..facts }];
    settle(&mut harness);
    for label in ["321", "56.5", "7", "4", "last ten minutes"] {
        harness.get_by_label(label);
    }
    assert!(harness.query_by_label("robots on the edge").is_none(), "not without the heat map");
    let settings = &mut harness.state_mut().interface.settings;
    (settings.heat, settings.heat_of) = (true, "occupancy:run".parse().expect("a heat map"));
    settle(&mut harness);
    for label in ["1.5", "321", "contact, s", "the run so far"] {
        harness.get_by_label(label);
    }
    harness.state_mut().closed = vec![0];
    settle(&mut harness);
    harness.get_by_label("closed");
    harness.hover_at(beside);
    settle(&mut harness);
    assert!(harness.query_by_label("edge 34").is_none());
    assert_eq!(harness.state().interface.watched_places(), (vec![], None));
}

#[test]
fn in_the_past_only_the_robots_of_an_edge_are_told() {
    let mut fixture = Fixture::new(5);
    (fixture.is_past, fixture.interface.settings.edges) = (true, true);
    let mut harness = harness(fixture);
    let present = Presence { robots: 7, waiting: 4, listed: vec![0] };
    harness.state_mut().jams.edges = vec![EdgeFacts { edge: 0, present, traffic: None }];
    let edge = on_screen(&harness, Vec2::new(0.5, 1.0));
    harness.hover_at(edge);
    settle(&mut harness);
    harness.get_by_label("edge 34");
    harness.get_by_label("5");
    assert!(harness.query_by_label("7").is_none(), "as many as there are now");
    assert!(harness.query_by_label("more with: regatta plugin traffic").is_none());
}

#[test]
fn a_hot_spot_is_flown_to_and_the_list_is_exported() {
    let mut harness = harness(Fixture::new(5));
    let spot = |x: f32, contact_secs| Spot {
        place: Vec2::new(x, 3.0),
        contact_secs,
        standing_secs: 10.0,
        seen: [61.0, 90.0],
        edges: vec![0],
        trend: Trend::Growing,
    };
    press(&mut harness, Key::Num7);
    harness.get_by_label("nobody has lost time");
    harness.get_by_label("since the start of the run");
    harness.state_mut().jams.since = Since { secs: 754.0, is_published: false };
    settle(&mut harness);
    harness.get_by_label("since 12:34, when this window began to watch");
    harness.state_mut().jams.since.is_published = true;
    settle(&mut harness);
    harness.get_by_label("since 12:34, when regatta plugin traffic began");
    harness.state_mut().jams.spots = [spot(40.0, 25.0), spot(7.0, 0.0)].into();
    settle(&mut harness);
    harness.get_by_label("45 robot s lost");
    harness.get_by_label("hot spot 1").click();
    harness.run_steps(120);
    let target = harness.state().interface.camera_controller.camera().target;
    assert!((target.x - 40.0).abs() < 0.5 && (target.y - 3.0).abs() < 0.5, "{target}");
    assert_eq!(harness.state().interface.selected, Some(Item::Edge(0)));
    harness.get_by_label("export").click();
    settle(&mut harness);
    let written = harness.state().actions.iter().find_map(|action| match action {
        Action::Write { path, text } => Some((path.clone(), text.clone())),
        _ => None,
    });
    let (path, text) = written.expect("a file");
    assert_eq!((path.to_str(), text.lines().count()), (Some("hot-spots.csv"), 3));
    assert_eq!(text.lines().nth(1), Some("1,40.00,3.00,35.0,25.0,10.0,61.0,90.0,growing,34"));
}

#[test]
fn plots_show_the_figures_at_the_time_under_the_pointer_and_a_click_goes_there() {
    let mut fixture = Fixture::new(5);
    let sample = |second: u32| Sample {
        secs: f64::from(second),
        states: [0, 100 - second, second, 0, 0, 0, 0, 0],
        touching: 2,
        mean_speed: 0.75,
        ..Sample::default()
    };
    fixture.jams.series = (0..=80).map(sample).collect();
    let mut harness = harness(fixture);
    assert!(harness.query_by_label("mean speed, m/s").is_none());
    press(&mut harness, Key::Num8);
    harness.get_by_label("waiting 80");
    harness.get_by_label("0.75");
    harness.get_by_label("not published");
    // Over the middle of the plot of those that wait.
    let title = harness.get_by_label("touching pairs").rect();
    let at = pos2(title.left() + 130.0, title.top() + 70.0);
    harness.hover_at(at);
    settle(&mut harness);
    let times =
        harness.query_all_by_label_contains("at 0:").count() + harness.query_all_by_label_contains("at 1:").count();
    assert_eq!(times, 5, "each plot tells the same time");
    harness.drag_at(at);
    harness.drop_at(at);
    settle(&mut harness);
    let seeks: Vec<_> =
        harness.state().requests().into_iter().filter(|(kind, ..)| *kind == ControlKind::Seek).collect();
    assert!(seeks.len() == 1 && seeks[0].1 > 10_000_000_000 && seeks[0].1 < 80_000_000_000, "{seeks:?}");
}

#[test]
fn the_panel_reports_a_robot_that_has_left() {
    let mut harness = harness(Fixture::new(5));
    harness.state_mut().interface.select(Some(Item::Robot(77)));
    settle(&mut harness);
    harness.get_by_label("not in the fleet now");
}

#[test]
fn udp_is_started_with_the_typed_addresses() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::Num6);
    harness.get_by_label("Receive").click();
    settle(&mut harness);
    harness.get_by_label("Send").click();
    settle(&mut harness);
    let wanted = [
        Action::StartUdpSource { listen: "127.0.0.1:9870".into(), echo_to: None, offset: Vec2::ZERO },
        Action::StartUdpSender { to: "127.0.0.1:9870".into() },
    ];
    let started: Vec<_> = harness.state().actions.iter().filter(|action| wanted.contains(action)).cloned().collect();
    assert_eq!(started, wanted);
}

#[test]
fn files_for_the_floor_and_the_robots_are_typed_or_dropped() {
    let mut harness = harness(Fixture::new(5));
    press(&mut harness, Key::Num4);
    harness.get_by_label("floor file").scroll_to_me();
    settle(&mut harness);
    let line = harness.get_by_label("floor file");
    line.focus();
    line.type_text("map.yaml");
    settle(&mut harness);
    harness.get_all_by_label("load").next().expect("a button").scroll_to_me();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "", "the file is not loaded yet");
    harness.get_all_by_label("load").next().expect("a button").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "map.yaml");
    harness.state_mut().interface.use_file(std::path::Path::new("tug.STL"));
    settle(&mut harness);
    let mesh = harness.state().interface.settings.mesh.clone().expect("a mesh");
    assert_eq!((mesh.file.as_str(), mesh.scale, mesh.z, mesh.yaw), ("tug.STL", 1.0, 0.0, 0.0));
    harness.get_all_by_label("remove").next().expect("a button").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "");
    assert!(harness.state().interface.settings.mesh.is_some());
    harness.get_by_label("add a lamp").scroll_to_me();
    settle(&mut harness);
    harness.get_by_label("add a lamp").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.lamps.len(), 1);
}

#[test]
fn the_panel_shows_the_rest_of_a_route() {
    let mut fixture = Fixture::new(5);
    let released = RouteLength { edges: 1, metres: 4.25, is_partial: false };
    fixture.route = Some(Remaining { released, planned: RouteLength { edges: 300, metres: 812.0, is_partial: true } });
    fixture.interface.select(Some(Item::Robot(2)));
    let mut harness = harness(fixture);
    settle(&mut harness);
    assert!(harness.query_by_label("1 edge, 4.2 m").is_some());
    assert!(harness.query_by_label("300 edges, > 812.0 m").is_some());
    harness.state_mut().route = Some(Remaining::default());
    settle(&mut harness);
    assert!(harness.query_by_label("nothing left to drive").is_some());
    harness.state_mut().route = None;
    settle(&mut harness);
    assert!(harness.query_by_label("ROUTE").is_none(), "the route is unknown");
}

#[test]
fn several_robots_are_selected() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Fleet);
    let mut harness = harness(fixture);
    let selected = |harness: &Harness<'_, Fixture>| harness.state().interface.robots();
    let click = |harness: &mut Harness<'_, Fixture>, robot: u32, modifiers: Modifiers| {
        harness.get_by_label(&format!("robot {robot}")).click_modifiers(modifiers);
        settle(harness);
    };
    click(&mut harness, 3, Modifiers::NONE);
    click(&mut harness, 5, Modifiers::COMMAND);
    click(&mut harness, 7, Modifiers::COMMAND);
    assert_eq!(selected(&harness), [7, 5, 3]);
    harness.get_by_label("Robot 7");
    click(&mut harness, 7, Modifiers::COMMAND);
    assert_eq!(selected(&harness), [5, 3], "a second click removes the robot");
    harness.get_by_label("3").click();
    settle(&mut harness);
    assert_eq!(selected(&harness), [3, 5], "a click on another selected robot shows that one");
    harness.get_by_label("Robot 3");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    harness.event(egui::Event::Text("41".into()));
    settle(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Enter);
    settle(&mut harness);
    assert_eq!(selected(&harness), [41, 3, 5], "added by the keyboard");
    press(&mut harness, Key::Enter);
    assert_eq!(selected(&harness), [41], "selected alone");
    press(&mut harness, Key::Escape);
    assert!(selected(&harness).is_empty());
}

#[test]
fn a_replay_has_its_files_name_and_no_slider_for_robots() {
    let mut harness = harness(replay(4.0));
    assert_eq!(harness.get_all_by_label("morning.mcap").count(), 2, "in the top bar and at the timeline");
    harness.get_by_label("recording");
    harness.get_by_label("00:00.00 – 00:10.00");
    assert!(harness.query_by_label("robots").is_none(), "a replay would refuse another number");
    press(&mut harness, Key::K);
    harness.get_by_label("a recording has the robots that it has");
    assert_eq!(harness.state().requests(), []);
    harness.state_mut().recording = None;
    settle(&mut harness);
    harness.get_by_label("robots");
    assert!(harness.query_by_label("morning.mcap").is_none());
}

#[test]
fn the_bar_and_the_marks_go_to_times() {
    let mut harness = harness(replay(4.0));
    let bar = harness.get_by_label("Timeline").rect();
    harness.drag_at(bar.center());
    settle(&mut harness);
    harness.drop_at(bar.center());
    settle(&mut harness);
    let requests = harness.state().requests();
    let (kind, time, _) = requests[0];
    assert_eq!((kind, requests.len()), (ControlKind::Seek, 1), "{requests:?}");
    assert!(time.abs_diff(5_000_000_000) < 20_000_000, "the middle: {time}");
    harness.state_mut().actions.clear();
    press(&mut harness, Key::X);
    press(&mut harness, Key::Z);
    // The mark's frame is shown, which lies a little before the mark.
    harness.state_mut().recording.as_mut().expect("a recording").1 = 1.95;
    harness.get_by_label("Next mark").click();
    settle(&mut harness);
    press(&mut harness, Key::Comma);
    let seek = |time| (ControlKind::Seek, time, 0.0);
    let wanted = [
        seek(6_000_000_000),
        seek(2_000_000_000),
        seek(6_000_000_000),
        (ControlKind::Pause, 0, 0.0),
        seek(1_949_999_999),
    ];
    let requests = harness.state().requests();
    assert!(
        requests.iter().zip(wanted).all(|(one, other)| one.0 == other.0 && one.1.abs_diff(other.1) < 200),
        "{requests:?}"
    );
    assert_eq!(requests.len(), wanted.len());
}

#[test]
fn a_part_is_repeated_until_it_is_ended() {
    let mut harness = harness(replay(3.0));
    let go = |harness: &mut Harness<'_, Fixture>, now, run| {
        harness.state_mut().recording.as_mut().expect("a recording").1 = now;
        harness.state_mut().header.run_id = run;
        settle(harness);
    };
    press(&mut harness, Key::Y);
    go(&mut harness, 5.0, 1);
    press(&mut harness, Key::Y);
    settle(&mut harness);
    let back = (ControlKind::Seek, 3_000_000_000, 0.0);
    assert_eq!(harness.state().requests(), [back], "once, although many pictures were drawn");
    go(&mut harness, 3.0, 2);
    assert_eq!(harness.state().requests(), [back]);
    go(&mut harness, 5.1, 2);
    assert_eq!(harness.state().requests(), [back, back]);
    // Whoever goes elsewhere stays there.
    go(&mut harness, 8.0, 3);
    assert_eq!(harness.state().requests(), [back, back]);
    harness.get_by_label("end the loop").click();
    settle(&mut harness);
    go(&mut harness, 5.2, 3);
    assert_eq!(harness.state().requests(), [back, back]);
}

#[test]
fn at_its_end_a_recording_is_played_again_and_a_fleet_that_has_ended_is_greyed() {
    let mut fixture = replay(10.0);
    (fixture.engine, fixture.header.clock) = (EngineState::Paused, ClockState::Paused as u32);
    let mut harness = harness(fixture);
    press(&mut harness, Key::Space);
    assert_eq!(harness.state().requests(), [(ControlKind::Seek, 0, 0.0), (ControlKind::Resume, 0, 0.0)]);
    assert!(harness.query_by_label("The replay has ended").is_none());
    harness.state_mut().engine = EngineState::Gone;
    settle(&mut harness);
    harness.get_by_label("The replay has ended");
    harness.state_mut().recording = None;
    settle(&mut harness);
    harness.get_by_label("The engine has ended");
    harness.get_by_label("this is its last picture, of 01:23.46; a new one is shown as soon as it runs");
}

#[test]
fn the_past_of_a_live_run_is_looked_at_and_left() {
    let mut harness = harness(Fixture::new(5));
    assert!(harness.query_by_label("Timeline").is_none(), "the bar has to be asked for");
    press(&mut harness, Key::U);
    harness.get_by_label("the last 00:10.00 are kept, up to ten minutes: 12 of 256 MB");
    let bar = harness.get_by_label("Timeline").rect();
    harness.drag_at(bar.center());
    settle(&mut harness);
    harness.drop_at(bar.center());
    settle(&mut harness);
    let looked = |harness: &Harness<'_, Fixture>| match harness.state().actions.last() {
        Some(Action::LookBack(time)) => *time,
        other => panic!("{other:?}"),
    };
    assert!(looked(&harness).is_some_and(|time| time.abs_diff(78_456_000_000) < 20_000_000), "{:?}", looked(&harness));
    assert_eq!(harness.state().requests(), [], "the engine isn't asked for anything");
    harness.state_mut().is_past = true;
    settle(&mut harness);
    harness.get_by_label("past");
    harness.get_by_label("robots");
    harness.get_by_label("back to live").click();
    settle(&mut harness);
    assert_eq!(looked(&harness), None);
    press(&mut harness, Key::Comma);
    assert_eq!(looked(&harness), Some(83_455_999_999), "before the shown frame");
}

/// Returns the orders that were given.
#[test]
fn notes_of_a_live_run_are_marks_that_are_gone_to() {
    let mut harness = harness(Fixture::new(5));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::N);
    settle(&mut harness);
    harness.event(egui::Event::Text("jam at dock 1".into()));
    settle(&mut harness);
    press(&mut harness, Key::Enter);
    harness.get_by_label("jam at dock 1");
    let note = harness.state().header.sim_time_nanos;
    // Five seconds later.
    harness.state_mut().header.sim_time_nanos += 5_000_000_000;
    settle(&mut harness);
    harness.get_by_label("Previous mark").click();
    settle(&mut harness);
    assert_eq!(harness.state().actions, [Action::LookBack(Some(note))]);
    harness.state_mut().actions.clear();
    (harness.state_mut().is_past, harness.state_mut().header.sim_time_nanos) = (true, note - 1_000_000_000);
    settle(&mut harness);
    assert!(harness.query_by_label("jam at dock 1").is_none(), "before the note");
    // The times of the fixture end with its frame.
    harness.state_mut().header.sim_time_nanos = note;
    press(&mut harness, Key::Z);
    assert!(harness.state().actions.is_empty(), "there is none before it");
    harness.get_by_label("no mark before this");
    harness.state_mut().header.run_id = 2;
    settle(&mut harness);
    assert!(harness.query_by_label("jam at dock 1").is_none(), "another run has other notes");
}

#[test]
fn a_note_of_a_recording_is_written_and_escape_drops_one() {
    let mut harness = harness(replay(3.0));
    harness.get_by_label("note").click();
    settle(&mut harness);
    harness.event(egui::Event::Text(" they meet  here".into()));
    settle(&mut harness);
    assert!(harness.state().requests().is_empty(), "letters typed into a field trigger no shortcuts");
    press(&mut harness, Key::Enter);
    let written = Action::Note { time: 3_000_000_000, text: "they meet  here".to_owned() };
    assert_eq!(harness.state().actions, [written]);
    harness.state_mut().actions.clear();
    for key in [Key::Escape, Key::Enter] {
        harness.key_press_modifiers(Modifiers::SHIFT, Key::N);
        settle(&mut harness);
        harness.get_by_label("text of the note");
        if key == Key::Escape {
            harness.event(egui::Event::Text("never mind".into()));
            settle(&mut harness);
        }
        press(&mut harness, key);
        assert!(harness.query_by_label("text of the note").is_none(), "{key:?}");
    }
    assert!(harness.state().actions.is_empty(), "neither one that was dropped, nor one without a text");
}

#[test]
fn a_click_on_the_minimap_moves_the_camera_there() {
    let mut fixture = Fixture::new(5);
    fixture.interface.settings.minimap = true;
    let mut harness = harness(fixture);
    let map = harness.get_by_label("minimap").rect();
    let bounds = Bounds::default();
    for part in [egui::vec2(0.25, 0.25), egui::vec2(0.75, 0.5)] {
        let at = map.min + part * map.size();
        harness.drag_at(at);
        harness.drop_at(at);
        settle(&mut harness);
        let extent = bounds.high - bounds.low;
        let expected = bounds.low + Vec2::new(part.x, 1.0 - part.y) * extent;
        let target = harness.state().interface.camera_controller.camera().target.truncate();
        assert!(target.distance(expected) < 0.02 * extent.length(), "{target} instead of {expected}");
    }
    assert!(!harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })), "not the picture");
}

#[test]
fn a_click_on_the_view_cube_turns_the_camera() {
    let mut harness = harness(Fixture::new(5));
    let cube = harness.get_by_label("view cube").rect();
    harness.drag_at(cube.center() - egui::vec2(0.0, 14.0));
    harness.drop_at(cube.center() - egui::vec2(0.0, 14.0));
    harness.run_steps(80);
    let camera = harness.state().interface.camera_controller.camera();
    assert!((camera.pitch - core::f32::consts::FRAC_PI_2).abs() < 0.02, "its top is above: {camera:?}");
    assert!(!harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })), "not the picture");
}

fn orders(harness: &Harness<'_, Fixture>) -> Vec<UserOrder> {
    let orders = harness.state().actions.iter().filter_map(|action| match action {
        Action::Order(order) => Some(*order),
        _ => None,
    });
    orders.collect()
}

/// Opens the menu of an item in the middle of the picture, and clicks an entry.
fn choose(harness: &mut Harness<'_, Fixture>, item: Item, entry: &str) {
    harness.state_mut().actions.clear();
    harness.state_mut().interface.open_menu(Some(item), pos2(600.0, 300.0));
    settle(harness);
    harness.get_by_label(entry).click();
    settle(harness);
}

#[test]
fn a_right_click_asks_for_the_menu_and_escape_or_a_click_elsewhere_closes_it() {
    let mut harness = harness(Fixture::new(5));
    let at = pos2(600.0, 300.0);
    harness.hover_at(at);
    harness.run_steps(2);
    for pressed in [true, false] {
        let button = egui::PointerButton::Secondary;
        harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
        harness.run_steps(1);
    }
    settle(&mut harness);
    let asked = harness.state().actions.iter().find_map(|action| match action {
        Action::Menu { at, window } => Some((*at, *window)),
        _ => None,
    });
    let (picture, window) = asked.expect("the menu is asked for");
    assert_eq!(window, Vec2::new(600.0, 300.0));
    assert_eq!(window - picture, Vec2::new(8.0, 50.0), "below the top bar, within the harness's margin of 8 points");
    for by_key in [true, false] {
        harness.state_mut().interface.open_menu(Some(Item::Edge(0)), at);
        settle(&mut harness);
        harness.get_by_label("Close edge");
        if by_key {
            press(&mut harness, Key::Escape);
        } else {
            harness.drag_at(pos2(300.0, 500.0));
            harness.drop_at(pos2(300.0, 500.0));
            settle(&mut harness);
        }
        assert!(harness.query_by_label("Close edge").is_none(), "{by_key}");
    }
    assert!(orders(&harness).is_empty());
}

#[test]
fn the_menu_gives_orders_and_undoes_them() {
    let mut harness = harness(Fixture::new(5));
    choose(&mut harness, Item::Robot(2), "Hold");
    assert_eq!(orders(&harness), [UserOrder::Hold(2)]);
    assert!(harness.query_by_label("Break down").is_none(), "the menu is closed");
    choose(&mut harness, Item::Robot(1), "Resume");
    assert_eq!(orders(&harness), [UserOrder::Resume(1)], "this one is held");
    choose(&mut harness, Item::Robot(2), "Break down");
    assert_eq!(orders(&harness), [UserOrder::Break(2)]);
    let fixture = harness.state_mut();
    ColumnsMut::split(&mut fixture.lines, 5).state[2] = RobotState::Broken as u8;
    choose(&mut harness, Item::Robot(2), "Repair");
    assert_eq!(orders(&harness), [UserOrder::Repair(2)]);
    choose(&mut harness, Item::Edge(0), "Close edge");
    assert_eq!(orders(&harness), [UserOrder::Close(34)]);
    harness.state_mut().closed = vec![0];
    choose(&mut harness, Item::Edge(0), "Open edge");
    assert_eq!(orders(&harness), [UserOrder::Open(34)]);
    harness.get_by_label("closed (1)");
}

#[test]
fn selected_robots_are_sent_to_a_node_unless_a_manager_steers_them() {
    let mut harness = harness(Fixture::new(5));
    choose(&mut harness, Item::Node(1), "Send here");
    assert!(orders(&harness).is_empty(), "nobody is selected");
    harness.state_mut().interface.select(Some(Item::Robot(4)));
    choose(&mut harness, Item::Node(1), "Send robot 4 here");
    assert_eq!(orders(&harness), [UserOrder::Send { robot: 4, node: 8 }]);
    harness.state_mut().interface.toggle_selected(Item::Robot(2));
    choose(&mut harness, Item::Node(0), "Send 2 robots here");
    assert_eq!(orders(&harness), [2, 4].map(|robot| UserOrder::Send { robot, node: 7 }));
    harness.state_mut().plans.has_goals = true;
    choose(&mut harness, Item::Node(0), "Send 2 robots here");
    assert!(orders(&harness).is_empty(), "the manager would stop them");
}

#[test]
fn recordings_and_the_past_take_no_orders() {
    let mut past = Fixture::new(5);
    past.is_past = true;
    let mut gone = Fixture::new(5);
    gone.engine = EngineState::Gone;
    let reasons = ["This is a recording", "This is the past", "The engine has ended."];
    for (fixture, reason) in [replay(1.0), past, gone].into_iter().zip(reasons) {
        let mut harness = harness(fixture);
        choose(&mut harness, Item::Edge(0), "Close edge");
        assert!(orders(&harness).is_empty(), "{reason}");
        harness.get_by_label_contains(reason);
    }
}

/// An entry about a robot.
fn entry(time: u64, kind: Kind, robot: u32, text: &str) -> Entry {
    let severity = Severity::Warning;
    Entry {
        time_nanos: time * 1_000_000_000,
        kind,
        severity,
        robot: Some(robot),
        place: Place::None,
        text: text.into(),
    }
}

#[test]
fn alarms_are_acknowledged_and_entries_filtered_and_jumped_to() {
    let mut fixture = Fixture::new(50);
    fixture.interface.settings.left = Some(LeftPanel::Log);
    let news = vec![
        (entry(3, Kind::Fault, 7, "robot 7 broke down"), AlarmChange::Begins(AlarmKey::Robot(7))),
        (entry(4, Kind::Stop, 9, "robot 9 stalls"), AlarmChange::None),
        (Entry { robot: None, place: Place::Edge(34), ..entry(5, Kind::Edge, 0, "edge 34 closed") }, AlarmChange::None),
    ];
    fixture.interface.log().take(LogReport { news, ..LogReport::default() });
    let mut harness = harness(fixture);
    harness.get_by_label("1 alarm");
    harness.get_by_label("Alarms 1");
    harness.get_by_label("acknowledge Robot(7)").click();
    settle(&mut harness);
    assert_eq!(harness.state_mut().interface.log().unacknowledged(), 0);
    harness.get_by_label("1 alarm");
    let over = (entry(6, Kind::Fault, 7, "robot 7 repaired"), AlarmChange::Ends(AlarmKey::Robot(7)));
    harness.state_mut().interface.log().take(LogReport { news: vec![over], ..LogReport::default() });
    settle(&mut harness);
    harness.get_by_label("no alarms");
    harness.get_by_label_contains("robot 9 stalls").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(9)));
    harness.get_by_label_contains("edge 34 closed").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Item::Edge(0)));
    harness.get_by_label("text of entries").click();
    settle(&mut harness);
    harness.event(egui::Event::Text("#7".into()));
    settle(&mut harness);
    assert!(harness.query_by_label_contains("robot 9 stalls").is_none());
    harness.get_by_label_contains("robot 7 broke down");
}

#[test]
fn the_log_of_a_recording_jumps_to_its_marks() {
    let mut fixture = replay(1.0);
    fixture.interface.settings.left = Some(LeftPanel::Log);
    let mut harness = harness(fixture);
    harness.get_by_label("2 marks");
    harness.get_by_label_contains("robot 3 and 1 more broke down").click();
    settle(&mut harness);
    let sought = harness.state().requests().into_iter().find(|(kind, ..)| *kind == ControlKind::Seek);
    assert_eq!(sought.map(|(_, time, _)| time), Some(6_000_000_000));
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(3)));
}
