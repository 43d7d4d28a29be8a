//! The layout of the interface at several sizes of the window and scales: no two controls overlap, and none is cut.

use egui::{Key, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::Vec2;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::frame::{ColumnsMut, Frame, FrameHeader, Line, frame_lines, stride_lines};
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::feed::Counts;
use regatta_viewer::interface::Interface;
use regatta_viewer::interface::camera_controller::CameraController;
use regatta_viewer::interface::labels::Labels;
use regatta_viewer::interface::measure::End;
use regatta_viewer::interface::settings::{LeftPanel, RightPanel, Settings};
use regatta_viewer::interface::timing::Timing;
use regatta_viewer::interface::view_model::{Action, EngineState, Item, ViewModel};
use regatta_viewer::jams::presence::Presence;
use regatta_viewer::jams::{EdgeFacts, JamFacts, NodeFacts};
use regatta_viewer::log::{AlarmChange, AlarmKey, Entry, Kind, LogReport, Place, Severity};
use regatta_viewer::palette::{Colouring, Legend, Theme};
use regatta_viewer::plans::PlanFacts;

/// The sizes of the window in pixels, and the scales.
const SIZES: [[f32; 2]; 3] = [[640.0, 400.0], [1280.0, 720.0], [1920.0, 1080.0]];
const SCALES: [f32; 2] = [1.0, 1.5];

/// Twenty robots on an edge.
struct Fixture {
    interface: Interface,
    header: FrameHeader,
    lines: Vec<Line>,
    world: WorldData,
    labels: Labels,
    jams: JamFacts,
    timing: Timing,
    legend: Legend,
    picture: Rect,
    actions: Vec<Action>,
}

impl Fixture {
    fn new() -> Self {
        let robots = 20;
        let header = FrameHeader {
            run_id: 1,
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            sim_time_nanos: 83_456_000_000,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(robots)];
        let columns = ColumnsMut::split(&mut lines, robots);
        (0..robots).for_each(|i| (columns.x[i], columns.state[i], columns.edge[i]) = (i as f32, 1, (i % 2) as u32));
        let mut world = WorldData {
            nodes: vec![
                NodeRecord { id: 446, ..NodeRecord::default() },
                NodeRecord { id: 7, x: 20.0, ..NodeRecord::default() },
            ],
            ..WorldData::default()
        };
        let edge = EdgeRecord { id: 567, origin: 0, destination: 1, length: 20.0, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [20.0, 0.0])]);
        Self {
            interface: Interface::new(Settings::default(), CameraController::new(Camera::default(), true)),
            header,
            lines,
            labels: Labels::new(&world.view(1, 1), None),
            world,
            jams: JamFacts::default(),
            timing: Timing::new("an adapter".into()),
            legend: Colouring::default().legend(Theme::Dark, &[], None),
            picture: Rect::ZERO,
            actions: Vec::new(),
        }
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let status = ControlResponse { robots: 20, speed: 1.0, ..ControlResponse::default() };
        let model = ViewModel {
            timeline: None,
            jams: &self.jams,
            density: None,
            closed: &[],
            fleet: "a-fleet-with-a-long-name",
            engine: EngineState::Running,
            status: Some(&status),
            frame: Some(Frame::new(&self.header, &self.lines).expect("a frame")),
            world: self.world.view(1, 1),
            labels: &self.labels,
            robot_type_column: None,
            contacts: None,
            legend: &self.legend,
            columns: &[],
            values: &[("collision".parse().expect("a name"), 2.0)],
            task: None,
            route: None,
            plans: PlanFacts::default(),
            rows: None,
            matches: None,
            bounds: Bounds::default(),
            followed: None,
            timing: &self.timing,
            counts: Counts::default(),
            lag: None,
            trail_points: 0,
            udp: [false, false],
        };
        let (picture, actions) = self.interface.show(ui, &model);
        self.picture = picture;
        self.actions.extend(actions);
    }
}

