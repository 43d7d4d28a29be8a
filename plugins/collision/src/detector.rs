//! From frames to contacts.

use std::ops::ControlFlow;

use regatta_plugin::contact::{ContactEvent, ContactRecord};
use regatta_plugin::frame::Columns;
use regatta_plugin::world::{EdgeRecord, RobotTypeRecord};

use crate::checks::{check, check_all};
use crate::crowd::Crowd;
use crate::ledger::{Found, Ledger, Moment};
use crate::radix;
use crate::roads::Roads;
use crate::settings::Settings;
use crate::strips::Strips;
use crate::sweep::Limits;
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
    near: Vec<[u32; 2]>,
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
            near: Vec::new(),
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
        self.ledger.open(Moment { run_id: scene.run_id, tick: scene.tick, nanos: scene.sim_time_nanos });
        self.find_pairs(columns, types);
        let bits = radix::bits_below(robots);
        radix::sort(&mut self.found, &mut self.scratch, 0..bits, |found| found.robots[0].into());
        for same in self.found.chunk_by_mut(|a, b| a.robots[0] == b.robots[0]) {
            same.sort_unstable_by_key(|found| found.robots[1]);
        }
        self.ledger.close(&self.found, times(PAIRS, robots), columns.edge);
        self.mark(robots);
    }

    fn find_pairs(&mut self, columns: Columns, types: &[f32]) {
        let Self { settings, roads, strips, near, found, ledger, .. } = self;
        let crowd = Crowd { columns, types, roads, settings: *settings };
        let robots = columns.x.len();
        self.unplaced = strips.take(&crowd);
        let mut find = |limits: Limits, most: usize, found: &mut Vec<Found>| {
            strips.sweep(&crowd, limits, |strip, candidates| {
                check_all(&crowd, strip, candidates, near, found);
                if found.len() > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        };
        let (looks, checks) = (times(LOOKS, robots), times(CHECKS, robots));
        let all = Limits { looks_each: usize::MAX, checks_each: usize::MAX, looks, checks };
        found.clear();
        self.capped = find(all, times(PAIRS, robots), found).is_break();
        if self.capped {
            ledger.cap();
            found.clear();
            let (looks_each, checks_each) = SOME;
            // Without limits in all, it doesn't break off.
            let _ = find(Limits { looks_each, checks_each, looks: usize::MAX, checks: usize::MAX }, usize::MAX, found);
            find_known(strips, ledger.contacts(), &crowd, found);
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

/// Adds the pairs that had a level before and still have one.
fn find_known(strips: &Strips, known: &[ContactRecord], crowd: &Crowd, found: &mut Vec<Found>) {
    let places = strips.places();
    let place = |robot: u32| {
        let (strip, place) = (*places.get(robot as usize)?)?;
        Some((strips.strip(strip), place))
    };
    for contact in known {
        if let [Some(one), Some(other)] = contact.robots.map(place) {
            check(crowd, one, other, found);
        }
    }
}
