//! The orbit camera: its pose and its projections.
//!
//! World coordinates are metres, x east, y north, z up. The camera orbits a target at a distance;
//! its view direction is given by `yaw` (counter-clockwise from east) and `pitch` (downwards from
//! the horizon).

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Mat4, Vec2, Vec3, Vec4};

/// The least height of the camera's eye, in metres.
pub const LOWEST_EYE: f32 = 0.1;
/// The distance of the near plane from the eye, in metres.
const NEAR: f32 = 0.05;
/// The range of the distance to the target, in metres.
const DISTANCES: (f32, f32) = (0.3, 100_000.0);
/// The range of the pitch, in radians below the horizon.
const PITCHES: (f32, f32) = (-1.2, FRAC_PI_2);
/// The vertical field of view of a plan's camera, in radians. Half a metre of height is seen from
/// 500 times the height of the picture on the ground, or farther.
const PLAN_FOV: f32 = 0.002;
/// The share of the picture that stays free around a rectangle that is fitted into it.
const MARGIN: f32 = 0.06;

/// The camera of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point that the camera orbits and looks at, in metres.
    pub target: Vec3,
    /// Heading of the view direction, in radians counter-clockwise from east.
    pub yaw: f32,
    /// Angle of the view direction below the horizon, in radians; π/2 is straight down.
    pub pitch: f32,
    /// Distance from the eye to the target, in metres.
    pub distance: f32,
    /// Vertical field of view, in radians.
    pub fov_y: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self { target: Vec3::ZERO, yaw: FRAC_PI_2, pitch: 0.9, distance: 30.0, fov_y: 0.75 }
    }
}

impl Camera {
    /// Returns a camera that looks at a rectangle of the ground from an angle and shows all of it.
    pub fn fit(bounds: Bounds, aspect: f32) -> Self {
        Self { pitch: 0.95, ..Self::default() }.fitted(bounds, aspect)
    }

    /// Returns a camera that looks straight down at a rectangle of the ground, north up, and shows
    /// all of it.
    pub fn top(bounds: Bounds, aspect: f32) -> Self {
        Self { pitch: FRAC_PI_2, ..Self::default() }.fitted(bounds, aspect)
    }

    /// Returns the camera of a plan: straight down, north up, and from so far away that it is
    /// orthographic in effect. An object half a metre high is shifted by less than a ten-thousandth
    /// of the picture's height.
    pub fn plan(bounds: Bounds, window: Window) -> Self {
        Self { pitch: FRAC_PI_2, fov_y: PLAN_FOV, ..Self::default() }.fitted_within(bounds, window)
    }

    /// Returns the camera of a plan around a place, with the height of the ground in the picture in
    /// metres.
    pub fn plan_around(place: Vec2, height: f32) -> Self {
        let distance = height / (2.0 * (PLAN_FOV / 2.0).tan());
        let camera = Self {
            target: place.extend(0.0),
            pitch: FRAC_PI_2,
            fov_y: PLAN_FOV,
            distance,
            ..Self::default()
        };
        camera.clamped()
    }

    /// Whether this is the camera of a plan.
    pub fn is_plan(&self) -> bool {
        self.fov_y < 2.0 * PLAN_FOV
    }

    /// Metres per pixel at the target, in a picture of `height` pixels.
    pub fn metres_per_pixel(&self, height: f32) -> f32 {
        self.distance / self.pixels_per_radian(height)
    }

    /// Returns this camera as that of a plan, or as one in perspective that shows about the same
    /// from an angle.
    #[must_use]
    pub fn toggled_plan(self) -> Self {
        let usual = Self::default();
        let scale = (self.fov_y / 2.0).tan();
        let (fov_y, pitch, yaw) = if self.is_plan() {
            (usual.fov_y, usual.pitch, self.yaw)
        } else {
            (PLAN_FOV, FRAC_PI_2, FRAC_PI_2)
        };
        let distance = self.distance * scale / (fov_y / 2.0).tan();
        Self { target: self.target.with_z(0.0), yaw, pitch, distance, fov_y }.clamped()
    }

    /// The range of the distance to the target, in metres: the height of the ground in the picture
    /// decides.
    fn distances(&self) -> (f32, f32) {
        let scale = (Self::default().fov_y / 2.0).tan() / (self.fov_y / 2.0).tan();
        if self.is_plan() { (DISTANCES.0 * scale, DISTANCES.1 * scale) } else { DISTANCES }
    }

    /// Returns a camera from the position of its eye and its view direction.
    pub fn from_eye(eye: Vec3, yaw: f32, pitch: f32) -> Self {
        let camera = Self { yaw, pitch, ..Self::default() };
        let eye = eye.with_z(eye.z.max(LOWEST_EYE));
        // The target is where the view direction meets the ground, unless that is far away.
        let distance = if pitch > 0.01 { (eye.z / pitch.sin()).min(50.0 + eye.z) } else { 10.0 };
        Self { target: eye + camera.forward() * distance, distance, ..camera }
    }

