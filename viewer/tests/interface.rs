//! The interface, driven as a person drives it: egui_kittest clicks, types and presses keys on made-up facts.

use egui::{Key, Modifiers, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::Vec2;
use regatta_plugin::Frame;
use regatta_plugin::contact::{ContactHeader, ContactRecord, Contacts};
use regatta_plugin::control::{ControlKind, ControlResponse};
use regatta_plugin::frame::{ClockState, ColumnsMut, FrameHeader, Line, RobotState, frame_lines, stride_lines};
use regatta_plugin::world::{EdgeRecord, NodeRecord};
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::feed::Counts;
use regatta_viewer::interface::Interface;
use regatta_viewer::interface::facts::{Action, Engine, Facts, Thing};
use regatta_viewer::interface::labels::Labels;
use regatta_viewer::interface::performance::Timing;
use regatta_viewer::interface::rig::{Follow, Rig};
use regatta_viewer::interface::rows::{Rows, SortBy};
use regatta_viewer::interface::settings::{Left, Right, Settings};
use regatta_viewer::palette::{Colouring, Legend, Theme};
use regatta_viewer::route::{Remaining, RouteLength};

/// A fleet that stands in a row, and the interface over it.
struct Desk {
    interface: Interface,
    header: FrameHeader,
    lines: Vec<Line>,
    nodes: Vec<NodeRecord>,
    edges: Vec<EdgeRecord>,
    labels: Labels,
    pairs: Vec<ContactRecord>,
    route: Option<Remaining>,
    rows: Option<Rows>,
    status: Option<ControlResponse>,
    engine: Engine,
    timing: Timing,
    legend: Legend,
    actions: Vec<Action>,
}

impl Desk {
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
            interface: Interface::new(Settings::default(), Rig::new(Camera::default(), true)),
            header,
            lines,
            nodes: vec![
                NodeRecord { id: 7, x: 1.0, y: 2.0, theta: 0.0 },
                NodeRecord { id: 8, ..NodeRecord::default() },
            ],
            edges: vec![EdgeRecord { id: 34, origin: 0, destination: 1, length: 5.0, ..EdgeRecord::default() }],
            labels: Labels::default(),
            pairs: Vec::new(),
            route: None,
            rows: None,
            status: Some(ControlResponse { robots: robots as u32, speed: 1.0, ..ControlResponse::default() }),
            engine: Engine::Running,
            timing: Timing::new("an adapter".into()),
            legend: Colouring::default().legend(Theme::Dark, &[], None),
            actions: Vec::new(),
        }
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let touching = self.pairs.len() as u32;
        let contact_header = ContactHeader { touching, touching_ever: 9, ..ContactHeader::default() };
        let facts = Facts {
            fleet: "test",
            engine: self.engine,
            status: self.status.as_ref(),
            frame: (self.engine != Engine::Awaited).then(|| Frame::new(&self.header, &self.lines).expect("a frame")),
            nodes: &self.nodes,
            edges: &self.edges,
            labels: &self.labels,
            types: &[],
            kinds: None,
            contacts: Some(Contacts { header: &contact_header, pairs: &self.pairs, missed: 0 }),
            legend: &self.legend,
            columns: &["battery".parse().expect("a name")],
            values: &[("battery".parse().expect("a name"), 0.75)],
            route: self.route,
            rows: self.rows.as_ref(),
            bounds: Bounds::default(),
            followed: None,
            timing: &self.timing,
            counts: Counts { read: 1234, skipped: 5 },
            lag: Some(0.001),
            trail_points: 0,
            udp: [false, false],
        };
        let (_, actions) = self.interface.show(ui, &facts);
        self.actions.extend(actions);
    }

    fn sent(&self) -> Vec<(ControlKind, u64, f32)> {
        let requests = self.actions.iter().filter_map(|action| match action {
            Action::Control(request) => Some((request.kind()?, request.count, request.speed)),
            _ => None,
        });
        requests.collect()
    }
}

