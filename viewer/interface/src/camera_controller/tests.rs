use glam::Vec3;
use regatta_scene::camera::LOWEST_EYE;

use super::*;

const SIZE: Vec2 = Vec2::new(900.0, 600.0);

fn controller() -> CameraController {
    let camera =
        Camera { target: Vec3::new(20.0, -7.0, 0.0), pitch: 0.8, yaw: 0.4, ..Camera::default() };
    CameraController::new(camera, true)
}

#[test]
fn the_point_under_the_cursor_stays_there_when_zooming() {
    for cursor in [SIZE / 2.0, Vec2::new(100.0, 500.0), Vec2::new(850.0, 250.0)] {
        for factor in [0.5, 0.9, 1.3] {
            let mut controller = controller();
            let before = controller.camera().unproject(cursor, SIZE).unwrap();
            controller.zoom(factor, Some(cursor), SIZE);
            let after = controller.camera().unproject(cursor, SIZE).unwrap();
            assert!((before - after).length() < 0.05, "{cursor} x {factor}: {before}, {after}");
        }
    }
}

#[test]
fn panning_moves_the_ground_with_the_pointer() {
    let mut controller = controller();
    let (from, to) = (Vec2::new(300.0, 400.0), Vec2::new(420.0, 350.0));
    let grabbed = controller.camera().unproject(from, SIZE).unwrap();
    controller.pan(from, to, SIZE);
    let now = controller.camera().unproject(to, SIZE).unwrap();
    assert!((grabbed - now).length() < 0.05, "{grabbed}, {now}");
}

#[test]
fn panning_above_the_horizon_keeps_its_direction() {
    let mut controller =
        CameraController::new(Camera { pitch: 0.05, yaw: FRAC_PI_2, ..Camera::default() }, true);
    controller.pan(Vec2::new(450.0, 50.0), Vec2::new(500.0, 90.0), SIZE);
    let target = controller.camera().target;
    assert!(target.x < 0.0 && target.y > 0.0, "{target}");
}

#[test]
fn the_eye_stays_above_the_ground() {
    let mut controller = controller();
    for _ in 0..200 {
        controller.orbit(Vec2::new(3.0, -40.0));
        controller.zoom(0.8, Some(Vec2::new(10.0, 590.0)), SIZE);
        assert!(controller.camera().eye().z >= LOWEST_EYE - 1e-3, "{:?}", controller.camera());
    }
}

#[test]
fn a_vertical_drag_changes_the_pitch_and_a_horizontal_one_the_yaw() {
    let mut controller = controller();
    let before = controller.camera();
    controller.orbit(Vec2::new(0.0, 30.0));
    assert!(
        controller.camera().pitch > before.pitch
            && (controller.camera().yaw - before.yaw).abs() < 1e-6
    );
    controller.orbit(Vec2::new(30.0, 0.0));
    assert!((controller.camera().yaw - before.yaw).abs() > 0.1);
    assert_eq!(controller.camera().target, before.target);
}

#[test]
fn a_flight_arrives_at_its_destination() {
    let mut controller = controller();
    controller.fly_to(Vec2::new(-50.0, 60.0));
    assert!(controller.is_flying());
    for _ in 0..100 {
        controller.advance(1.0 / 60.0, None);
    }
    assert!(!controller.is_flying());
    assert!(controller.camera().target.truncate().distance(Vec2::new(-50.0, 60.0)) < 1e-3);
}

#[test]
fn following_cycles_through_its_modes_and_stays_with_the_robot() {
    let mut controller = controller();
    controller.cycle_follow(7);
    assert_eq!(controller.followed(), Some((7, Follow::Behind)));
    let pose = Pose { place: Vec2::new(3.0, 4.0), theta: 2.0 };
    controller.advance(0.01, Some(pose));
    assert!(
        (controller.camera().yaw - 2.0).abs() < 1e-5
            && controller.camera().target.truncate() == pose.place
    );
    controller.orbit(Vec2::new(10.0, 0.0));
    controller.advance(0.01, Some(pose));
    assert!((controller.camera().yaw - 2.0).abs() > 0.03, "the yaw offset is kept");
    controller.cycle_follow(7);
    assert_eq!(controller.followed(), Some((7, Follow::Above)));
    controller.cycle_follow(7);
    assert_eq!(controller.followed(), None);
}

#[test]
fn fit_shows_everything_from_any_camera_of_a_plan() {
    let bounds = Bounds { low: Vec2::new(-20.0, 5.0), high: Vec2::new(180.0, 90.0) };
    let window = Window { low: Vec2::new(0.3, 0.05), ..Window::whole(SIZE.x / SIZE.y) };
    let mut random = 1_u32;
    let mut next = |limit: f32| {
        random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (random >> 8) as f32 / (1 << 24) as f32 * limit
    };
    for case in 0..200 {
        let mut controller = CameraController::plan();
        controller.keep_fitted(bounds, window);
        for _ in 0..next(6.0) as u32 {
            let at = Vec2::new(next(SIZE.x), next(SIZE.y));
            match next(6.0) as u32 {
                0 => controller.zoom(next(4.0) + 0.1, Some(at), SIZE),
                1 => controller.pan(at, Vec2::new(next(SIZE.x), next(SIZE.y)), SIZE),
                2 => controller.orbit(at - SIZE / 2.0),
                3 => controller.fit(bounds, window),
                4 => controller.fly_to(at),
                _ => controller.follow(Some((3, Follow::Above))),
            }
            controller.advance(f64::from(next(1.0)), None);
        }
        if !controller.camera().is_plan() {
            controller.toggle_plan();
        }
        controller.fit(bounds, window);
        for _ in 0..60 {
            controller.advance(1.0 / 30.0, None);
            controller.keep_fitted(bounds, window);
        }
        let camera = controller.camera();
        for corner in [bounds.low, bounds.high, Vec2::new(bounds.low.x, bounds.high.y)] {
            let at = camera.project(corner.extend(0.0), SIZE).expect("in sight") / SIZE;
            let is_inside = at.cmpge(window.low - 0.01).all() && at.cmple(window.high + 0.01).all();
            assert!(is_inside, "case {case}: {at} with {camera:?}");
        }
    }
}
