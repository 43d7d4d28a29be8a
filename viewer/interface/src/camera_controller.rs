//! The motion of the camera: by the user, along flights, and behind a followed robot. Geometry and
//! time only.

use std::f32::consts::FRAC_PI_2;

use glam::Vec2;
use regatta_scene::camera::{Bounds, Camera, Window};

use super::pose::{Pose, shortest_turn};

/// Radians that the camera turns per point of a drag.
const TURN_PER_POINT: f32 = 0.006;
/// Seconds of a flight.
const FLIGHT_SECONDS: f64 = 0.45;
/// The largest distance to the target after a flight to a place, in metres.
const CLOSE: f32 = 9.0;
/// Pitch in radians below the horizon and distance in metres of a camera that follows from behind.
const BEHIND: (f32, f32) = (0.42, 6.0);
/// The smallest height over a robot that is followed from above, in metres.
const ABOVE: f32 = 14.0;
/// The height of the target on a robot, in metres above the ground.
const TARGET_HEIGHT: f32 = 0.25;

/// The position from which a robot is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// From behind; the camera turns with the robot.
    Behind,
    /// From above; north stays up.
    Above,
}

/// The camera of a window, and its motion.
#[derive(Clone, Copy, Debug)]
pub struct CameraController {
    camera: Camera,
    flight: Option<Flight>,
    follow: Option<(u32, Follow)>,
    /// The camera's yaw relative to the followed robot's heading, in radians.
    yaw_offset: f32,
    /// The direction from which everything is kept in the picture, also when it grows; `None`
    /// after the user has moved the camera.
    fit: Option<Fit>,
}

/// A direction from which everything is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    /// The direction of the start.
    Default,
    /// The current direction.
    Current,
    /// Straight down.
    FromAbove,
}

