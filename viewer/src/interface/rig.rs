//! What moves the camera: hands, flights to somewhere, and a robot that it follows. Nothing but geometry and time.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Vec2, Vec3};

use crate::camera::{Bounds, Camera};

/// Radians that the look turns per point of a drag.
const TURN_PER_POINT: f32 = 0.006;
/// Seconds of a flight.
const FLIGHT: f64 = 0.45;
/// Metres from a robot that is flown to.
const CLOSE: f32 = 9.0;
/// How the camera stands behind a robot: radians below the horizon, metres away.
const BEHIND: (f32, f32) = (0.42, 6.0);
/// Metres above a robot that is followed from above.
const ABOVE: f32 = 14.0;
/// Metres above the ground at which a robot is looked at.
const WAIST: f32 = 0.25;

/// Where a robot is and how it is turned, as drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Metres east and north.
    pub place: Vec2,
    /// Radians counter-clockwise from east.
    pub theta: f32,
}

/// How a robot is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// From behind, turning with it.
    Behind,
    /// From above, north stays up.
    Above,
}

/// The camera, and what moves it.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    camera: Camera,
    flight: Option<Flight>,
    follow: Option<(u32, Follow)>,
    /// How the look differs from the followed robot's heading, in radians.
    beside: f32,
    /// How it shows all there is, also when that grows, as long as nobody moves it.
    whole: Option<Whole>,
}

/// A look at all there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Whole {
    /// As it is at the start.
    Usual,
    /// From where it was turned to.
    Turned,
    /// Straight down.
    FromAbove,
}

impl Default for Rig {
    /// Shows all there is, from an angle, until somebody moves it.
    fn default() -> Self {
        Self::new(Camera::default(), false)
    }
}

#[derive(Clone, Copy, Debug)]
struct Flight {
    from: Camera,
    to: Camera,
    /// Part of the way, 0 to 1.
    part: f64,
}

impl Rig {
    /// Starts with a camera. One that was `chosen` stays there.
    pub fn new(camera: Camera, chosen: bool) -> Self {
        Self {
            camera: camera.clamped(),
            flight: None,
            follow: None,
            beside: 0.0,
            whole: (!chosen).then_some(Whole::Usual),
        }
    }

    /// Shows all there is from straight above, until somebody moves it.
    pub fn top_view() -> Self {
        Self { whole: Some(Whole::FromAbove), ..Self::default() }
    }

    /// Shows all there is as long as nobody has moved the camera.
    pub fn keep_fitted(&mut self, bounds: Bounds, aspect: f32) {
        match self.whole.filter(|_| self.flight.is_none()) {
            Some(Whole::Usual) => self.camera = Camera::fit(bounds, aspect),
            Some(Whole::Turned) => self.camera = self.camera.fitted(bounds, aspect).clamped(),
            Some(Whole::FromAbove) => self.camera = Camera::top(bounds, aspect).clamped(),
            None => {}
        }
    }

    /// The camera as it is now.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Whether it moves by itself.
    pub fn is_flying(&self) -> bool {
        self.flight.is_some()
    }

    /// Which robot is followed, and how.
    pub fn followed(&self) -> Option<(u32, Follow)> {
        self.follow
    }

    /// Turns the look round the target by a drag of so many points.
    pub fn orbit(&mut self, drag: Vec2) {
        self.turn(-drag.x * TURN_PER_POINT, drag.y * TURN_PER_POINT);
    }

    /// Turns the look to the left and downwards, in radians.
    pub fn turn(&mut self, left: f32, down: f32) {
        self.touch();
        self.beside += left;
        let camera = Camera { yaw: self.camera.yaw + left, pitch: self.camera.pitch + down, ..self.camera };
        self.camera = camera.clamped();
    }

    /// Moves the ground along with a pointer that went from one point of a picture to another.
    pub fn pan(&mut self, from: Vec2, to: Vec2, size: Vec2) {
        let per_point = self.camera.distance / self.camera.pixels_per_radian(size.y);
        let grabbed = self.camera.unproject(from, size).zip(self.camera.unproject(to, size));
        let most = (to - from).length() * per_point * 6.0;
        let step = match grabbed.map(|(from, to)| from - to) {
            Some(step) if step.length() <= most => step,
            // Near the horizon a point is kilometres.
            _ => {
                let north = Vec2::from_angle(self.camera.yaw);
                (north * (to.y - from.y) - north.perp() * (from.x - to.x)) * per_point
            }
        };
        self.shift(step);
    }

    /// Moves the camera over the ground: to the right and forward as it looks, in parts of its distance.
    pub fn walk(&mut self, right: f32, forward: f32) {
        let ahead = Vec2::from_angle(self.camera.yaw);
        self.shift((ahead * forward - ahead.perp() * right) * self.camera.distance);
    }

