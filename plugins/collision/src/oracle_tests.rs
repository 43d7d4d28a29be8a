//! The detector against a brute-force oracle, that checks every two robots of each frame: pair by pair, event by event.

use std::collections::BTreeMap;

use proptest::prelude::*;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord, Shape};

use crate::body::Body;
use crate::detector::{Detector, Scene};
use crate::footprint::CIRCLE;
use crate::heading::heading;
use crate::meeting::{ALWAYS, meet};
use crate::pair::{GROWN, Signs};
use crate::path::Paths;
use crate::prediction::{Drive, Piece, predict};
use crate::settings::Settings;

/// A robot of a frame, by rows: the way to write it down, not the way to look at it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Robot {
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    pub speed: f32,
    pub s: f32,
    pub edge: u32,
    pub state: u8,
    pub kind: f32,
}

impl Robot {
    pub(crate) const IDLE: Self =
        Self { x: 0.0, y: 0.0, theta: 0.0, speed: 0.0, s: 0.0, edge: NO_EDGE, state: 0, kind: 0.0 };
}

/// Kinds of robots: usual ones, huge and tiny ones, and one that makes no sense.
pub(crate) fn types() -> Vec<RobotTypeRecord> {
    let kind = |shape: Shape, length: f32, width: f32| RobotTypeRecord {
        name: RobotTypeRecord::padded_name("kind"),
        shape: shape as u32,
        length,
        width,
        max_speed: f32::INFINITY,
        max_acceleration: f32::INFINITY,
    };
    vec![
        kind(Shape::Rectangle, 0.9, 0.6),
        kind(Shape::Circle, 0.5, 0.0),
        kind(Shape::Rectangle, 25.0, 8.0),
        kind(Shape::Rectangle, 0.02, 0.01),
        kind(Shape::Circle, 40.0, 0.0),
        kind(Shape::Rectangle, f32::NAN, 1.0),
    ]
}

fn edges() -> Vec<EdgeRecord> {
    let edge = |control_points: [[f32; 2]; 4], length| EdgeRecord { control_points, length, ..EdgeRecord::default() };
    vec![
        edge([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [6.0, 0.0]], 6.0),
        edge([[0.0, 0.0], [1.1, 0.0], [2.0, 0.9], [2.0, 2.0]], 3.2),
        edge([[0.0, 0.0], [5.0, 0.0], [-5.0, 5.0], [8.0, 5.0]], 13.0),
        edge([[f32::NAN; 2]; 4], 5.0),
    ]
}

/// Runs a detector over frames, each a second after the one before, and asks the oracle after each.
struct Trial {
    settings: Settings,
    detector: Detector,
    paths: Paths,
    types: Vec<RobotTypeRecord>,
    levels: BTreeMap<[u32; 2], (ContactLevel, u64)>,
    tick: u64,
}

impl Trial {
    fn new(settings: Settings) -> Self {
        let mut detector = Detector::new(settings);
        detector.set_world(&edges(), &types());
        let (paths, types) = (Paths::new(&edges()), types());
        Self { settings, detector, paths, types, levels: BTreeMap::new(), tick: 0 }
    }

    fn look(&mut self, robots: &[Robot]) {
        self.tick += 1;
        look(&mut self.detector, robots, self.tick);
        let changes = self.judge(robots);
        let told: Vec<_> = self.detector.events().iter().map(change).collect();
        assert_eq!(told, changes, "changes of tick {}", self.tick);
        let mut listed = BTreeMap::new();
        for contact in self.detector.contacts() {
            let level = ContactLevel::from_number(contact.level).expect("a level");
            assert_eq!(listed.insert(contact.robots, (level, contact.since_tick)), None, "told twice");
            assert_eq!(contact.edge, robots[contact.robots[0] as usize].edge);
        }
        assert_eq!(listed, self.levels, "pairs of tick {}", self.tick);
        let touching = self.detector.contacts().iter().take_while(|contact| contact.level == 2).count();
        assert_eq!(touching, self.detector.touching(), "those that touch first");
        let mut levels = vec![0.0_f32; robots.len()];
        for (pair, (level, _)) in &self.levels {
            pair.iter().for_each(|&robot| levels[robot as usize] = levels[robot as usize].max(*level as u32 as f32));
        }
        assert_eq!(self.detector.levels(), levels);
        assert!(!self.detector.is_capped());
    }

