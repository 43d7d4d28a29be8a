//! The orbit camera: where it stands, and what that makes of a point of the world. Nothing but geometry.
//!
//! World: metres, x east, y north, z up. The camera looks along `yaw` (counter-clockwise from east) and down by
//! `pitch` at a target, from a distance.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Mat4, Vec2, Vec3, Vec4};

/// The camera's eye never goes below this height, in metres.
pub const LOWEST_EYE: f32 = 0.1;
/// The plane before which nothing is drawn, in metres from the eye.
const NEAR: f32 = 0.05;
/// Nearest and farthest that the camera goes to its target, in metres.
const DISTANCES: (f32, f32) = (0.3, 100_000.0);
/// Steepest and flattest look, in radians below the horizon.
const PITCHES: (f32, f32) = (-1.2, FRAC_PI_2);
/// Part of the picture that is left around what is fitted into it.
const MARGIN: f32 = 0.06;

/// Where the camera is and how it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// What it looks at, in metres.
    pub target: Vec3,
    /// Direction of the look over the ground, in radians counter-clockwise from east.
    pub yaw: f32,
    /// How far below the horizon it looks, in radians; π/2 is straight down.
    pub pitch: f32,
    /// From the eye to the target, in metres.
    pub distance: f32,
    /// Angle between the top and the bottom of the picture, in radians.
    pub fov_y: f32,
}

/// A rectangle of the ground, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// South-west corner.
    pub low: Vec2,
    /// North-east corner.
    pub high: Vec2,
}

impl Bounds {
    /// The smallest rectangle around some points; `None` without points.
    pub fn around(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        let grow = |bounds: Self, point: Vec2| Self { low: bounds.low.min(point), high: bounds.high.max(point) };
        let mut points = points.into_iter().filter(|point| point.is_finite());
        let first = points.next()?;
        Some(points.fold(Self { low: first, high: first }, grow))
    }

    /// A rectangle of that width and height around the origin, in metres.
    pub fn of_size(size: [f32; 2]) -> Self {
        let half = Vec2::from(size) / 2.0;
        Self { low: -half, high: half }
    }

    /// Whether the other lies in it.
    pub fn holds(self, other: Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all()
    }

    /// Around both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Larger by a fifth, and a metre, on all sides.
    #[must_use]
    pub fn wider(self) -> Self {
        let more = (self.high - self.low) * 0.2 + 1.0;
        Self { low: self.low - more, high: self.high + more }
    }

    /// Its middle.
    pub fn centre(self) -> Vec2 {
        (self.low + self.high) / 2.0
    }
}

impl Default for Bounds {
    /// Twenty metres around the origin: what is looked at while there is nothing.
    fn default() -> Self {
        Self { low: Vec2::splat(-10.0), high: Vec2::splat(10.0) }
    }
}

impl Default for Camera {
    fn default() -> Self {
        Self { target: Vec3::ZERO, yaw: FRAC_PI_2, pitch: 0.9, distance: 30.0, fov_y: 0.75 }
    }
}

impl Camera {
    /// Looks at a rectangle of the ground from an angle, all of it in the picture.
    pub fn fit(bounds: Bounds, aspect: f32) -> Self {
        Self { pitch: 0.95, ..Self::default() }.fitted(bounds, aspect)
    }

    /// Looks straight down at a rectangle of the ground, north up, all of it in the picture.
    pub fn top(bounds: Bounds, aspect: f32) -> Self {
        Self { pitch: FRAC_PI_2, ..Self::default() }.fitted(bounds, aspect)
    }

    /// A camera whose eye stands at a point and looks along `yaw`, `pitch` radians below the horizon.
    pub fn at(eye: Vec3, yaw: f32, pitch: f32) -> Self {
        let camera = Self { yaw, pitch, ..Self::default() };
        let eye = eye.with_z(eye.z.max(LOWEST_EYE));
        // The target is where the look meets the ground, unless that is far away.
        let distance = if pitch > 0.01 { (eye.z / pitch.sin()).min(50.0 + eye.z) } else { 10.0 };
        Self { target: eye + camera.forward() * distance, distance, ..camera }
    }

