//! From frames to contacts.

use std::ops::ControlFlow;

use regatta_plugin::contact::{ContactEvent, ContactRecord};
use regatta_plugin::frame::Columns;
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::crowd::{Crowd, Roads};
use crate::ledger::{Found, Ledger, Moment};
use crate::pair::Signs;
use crate::radix;
use crate::settings::Settings;
use crate::strips::{Limits, Strips};

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
    crowd: Crowd,
    strips: Strips,
    found: Vec<u64>,
    scratch: Vec<u64>,
    ledger: Ledger,
    levels: Vec<f32>,
    capped: bool,
}

impl Detector {
    /// A detector of an empty world.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            roads: Roads::new(&[], &[]),
            crowd: Crowd::default(),
            strips: Strips::default(),
            found: Vec::new(),
            scratch: Vec::new(),
            ledger: Ledger::default(),
            levels: Vec::new(),
            capped: false,
        }
    }

    /// Takes another world. Without robot types, every robot is a rectangle of 0.9 m × 0.6 m.
    pub fn set_world(&mut self, edges: &[EdgeRecord], types: &[RobotTypeRecord]) {
        self.roads = Roads::new(edges, types);
    }

    /// Looks at a frame.
    pub fn look(&mut self, scene: &Scene) {
        let robots = scene.columns.x.len();
        self.crowd.take(scene.columns, scene.types, &self.roads, self.settings);
        self.strips.sort(self.crowd.boxes());
        self.ledger.open(Moment { run_id: scene.run_id, tick: scene.tick, nanos: scene.sim_time_nanos });
        let bits = radix::bits_below(robots.max(self.ledger.robots()));
        let most = times(PAIRS, robots);
        let all = Limits {
            looks_each: usize::MAX,
            checks_each: usize::MAX,
            looks: times(LOOKS, robots),
            checks: times(CHECKS, robots),
        };
        self.found.clear();
        self.capped = self.find(all, most, bits).is_break();
        if self.capped {
            self.find_some(bits);
        }
        radix::sort(&mut self.found, &mut self.scratch, Signs::BITS..Signs::BITS + 2 * bits);
        let mask = (1 << bits) - 1;
        let found = self.found.iter().map(|found| {
            let pair = found >> Signs::BITS;
            Found { robots: [(pair >> bits & mask) as u32, (pair & mask) as u32], signs: Signs::from_bits(*found) }
        });
        self.ledger.close(found, most, &self.crowd, scene.columns.edge);
        self.mark(robots);
    }

    /// Adds every two robots that have a level, until that is too much.
    fn find(&mut self, limits: Limits, most: usize, bits: u32) -> ControlFlow<()> {
        let Self { crowd, strips, found, settings, .. } = self;
        strips.sweep(limits, |one, other| {
            let (first, second) = if one < other { (one, other) } else { (other, one) };
            let signs = Signs::of(crowd, *settings, first, second);
            if signs.any() {
                found.push(packed(first, second, signs, bits));
            }
            if found.len() > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    }

    /// Adds the pairs that had a level before, and for each robot some of its neighbours. Some come twice.
    fn find_some(&mut self, bits: u32) {
        let Self { crowd, ledger, found, settings, .. } = self;
        found.clear();
        for &ContactRecord { robots: [first, second], .. } in ledger.contacts() {
            let are_there = [first, second].iter().all(|&robot| crowd.body_of(robot).is_there());
            let signs = if are_there { Signs::of(crowd, *settings, first, second) } else { Signs::default() };
            if signs.any() {
                found.push(packed(first, second, signs, bits));
            }
        }
        let (looks_each, checks_each) = SOME;
        let some = Limits { looks_each, checks_each, looks: usize::MAX, checks: usize::MAX };
        // Without limits in all, it doesn't end early.
        let _ = self.find(some, usize::MAX, bits);
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

    /// What the last frame changed.
    ///
    /// A pair that is [touching](regatta_plugin::contact::ContactLevel::Touching) is also possible: so each `began` of a level has one `ended`,
    /// and a pair's touching lies within its being possible.
    pub fn events(&self) -> &[ContactEvent] {
        self.ledger.events()
    }

    /// Whether there were more pairs than the detector looks at.
    ///
    /// Then it has looked at all pairs that had a level before, and for each robot at some of its neighbours: every
    /// pair that it tells is one, but there may be others.
    pub fn is_capped(&self) -> bool {
        self.capped
    }

    /// Each robot's level: 0 if it is clear, else the highest [level](regatta_plugin::contact::ContactLevel) of its pairs.
    pub fn levels(&self) -> &[f32] {
        &self.levels
    }
}

fn times((each, besides): (usize, usize), robots: usize) -> usize {
    each * robots + besides
}

/// A pair and its signs in one number that sorts by pair.
fn packed(first: u32, second: u32, signs: Signs, bits: u32) -> u64 {
    (u64::from(first) << bits | u64::from(second)) << Signs::BITS | signs.to_bits()
}
