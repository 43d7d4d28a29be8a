//! From frames to contacts.

use std::ops::ControlFlow;

use regatta_plugin::contact::{ContactEvent, ContactRecord};
use regatta_plugin::frame::Columns;
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::body::{meeting_place, relative_speed};
use crate::crowd::{Crowd, Mover, Roads};
use crate::ledger::{Found, Ledger, Moment};
use crate::pair::Signs;
use crate::radix;
use crate::settings::Settings;
use crate::strips::{Limits, Strip, Strips};
use crate::tally::Tally;

/// Overlaps of boxes that are checked, for each robot on average and besides.
const CHECKS: (usize, usize) = (64, 1 << 18);
/// Looks for overlaps, likewise.
const LOOKS: (usize, usize) = (512, 1 << 22);
/// Pairs in the list, likewise. Enough for every two of 360 robots.
const PAIRS: (usize, usize) = (8, 1 << 16);
/// When that was not enough: neighbours that are looked at for each robot, and of those the ones that are checked.
const SOME: (usize, usize) = (512, 8);

/// What the detector looks at: a frame, and which type each robot is of.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'frame> {
    /// The frame's run. With another run, or a tick before the last one's, everything begins anew.
    pub run_id: u64,
    /// Its tick.
    pub tick: u64,
    /// Its simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// Its columns.
    pub columns: Columns<'frame>,
    /// Each robot's index into the robot types, as the column `type` has it. Robots beyond its end, and those whose
    /// value is no index, are of the first type.
    pub types: &'frame [f32],
}

/// Finds out which robots touch and which may, frame by frame.
///
/// Keeps its memory: once it has seen a fleet, further frames of it need none.
#[derive(Debug)]
pub struct Detector {
    settings: Settings,
    roads: Roads,
    strips: Strips,
    found: Vec<Found>,
    scratch: Vec<Found>,
    ledger: Ledger,
    levels: Vec<f32>,
    unplaced: usize,
    capped: bool,
}

impl Detector {
    /// A detector of an empty world.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            roads: Roads::new(&[], &[]),
            strips: Strips::default(),
            found: Vec::new(),
            scratch: Vec::new(),
            ledger: Ledger::default(),
            levels: Vec::new(),
            unplaced: 0,
            capped: false,
        }
    }

    /// Takes another world. Without robot types, every robot is a rectangle of 0.9 m × 0.6 m.
    pub fn set_world(&mut self, edges: &[EdgeRecord], types: &[RobotTypeRecord]) {
        self.roads = Roads::new(edges, types);
    }

    /// Looks at a frame.
    pub fn look(&mut self, scene: &Scene) {
        let &Scene { columns, types, .. } = scene;
        let robots = columns.x.len();
        self.unplaced = self.strips.take(&Crowd { columns, types, roads: &self.roads, settings: self.settings });
        self.ledger.open(Moment { run_id: scene.run_id, tick: scene.tick, nanos: scene.sim_time_nanos });
        self.find_pairs(robots);
        let bits = radix::bits_below(robots);
        radix::sort(&mut self.found, &mut self.scratch, 0..bits, |found| found.robots[0].into());
        for same in self.found.chunk_by_mut(|a, b| a.robots[0] == b.robots[0]) {
            same.sort_unstable_by_key(|found| found.robots[1]);
        }
        self.ledger.close(&self.found, times(PAIRS, robots), columns.edge);
        self.mark(robots);
    }

    fn find_pairs(&mut self, robots: usize) {
        let (looks, checks) = (times(LOOKS, robots), times(CHECKS, robots));
        let all = Limits { looks_each: usize::MAX, checks_each: usize::MAX, looks, checks };
        self.found.clear();
        self.capped = self.find(all, times(PAIRS, robots)).is_break();
        if self.capped {
            self.found.clear();
            self.find_known();
            let (looks_each, checks_each) = SOME;
            // Without limits in all, it doesn't break off.
            let _ = self.find(Limits { looks_each, checks_each, looks: usize::MAX, checks: usize::MAX }, usize::MAX);
        }
    }

    /// Adds every two robots that have a level, until that is too much.
    fn find(&mut self, limits: Limits, most: usize) -> ControlFlow<()> {
        let Self { strips, found, settings, .. } = self;
        strips.sweep(limits, |strip, candidates| {
            for places in candidates {
                let [one, other] = places.map(|place| (strip, strip.mover(place)));
                check(*settings, one, other, found);
            }
            if found.len() > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    }

    /// Adds the pairs that had a level before and still have one.
    fn find_known(&mut self) {
        let places = self.strips.places();
        let mover = |robot: u32| {
            let (strip, place) = (*places.get(robot as usize)?)?;
            let strip = self.strips.strip(strip);
            Some((strip, strip.mover(place)))
        };
        for contact in self.ledger.contacts() {
            if let [Some(one), Some(other)] = contact.robots.map(mover) {
                check(self.settings, one, other, &mut self.found);
            }
        }
    }

    fn mark(&mut self, robots: usize) {
        self.levels.clear();
        self.levels.resize(robots, 0.0);
        // Those that touch stand first in the list, and have the last word.
        for contact in self.ledger.contacts().iter().rev() {
            contact.robots.iter().for_each(|&robot| self.levels[robot as usize] = contact.level as f32);
        }
    }

    /// All pairs with a level now: those that touch first, each kind by robots.
    pub fn contacts(&self) -> &[ContactRecord] {
        self.ledger.contacts()
    }

    /// How many of them touch.
    pub fn touching(&self) -> usize {
        self.ledger.touching()
    }

    /// What the last frame changed.
    ///
    /// A pair that is [touching](regatta_plugin::contact::ContactLevel::Touching) is also possible: so each `began` of
    /// a level has one `ended`, and a pair's touching lies within its being possible.
    pub fn events(&self) -> &[ContactEvent] {
        self.ledger.events()
    }

    /// Each robot's level: 0 if it is clear, else the highest [level](regatta_plugin::contact::ContactLevel) of its
    /// pairs.
    pub fn levels(&self) -> &[f32] {
        &self.levels
    }

    /// Totals of the run.
    pub fn tally(&self) -> &Tally {
        self.ledger.tally()
    }

    /// Robots that can't be checked, because their pose or the footprint of their type is none.
    pub fn unplaced(&self) -> usize {
        self.unplaced
    }

    /// Whether there were more pairs than the detector looks at.
    ///
    /// Then it has looked at all pairs that had a level before, and for each robot at some of its neighbours: every
    /// pair that it tells is one, but there may be others.
    pub fn is_capped(&self) -> bool {
        self.capped
    }
}

fn times((each, besides): (usize, usize), robots: usize) -> usize {
    each * robots + besides
}

/// Checks two robots, and adds them if they may have a level. The one with the lower id comes first, so that they always
/// come out the same.
fn check(settings: Settings, one: (&Strip, &Mover), other: (&Strip, &Mover), found: &mut Vec<Found>) {
    let ((strip_a, a), (strip_b, b)) = if one.1.robot < other.1.robot { (one, other) } else { (other, one) };
    let signs = Signs::of(settings, (&a.body, strip_a.pieces_of(a)), (&b.body, strip_b.pieces_of(b)));
    if signs.any() {
        found.push(Found {
            robots: [a.robot, b.robot],
            place: meeting_place(&a.body, &b.body),
            relative_speed: relative_speed(&a.body, &b.body),
            signs,
        });
    }
}