fn harness(desk: Desk) -> Harness<'static, Desk> {
    let builder = Harness::builder().with_size([1280.0, 720.0]).with_max_steps(64);
    let mut harness = builder.build_ui_state(|ui, desk: &mut Desk| desk.show(ui), desk);
    harness.run_ok();
    harness
}

/// Lets some pictures pass: what spins or counts down never comes to rest.
fn settle(harness: &mut Harness<'_, Desk>) {
    harness.run_steps(6);
}

fn press(harness: &mut Harness<'_, Desk>, key: Key) {
    harness.key_press(key);
    settle(harness);
}

#[test]
fn the_clock_is_stopped_stepped_and_let_go() {
    let mut harness = harness(Desk::new(5));
    harness.get_by_label("Pause").click();
    settle(&mut harness);
    assert_eq!(harness.state().sent(), [(ControlKind::Pause, 0, 0.0)]);
    harness.state_mut().actions.clear();
    harness.state_mut().header.clock = ClockState::Paused as u32;
    settle(&mut harness);
    harness.get_by_label("Step").click();
    settle(&mut harness);
    harness.get_by_label("Resume").click();
    settle(&mut harness);
    assert_eq!(harness.state().sent(), [(ControlKind::Step, 1, 0.0), (ControlKind::Resume, 0, 0.0)]);
}

#[test]
fn keys_do_what_the_buttons_do() {
    let mut harness = harness(Desk::new(5));
    for key in [Key::Space, Key::CloseBracket, Key::OpenBracket, Key::I] {
        press(&mut harness, key);
    }
    let sent = harness.state().sent();
    let wanted = [
        (ControlKind::Pause, 0, 0.0),
        (ControlKind::Speed, 0, 2.0),
        (ControlKind::Speed, 0, 0.5),
        (ControlKind::Robots, 6, 0.0),
    ];
    assert_eq!(sent, wanted);
}

#[test]
fn without_an_engine_it_waits_and_sends_nothing() {
    let mut desk = Desk::new(5);
    (desk.engine, desk.status) = (Engine::Awaited, None);
    let mut harness = harness(desk);
    settle(&mut harness);
    harness.get_by_label("Waiting for fleet 'test'");
    harness.get_by_label("Pause").click();
    settle(&mut harness);
    assert!(harness.state().sent().is_empty());
}

#[test]
fn a_robot_is_found_by_its_id_and_flown_to() {
    let mut harness = harness(Desk::new(500));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.left, Some(Left::Fleet));
    harness.event(egui::Event::Text("321".into()));
    settle(&mut harness);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().interface.selected, Some(Thing::Robot(321)));
    harness.run_steps(120);
    let target = harness.state().interface.rig.camera().target;
    assert!(target.truncate().distance(Vec2::new(321.0, -321.0)) < 0.01, "{target}");
    harness.get_by_label("Robot 321");
    assert!(harness.state().sent().is_empty(), "digits in a field are no keys");
}

#[test]
fn the_list_shows_the_rows_that_are_in_sight_of_a_million() {
    let mut desk = Desk::new(1_000_000);
    desk.interface.settings.left = Some(Left::Fleet);
    let mut harness = harness(desk);
    harness.get_by_label("robot 0");
    assert!(harness.query_by_label("robot 100").is_none());
    harness.get_by_label("sort by id").click();
    settle(&mut harness);
    harness.get_by_label("robot 999999").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Thing::Robot(999_999)));
    for _ in 0..3 {
        press(&mut harness, Key::PageDown);
    }
    assert!(harness.query_by_label("robot 999999").is_none(), "three pages on");
    harness.get_by_label("sort by x").click();
    settle(&mut harness);
    let asked = harness.state().actions.iter().rev().find_map(|action| match action {
        Action::Rows(query) => Some(query.clone()),
        _ => None,
    });
    let query = asked.expect("rows are asked for");
    assert_eq!((query.sort, query.descending), (SortBy::X, false));
    harness.state_mut().rows = Some(Rows { query, ids: vec![42, 17, 4] });
    settle(&mut harness);
    harness.get_by_label("robot 17");
    assert!(harness.query_by_label("robot 1").is_none());
}

