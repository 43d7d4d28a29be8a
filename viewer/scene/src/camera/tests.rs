use super::*;

const SIZE: Vec2 = Vec2::new(800.0, 600.0);

fn close(a: Vec2, b: Vec2) -> bool {
    (a - b).length() < 0.01
}

#[test]
fn the_top_view_has_north_up_and_east_right() {
    let bounds = Bounds { low: Vec2::new(-5.0, -5.0), high: Vec2::new(15.0, 5.0) };
    let camera = Camera::top(bounds, 4.0 / 3.0);
    let middle = camera.project(Vec3::new(5.0, 0.0, 0.0), SIZE).unwrap();
    assert!(close(middle, SIZE / 2.0), "{middle}");
    let north = camera.project(Vec3::new(5.0, 3.0, 0.0), SIZE).unwrap();
    let east = camera.project(Vec3::new(8.0, 0.0, 0.0), SIZE).unwrap();
    assert!(north.y < middle.y && (north.x - middle.x).abs() < 0.01, "{north}");
    assert!(east.x > middle.x && (east.y - middle.y).abs() < 0.01, "{east}");
}

#[test]
fn a_fitted_rectangle_is_in_the_picture() {
    for (low, high) in [
        ((-300.0, 20.0), (700.0, 90.0)),
        ((0.0, 0.0), (0.0, 0.0)),
        ((7000.0, 0.0), (7001.0, 900.0)),
    ] {
        let bounds = Bounds { low: low.into(), high: high.into() };
        for camera in [Camera::top(bounds, 4.0 / 3.0), Camera::fit(bounds, 4.0 / 3.0)] {
            for corner in [bounds.low, bounds.high] {
                let at = camera.project(corner.extend(0.0), SIZE).unwrap();
                assert!(
                    at.cmpge(Vec2::ZERO).all() && at.cmple(SIZE).all(),
                    "{camera:?}: {corner} at {at}"
                );
            }
        }
    }
}

#[test]
fn a_plan_is_orthographic_to_a_fraction_of_a_pixel() {
    let camera = Camera::plan_around(Vec2::new(7000.0, -3000.0), 40.0);
    let per_metre = SIZE.y / 40.0;
    assert!((camera.metres_per_pixel(SIZE.y) * per_metre - 1.0).abs() < 1e-3);
    for (east, north) in [(0.0, 0.0), (26.0, 19.0), (-26.0, -19.0)] {
        let place = Vec2::new(7000.0 + east, -3000.0 + north);
        let wanted = SIZE / 2.0 + Vec2::new(east, -north) * per_metre;
        for height in [0.0, 0.5] {
            let at = camera.project(place.extend(height), SIZE).unwrap();
            assert!(at.distance(wanted) < 0.2, "{place} at {height} m: {at} instead of {wanted}");
        }
        assert!(camera.unproject(wanted, SIZE).unwrap().distance(place) < 0.02);
    }
    let back = camera.toggled_plan();
    assert!(!back.is_plan() && back.toggled_plan().is_plan());
    assert!((back.metres_per_pixel(SIZE.y) - camera.metres_per_pixel(SIZE.y)).abs() < 1e-4);
}

#[test]
fn what_is_fitted_into_a_part_of_the_picture_lies_there() {
    let bounds = Bounds { low: Vec2::new(-30.0, 0.0), high: Vec2::new(90.0, 50.0) };
    let window = Window { aspect: 1.6, low: Vec2::new(0.3, 0.0), high: Vec2::new(0.95, 1.0) };
    let size = Vec2::new(1600.0, 1000.0);
    for camera in [
        Camera::plan(bounds, window),
        Camera { pitch: 0.95, ..Camera::default() }.fitted_within(bounds, window),
    ] {
        for corner in [
            bounds.low,
            bounds.high,
            Vec2::new(bounds.low.x, bounds.high.y),
            Vec2::new(bounds.high.x, bounds.low.y),
        ] {
            let at = camera.project(corner.extend(0.0), size).unwrap() / size;
            assert!(
                at.cmpge(window.low - 0.01).all() && at.cmple(window.high + 0.01).all(),
                "{corner} at {at}"
            );
        }
    }
}

#[test]
fn unproject_inverts_project() {
    let camera = Camera {
        yaw: 1.0,
        pitch: 0.5,
        distance: 40.0,
        target: Vec3::new(100.0, -30.0, 0.0),
        ..Camera::default()
    };
    for ground in [Vec2::new(100.0, -30.0), Vec2::new(90.0, -20.0), Vec2::new(110.0, -5.0)] {
        let pixel = camera.project(ground.extend(0.0), SIZE).unwrap();
        let back = camera.unproject(pixel, SIZE).unwrap();
        assert!(close(back, ground), "{ground} at {pixel} is {back}");
    }
    assert_eq!(camera.unproject(Vec2::ZERO, SIZE).map(|_| ()), Some(()));
    assert_eq!(
        Camera { pitch: 0.0, ..camera }.unproject(Vec2::ZERO, SIZE),
        None,
        "above the horizon"
    );
}

#[test]
fn the_eye_stays_above_the_ground() {
    for target in [-500.0, 0.0, 3.0] {
        for pitch in [-3.0, -0.5, 0.0, 1.0, 9.0] {
            let camera = Camera { pitch, target: Vec3::new(0.0, 0.0, target), ..Camera::default() }
                .clamped();
            assert!(camera.eye().z >= LOWEST_EYE - 1e-3, "{camera:?}: {}", camera.eye().z);
        }
    }
    assert!(
        (Camera { yaw: 7.0, ..Camera::default() }.clamped().yaw - (7.0 - 2.0 * PI)).abs() < 1e-5
    );
}

#[test]
fn a_camera_from_an_eye_keeps_its_position() {
    for pitch in [-0.3, 0.0, 0.3, FRAC_PI_2] {
        let camera = Camera::from_eye(Vec3::new(3.0, 4.0, 5.0), 0.7, pitch);
        assert!(camera.eye().distance(Vec3::new(3.0, 4.0, 5.0)) < 1e-3, "{}", camera.eye());
    }
}
