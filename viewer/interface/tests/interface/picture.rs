//! Mouse and keys on the picture, the minimap and the view cube.

use super::*;

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
    assert!(
        turned.pitch > before.pitch + 0.1 && (turned.yaw - before.yaw).abs() < 1e-5,
        "{before:?} {turned:?}"
    );
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
    assert!(
        harness
            .state()
            .actions
            .iter()
            .any(|action| matches!(action, Action::Pick { extend: false, .. }))
    );
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
    assert_eq!(harness.state().interface.selection.item, None);
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
        assert!(
            target.distance(expected) < 0.02 * extent.length(),
            "{target} instead of {expected}"
        );
    }
    assert!(
        !harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })),
        "not the picture"
    );
}

#[test]
fn a_click_on_the_view_cube_turns_the_camera() {
    let mut harness = harness(Fixture::new(5));
    let cube = harness.get_by_label("view cube").rect();
    harness.drag_at(cube.center() - egui::vec2(0.0, 14.0));
    harness.drop_at(cube.center() - egui::vec2(0.0, 14.0));
    harness.run_steps(80);
    let camera = harness.state().interface.camera_controller.camera();
    assert!(
        (camera.pitch - core::f32::consts::FRAC_PI_2).abs() < 0.02,
        "its top is above: {camera:?}"
    );
    assert!(
        !harness.state().actions.iter().any(|action| matches!(action, Action::Pick { .. })),
        "not the picture"
    );
}

#[test]
fn a_click_keeps_the_camera_where_it_is_when_the_panel_of_the_selection_opens() {
    let mut harness = harness(Fixture::new(5));
    settle(&mut harness);
    let before = harness.state().interface.camera_controller.camera();
    let at = pos2(640.0, 360.0);
    harness.hover_at(at);
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(2);
    harness.state_mut().interface.settings.right = Some(RightPanel::Selection);
    harness.state_mut().interface.select(Some(Item::Robot(3)));
    settle(&mut harness);
    harness.get_by_label_contains("Fly there");
    assert_eq!(
        harness.state().interface.camera_controller.camera(),
        before,
        "the next click is aimed at what is there"
    );
}

#[test]
fn a_key_that_goes_up_as_another_one_does_not_zoom_for_good() {
    let mut harness = harness(Fixture::new(5));
    let distance = |harness: &Harness<'_, Fixture>| {
        harness.state().interface.camera_controller.camera().distance
    };
    let key = |key, pressed, modifiers| egui::Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers,
    };
    let before = distance(&harness);
    harness.event(key(egui::Key::Plus, true, Modifiers::SHIFT));
    harness.run_steps(3);
    let zoomed = distance(&harness);
    assert!(zoomed < before, "{before} {zoomed}");
    // Shift is released first.
    harness.event(key(egui::Key::Equals, false, Modifiers::NONE));
    harness.run_steps(1);
    let released = distance(&harness);
    harness.run_steps(20);
    assert_eq!(distance(&harness), released);
}