    /// Every two robots, one pair after the other.
    fn judge(&mut self, robots: &[Robot]) -> Vec<([u32; 2], u32, u32)> {
        let bodies: Vec<_> = robots.iter().map(|robot| self.body(robot)).collect();
        let mut changes = Vec::new();
        let most = robots.len().max(self.levels.keys().map(|pair| pair[1] as usize + 1).max().unwrap_or(0));
        for first in 0..most {
            for second in first + 1..most {
                let pair = [first as u32, second as u32];
                let before = self.levels.get(&pair).map(|(level, _)| *level);
                let both = (bodies.get(first).and_then(Option::as_ref), bodies.get(second).and_then(Option::as_ref));
                let level = match both {
                    (Some(a), Some(b)) => self.signs(a, b).level(before),
                    _ => None,
                };
                if level == before {
                    continue;
                }
                for (reached, number) in [(ContactLevel::Possible, 1), (ContactLevel::Touching, 2)] {
                    if before < Some(reached) && level >= Some(reached) {
                        changes.push((pair, number, ContactChange::Began as u32));
                    }
                }
                for (left, number) in [(ContactLevel::Touching, 2), (ContactLevel::Possible, 1)] {
                    if before >= Some(left) && level < Some(left) {
                        changes.push((pair, number, ContactChange::Ended as u32));
                    }
                }
                match level {
                    Some(level) => drop(self.levels.insert(pair, (level, self.tick))),
                    None => drop(self.levels.remove(&pair)),
                }
            }
        }
        changes
    }

    /// No quick looks: every piece of both ways, whatever the present says.
    fn signs(&self, (a, pieces_a): &(Body, Vec<Piece>), (b, pieces_b): &(Body, Vec<Piece>)) -> Signs {
        let now = Signs::now(self.settings, a, b);
        if self.settings.horizon() == 0.0 {
            return now;
        }
        now.or(Signs::later(meet((a, pieces_a), (b, pieces_b), ALWAYS, GROWN)))
    }

    /// What the documentation says of who is looked at, and as what.
    fn body(&self, robot: &Robot) -> Option<(Body, Vec<Piece>)> {
        let is_pose = robot.x.abs() <= 1e6 && robot.y.abs() <= 1e6 && robot.theta.abs() <= 1e3;
        if robot.state > 4 || !is_pose {
            return None;
        }
        let is_index = robot.kind >= 0.0 && (robot.kind as usize) < self.types.len();
        let kind = &self.types[if is_index { robot.kind as usize } else { 0 }];
        if !(kind.length.is_finite() && kind.width.is_finite()) {
            return None;
        }
        let speed = if robot.speed.is_nan() { 0.0 } else { robot.speed.clamp(-50.0, 50.0) };
        let heading = heading(robot.theta);
        let half_width = if kind.shape() == Shape::Circle { CIRCLE } else { 0.5 * kind.width };
        let body = Body { place: [robot.x, robot.y], heading, half_length: 0.5 * kind.length, half_width };
        let mut pieces = Vec::new();
        if self.settings.horizon() > 0.0 {
            let speed = if robot.state == RobotState::Held as u8 { 0.0 } else { speed };
            let drive = Drive { speed, s: robot.s, chords: self.paths.of(robot.edge) };
            predict(&body, drive, self.settings.horizon(), &mut pieces);
        }
        Some((body, pieces))
    }
}

fn change(event: &ContactEvent) -> ([u32; 2], u32, u32) {
    (event.robots, event.level, event.change)
}

/// Lets a detector look at a frame of these robots.
pub(crate) fn look(detector: &mut Detector, robots: &[Robot], tick: u64) {
    let column = |of: fn(&Robot) -> f32| robots.iter().map(of).collect::<Vec<_>>();
    let [x, y, theta] = [column(|robot| robot.x), column(|robot| robot.y), column(|robot| robot.theta)];
    let [speed, s, types] = [column(|robot| robot.speed), column(|robot| robot.s), column(|robot| robot.kind)];
    let edge: Vec<_> = robots.iter().map(|robot| robot.edge).collect();
    let state: Vec<_> = robots.iter().map(|robot| robot.state).collect();
    let columns = Columns { x: &x, y: &y, theta: &theta, speed: &speed, s: &s, edge: &edge, state: &state };
    detector.look(&Scene { run_id: 1, tick, sim_time_nanos: tick * 1_000_000_000, columns, types: &types });
}

fn settings() -> impl Strategy<Value = Settings> {
    let (margin, horizon) =
        (prop::sample::select(vec![0.0, 0.2, 3.0]), prop::sample::select(vec![0.0, 0.5, 2.0, 20.0]));
    (margin, horizon).prop_map(|(margin, horizon)| Settings::new(margin, horizon).expect("sane"))
}

/// Where robots stand: close together, on one spot, in a row or a column, far out, in a lattice, here and there.
#[derive(Clone, Copy, Debug)]
enum Layout {
    Box(f32),
    Spot,
    Row(f32),
    Column(f32),
    Corner(f32),
    Lattice(f32),
}

fn layouts() -> impl Strategy<Value = Layout> {
    prop_oneof![
        (1.0_f32..60.0).prop_map(Layout::Box),
        Just(Layout::Spot),
        prop::sample::select(vec![0.25, 0.9, 0.6, 100.0, 8_000.0]).prop_map(Layout::Row),
        prop::sample::select(vec![0.25, 0.9, 0.6, 100.0, 8_000.0]).prop_map(Layout::Column),
        prop::sample::select(vec![8_000.0, 999_990.0]).prop_map(Layout::Corner),
        prop::sample::select(vec![2.0, 8.0, 512.0, 65_536.0]).prop_map(Layout::Lattice),
    ]
}