fn harness([width, height]: [f32; 2], scale: f32, prepare: impl FnOnce(&mut Interface)) -> Harness<'static, Fixture> {
    let mut fixture = Fixture::new();
    fixture.interface.settings.scale = scale;
    prepare(&mut fixture.interface);
    let builder = Harness::builder().with_size([width, height]).with_max_steps(64);
    let mut harness = builder.build_ui_state(|ui, fixture: &mut Fixture| fixture.show(ui), fixture);
    harness.run_steps(8);
    harness
}

/// What the names of rows of lists contain.
const ROWS: [&str; 3] = ["'robot ", "'acknowledge ", " broke down "];

/// Checks the controls in panels, of which the ones below the window's end are scrolled to: none is cut at its sides, and no two
/// that are in sight overlap. Returns how many are in sight.
fn check_panels(harness: &Harness<'_, Fixture>, [width, height]: [f32; 2], what: &str) -> usize {
    let scale = harness.state().interface.settings.scale;
    // Between the bar at the top and the one at the bottom.
    let area = Rect::from_min_max(egui::pos2(0.0, 42.0), egui::pos2(width / scale, height / scale - 48.0));
    let in_sight = |rect: &Rect| rect.top() >= area.top() && rect.bottom() <= area.bottom();
    // Rows of lists are drawn beyond the ends of their lists, and cut there.
    let is_row = |name: &str| ROWS.iter().any(|row| name.contains(row));
    let all = controls(harness).into_iter();
    let controls: Vec<_> = all.filter(|(name, rect)| in_sight(rect) && !is_row(name)).collect();
    no_overlap(&controls, area, what);
    controls.len()
}

/// Checks the controls of the bars: they are whole, and don't overlap. `area` is the window, in points.
fn check(harness: &Harness<'_, Fixture>, [width, height]: [f32; 2], what: &str) {
    let scale = harness.state().interface.settings.scale;
    let area = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height) / scale);
    let controls = controls(harness);
    assert!(controls.len() > 4, "{what}: {controls:?}");
    no_overlap(&controls, area, what);
}

/// The names and places of all controls.
fn controls(harness: &Harness<'_, Fixture>) -> Vec<(String, Rect)> {
    let is_control = |role: egui::accesskit::Role| {
        use egui::accesskit::Role::{Button, CheckBox, ComboBox, Slider, SpinButton, TextInput};
        matches!(role, Button | CheckBox | ComboBox | Slider | SpinButton | TextInput)
    };
    let mut controls = Vec::new();
    for node in harness.root().children_recursive() {
        let (role, name) = (node.accesskit_node().role(), node.accesskit_node().label().unwrap_or_default());
        if is_control(role) && node.rect().is_positive() {
            controls.push((format!("{role:?} '{name}'"), node.rect()));
        }
    }
    controls
}

fn no_overlap(controls: &[(String, Rect)], area: Rect, what: &str) {
    for (i, (name, rect)) in controls.iter().enumerate() {
        assert!(area.expand(0.6).contains_rect(*rect), "{what}: {name} at {rect:?} is cut by {area:?}");
        for (other, beside) in &controls[..i] {
            let common = rect.intersect(*beside);
            let nested = rect.expand(0.5).contains_rect(*beside) || beside.expand(0.5).contains_rect(*rect);
            let overlap = common.width() > 0.6 && common.height() > 0.6 && !nested;
            assert!(!overlap, "{what}: {name} {rect:?} over {other} {beside:?}");
        }
    }
}

#[test]
fn the_bars_fit_into_windows_of_all_sizes() {
    for size in SIZES {
        for scale in SCALES {
            let harness = harness(size, scale, |_| {});
            check(&harness, size, &format!("{size:?} at {scale}"));
        }
    }
}