#[test]
fn a_click_on_a_collision_flies_there() {
    let mut desk = Desk::new(50);
    desk.interface.settings.left = Some(Left::Collisions);
    desk.pairs = vec![ContactRecord { robots: [3, 9], level: 2, x: 30.0, y: -12.0, ..ContactRecord::default() }];
    let mut harness = harness(desk);
    harness.get_by_label("1");
    harness.get_by_label("robots 3 and 9 touching").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Thing::Robot(3)));
    assert_eq!(harness.state().interface.robots(), [3, 9]);
    harness.run_steps(120);
    let target = harness.state().interface.rig.camera().target;
    assert!(target.truncate().distance(Vec2::new(30.0, -12.0)) < 0.01, "{target}");
    harness.get_by_label("robot 9").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Thing::Robot(9)), "the other one of the pair");
}

#[test]
fn the_picture_is_dragged_zoomed_and_picked() {
    let mut harness = harness(Desk::new(5));
    let before = harness.state().interface.rig.camera();
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
    let turned = harness.state().interface.rig.camera();
    assert!(turned.pitch > before.pitch + 0.1 && (turned.yaw - before.yaw).abs() < 1e-5, "{before:?} {turned:?}");
    // A pointer that drops something leaves the window.
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
    let zoomed = harness.state().interface.rig.camera();
    assert!(zoomed.distance < turned.distance * 0.7, "{turned:?} {zoomed:?}");
    assert!(!harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })), "a drag is no click");
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(2);
    assert!(harness.state().actions.iter().any(|action| matches!(action, Action::Pick { beside: false, .. })));
}

#[test]
fn a_whole_drag_between_two_pictures_is_a_drag() {
    let mut harness = harness(Desk::new(5));
    let before = harness.state().interface.rig.camera();
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
    let moved = harness.state().interface.rig.camera();
    assert!(moved.target.distance(before.target) > 0.1, "{before:?} {moved:?}");
    assert_eq!((moved.yaw, moved.pitch), (before.yaw, before.pitch));
}

#[test]
fn held_keys_move_the_camera() {
    let mut harness = harness(Desk::new(5));
    let before = harness.state().interface.rig.camera();
    harness.key_down(Key::W);
    harness.run_steps(10);
    harness.key_up(Key::W);
    harness.run_steps(2);
    let after = harness.state().interface.rig.camera();
    let way = (after.target - before.target).truncate();
    assert!(way.dot(Vec2::from_angle(before.yaw)) > 0.1, "{way}");
    harness.run_steps(10);
    assert_eq!(harness.state().interface.rig.camera(), after, "it stands when the key is up");
}

#[test]
fn following_goes_through_its_ways_by_one_key() {
    let mut harness = harness(Desk::new(5));
    press(&mut harness, Key::N);
    let mut ways = Vec::new();
    for _ in 0..3 {
        press(&mut harness, Key::F);
        ways.push(harness.state().interface.rig.followed());
    }
    assert_eq!(ways, [Some((0, Follow::Behind)), Some((0, Follow::Above)), None]);
    press(&mut harness, Key::Escape);
    assert_eq!(harness.state().interface.selected, None);
}