    /// Moves the camera, without a turn, so that it shows all of a rectangle of the ground.
    #[must_use]
    pub fn fitted(self, bounds: Bounds, aspect: f32) -> Self {
        self.fitted_within(bounds, Window::whole(aspect))
    }

    /// Moves the camera, without a turn, so that it shows all of a rectangle of the ground in a
    /// part of the picture.
    #[must_use]
    pub fn fitted_within(self, bounds: Bounds, window: Window) -> Self {
        let aspect = window.aspect;
        let is_whole = window == Window::whole(aspect);
        // The way from the middle of the picture to that of the part.
        let aside = ((window.low + window.high) / 2.0 - 0.5) * Vec2::new(aspect, 1.0);
        let size = (bounds.high - bounds.low).max(Vec2::splat(1.0));
        let corners =
            [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|corner| bounds.low + corner * size);
        let mut camera = Self { target: bounds.centre().extend(0.0), ..self };
        // In perspective, the rectangle's centre is not in the middle of its projection, so the
        // target is found iteratively.
        for _ in 0..if is_whole { 4 } else { 8 } {
            camera = camera.at_least_distance(&corners, window);
            let projected =
                Bounds::from_points(corners.iter().filter_map(|corner| {
                    camera.project(corner.extend(0.0), Vec2::new(aspect, 1.0))
                }));
            let middle = projected.and_then(|bounds| {
                camera.unproject(bounds.centre() - aside, Vec2::new(aspect, 1.0))
            });
            camera.target = middle.unwrap_or(camera.target.truncate()).extend(0.0);
        }
        if is_whole {
            camera.at_least_distance(&corners, window).clamped()
        } else {
            camera.clamped()
        }
    }

    /// Moves the camera, without a turn and along the ground, so that a point is in the middle of a
    /// part of the picture.
    #[must_use]
    pub fn aimed_at(self, point: Vec3, window: Window) -> Self {
        let aside = ((window.low + window.high) / 2.0 - 0.5) * Vec2::new(window.aspect, 1.0);
        let camera = Self { target: point, ..self };
        let size = Vec2::new(window.aspect, 1.0);
        let (eye, ray) = (camera.eye(), camera.ray(size / 2.0 + aside, size));
        let ahead = (point.z - eye.z) / ray.z;
        // Near the horizon, a part of the picture is kilometres.
        let shift = if ray.z < 0.0 && ahead < 4.0 * self.distance {
            eye + ray * ahead - point
        } else {
            camera.right() * (aside.x / camera.pixels_per_radian(1.0) * self.distance)
        };
        Self { target: (point - shift).with_z(point.z), ..self }
    }

    /// Sets the least distance at which all of the points are in the picture, or are no farther
    /// apart than a part of it is wide and high.
    fn at_least_distance(mut self, points: &[Vec2], window: Window) -> Self {
        let (mut near, mut far) = self.distances();
        for _ in 0..40 {
            self.distance = (near * far).sqrt();
            if self.fits(points, window) { far = self.distance } else { near = self.distance }
        }
        Self { distance: far, ..self }
    }

    /// Whether all of the points are in the picture, or are no farther apart than a part of it is
    /// wide and high.
    fn fits(&self, points: &[Vec2], window: Window) -> bool {
        let room = (window.high - window.low) * (1.0 - MARGIN);
        let clip = self.clip_from_world(window.aspect);
        let mut all = Vec::with_capacity(points.len());
        for point in points {
            let at = clip * point.extend(0.0).extend(1.0);
            if at.w <= 0.0 || at.w.is_nan() {
                return false;
            }
            all.push(at.truncate().truncate() / at.w);
        }
        if window == Window::whole(window.aspect) {
            return all.iter().all(|at| at.abs().cmplt(room).all());
        }
        let extent = Bounds::from_points(all).map_or(Vec2::ZERO, |bounds| bounds.high - bounds.low);
        extent.cmplt(room * 2.0).all()
    }

    /// Wraps the yaw to (-π, π], clamps pitch and distance to their ranges, and keeps the eye above
    /// the ground.
    #[must_use]
    pub fn clamped(mut self) -> Self {
        self.yaw = PI - (PI - self.yaw).rem_euclid(2.0 * PI);
        self.pitch = self.pitch.clamp(PITCHES.0, PITCHES.1);
        let (near, far) = self.distances();
        self.distance = self.distance.clamp(near, far);
        if self.is_plan() {
            self.pitch = FRAC_PI_2;
        }
        let lowest_sine = (LOWEST_EYE - self.target.z) / self.distance;
        if lowest_sine >= 1.0 {
            self.target.z = LOWEST_EYE - self.distance * self.pitch.sin();
        } else {
            self.pitch = self.pitch.max(lowest_sine.asin());
        }
        self
    }