#[test]
fn panels_fit_into_windows_of_all_sizes() {
    let mut controls = 0;
    for size in SIZES {
        for scale in SCALES {
            for right in [RightPanel::Performance, RightPanel::Selection, RightPanel::View, RightPanel::Connection] {
                // A narrow window has room for one panel.
                let left = (size[0] / scale >= 900.0).then_some(LeftPanel::Fleet);
                let harness = harness(size, scale, |interface| {
                    interface.select(Some(Item::Robot(3)));
                    (interface.settings.left, interface.settings.right) = (left, Some(right));
                });
                let links = harness.query_all_by_label("robot 3").count();
                assert_eq!(links > 0, left.is_some(), "the list of robots: {size:?} at {scale}");
                controls += check_panels(&harness, size, &format!("{right:?}, {size:?} at {scale}"));
            }
        }
    }
    assert!(controls > 200, "{controls} controls were compared");
}

#[test]
fn the_menu_and_the_log_fit_into_windows_of_all_sizes() {
    for size in SIZES {
        for scale in SCALES {
            let mut menu = harness(size, scale, |interface| {
                interface.select(Some(Item::Robot(3)));
                interface.settings.right = None;
                interface.open_menu(Some(Item::Robot(3)), egui::pos2(size[0], size[1]) / scale);
            });
            menu.run_steps(4);
            menu.get_by_label("Break down");
            check(&menu, size, &format!("menu, {size:?} at {scale}"));
            let alarm = |robot: u32| {
                let text = format!("robot {robot} broke down far away from everything that is near to anybody");
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
            let log = harness(size, scale, |interface| {
                interface.settings.left = Some(LeftPanel::Log);
                interface.log().take(LogReport { news: (0..40).map(alarm).collect(), ..LogReport::default() });
            });
            log.get_by_label("40 alarms");
            log.get_by_label("text of entries");
            check_panels(&log, size, &format!("log, {size:?} at {scale}"));
        }
    }
}

#[test]
fn lists_fit_into_windows_of_all_sizes() {
    for size in SIZES {
        for scale in SCALES {
            for left in [LeftPanel::Fleet, LeftPanel::Collisions, LeftPanel::Spots] {
                let harness = harness(size, scale, |interface| interface.settings.left = Some(left));
                check_panels(&harness, size, &format!("{left:?}, {size:?} at {scale}"));
            }
        }
    }
}

#[test]
fn the_help_fits_into_windows_of_all_sizes() {
    for size in SIZES {
        for scale in SCALES {
            let mut harness = harness(size, scale, |_| {});
            harness.key_press(Key::F1);
            harness.run_steps(6);
            let title = harness.get_by_label("Keys and mouse").rect();
            let last = harness.get_by_label("close the window").rect();
            let area = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(size[0], size[1]) / scale);
            assert!(area.contains_rect(title), "{size:?} at {scale}: {title:?}");
            // Texts below the window's end are scrolled to; none is beside it.
            assert!(
                last.right() <= area.right() && last.left() >= area.left(),
                "{size:?} at {scale}: {last:?} {area:?}"
            );
        }
    }
}

#[test]
fn the_picture_stays_where_it_is_when_a_panel_opens() {
    let mut harness = harness(SIZES[1], 1.0, |_| {});
    let before = (harness.state().picture, harness.state().interface.camera_controller.camera());
    for key in [Key::Num1, Key::Num4] {
        harness.key_press(key);
        harness.run_steps(6);
    }
    assert_eq!(harness.state().interface.settings.left, Some(LeftPanel::Fleet));
    assert_eq!((harness.state().picture, harness.state().interface.camera_controller.camera()), before);
    // What is fitted lies between the panels.
    harness.key_press(Key::O);
    harness.key_press(Key::Home);
    harness.run_steps(80);
    let (camera, picture) = (harness.state().interface.camera_controller.camera(), harness.state().picture);
    let size = Vec2::new(picture.width(), picture.height());
    for corner in [Bounds::default().low, Bounds::default().high] {
        let at = camera.project(corner.extend(0.0), size).expect("in sight");
        assert!(at.x > 290.0 && at.x < 1000.0 && at.cmpge(Vec2::ZERO).all() && at.y <= size.y, "{corner} at {at}");
    }
}

