//! The behaviour of the interface in a window of a usual size.

use egui::Key;
use egui_kittest::kittest::Queryable;
use glam::{Vec2, Vec3};
use regatta_interface::Interface;
use regatta_interface::camera_controller::CameraController;
use regatta_interface::jams::{EdgeFacts, NodeFacts, Presence};
use regatta_interface::measure::End;
use regatta_interface::settings::{LeftPanel, RightPanel, Settings};
use regatta_interface::view_model::{Action, Item};
use regatta_plugin::frame::ColumnsMut;

use crate::camera::{middle_of_free_part, seen_at};
use crate::fixture::{USUAL, harness};

#[test]
fn keys_right_after_the_search_shortcut_are_for_the_search() {
    let mut harness = harness(USUAL, 1.0, |_| {});
    // All in one picture, as at a low rate.
    let key = |key, modifiers| egui::Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    };
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
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(17)));
    assert_eq!(
        harness.state().interface.settings.left,
        Some(LeftPanel::Fleet),
        "1 is no shortcut there"
    );
}

#[test]
fn an_edge_lists_its_robots_and_a_column_of_categories_its_word() {
    let mut harness = harness(USUAL, 1.0, |interface| interface.select(Some(Item::Edge(0))));
    harness.state_mut().jams.edges = vec![EdgeFacts {
        present: Presence { robots: 14, waiting: 0, listed: (0..12).collect() },
        ..EdgeFacts::default()
    }];
    harness.run_steps(4);
    harness.get_by_label("ROBOTS ON IT: 14");
    harness.get_by_label("and 2\u{a0}more");
    harness.get_by_label("robot 4").click();
    harness.run_steps(4);
    assert_eq!(harness.state().interface.selection.item, Some(Item::Robot(4)));
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
    let mut harness = harness(USUAL, 1.0, |_| {});
    harness.key_press(Key::M);
    harness.run_steps(4);
    harness.get_by_label("measure: click a robot or a place");
    let at = egui::pos2(640.0, 300.0);
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(3);
    let asked =
        harness.state().actions.iter().any(|action| matches!(action, Action::Measure { .. }));
    assert!(
        asked
            && !harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. }))
    );
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
    let mut harness = harness(USUAL, 1.0, |interface| interface.select(Some(Item::Robot(3))));
    harness.key_press(Key::J);
    for step in 0..120 {
        let fixture = harness.state_mut();
        fixture.header.sim_time_nanos += 10_000_000;
        ColumnsMut::split(&mut fixture.lines, 20).y[3] = step as f32 * 0.05;
        harness.run_steps(1);
        if !harness.state().interface.camera_controller.is_flying() {
            let robot = Vec3::new(3.0, step as f32 * 0.05, 0.25);
            let (at, middle) = (seen_at(&harness, robot), middle_of_free_part(&harness));
            // A hundred points are a metre.
            assert!(
                (at - middle).abs().max_element() < 15.0 && step > 1,
                "after {step} pictures: {at} {middle}"
            );
            return;
        }
    }
    panic!("the flight ends");
}