    fn shift(&mut self, step: Vec2) {
        self.touch();
        self.follow = None;
        self.camera = Camera { target: self.camera.target + step.extend(0.0), ..self.camera }.clamped();
    }

    /// Goes nearer (a factor below 1) or farther; what is under `cursor` stays there.
    pub fn zoom(&mut self, factor: f32, cursor: Option<Vec2>, size: Vec2) {
        self.touch();
        let before = self.camera;
        let wanted = Camera { distance: before.distance * factor, ..before }.clamped();
        let factor = wanted.distance / before.distance;
        let anchor = cursor.filter(|_| self.follow.is_none()).and_then(|cursor| before.unproject(cursor, size));
        // A look just below the horizon would take the camera far away.
        let anchor = anchor.filter(|anchor| anchor.distance(before.target.truncate()) < 4.0 * before.distance);
        let anchor = anchor.map_or(before.target, |anchor| anchor.extend(0.0));
        let target = if self.follow.is_some() { before.target } else { anchor + (before.target - anchor) * factor };
        self.camera = Camera { target, distance: wanted.distance, ..before }.clamped();
    }

    fn touch(&mut self) {
        self.whole = None;
        self.flight = None;
    }

    /// Flies to where all there is can be seen, from an angle.
    pub fn fit(&mut self, bounds: Bounds, aspect: f32) {
        let camera = Camera { pitch: self.camera.pitch.clamp(0.5, 1.1), ..self.camera };
        self.follow = None;
        self.fly(camera.fitted(bounds, aspect));
        self.whole = Some(Whole::Turned);
    }

    /// Flies to where all there is can be seen from straight above, north up.
    pub fn top(&mut self, bounds: Bounds, aspect: f32) {
        self.follow = None;
        self.fly(Camera::top(bounds, aspect));
        self.whole = Some(Whole::FromAbove);
    }

    /// Flies to a place on the ground, and near it if it was far away.
    pub fn fly_to(&mut self, place: Vec2) {
        self.touch();
        self.follow = None;
        let distance = self.camera.distance.min(CLOSE);
        self.fly(Camera { target: place.extend(WAIST), distance, ..self.camera });
    }

    fn fly(&mut self, to: Camera) {
        self.whole = None;
        self.flight = Some(Flight { from: self.camera, to: to.clamped(), part: 0.0 });
    }

    /// Follows a robot, or none.
    pub fn follow(&mut self, follow: Option<(u32, Follow)>) {
        self.touch();
        self.follow = follow;
        self.beside = 0.0;
        match follow {
            Some((_, Follow::Behind)) => (self.camera.pitch, self.camera.distance) = BEHIND,
            Some((_, Follow::Above)) => {
                (self.camera.pitch, self.camera.yaw) = (FRAC_PI_2, FRAC_PI_2);
                self.camera.distance = self.camera.distance.clamp(ABOVE, 4.0 * ABOVE);
            }
            None => {}
        }
    }

    /// Stops following, where it is.
    pub fn follow_nobody(&mut self) {
        self.follow = None;
    }

    /// The next way of following a robot: behind, above, not.
    pub fn cycle_follow(&mut self, robot: u32) {
        let next = match self.follow {
            Some((followed, Follow::Behind)) if followed == robot => Some(Follow::Above),
            Some((followed, Follow::Above)) if followed == robot => None,
            _ => Some(Follow::Behind),
        };
        self.follow(next.map(|how| (robot, how)));
    }

    /// Lets so many seconds pass; `followed` is where the followed robot is now.
    pub fn advance(&mut self, seconds: f64, followed: Option<Pose>) {
        if let Some(flight) = &mut self.flight {
            flight.part = (flight.part + seconds / FLIGHT).min(1.0);
            self.camera = flight.camera().clamped();
            if flight.part >= 1.0 {
                self.flight = None;
            }
        }
        if let (Some((_, how)), Some(pose)) = (self.follow, followed) {
            self.camera.target = pose.place.extend(WAIST);
            if how == Follow::Behind {
                self.camera.yaw = pose.theta + self.beside;
            }
            self.camera = self.camera.clamped();
        }
    }
}

impl Flight {
    fn camera(&self) -> Camera {
        let part = self.part as f32;
        let part = part * part * (3.0 - 2.0 * part);
        let mix = |from: f32, to: f32| from + (to - from) * part;
        let (from, to) = (self.from, self.to);
        Camera {
            target: from.target + (to.target - from.target) * part,
            yaw: from.yaw + short_way(from.yaw, to.yaw) * part,
            pitch: mix(from.pitch, to.pitch),
            distance: mix(from.distance.ln(), to.distance.ln()).exp(),
            fov_y: to.fov_y,
        }
    }
}

/// From one direction to another the short way round, in radians in (-π, π].
pub fn short_way(from: f32, to: f32) -> f32 {
    PI - (PI - (to - from)).rem_euclid(2.0 * PI)
}