    /// Keeps yaw and pitch, and goes where all of the rectangle is in the picture.
    #[must_use]
    pub fn fitted(self, bounds: Bounds, aspect: f32) -> Self {
        let size = (bounds.high - bounds.low).max(Vec2::splat(1.0));
        let corners = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|corner| bounds.low + corner * size);
        let mut camera = Self { target: bounds.centre().extend(0.0), ..self };
        // What is near takes more of the picture than what is far: the middle of it is not that of the rectangle.
        for _ in 0..4 {
            camera = camera.far_enough(&corners, aspect);
            let seen = Bounds::around(
                corners.iter().filter_map(|corner| camera.project(corner.extend(0.0), Vec2::new(aspect, 1.0))),
            );
            let middle = seen.and_then(|seen| camera.unproject(seen.centre(), Vec2::new(aspect, 1.0)));
            camera.target = middle.unwrap_or(camera.target.truncate()).extend(0.0);
        }
        camera.far_enough(&corners, aspect).clamped()
    }

    /// At the least distance from which all of the points are in the picture.
    fn far_enough(mut self, points: &[Vec2], aspect: f32) -> Self {
        let room = 1.0 - MARGIN;
        let fits = |camera: &Self| {
            let clip = camera.clip_from_world(aspect);
            points.iter().all(|point| {
                let at = clip * point.extend(0.0).extend(1.0);
                at.w > 0.0 && at.x.abs() < at.w * room && at.y.abs() < at.w * room
            })
        };
        let (mut near, mut far) = DISTANCES;
        for _ in 0..40 {
            self.distance = (near * far).sqrt();
            if fits(&self) { far = self.distance } else { near = self.distance }
        }
        Self { distance: far, ..self }
    }

    /// With yaw in (-π, π], pitch and distance in their ranges, and the eye above the ground.
    #[must_use]
    pub fn clamped(mut self) -> Self {
        self.yaw = PI - (PI - self.yaw).rem_euclid(2.0 * PI);
        self.pitch = self.pitch.clamp(PITCHES.0, PITCHES.1);
        self.distance = self.distance.clamp(DISTANCES.0, DISTANCES.1);
        let lowest_sine = (LOWEST_EYE - self.target.z) / self.distance;
        if lowest_sine >= 1.0 {
            self.target.z = LOWEST_EYE - self.distance * self.pitch.sin();
        } else {
            self.pitch = self.pitch.max(lowest_sine.asin());
        }
        self
    }

    /// Direction of the look.
    pub fn forward(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        Vec3::new(cos * self.yaw.cos(), cos * self.yaw.sin(), -sin)
    }

    /// To the right of the picture, level.
    pub fn right(&self) -> Vec3 {
        Vec3::new(self.yaw.sin(), -self.yaw.cos(), 0.0)
    }

    /// Up in the picture.
    pub fn up(&self) -> Vec3 {
        self.right().cross(self.forward())
    }

    /// Where the eye is, in metres.
    pub fn eye(&self) -> Vec3 {
        self.target - self.forward() * self.distance
    }

    /// The camera's own axes (x right, y up, z back) as seen from the world.
    pub fn view_from_world(&self) -> Mat4 {
        self.view_from(Vec3::ZERO)
    }

    /// The same for coordinates that count from `origin`: small numbers far from the world's origin.
    pub fn view_from(&self, origin: Vec3) -> Mat4 {
        let (right, up, back, eye) = (self.right(), self.up(), -self.forward(), self.eye() - origin);
        Mat4::from_cols(
            Vec4::new(right.x, up.x, back.x, 0.0),
            Vec4::new(right.y, up.y, back.y, 0.0),
            Vec4::new(right.z, up.z, back.z, 0.0),
            Vec4::new(-right.dot(eye), -up.dot(eye), -back.dot(eye), 1.0),
        )
    }

    /// From the world to clip space, with depth reversed: 1 at the near plane, 0 infinitely far away.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        self.clip_from(Vec3::ZERO, aspect)
    }

    /// The same for coordinates that count from `origin`.
    pub fn clip_from(&self, origin: Vec3, aspect: f32) -> Mat4 {
        let focal = 1.0 / (self.fov_y / 2.0).tan();
        let projection = Mat4::from_cols(
            Vec4::new(focal / aspect, 0.0, 0.0, 0.0),
            Vec4::new(0.0, focal, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 0.0, -1.0),
            Vec4::new(0.0, 0.0, NEAR, 0.0),
        );
        projection * self.view_from(origin)
    }

    /// Pixels that a metre covers at a distance of a metre, in a picture of that height.
    pub fn pixels_per_radian(&self, height: f32) -> f32 {
        height / (2.0 * (self.fov_y / 2.0).tan())
    }

    /// Where a point of the world is in a picture of `size` pixels, from its top left; `None` behind the camera.
    pub fn project(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let clip = self.clip_from_world(size.x / size.y) * point.extend(1.0);
        let ndc = Vec2::new(clip.x, -clip.y) / clip.w;
        (clip.w > NEAR).then(|| (ndc + 1.0) / 2.0 * size)
    }

    /// Direction of the look through a pixel, of length 1.
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> Vec3 {
        let ndc = pixel / size * 2.0 - 1.0;
        let tan = (self.fov_y / 2.0).tan();
        let sideways = self.right() * (ndc.x * tan * size.x / size.y);
        (self.forward() + sideways - self.up() * (ndc.y * tan)).normalize()
    }

    /// The point of the ground under a pixel; `None` above the horizon.
    pub fn unproject(&self, pixel: Vec2, size: Vec2) -> Option<Vec2> {
        let (eye, ray) = (self.eye(), self.ray(pixel, size));
        (ray.z < -1e-4).then(|| (eye - ray * (eye.z / ray.z)).truncate())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(800.0, 600.0);

    fn close(a: Vec2, b: Vec2) -> bool {
        (a - b).length() < 0.01
    }

    #[test]
    fn top_has_north_up_and_east_right() {
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
    fn what_is_fitted_is_in_the_picture() {
        for (low, high) in [((-300.0, 20.0), (700.0, 90.0)), ((0.0, 0.0), (0.0, 0.0)), ((7000.0, 0.0), (7001.0, 900.0))]
        {
            let bounds = Bounds { low: low.into(), high: high.into() };
            for camera in [Camera::top(bounds, 4.0 / 3.0), Camera::fit(bounds, 4.0 / 3.0)] {
                for corner in [bounds.low, bounds.high] {
                    let at = camera.project(corner.extend(0.0), SIZE).unwrap();
                    assert!(at.cmpge(Vec2::ZERO).all() && at.cmple(SIZE).all(), "{camera:?}: {corner} at {at}");
                }
            }
        }
    }

    #[test]
    fn unprojecting_reverses_projecting() {
        let camera =
            Camera { yaw: 1.0, pitch: 0.5, distance: 40.0, target: Vec3::new(100.0, -30.0, 0.0), ..Camera::default() };
        for ground in [Vec2::new(100.0, -30.0), Vec2::new(90.0, -20.0), Vec2::new(110.0, -5.0)] {
            let pixel = camera.project(ground.extend(0.0), SIZE).unwrap();
            let back = camera.unproject(pixel, SIZE).unwrap();
            assert!(close(back, ground), "{ground} at {pixel} is {back}");
        }
        assert_eq!(camera.unproject(Vec2::ZERO, SIZE).map(|_| ()), Some(()));
        assert_eq!(Camera { pitch: 0.0, ..camera }.unproject(Vec2::ZERO, SIZE), None, "above the horizon");
    }

    #[test]
    fn the_eye_stays_above_the_ground() {
        for target in [-500.0, 0.0, 3.0] {
            for pitch in [-3.0, -0.5, 0.0, 1.0, 9.0] {
                let camera = Camera { pitch, target: Vec3::new(0.0, 0.0, target), ..Camera::default() }.clamped();
                assert!(camera.eye().z >= LOWEST_EYE - 1e-3, "{camera:?}: {}", camera.eye().z);
            }
        }
        assert!((Camera { yaw: 7.0, ..Camera::default() }.clamped().yaw - (7.0 - 2.0 * PI)).abs() < 1e-5);
    }

    #[test]
    fn a_camera_at_a_point_is_there() {
        for pitch in [-0.3, 0.0, 0.3, FRAC_PI_2] {
            let camera = Camera::at(Vec3::new(3.0, 4.0, 5.0), 0.7, pitch);
            assert!(camera.eye().distance(Vec3::new(3.0, 4.0, 5.0)) < 1e-3, "{}", camera.eye());
        }
    }
}