#[test]
fn panels_and_choices_have_keys_and_the_help_lists_them() {
    let mut harness = harness(Desk::new(5));
    for (key, panel) in [
        (Key::Num3, Right::Selection),
        (Key::Num4, Right::View),
        (Key::Num5, Right::Performance),
        (Key::Num6, Right::Connection),
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
fn an_edge_and_its_nodes_tell_of_each_other() {
    let mut harness = harness(Desk::new(5));
    harness.state_mut().interface.select(Some(Thing::Edge(0)));
    settle(&mut harness);
    harness.get_by_label("Edge 34");
    harness.get_by_label("node 7").click();
    settle(&mut harness);
    harness.get_by_label("Node 7");
    harness.get_by_label("edge 34").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.selected, Some(Thing::Edge(0)));
}

#[test]
fn a_robot_that_is_gone_is_told_so() {
    let mut harness = harness(Desk::new(5));
    harness.state_mut().interface.select(Some(Thing::Robot(77)));
    settle(&mut harness);
    harness.get_by_label("is not in the fleet now");
}

#[test]
fn udp_is_started_with_what_was_typed() {
    let mut harness = harness(Desk::new(5));
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
fn files_for_floor_and_robots_are_typed_or_dropped() {
    let mut harness = harness(Desk::new(5));
    press(&mut harness, Key::Num4);
    let line = harness.get_by_label("floor file");
    line.focus();
    line.type_text("map.yaml");
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "", "not yet");
    harness.get_all_by_label("load").next().expect("a button").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "map.yaml");
    harness.state_mut().interface.take_file(std::path::Path::new("tug.STL"));
    settle(&mut harness);
    let mesh = harness.state().interface.settings.mesh.clone().expect("a mesh");
    assert_eq!((mesh.file.as_str(), mesh.scale, mesh.z), ("tug.STL", 1.0, 0.0));
    harness.get_all_by_label("remove").next().expect("a button").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.floor_image, "");
    assert!(harness.state().interface.settings.mesh.is_some());
    harness.get_by_label("add a lamp").click();
    settle(&mut harness);
    assert_eq!(harness.state().interface.settings.lamps.len(), 1);
}

#[test]
fn the_panel_tells_how_much_of_a_route_is_left() {
    let mut desk = Desk::new(5);
    let released = RouteLength { edges: 1, metres: 4.25, is_partial: false };
    desk.route = Some(Remaining { released, planned: RouteLength { edges: 300, metres: 812.0, is_partial: true } });
    desk.interface.select(Some(Thing::Robot(2)));
    let mut harness = harness(desk);
    settle(&mut harness);
    assert!(harness.query_by_label("1 edge, 4.2 m").is_some());
    assert!(harness.query_by_label("300 edges, > 812.0 m").is_some());
    harness.state_mut().route = Some(Remaining::default());
    settle(&mut harness);
    assert!(harness.query_by_label("nothing to drive").is_some());
    harness.state_mut().route = None;
    settle(&mut harness);
    assert!(harness.query_by_label("ROUTE").is_none(), "nobody knows it");
}

#[test]
fn robots_are_selected_beside_others() {
    let mut desk = Desk::new(50);
    desk.interface.settings.left = Some(Left::Fleet);
    let mut harness = harness(desk);
    let rows = |harness: &Harness<'_, Desk>| harness.state().interface.robots();
    let click = |harness: &mut Harness<'_, Desk>, robot: u32, modifiers: Modifiers| {
        harness.get_by_label(&format!("robot {robot}")).click_modifiers(modifiers);
        settle(harness);
    };
    click(&mut harness, 3, Modifiers::NONE);
    click(&mut harness, 5, Modifiers::COMMAND);
    click(&mut harness, 7, Modifiers::COMMAND);
    assert_eq!(rows(&harness), [7, 5, 3]);
    harness.get_by_label("Robot 7");
    click(&mut harness, 7, Modifiers::COMMAND);
    assert_eq!(rows(&harness), [5, 3], "a second time takes it out");
    harness.get_by_label("3").click();
    settle(&mut harness);
    assert_eq!(rows(&harness), [3, 5], "a click on another of them shows that one");
    harness.get_by_label("Robot 3");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::F);
    settle(&mut harness);
    harness.event(egui::Event::Text("41".into()));
    settle(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Enter);
    settle(&mut harness);
    assert_eq!(rows(&harness), [41, 3, 5], "without a mouse");
    press(&mut harness, Key::Enter);
    assert_eq!(rows(&harness), [41], "alone");
    press(&mut harness, Key::Escape);
    assert!(rows(&harness).is_empty());
}
