//! The detector against a brute-force oracle that checks every two robots of each frame: pair by
//! pair, event by event.

use std::collections::BTreeMap;

use glam::Vec2;
use proptest::prelude::*;
use regatta_plugin::contact::{ContactChange, ContactEvent, ContactLevel};
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::world::{RobotTypeRecord, Shape};

use super::fleet::{Robot, frames, later, test_world, update};
use crate::body::{Body, CIRCLE};
use crate::continuous::{ALWAYS, closest_proximity};
use crate::criteria::{Criteria, INFLATION, Settings};
use crate::detector::Detector;
use crate::heading::heading;
use crate::leg_table::LegTable;
use crate::prediction::{Intent, Limits, Motion, Predictor, Segment};

/// All trajectories of a robot.
type Ways = Vec<Vec<Segment>>;

/// A detector and the oracle, which are compared after each frame. Frames are a second apart.
struct Trial {
    settings: Settings,
    detector: Detector,
    legs: LegTable,
    robot_types: Vec<RobotTypeRecord>,
    levels: BTreeMap<[u32; 2], (ContactLevel, u64)>,
    tick: u64,
}

impl Trial {
    fn new(settings: Settings) -> Self {
        let mut detector = Detector::new(settings);
        let world = test_world();
        detector.set_world(&world.view(1, 1));
        let (legs, robot_types) = (LegTable::new(&world.view(1, 1)), world.robot_types);
        Self { settings, detector, legs, robot_types, levels: BTreeMap::new(), tick: 0 }
    }

    fn update(&mut self, robots: &[Robot]) {
        self.tick += 1;
        update(&mut self.detector, robots, self.tick);
        let changes = self.advance_oracle(robots);
        let events: Vec<_> = self.detector.events().iter().map(change).collect();
        assert_eq!(events, changes, "changes of tick {}", self.tick);
        let mut listed = BTreeMap::new();
        for contact in self.detector.contacts() {
            let level = ContactLevel::from_number(contact.level).expect("a level");
            assert_eq!(
                listed.insert(contact.robots, (level, contact.since_tick)),
                None,
                "listed twice"
            );
            assert_eq!(contact.edge, robots[contact.robots[0] as usize].edge);
        }
        assert_eq!(listed, self.levels, "pairs of tick {}", self.tick);
        let touching =
            self.detector.contacts().iter().take_while(|contact| contact.level == 2).count();
        assert_eq!(touching, self.detector.touching(), "touching pairs come first");
        let mut levels = vec![0.0_f32; robots.len()];
        for (pair, (level, _)) in &self.levels {
            pair.iter().for_each(|&robot| {
                levels[robot as usize] = levels[robot as usize].max(*level as u32 as f32)
            });
        }
        assert_eq!(self.detector.levels(), levels);
        assert!(!self.detector.is_capped());
    }

