//! The picture and its camera, while panels open and close.

use std::ops::RangeInclusive;

use egui::{Key, Rect};
use egui_kittest::Harness;
use glam::Vec2;
use regatta_viewer::camera::{Bounds, Camera};
use regatta_viewer::interface::camera_controller::CameraController;
use regatta_viewer::interface::settings::{LeftPanel, RightPanel};

use crate::fixture::{Fixture, USUAL, harness, harness_of};
use crate::states::past;

/// Where the picture is, and its camera.
fn view(harness: &Harness<'_, Fixture>) -> (Rect, Camera) {
    (harness.state().picture, harness.state().interface.camera_controller.camera())
}

/// Neither a camera that was placed nor one that is still fitted to the fleet.
#[test]
fn the_picture_stays_where_it_is_when_a_panel_opens() {
    for camera in
        [CameraController::new(Camera::default(), true), CameraController::default(), CameraController::plan()]
    {
        let mut harness = harness_of(USUAL, 1.0, |fixture| {
            past(fixture);
            fixture.interface.camera_controller = camera;
        });
        let before = view(&harness);
        // Panels on both sides, the plots, and the bar of the past; then they close again.
        for key in [Key::Num1, Key::Num4, Key::Num8, Key::U, Key::Num1, Key::Num9, Key::Num8, Key::U] {
            harness.key_press(key);
            harness.run_steps(6);
            assert_eq!(view(&harness), before, "after {key:?}");
        }
        assert_eq!(harness.state().interface.settings.left, Some(LeftPanel::Log));
    }
}

#[test]
fn an_untouched_camera_is_fitted_between_the_panels_of_the_first_picture_and_to_another_size() {
    let mut harness = harness(USUAL, 1.0, |interface| {
        interface.camera_controller = CameraController::plan();
        interface.settings.right = Some(RightPanel::View);
    });
    for width in [1280.0, 1600.0] {
        harness.set_size(egui::vec2(width, 720.0));
        harness.run_steps(6);
        is_between(&harness, 0.0..=width - 280.0);
    }
}

/// Checks that the fleet's bounds lie within a part of the picture, in points from its left side.
fn is_between(harness: &Harness<'_, Fixture>, part: RangeInclusive<f32>) {
    let (picture, camera) = view(harness);
    let size = Vec2::new(picture.width(), picture.height());
    let corners = [Bounds::default().low, Bounds::default().high];
    let at = corners.map(|corner| camera.project(corner.extend(0.0), size).expect("in sight"));
    let is_inside = |at: &Vec2| part.contains(&at.x) && (0.0..=size.y).contains(&at.y);
    assert!(at.iter().all(is_inside), "{at:?} in {part:?}");
    // It fills the part.
    let room = (part.end() - part.start()).min(size.y);
    assert!((at[1] - at[0]).abs().max_element() > 0.5 * room, "{at:?}");
}

#[test]
fn what_is_fitted_lies_between_the_panels() {
    let mut harness = harness(USUAL, 1.0, |_| {});
    for key in [Key::Num1, Key::Num4] {
        harness.key_press(key);
        harness.run_steps(6);
    }
    harness.key_press(Key::O);
    harness.key_press(Key::Home);
    harness.run_steps(80);
    is_between(&harness, 470.0..=1000.0);
    // And stays there when they close.
    let before = view(&harness);
    harness.key_press(Key::Num4);
    harness.run_steps(6);
    assert_eq!(view(&harness), before);
}