impl Fit {
    /// Returns a camera with this direction; `current` is the camera so far.
    fn direction(self, current: Camera) -> Camera {
        match self {
            Self::Current => current,
            _ if current.is_plan() => Camera { yaw: FRAC_PI_2, ..current },
            Self::Default => Camera { pitch: 0.95, ..Camera::default() },
            Self::FromAbove => Camera { pitch: FRAC_PI_2, ..Camera::default() },
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Flight {
    from: Camera,
    to: Camera,
    /// 0 at the start, 1 at the end.
    progress: f64,
    /// The place on the ground that it leads to, in metres, and the robot there.
    place: Option<Vec2>,
    robot: Option<u32>,
}

impl Default for CameraController {
    /// Shows everything, from an angle, until the user moves the camera.
    fn default() -> Self {
        Self::new(Camera::default(), false)
    }
}

impl CameraController {
    /// Creates a controller. If `is_fixed`, the camera stays as given; otherwise it shows
    /// everything.
    pub fn new(camera: Camera, is_fixed: bool) -> Self {
        Self {
            camera: camera.clamped(),
            flight: None,
            follow: None,
            yaw_offset: 0.0,
            fit: (!is_fixed).then_some(Fit::Default),
        }
    }

    /// Creates a controller that shows everything from straight above until the user moves the
    /// camera.
    pub fn top_view() -> Self {
        Self { fit: Some(Fit::FromAbove), ..Self::default() }
    }

    /// Creates a controller that shows a plan of everything until the user moves the camera.
    pub fn plan() -> Self {
        Self { camera: Camera::default().toggled_plan(), ..Self::top_view() }
    }

    /// Fits the bounds into the part of the picture that is free now, unless the user has moved the
    /// camera or a flight is under way.
    pub fn keep_fitted(&mut self, bounds: Bounds, window: Window) {
        let Some(fit) = self.fit.filter(|_| self.flight.is_none()) else { return };
        self.camera = fit.direction(self.camera).fitted_within(bounds, window).clamped();
    }

    /// Whether the camera shows everything, whatever panels open.
    pub fn is_fitted(&self) -> bool {
        self.fit.is_some()
    }

    /// Returns the current camera.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Whether a flight is under way.
    pub fn is_flying(&self) -> bool {
        self.flight.is_some()
    }

    /// Returns the followed robot and the position from which it is followed.
    pub fn followed(&self) -> Option<(u32, Follow)> {
        self.follow
    }

    /// Orbits around the target by a drag, in points.
    pub fn orbit(&mut self, drag: Vec2) {
        self.turn(-drag.x * TURN_PER_POINT, drag.y * TURN_PER_POINT);
    }

    /// Turns the camera around the target to the left and downwards, in radians.
    pub fn turn(&mut self, left: f32, down: f32) {
        self.end_automatic_motion();
        self.yaw_offset += left;
        let camera =
            Camera { yaw: self.camera.yaw + left, pitch: self.camera.pitch + down, ..self.camera };
        self.camera = camera.clamped();
    }

    /// Moves the ground along with a pointer that went from one point of a picture of this size to
    /// another.
    pub fn pan(&mut self, from: Vec2, to: Vec2, size: Vec2) {
        let per_point = self.camera.distance / self.camera.pixels_per_radian(size.y);
        let ends = self.camera.unproject(from, size).zip(self.camera.unproject(to, size));
        let longest = (to - from).length() * per_point * 6.0;
        let step = match ends.map(|(from, to)| from - to) {
            Some(step) if step.length() <= longest => step,
            // Near the horizon a point is kilometres.
            _ => {
                let forward = Vec2::from_angle(self.camera.yaw);
                (forward * (to.y - from.y) - forward.perp() * (from.x - to.x)) * per_point
            }
        };
        self.shift(step);
    }

    /// Moves the camera over the ground, to its right and forward, as fractions of its distance.
    pub fn translate(&mut self, right: f32, forward: f32) {
        let ahead = Vec2::from_angle(self.camera.yaw);
        self.shift((ahead * forward - ahead.perp() * right) * self.camera.distance);
    }

    fn shift(&mut self, step: Vec2) {
        self.end_automatic_motion();
        self.follow = None;
        self.camera =
            Camera { target: self.camera.target + step.extend(0.0), ..self.camera }.clamped();
    }

    /// Moves the camera over a place on the ground.
    pub fn move_to(&mut self, place: Vec2) {
        self.shift(place - self.camera.target.truncate());
    }

    /// Multiplies the distance by a factor; the point of the ground under `cursor` stays there.
    pub fn zoom(&mut self, factor: f32, cursor: Option<Vec2>, size: Vec2) {
        self.end_automatic_motion();
        let before = self.camera;
        let wanted = Camera { distance: before.distance * factor, ..before }.clamped();
        let factor = wanted.distance / before.distance;
        let anchor = cursor
            .filter(|_| self.follow.is_none())
            .and_then(|cursor| before.unproject(cursor, size));
        // A point just below the horizon would move the camera far away.
        let anchor = anchor
            .filter(|anchor| anchor.distance(before.target.truncate()) < 4.0 * before.distance);
        let anchor = anchor.map_or(before.target, |anchor| anchor.extend(0.0));
        let target = if self.follow.is_some() {
            before.target
        } else {
            anchor + (before.target - anchor) * factor
        };
        self.camera = Camera { target, distance: wanted.distance, ..before }.clamped();
    }

    /// Leaves the camera where it is: it doesn't follow the free part of the picture any more.
    pub fn stay(&mut self) {
        self.fit = None;
    }

    fn end_automatic_motion(&mut self) {
        self.fit = None;
        self.flight = None;
    }

    /// Flies to where everything is in the picture, seen from an angle.
    pub fn fit(&mut self, bounds: Bounds, window: Window) {
        let pitch =
            if self.camera.is_plan() { FRAC_PI_2 } else { self.camera.pitch.clamp(0.5, 1.1) };
        self.follow = None;
        self.fly(Camera { pitch, ..self.camera }.fitted_within(bounds, window));
        self.fit = Some(Fit::Current);
    }

    /// Flies to where everything is in the picture, seen from straight above with north up.
    pub fn top(&mut self, bounds: Bounds, window: Window) {
        self.follow = None;
        self.fly(Fit::FromAbove.direction(self.camera).fitted_within(bounds, window));
        self.fit = Some(Fit::FromAbove);
    }

    /// Switches between the plan and the view in perspective. Both show about the same ground.
    pub fn toggle_plan(&mut self) {
        let fit = self.fit;
        self.end_automatic_motion();
        self.follow = None;
        self.camera = self.camera.toggled_plan();
        self.fit = fit;
    }

    /// Flies to a camera.
    pub fn fly_to_camera(&mut self, camera: Camera) {
        self.follow = None;
        self.fly(camera);
    }

    /// Sets the camera's direction in radians. Its target stays.
    pub fn look(&mut self, yaw: f32, pitch: f32) {
        let usual = if self.camera.is_plan() { self.camera.toggled_plan() } else { self.camera };
        self.fly(Camera { yaw, pitch, ..usual });
    }

    /// Flies to a place on the ground, and closer if the camera is far away. The place gets into
    /// the middle of the picture, or of the part of it that [`Self::aim`] is called with.
    pub fn fly_to(&mut self, place: Vec2) {
        self.end_automatic_motion();
        self.follow = None;
        // The height of the ground in a picture decides what is close.
        let close = CLOSE * (Camera::default().fov_y / 2.0).tan() / (self.camera.fov_y / 2.0).tan();
        let distance = self.camera.distance.min(close);
        self.fly(Camera { target: place.extend(TARGET_HEIGHT), distance, ..self.camera });
        self.flight = self.flight.map(|flight| Flight { place: Some(place), ..flight });
    }

    /// Flies to a place on the ground at the same height, and to its robot also while that drives
    /// on. As for [`Self::fly_to`], [`Self::aim`] tells the part of the picture.
    pub fn show(&mut self, robot: Option<u32>, place: Vec2) {
        self.end_automatic_motion();
        self.follow = None;
        self.fly(Camera { target: place.extend(TARGET_HEIGHT), ..self.camera });
        self.flight = self.flight.map(|flight| Flight { place: Some(place), robot, ..flight });
    }

    /// Flies to a robot, also while it drives on.
    pub fn fly_to_robot(&mut self, robot: u32, place: Vec2) {
        self.fly_to(place);
        self.flight = self.flight.map(|flight| Flight { robot: Some(robot), ..flight });
    }

    /// The robot that the flight leads to.
    pub fn flies_to(&self) -> Option<u32> {
        self.flight.and_then(|flight| flight.robot)
    }

    /// Lets a flight to a place end with that in the middle of a part of the picture. `robot` is
    /// where its robot is now.
    pub fn aim(&mut self, robot: Option<Vec2>, window: Window) {
        if let Some(flight) = &mut self.flight {
            flight.place = robot.or(flight.place);
            if let Some(place) = flight.place {
                flight.to = flight.to.aimed_at(place.extend(TARGET_HEIGHT), window).clamped();
            }
        }
    }

    fn fly(&mut self, to: Camera) {
        self.fit = None;
        // A change between a plan and a perspective isn't animated: it would pass through all
        // fields of view.
        if self.camera.is_plan() != to.is_plan() {
            self.camera = to.clamped();
            return;
        }
        self.flight = Some(Flight {
            from: self.camera,
            to: to.clamped(),
            progress: 0.0,
            place: None,
            robot: None,
        });
    }

    /// Follows a robot, or none.
    pub fn follow(&mut self, follow: Option<(u32, Follow)>) {
        self.end_automatic_motion();
        self.follow = follow;
        self.yaw_offset = 0.0;
        match follow {
            Some((_, Follow::Behind)) => {
                self.camera.fov_y = Camera::default().fov_y;
                (self.camera.pitch, self.camera.distance) = BEHIND;
            }
            // A plan stays as large as it is.
            Some((_, Follow::Above)) if self.camera.is_plan() => self.camera.yaw = FRAC_PI_2,
            Some((_, Follow::Above)) => {
                (self.camera.pitch, self.camera.yaw) = (FRAC_PI_2, FRAC_PI_2);
                self.camera.distance = self.camera.distance.clamp(ABOVE, 4.0 * ABOVE);
            }
            None => {}
        }
    }

    /// Stops following; the camera stays where it is.
    pub fn stop_following(&mut self) {
        self.follow = None;
    }

    /// Follows a robot in the next mode: from behind, from above, off.
    pub fn cycle_follow(&mut self, robot: u32) {
        let next = match self.follow {
            Some((followed, Follow::Behind)) if followed == robot => Some(Follow::Above),
            Some((followed, Follow::Above)) if followed == robot => None,
            _ => Some(Follow::Behind),
        };
        self.follow(next.map(|follow| (robot, follow)));
    }

    /// Advances flights and following by some seconds; `followed` is the current pose of the
    /// followed robot.
    pub fn advance(&mut self, seconds: f64, followed: Option<Pose>) {
        if let Some(flight) = &mut self.flight {
            flight.progress = (flight.progress + seconds / FLIGHT_SECONDS).min(1.0);
            self.camera = flight.camera().clamped();
            if flight.progress >= 1.0 {
                self.flight = None;
            }
        }
        if let (Some((_, follow)), Some(pose)) = (self.follow, followed) {
            self.camera.target = pose.place.extend(TARGET_HEIGHT);
            if follow == Follow::Behind {
                self.camera.yaw = pose.theta + self.yaw_offset;
            }
            self.camera = self.camera.clamped();
        }
    }
}

impl Flight {
    /// Returns the camera at the current progress, with smooth acceleration and a distance that
    /// changes exponentially.
    fn camera(&self) -> Camera {
        let part = self.progress as f32;
        let part = part * part * (3.0 - 2.0 * part);
        let (from, to) = (self.from, self.to);
        let from_log = from.distance.ln();
        Camera {
            target: from.target + (to.target - from.target) * part,
            yaw: from.yaw + shortest_turn(from.yaw, to.yaw) * part,
            pitch: from.pitch + (to.pitch - from.pitch) * part,
            distance: (from_log + (to.distance.ln() - from_log) * part).exp(),
            fov_y: to.fov_y,
        }
    }
}

#[cfg(test)]
mod tests;