    /// Applies the definition to every two robots, one pair after the other. Returns the changes as
    /// (pair, level, change).
    fn advance_oracle(&mut self, robots: &[Robot]) -> Vec<([u32; 2], u32, u32)> {
        let bodies: Vec<_> = robots.iter().map(|robot| self.body(robot)).collect();
        let mut changes = Vec::new();
        let most = robots
            .len()
            .max(self.levels.keys().map(|pair| pair[1] as usize + 1).max().unwrap_or(0));
        for first in 0..most {
            for second in first + 1..most {
                let pair = [first as u32, second as u32];
                let before = self.levels.get(&pair).map(|(level, _)| *level);
                let both = (
                    bodies.get(first).and_then(Option::as_ref),
                    bodies.get(second).and_then(Option::as_ref),
                );
                let level = match both {
                    (Some(a), Some(b)) => self.criteria(a, b).level(before),
                    _ => None,
                };
                if level == before {
                    continue;
                }
                for (reached, number) in [(ContactLevel::Possible, 1), (ContactLevel::Touching, 2)]
                {
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

    /// Checks all segments of all trajectories of both, without any shortcut.
    fn criteria(&self, (a, ways_a): &(Body, Ways), (b, ways_b): &(Body, Ways)) -> Criteria {
        let now = Criteria::now(self.settings, a, b);
        if self.settings.horizon() == 0.0 {
            return now;
        }
        let ways = ways_a.iter().flat_map(|way_a| ways_b.iter().map(move |way_b| (way_a, way_b)));
        ways.fold(now, |all, (way_a, way_b)| {
            all.or(Criteria::predicted(closest_proximity(
                (a, way_a),
                (b, way_b),
                ALWAYS,
                INFLATION,
            )))
        })
    }

    /// Returns a robot as the documentation defines it; `None` if it is excluded.
    fn body(&self, robot: &Robot) -> Option<(Body, Ways)> {
        let is_pose = robot.x.abs() <= 1e6 && robot.y.abs() <= 1e6 && robot.theta.abs() <= 1e3;
        if robot.state > 7 || !is_pose {
            return None;
        }
        let is_index =
            robot.robot_type >= 0.0 && (robot.robot_type as usize) < self.robot_types.len();
        let robot_type = &self.robot_types[if is_index { robot.robot_type as usize } else { 0 }];
        if !(robot_type.length.is_finite() && robot_type.width.is_finite()) {
            return None;
        }
        let speed = if robot.speed.is_nan() { 0.0 } else { robot.speed.clamp(-50.0, 50.0) };
        let heading = heading(robot.theta);
        let half_width =
            if robot_type.shape() == Shape::Circle { CIRCLE } else { 0.5 * robot_type.width };
        let body = Body {
            position: Vec2::new(robot.x, robot.y),
            heading,
            half_length: 0.5 * robot_type.length,
            half_width,
        };
        let intent = match RobotState::from_number(robot.state) {
            RobotState::Driving => Intent::Drive,
            RobotState::Held | RobotState::Stalled | RobotState::Broken => Intent::Hold,
            _ => Intent::Keep,
        };
        let limits = Limits::new(robot_type.max_speed, robot_type.max_acceleration);
        let motion = Motion { speed, s: robot.s, edge: robot.edge, intent, limits, route: None };
        let mut ways = Vec::new();
        if self.settings.horizon() > 0.0 {
            let world = (&self.legs, self.settings.horizon());
            Predictor::default().predict((&body, &motion), world, &mut Vec::new(), |segments| {
                ways.push(std::mem::take(segments));
            });
        }
        Some((body, ways))
    }
}

fn change(event: &ContactEvent) -> ([u32; 2], u32, u32) {
    (event.robots, event.level, event.change)
}

fn settings() -> impl Strategy<Value = Settings> {
    let (margin, horizon) = (
        prop::sample::select(vec![0.0, 0.2, 3.0]),
        prop::sample::select(vec![0.0, 0.5, 2.0, 20.0]),
    );
    (margin, horizon)
        .prop_map(|(margin, horizon)| Settings::new(margin, horizon).expect("valid settings"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_pair_and_every_change_agrees_with_the_oracle(
        settings in settings(),
        first in frames(60),
        second in frames(60),
        shifts in prop::collection::vec(0.0_f32..0.7, 1..6),
    ) {
        let mut trial = Trial::new(settings);
        for start in [&first, &second] {
            let mut frame = start.clone();
            trial.update(&frame);
            for shift in &shifts {
                frame = later(&frame, *shift);
                trial.update(&frame);
            }
        }
        trial.update(&[]);
    }
}

/// Several thousand robots, so that there are several buckets.
#[test]
fn a_large_fleet_agrees_with_the_oracle() {
    let mut seed = 1_u64;
    let mut unit = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1 << 24) as f32
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
            // One robot in a thousand is huge.
            robot_type: if number % 1000 == 1 { 2.0 } else { (number % 4 % 2) as f32 },
        })
        .collect();
    let mut trial = Trial::new(Settings::new(0.2, 2.0).expect("valid settings"));
    for _ in 0..3 {
        trial.update(&frame);
        frame = later(&frame, 0.1);
    }
    assert!(trial.detector.contacts().len() > 1000 && trial.detector.touching() > 100);
}

/// A large robot at the end of its leg, across it: within the horizon it has the heading of the
/// next leg.
#[test]
fn a_robot_that_takes_the_heading_of_the_next_leg_is_found_where_it_turns_to() {
    let row = (0..19).map(|number| Robot { x: 0.25 * number as f32, ..Robot::IDLE });
    let at_the_end = Robot {
        theta: std::f32::consts::FRAC_PI_2,
        s: 6.0,
        edge: 0,
        state: 6,
        robot_type: 2.0,
        ..Robot::IDLE
    };
    for speed in [0.1, 1e-40] {
        let mut trial = Trial::new(Settings::new(0.0, 0.5).expect("valid settings"));
        trial.update(
            &row.clone().chain([Robot { x: 4.5, speed, ..at_the_end }]).collect::<Vec<_>>(),
        );
    }
}