#[test]
fn keys_right_after_the_search_shortcut_are_for_the_search() {
    let mut harness = harness(SIZES[1], 1.0, |_| {});
    // All in one picture, as at a low rate.
    let key = |key, modifiers| egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
    let none = egui::Modifiers::NONE;
    for event in [
        key(Key::F, egui::Modifiers::COMMAND),
        key(Key::Num1, none),
        egui::Event::Text("1".into()),
        key(Key::Num7, none),
        egui::Event::Text("7".into()),
        key(Key::Enter, none),
    ] {
        harness.input_mut().events.push(event);
    }
    harness.run_steps(8);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(17)));
    assert_eq!(harness.state().interface.settings.left, Some(LeftPanel::Fleet), "1 is no shortcut there");
}

#[test]
fn an_edge_lists_its_robots_and_a_column_of_categories_its_word() {
    let mut harness = harness(SIZES[1], 1.0, |interface| interface.select(Some(Item::Edge(0))));
    harness.state_mut().jams.edges = vec![EdgeFacts {
        present: Presence { robots: 14, waiting: 0, listed: (0..12).collect() },
        ..EdgeFacts::default()
    }];
    harness.run_steps(4);
    harness.get_by_label("ROBOTS ON IT: 14");
    harness.get_by_label("and 2 more");
    harness.get_by_label("robot 4").click();
    harness.run_steps(4);
    assert_eq!(harness.state().interface.selected, Some(Item::Robot(4)));
    assert_eq!(harness.query_all_by_label("touching").count(), 2, "in the panel and in the legend");
    assert!(harness.query_by_label("2.000").is_none());
    harness.state_mut().interface.select(Some(Item::Node(0)));
    let present = Presence { robots: 1, waiting: 0, listed: vec![3] };
    harness.state_mut().jams.node = Some(NodeFacts { node: 0, present });
    harness.run_steps(4);
    harness.get_by_label("ROBOTS OVER IT: 1");
}

#[test]
fn an_empty_selection_panel_is_not_restored() {
    let settings = Settings { right: Some(RightPanel::Selection), ..Settings::default() };
    assert_eq!(Interface::new(settings, CameraController::default()).settings.right, None);
}

#[test]
fn clearance_is_measured_between_robots_and_distance_between_places() {
    let mut harness = harness(SIZES[1], 1.0, |_| {});
    harness.key_press(Key::M);
    harness.run_steps(4);
    harness.get_by_label("measure: click a robot or a place");
    let at = egui::pos2(640.0, 300.0);
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(3);
    let asked = harness.state().actions.iter().any(|action| matches!(action, Action::Measure { .. }));
    assert!(asked && !harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })));
    let interface = &mut harness.state_mut().interface;
    interface.measure_to(End::Place(Vec2::new(1.0, 2.0)));
    interface.measure_to(End::Place(Vec2::new(4.0, 6.0)));
    harness.run_steps(3);
    harness.get_by_label("distance 5.000 m, 53.1°");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label("distance 5.000 m, 53.1°").is_none());
}

#[test]
fn a_flight_to_a_moving_robot_arrives_where_it_is() {
    let mut harness = harness(SIZES[1], 1.0, |interface| interface.select(Some(Item::Robot(3))));
    harness.key_press(Key::J);
    for step in 0..120 {
        let fixture = harness.state_mut();
        fixture.header.sim_time_nanos += 10_000_000;
        ColumnsMut::split(&mut fixture.lines, 20).y[3] = step as f32 * 0.05;
        harness.run_steps(1);
        if !harness.state().interface.camera_controller.is_flying() {
            let target = harness.state().interface.camera_controller.camera().target;
            assert!((target.y - step as f32 * 0.05).abs() < 0.11 && step > 1, "after {step} pictures: {target}");
            return;
        }
    }
    panic!("the flight ends");
}