/// A pose between two, the heading the short way round.
pub fn between(from: Pose, to: Pose, part: f32) -> Pose {
    let place = from.place + (to.place - from.place) * part;
    Pose { place, theta: from.theta + short_way(from.theta, to.theta) * part }
}

/// A place on the ground that a camera's target stands on.
pub fn ground(target: Vec3) -> Vec2 {
    target.truncate()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::LOWEST_EYE;

    const SIZE: Vec2 = Vec2::new(900.0, 600.0);

    fn rig() -> Rig {
        let camera = Camera { target: Vec3::new(20.0, -7.0, 0.0), pitch: 0.8, yaw: 0.4, ..Camera::default() };
        Rig::new(camera, true)
    }

    #[test]
    fn what_is_under_the_cursor_stays_there_when_zooming() {
        for cursor in [SIZE / 2.0, Vec2::new(100.0, 500.0), Vec2::new(850.0, 250.0)] {
            for factor in [0.5, 0.9, 1.3] {
                let mut rig = rig();
                let before = rig.camera().unproject(cursor, SIZE).unwrap();
                rig.zoom(factor, Some(cursor), SIZE);
                let after = rig.camera().unproject(cursor, SIZE).unwrap();
                assert!((before - after).length() < 0.05, "{cursor} x {factor}: {before}, {after}");
            }
        }
    }

    #[test]
    fn the_ground_goes_with_the_pointer() {
        let mut rig = rig();
        let (from, to) = (Vec2::new(300.0, 400.0), Vec2::new(420.0, 350.0));
        let grabbed = rig.camera().unproject(from, SIZE).unwrap();
        rig.pan(from, to, SIZE);
        let now = rig.camera().unproject(to, SIZE).unwrap();
        assert!((grabbed - now).length() < 0.05, "{grabbed}, {now}");
    }

    #[test]
    fn panning_across_the_horizon_goes_the_same_way() {
        let mut rig = Rig::new(Camera { pitch: 0.05, yaw: FRAC_PI_2, ..Camera::default() }, true);
        rig.pan(Vec2::new(450.0, 50.0), Vec2::new(500.0, 90.0), SIZE);
        let target = rig.camera().target;
        assert!(target.x < 0.0 && target.y > 0.0, "{target}");
    }

    #[test]
    fn no_hand_brings_the_eye_below_the_ground() {
        let mut rig = rig();
        for _ in 0..200 {
            rig.orbit(Vec2::new(3.0, -40.0));
            rig.zoom(0.8, Some(Vec2::new(10.0, 590.0)), SIZE);
            assert!(rig.camera().eye().z >= LOWEST_EYE - 1e-3, "{:?}", rig.camera());
        }
    }

    #[test]
    fn drags_turn_by_their_own_axis() {
        let mut rig = rig();
        let before = rig.camera();
        rig.orbit(Vec2::new(0.0, 30.0));
        assert!(rig.camera().pitch > before.pitch && (rig.camera().yaw - before.yaw).abs() < 1e-6);
        rig.orbit(Vec2::new(30.0, 0.0));
        assert!((rig.camera().yaw - before.yaw).abs() > 0.1);
        assert_eq!(rig.camera().target, before.target);
    }

    #[test]
    fn flights_arrive() {
        let mut rig = rig();
        rig.fly_to(Vec2::new(-50.0, 60.0));
        assert!(rig.is_flying());
        for _ in 0..100 {
            rig.advance(1.0 / 60.0, None);
        }
        assert!(!rig.is_flying());
        assert!(ground(rig.camera().target).distance(Vec2::new(-50.0, 60.0)) < 1e-3);
    }

    #[test]
    fn following_goes_round_and_stays_with_the_robot() {
        let mut rig = rig();
        rig.cycle_follow(7);
        assert_eq!(rig.followed(), Some((7, Follow::Behind)));
        let pose = Pose { place: Vec2::new(3.0, 4.0), theta: 2.0 };
        rig.advance(0.01, Some(pose));
        assert!((rig.camera().yaw - 2.0).abs() < 1e-5 && ground(rig.camera().target) == pose.place);
        rig.orbit(Vec2::new(10.0, 0.0));
        rig.advance(0.01, Some(pose));
        assert!((rig.camera().yaw - 2.0).abs() > 0.03, "a look from the side stays one");
        rig.cycle_follow(7);
        assert_eq!(rig.followed(), Some((7, Follow::Above)));
        rig.cycle_follow(7);
        assert_eq!(rig.followed(), None);
    }

    #[test]
    fn headings_go_the_short_way_round() {
        let pose = |theta| Pose { place: Vec2::ZERO, theta };
        let halfway = between(pose(3.0), pose(-3.0), 0.5).theta;
        assert!((halfway - PI).abs() < 1e-5, "{halfway}");
    }
}
