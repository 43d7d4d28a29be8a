//! The picture and its camera, while panels open and close.

use std::ops::RangeInclusive;

use egui::{Key, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{Vec2, Vec3};
use regatta_interface::camera_controller::CameraController;
use regatta_interface::legend::LEGEND;
use regatta_interface::settings::{LeftPanel, RightPanel};
use regatta_interface::view_model::Item;
use regatta_plugin::work::WorkFigures;
use regatta_scene::camera::{Bounds, Camera, Window};
use regatta_scene::palette::{Colouring, Theme};

use crate::fixture::{Fixture, USUAL, harness, harness_of, windows};
use crate::states::{log_of, past};

/// The place of the picture, and its camera.
fn view(harness: &Harness<'_, Fixture>) -> (Rect, Camera) {
    (harness.state().picture, harness.state().interface.camera_controller.camera())
}

/// The place of a point of the world in the picture, in points of the window.
pub fn seen_at(harness: &Harness<'_, Fixture>, point: Vec3) -> Vec2 {
    let (picture, camera) = view(harness);
    let size = Vec2::new(picture.width(), picture.height());
    camera.project(point, size).expect("in sight") + Vec2::new(picture.left(), picture.top())
}

/// Whether the legend of a picture of this width is lines at its lower side.
fn is_narrow(width: f32) -> bool {
    width < 800.0
}

/// The middle of what is neither under a panel nor beside the legend, in points of the window.
pub fn middle_of_free_part(harness: &Harness<'_, Fixture>) -> Vec2 {
    let fixture = harness.state();
    let picture = fixture.picture;
    let mut left = fixture.panel("left").map_or(picture.left(), |panel| panel.right());
    let right = fixture.panel("right").map_or(picture.right(), |panel| panel.left());
    let mut bottom = fixture.plots().map_or(picture.bottom(), |panel| panel.top());
    if let Some((_, legend)) = fixture.interface.placed().iter().find(|(name, _)| *name == LEGEND) {
        match is_narrow(right - left) {
            true => bottom = legend.top() - 10.0,
            false => left = legend.right() + 10.0,
        }
    }
    Vec2::new(left + right, picture.top() + bottom) / 2.0
}

/// By a key, and from the log, with any panels: not under one of them, and not under the legend.
#[test]
fn a_flight_ends_in_the_middle_of_what_no_panel_covers() {
    let robot = Vec3::new(3.0, 0.0, 0.25);
    for (size, scale) in windows() {
        for (from_log, plots) in [(false, false), (false, true), (true, false)] {
            let mut harness = harness_of(size, scale, |fixture| {
                log_of(fixture, 4);
                fixture.interface.settings.plots = plots;
                fixture.interface.select((!from_log).then_some(Item::Robot(3)));
            });
            match from_log {
                true => harness
                    .get_all_by_label_contains("robot 3 broke")
                    .next()
                    .expect("an entry")
                    .click(),
                false => harness.key_press(Key::J),
            }
            harness.run_steps(80);
            let (at, middle) = (seen_at(&harness, robot), middle_of_free_part(&harness));
            let what =
                format!("{size:?} at {scale}, log {from_log}, plots {plots}: {at}, not {middle}");
            assert!(!harness.state().interface.camera_controller.is_flying(), "{what}");
            assert!((at.x - middle.x).abs() < 20.0 && (at.y - middle.y).abs() < 2.0, "{what}");
            let covers = |place: &Rect| place.contains(egui::pos2(at.x, at.y));
            let covered =
                harness.state().interface.placed().iter().find(|(_, place)| covers(place));
            assert_eq!(covered, None, "{what}");
        }
    }
}

#[test]
fn a_camera_that_was_placed_stays_where_it_is_when_a_panel_opens() {
    let mut harness = harness_of(USUAL, 1.0, |fixture| {
        past(fixture);
        fixture.interface.camera_controller = CameraController::new(Camera::default(), true);
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

#[test]
fn an_untouched_camera_is_fitted_anew_when_a_panel_opens_or_closes() {
    let mut harness = harness(USUAL, 1.0, |interface| {
        interface.camera_controller = CameraController::plan();
    });
    for (key, part) in [
        (Key::Num1, 290.0..=1280.0),
        (Key::Num4, 290.0..=1280.0),
        (Key::Num1, 0.0..=1000.0),
        (Key::Num4, 0.0..=1280.0),
    ] {
        harness.key_press(key);
        harness.run_steps(6);
        is_between(&harness, part);
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
    is_between(&harness, 290.0..=1280.0);
    // And fills the part that is free when one closes.
    harness.key_press(Key::Num1);
    harness.run_steps(6);
    is_between(&harness, 0.0..=1000.0);
}

/// The part of a window of 1280 × 800 points that a panel on each side leaves, with the plots or
/// without them.
fn share_of_the_plant(plots: bool) -> f32 {
    let mut harness = harness_of([1280.0, 800.0], 1.0, |fixture| {
        fixture.work = Some((1, WorkFigures::default()));
        fixture.interface.settings.plots = plots;
    });
    for key in [Key::Num1, Key::Num4] {
        harness.key_press(key);
        harness.run_steps(6);
    }
    let fixture = harness.state();
    let settings = &fixture.interface.settings;
    assert!(settings.left.is_some() && settings.right.is_some() && settings.plots == plots);
    let place = |name: &str| fixture.panel(name).expect("open");
    let window = place("top").union(place("bottom"));
    let low = fixture.plots().unwrap_or_else(|| place("bottom")).top();
    let size = egui::vec2(window.right() - place("left").right(), low - place("left").top());
    size.x * size.y / window.area()
}

#[test]
fn panels_leave_most_of_the_window_to_the_plant() {
    let shares = [false, true].map(share_of_the_plant);
    assert!(shares[0] >= 0.65 && shares[1] >= 0.6, "{shares:?}");
}

#[test]
fn a_flight_leads_a_place_to_the_middle_of_a_part_of_the_picture() {
    let (size, place) = (Vec2::new(900.0, 600.0), Vec2::new(-50.0, 60.0));
    let window =
        Window { low: Vec2::new(0.4, 0.1), high: Vec2::new(0.8, 0.6), aspect: size.x / size.y };
    let (usual, low) = (Camera::default(), Camera { pitch: 0.05, ..Camera::default() });
    for camera in [usual, low, usual.toggled_plan()] {
        let mut controller = CameraController::new(camera, true);
        controller.fly_to(place);
        while controller.is_flying() {
            controller.aim(None, window);
            controller.advance(1.0 / 60.0, None);
        }
        let at = controller.camera().project(place.extend(0.25), size).expect("in sight") / size;
        assert!((at.x - 0.6).abs() < 0.01, "{at} {camera:?}");
        // Near the horizon, the ground is kilometres away there.
        assert!((at.y - 0.35).abs() < 0.01 || camera.pitch < 0.1, "{at} {camera:?}");
    }
}

/// A small window with a panel on each side, as well as large ones.
#[test]
fn nothing_of_a_fitted_fleet_lies_under_the_legend() {
    for (size, scale) in windows() {
        let mut harness = harness(size, scale, |interface| {
            interface.camera_controller = CameraController::plan();
        });
        for key in [Key::Num1, Key::Num4, Key::O, Key::Home] {
            harness.key_press(key);
            harness.run_steps(40);
        }
        let legend = harness.state().interface.placed().iter();
        let legend = legend.clone().find(|(name, _)| *name == LEGEND).map(|(_, place)| *place);
        let west = seen_at(&harness, Bounds::default().low.extend(0.0)).x;
        let south = seen_at(&harness, Bounds::default().low.extend(0.0)).y;
        let is_clear = legend.is_none_or(|at| at.right() <= west || at.top() >= south);
        assert!(is_clear, "{size:?}: {legend:?}, {west} {south}");
    }
}

#[test]
fn a_robot_that_is_selected_by_a_key_is_moved_from_under_the_panel() {
    let robot = Vec3::new(3.0, 0.0, 0.25);
    for (size, scale) in windows() {
        let mut harness = harness_of(size, scale, |fixture| {
            log_of(fixture, 4);
            let target = robot - Vec3::new(14.0, 0.0, 0.0);
            let camera = Camera { target, ..Camera::default().toggled_plan() };
            fixture.interface.camera_controller = CameraController::new(camera, true);
            fixture.interface.select(Some(Item::Robot(2)));
        });
        harness.run_steps(6);
        let before = view(&harness).1.distance;
        harness.key_press(Key::N);
        harness.run_steps(80);
        let fixture = harness.state();
        let right = fixture.panel("right").map_or(size[0], |panel| panel.left());
        let at = seen_at(&harness, robot);
        assert!((0.0..right).contains(&at.x), "{size:?} at {scale}: {at}, panel at {right}");
        let closer = view(&harness).1.distance / before;
        assert!((closer - 1.0).abs() < 1e-3, "it comes no closer: {closer}");
    }
}

/// A window of 1024 by 700 with a robot's panel has no room for a column beside the plant.
#[test]
fn the_legend_of_a_narrow_window_is_lines_within_the_picture() {
    let harness = harness_of([1024.0, 700.0], 1.0, |fixture| {
        fixture.legend = Colouring::activity().legend(Theme::Dark, &[], None);
        fixture.interface.settings.right = Some(RightPanel::Selection);
        fixture.interface.select(Some(Item::Robot(3)));
    });
    let fixture = harness.state();
    let (_, legend) = *fixture
        .interface
        .placed()
        .iter()
        .find(|(name, _)| *name == LEGEND)
        .expect("room for a legend");
    let area = harness.ctx.memory(|memory| memory.area_rect(egui::Id::unique(LEGEND)));
    let panel = fixture.panel("right").expect("the panel");
    assert!(legend.width() > 3.0 * legend.height() && legend.right() < panel.left(), "{legend}");
    let picture = fixture.picture;
    assert!(area.is_some_and(|area| picture.contains_rect(area)), "{area:?} in {picture}");
}

#[test]
fn a_camera_that_shows_everything_goes_on_to_do_so_when_a_robot_is_selected() {
    for (size, scale) in windows() {
        let mut harness = harness(size, scale, |interface| {
            interface.camera_controller = CameraController::default();
        });
        for _ in 0..2 {
            harness.key_press(Key::N);
            harness.run_steps(40);
        }
        let controller = &harness.state().interface.camera_controller;
        assert!(controller.is_fitted() && !controller.is_flying(), "{size:?} at {scale}");
    }
}