impl Layout {
    fn place(self, number: usize, [u, v]: [f32; 2]) -> [f32; 2] {
        let row = number as f32;
        match self {
            Self::Box(side) => [u * side, v * side],
            Self::Spot => [3.25, -7.5],
            Self::Row(step) => [row * step, v * 0.3],
            Self::Column(step) => [u * 0.3, row * step],
            Self::Corner(far) => [far - u * 4.0, -far + v * 4.0],
            Self::Lattice(step) => [(number % 8) as f32 * step, (number / 8) as f32 * step],
        }
    }
}

fn robots() -> impl Strategy<Value = Robot> {
    let axis = prop::sample::select(vec![0.0, 0.5, 1.0, -0.5]).prop_map(|turn| turn * std::f32::consts::PI);
    let theta = prop_oneof![axis, -3.2_f32..3.2];
    let speed = prop_oneof![Just(0.0_f32), -2.0_f32..2.0, Just(1.0)];
    let edge = prop::sample::select(vec![0, 1, 2, 2, 3, 77, NO_EDGE]);
    let state = prop::sample::select(vec![0_u8, 1, 1, 1, 2, 3, 4, 5, 255]);
    let kind =
        prop::sample::select(vec![0.0_f32, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 6.0, -1.0, f32::NAN]);
    let unit = [0.0_f32..1.0, 0.0_f32..1.0];
    (unit, theta, speed, -1.0_f32..15.0, edge, state, kind)
        .prop_map(|([x, y], theta, speed, s, edge, state, kind)| Robot { x, y, theta, speed, s, edge, state, kind })
}

/// Numbers that a faulty producer may send.
fn garbage() -> impl Strategy<Value = f32> {
    prop::sample::select(vec![
        f32::NAN,
        f32::INFINITY,
        -f32::INFINITY,
        f32::MAX,
        -1e7,
        1e-40,
        0.0,
        1000.5,
        f32::MIN_POSITIVE,
    ])
}

/// A frame: some robots in a layout, of which a few are garbage.
fn frames(most: usize) -> impl Strategy<Value = Vec<Robot>> {
    let faults = prop::collection::vec((any::<prop::sample::Index>(), 0_usize..5, garbage()), 0..4);
    (layouts(), prop::collection::vec(robots(), 1..most), faults).prop_map(|(layout, mut robots, faults)| {
        for (number, robot) in robots.iter_mut().enumerate() {
            [robot.x, robot.y] = layout.place(number, [robot.x, robot.y]);
        }
        for (index, column, value) in faults {
            let Robot { x, y, theta, speed, s, .. } = index.get_mut(&mut robots[..]);
            *[x, y, theta, speed, s][column] = value;
        }
        robots
    })
}

/// Some time later: everybody has moved a bit, a few have changed their mind, left, or come.
fn later(robots: &[Robot], shift: f32) -> Vec<Robot> {
    let mut later = robots.to_vec();
    for (number, robot) in later.iter_mut().enumerate() {
        let step = shift * robot.speed.clamp(-2.0, 2.0);
        robot.x += step * robot.theta.cos();
        robot.y += step * robot.theta.sin();
        robot.s += step;
        robot.theta += 0.3 * shift;
        if (number + (shift * 100.0) as usize).is_multiple_of(7) {
            robot.state = (robot.state % 6 + 1) % 6;
        }
    }
    if shift > 0.5 {
        later.truncate(robots.len() / 2 + 1);
    }
    later
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_pair_and_every_change_is_the_oracles(
        settings in settings(),
        first in frames(60),
        second in frames(60),
        shifts in prop::collection::vec(0.0_f32..0.7, 1..6),
    ) {
        let mut trial = Trial::new(settings);
        for start in [&first, &second] {
            let mut frame = start.clone();
            trial.look(&frame);
            for shift in &shifts {
                frame = later(&frame, *shift);
                trial.look(&frame);
            }
        }
        trial.look(&[]);
    }
}

/// Several thousand, so that strips don't share their memory.
#[test]
fn a_large_fleet_is_the_oracles() {
    let mut roll = 1_u64;
    let mut unit = || {
        roll = roll.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (roll >> 40) as f32 / (1 << 24) as f32
    };
    let mut frame: Vec<_> = (0..4000)
        .map(|number| Robot {
            x: unit() * 130.0,
            y: unit() * 130.0 - 60.0,
            theta: unit() * 6.0 - 3.0,
            speed: unit() * 1.5,
            s: unit() * 6.0,
            edge: if number % 5 == 0 { NO_EDGE } else { number % 3 },
            state: if number % 50 == 0 { 255 } else { 1 },
            // One in a thousand is huge.
            kind: if number % 1000 == 1 { 2.0 } else { (number % 4 % 3) as f32 },
        })
        .collect();
    let mut trial = Trial::new(Settings::new(0.2, 2.0).expect("sane"));
    for _ in 0..3 {
        trial.look(&frame);
        frame = later(&frame, 0.1);
    }
    assert!(trial.detector.contacts().len() > 1000 && trial.detector.touching() > 100);
}
