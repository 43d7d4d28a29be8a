//! The detector: from frames to contacts.

use std::ops::ControlFlow;

use regatta_plugin::World;
use regatta_plugin::contact::{ContactEvent, ContactRecord};
use regatta_plugin::frame::Columns;

use crate::criteria::Settings;
use crate::frame_context::{FrameContext, WorldModel};
use crate::narrow_phase::{check, check_all};
use crate::radix;
use crate::routes::Routes;
use crate::strip_index::StripIndex;
use crate::sweep::Limits;
use crate::totals::RunTotals;
use crate::tracker::{ContactTracker, FrameTime, PairObservation};

/// The largest number of overlapping boxes that are checked.
const MAX_CHECKS: Limit = Limit { per_robot: 64, constant: 1 << 18 };
/// The largest number of comparisons of boxes.
const MAX_COMPARISONS: Limit = Limit { per_robot: 512, constant: 1 << 22 };
/// The largest number of pairs in the list. Enough for all pairs of 360 robots.
const MAX_PAIRS: Limit = Limit { per_robot: 8, constant: 1 << 16 };
/// The limits of a sweep after one of those was exceeded. Without limits on the whole frame, it
/// doesn't stop early.
const CAPPED: Limits = Limits {
    comparisons_per_robot: 512,
    checks_per_robot: 8,
    comparisons: usize::MAX,
    checks: usize::MAX,
};

/// A limit of a frame: for each robot on average, and in addition for any fleet.
struct Limit {
    per_robot: usize,
    constant: usize,
}

impl Limit {
    fn of(&self, robots: usize) -> usize {
        self.per_robot * robots + self.constant
    }
}

/// The detector's input: a frame, and the type of each robot.
#[derive(Clone, Copy, Debug)]
pub struct FrameInput<'frame> {
    /// Run of the frame. Another run, or a tick before the last frame's, resets the detector.
    pub run_id: u64,
    /// Tick of the frame.
    pub tick: u64,
    /// Simulated time of the frame, in nanoseconds.
    pub sim_time_nanos: u64,
    /// Columns of the frame.
    pub columns: Columns<'frame>,
    /// Each robot's index into the robot types, as in the column `type`. Robots beyond its end, and
    /// robots with an invalid index, have the first type.
    pub robot_types: &'frame [f32],
}

/// The detector of robots that touch or may touch, frame by frame.
///
/// It reuses its memory: after the first frame of a fleet, further frames allocate nothing.
#[derive(Debug)]
pub struct Detector {
    settings: Settings,
    world: WorldModel,
    routes: Routes,
    index: StripIndex,
    near: Vec<[u32; 2]>,
    observations: Vec<PairObservation>,
    scratch: Vec<PairObservation>,
    tracker: ContactTracker,
    levels: Vec<f32>,
    invalid_robots: usize,
    capped: bool,
}