    /// The view direction, of length 1.
    pub fn forward(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        Vec3::new(cos * self.yaw.cos(), cos * self.yaw.sin(), -sin)
    }

    /// The direction to the right in the picture, which is horizontal.
    pub fn right(&self) -> Vec3 {
        Vec3::new(self.yaw.sin(), -self.yaw.cos(), 0.0)
    }

    /// The direction upwards in the picture.
    pub fn up(&self) -> Vec3 {
        self.right().cross(self.forward())
    }

    /// The position of the eye, in metres.
    pub fn eye(&self) -> Vec3 {
        self.target - self.forward() * self.distance
    }

    /// The transform to view coordinates (x right, y up, z back) from coordinates relative to
    /// `origin`, which stay precise far from the world's origin.
    fn view_from(&self, origin: Vec3) -> Mat4 {
        let (right, up, back, eye) =
            (self.right(), self.up(), -self.forward(), self.eye() - origin);
        Mat4::from_cols(
            Vec4::new(right.x, up.x, back.x, 0.0),
            Vec4::new(right.y, up.y, back.y, 0.0),
            Vec4::new(right.z, up.z, back.z, 0.0),
            Vec4::new(-right.dot(eye), -up.dot(eye), -back.dot(eye), 1.0),
        )
    }

    /// The transform from world coordinates to clip space. Depth is reversed: 1 at the near plane,
    /// 0 at infinity.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        self.clip_from(Vec3::ZERO, aspect)
    }

    /// The transform to clip space from coordinates relative to `origin`.
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

    /// The number of pixels that a metre covers at a distance of one metre, in a picture of
    /// `height` pixels.
    pub fn pixels_per_radian(&self, height: f32) -> f32 {
        height / (2.0 * (self.fov_y / 2.0).tan())
    }

    /// Projects a point of the world into a picture of `size` pixels, counted from its top left;
    /// `None` behind the camera.
    pub fn project(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let clip = self.clip_from_world(size.x / size.y) * point.extend(1.0);
        let ndc = Vec2::new(clip.x, -clip.y) / clip.w;
        (clip.w > NEAR).then(|| (ndc + 1.0) / 2.0 * size)
    }

    /// The direction from the eye through a pixel, of length 1.
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> Vec3 {
        let ndc = pixel / size * 2.0 - 1.0;
        let tan = (self.fov_y / 2.0).tan();
        let sideways = self.right() * (ndc.x * tan * size.x / size.y);
        (self.forward() + sideways - self.up() * (ndc.y * tan)).normalize()
    }

    /// Returns the point of the ground at a pixel; `None` above the horizon.
    pub fn unproject(&self, pixel: Vec2, size: Vec2) -> Option<Vec2> {
        let (eye, ray) = (self.eye(), self.ray(pixel, size));
        (ray.z < -1e-4).then(|| (eye - ray * (eye.z / ray.z)).truncate())
    }
}

/// An axis-aligned rectangle of the ground, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// South-west corner.
    pub low: Vec2,
    /// North-east corner.
    pub high: Vec2,
}

impl Bounds {
    /// Returns the bounding box of some points, not counting points that are not finite; `None` if
    /// there are none.
    pub fn from_points(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        let mut points = points.into_iter().filter(|point| point.is_finite());
        let first = points.next()?;
        let mut bounds = Self { low: first, high: first };
        for point in points {
            bounds = Self { low: bounds.low.min(point), high: bounds.high.max(point) };
        }
        Some(bounds)
    }

    /// Returns a rectangle around the origin with a width and height in metres.
    pub fn of_size(size: Vec2) -> Self {
        let half = size / 2.0;
        Self { low: -half, high: half }
    }

    /// Whether another rectangle lies within this one.
    pub fn contains(self, other: Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all()
    }

    /// Returns the smallest rectangle that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Returns a rectangle that is larger by a fifth of its size plus one metre on all sides.
    #[must_use]
    pub fn padded(self) -> Self {
        let padding = (self.high - self.low) * 0.2 + 1.0;
        Self { low: self.low - padding, high: self.high + padding }
    }

    /// The rectangle's centre.
    pub fn centre(self) -> Vec2 {
        (self.low + self.high) / 2.0
    }
}

/// The part of a picture that nothing covers, as fractions of its width and height from the top
/// left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Width of the picture divided by its height.
    pub aspect: f32,
    /// The part's top left corner.
    pub low: Vec2,
    /// The part's bottom right corner.
    pub high: Vec2,
}

impl Window {
    /// Returns all of a picture.
    pub fn whole(aspect: f32) -> Self {
        Self { aspect, low: Vec2::ZERO, high: Vec2::ONE }
    }
}

impl Default for Bounds {
    /// A square of twenty metres around the origin, which an empty fleet is shown in.
    fn default() -> Self {
        Self { low: Vec2::splat(-10.0), high: Vec2::splat(10.0) }
    }
}

#[cfg(test)]
mod tests;