impl Detector {
    /// Creates a detector for an empty world.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            world: WorldModel::new(&World::default()),
            routes: Routes::default(),
            index: StripIndex::default(),
            near: Vec::new(),
            observations: Vec::new(),
            scratch: Vec::new(),
            tracker: ContactTracker::default(),
            levels: Vec::new(),
            invalid_robots: 0,
            capped: false,
        }
    }

    /// Replaces the world. Without robot types, every robot is a rectangle of 0.9 m × 0.6 m.
    pub fn set_world(&mut self, world: &World<'_>) {
        self.world = WorldModel::new(world);
        self.routes.clear();
    }

    /// Returns the routes that predictions follow.
    pub fn routes(&self) -> &Routes {
        &self.routes
    }

    /// Returns the routes that predictions follow, to learn others.
    pub fn routes_mut(&mut self) -> &mut Routes {
        &mut self.routes
    }

    /// Processes a frame.
    pub fn update(&mut self, input: &FrameInput) {
        let &FrameInput { columns, robot_types, .. } = input;
        let robots = columns.x.len();
        self.tracker.begin_frame(FrameTime {
            run_id: input.run_id,
            tick: input.tick,
            nanos: input.sim_time_nanos,
        });
        self.routes.follow(input.run_id, input.tick, columns.edge);
        self.find_pairs(columns, robot_types);
        let bits = radix::bits_below(robots);
        radix::sort(&mut self.observations, &mut self.scratch, 0..bits, |pair| {
            pair.robots[0].into()
        });
        for group in self.observations.chunk_by_mut(|a, b| a.robots[0] == b.robots[0]) {
            group.sort_unstable_by_key(|pair| pair.robots[1]);
        }
        self.tracker.end_frame(&self.observations, MAX_PAIRS.of(robots), columns.edge);
        self.mark(robots);
    }

    fn find_pairs(&mut self, columns: Columns, robot_types: &[f32]) {
        let Self { settings, world, routes, index, near, observations, tracker, .. } = self;
        let context = FrameContext { columns, robot_types, world, settings: *settings, routes };
        let robots = columns.x.len();
        self.invalid_robots = index.fill(&context);
        let mut find = |limits: Limits, max_pairs: usize, found: &mut Vec<PairObservation>| {
            found.clear();
            index.sweep(&context, limits, |strip, candidates| {
                check_all(&context, strip, candidates, near, found);
                if found.len() > max_pairs {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
        };
        let limits = Limits {
            comparisons_per_robot: usize::MAX,
            checks_per_robot: usize::MAX,
            comparisons: MAX_COMPARISONS.of(robots),
            checks: MAX_CHECKS.of(robots),
        };
        self.capped = find(limits, MAX_PAIRS.of(robots), observations).is_break();
        if self.capped {
            tracker.mark_capped();
            let _ = find(CAPPED, usize::MAX, observations);
            find_previous(index, tracker.contacts(), &context, observations);
        }
    }

    fn mark(&mut self, robots: usize) {
        self.levels.clear();
        self.levels.resize(robots, 0.0);
        // Touching pairs come first in the list and are written last, so that they prevail.
        for contact in self.tracker.contacts().iter().rev() {
            for robot in contact.robots {
                self.levels[robot as usize] = contact.level as f32;
            }
        }
    }

    /// Returns all pairs that have a level now: touching ones first, each sorted by robots.
    pub fn contacts(&self) -> &[ContactRecord] {
        self.tracker.contacts()
    }

    /// Returns the number of touching pairs.
    pub fn touching(&self) -> usize {
        self.tracker.touching()
    }

    /// Returns the changes of the last frame.
    ///
    /// A pair that is [touching](regatta_plugin::contact::ContactLevel::Touching) is also possible:
    /// each `began` of a level has one `ended`, and the time in which a pair touches lies within
    /// the time in which it is possible.
    pub fn events(&self) -> &[ContactEvent] {
        self.tracker.events()
    }

    /// Returns each robot's level: 0 if it is clear, else the highest
    /// [level](regatta_plugin::contact::ContactLevel) of its pairs.
    pub fn levels(&self) -> &[f32] {
        &self.levels
    }

    /// Returns the totals of the run.
    pub fn totals(&self) -> &RunTotals {
        self.tracker.totals()
    }

    /// Returns the number of robots that can't be checked, because their pose or the footprint of
    /// their type is invalid.
    pub fn invalid_robots(&self) -> usize {
        self.invalid_robots
    }

    /// Whether there were more pairs than the detector examines.
    ///
    /// If so, it has examined all pairs that had a level before, and some neighbours of each robot:
    /// every pair in the list is real, but there may be others.
    pub fn is_capped(&self) -> bool {
        self.capped
    }
}

/// Adds the pairs that had a level before and still have one.
fn find_previous(
    index: &StripIndex,
    previous: &[ContactRecord],
    context: &FrameContext,
    observations: &mut Vec<PairObservation>,
) {
    let locations = index.locations();
    for contact in previous {
        let found = contact.robots.map(|robot| locations.get(robot as usize).copied().flatten());
        if let [Some((bucket_a, slot_a)), Some((bucket_b, slot_b))] = found {
            let (a, b) = (index.bucket(bucket_a), index.bucket(bucket_b));
            check(context, (a, slot_a), (b, slot_b), observations);
        }
    }
}

#[cfg(test)]
mod tests;
