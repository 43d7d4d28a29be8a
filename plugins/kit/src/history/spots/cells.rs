//! Lost time by place.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::losses::Loss;
use regatta_plugin::frame::NO_EDGE;
use regatta_plugin::history::SPOT_EDGES;

/// Width and height of the cells in which lost time is added up, in metres.
pub const CELL: f32 = 2.0;
/// The largest number of cells; beyond it, time that is lost elsewhere is not counted.
const MAX_CELLS: usize = 200_000;
/// The time constants of the recent and of the usual loss, in simulated seconds.
pub const RECENT: f64 = 60.0;
pub const USUAL: f64 = 300.0;

/// A cell by its column and row.
pub type Key = [i32; 2];

/// The losses of a cell: all that a frame changes where robots stand on one edge, in one cache
/// line.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Cell {
    pub key: Key,
    /// Seconds of standing robots.
    pub standing_secs: f64,
    /// Places, weighted by seconds.
    pub places: [f64; 2],
    /// Losses that fade with the time constants [`RECENT`] and [`USUAL`], as of `last_seen`.
    pub fading: [f64; 2],
    /// The simulated time of the last loss.
    pub last_seen: f64,
    causes: Causes,
}

/// The kinds and edges of a cell's losses.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Causes {
    /// Robots that stood on one edge: all seconds are theirs.
    StandingOn(u32),
    /// [`Details`] has them.
    Several,
}

/// The part of a cell's losses that few frames change.
#[derive(Clone, Debug)]
pub struct Details {
    /// The simulated time of the first loss.
    pub first_seen: f64,
    /// Seconds of contacts.
    pub contact_secs: f64,
    /// The edges on which time was lost, and how many seconds; [`NO_EDGE`] where there are fewer.
    pub edges: [(u32, f64); SPOT_EDGES],
}

impl Cell {
    fn new(key: Key, loss: &Loss, now: f64) -> Self {
        let causes = match loss.edge {
            edge if loss.is_contact || edge == NO_EDGE => Causes::Several,
            edge => Causes::StandingOn(edge),
        };
        Self { key, standing_secs: 0.0, places: [0.0; 2], fading: [0.0; 2], last_seen: now, causes }
    }

    pub fn fading_at(&self, now: f64) -> [f64; 2] {
        let [recent, usual] = fade(now - self.last_seen);
        [self.fading[0] * recent, self.fading[1] * usual]
    }

    fn add(&mut self, loss: &Loss, moment: &Moment) {
        let Moment { now, before, secs, fade } = *moment;
        // Only the first loss of a frame fades the earlier ones.
        if self.last_seen < now {
            self.fading = match self.last_seen == before {
                true => [self.fading[0] * fade[0], self.fading[1] * fade[1]],
                false => self.fading_at(now),
            };
            self.last_seen = now;
        }
        for sum in &mut self.fading {
            *sum += secs;
        }
        if !loss.is_contact {
            self.standing_secs += secs;
        }
        for (sum, part) in self.places.iter_mut().zip(loss.place) {
            *sum += f64::from(part) * secs;
        }
    }
}

impl Details {
    fn new(now: f64) -> Self {
        Self { first_seen: now, contact_secs: 0.0, edges: [(NO_EDGE, 0.0); SPOT_EDGES] }
    }

    fn add(&mut self, loss: &Loss, secs: f64) {
        if loss.is_contact {
            self.contact_secs += secs;
        }
        let slot = self.edges.iter_mut().find(|(edge, _)| *edge == loss.edge || *edge == NO_EDGE);
        if let Some(slot) = slot.filter(|_| loss.edge != NO_EDGE) {
            *slot = (loss.edge, slot.1 + secs);
        }
    }
}

/// Rounds a finite number down. Unlike `f32::floor`, it calls no library on any target.
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    if whole as f32 > value { whole.saturating_sub(1) } else { whole }
}

/// The parts of the recent and of the usual loss that are left after some seconds.
fn fade(age: f64) -> [f64; 2] {
    [RECENT, USUAL].map(|constant| (-age.max(0.0) / constant).exp())
}

/// The time of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    now: f64,
    before: f64,
    secs: f64,
    /// The rest of a loss in the frame before. Most cells that lose time in a frame did so in
    /// that one.
    fade: [f64; 2],
}

impl Moment {
    /// A frame at `now` that covers some seconds, after a frame at `before`; all in simulated
    /// seconds.
    pub fn new(before: f64, now: f64, secs: f64) -> Self {
        Self { now, before, secs, fade: fade(now - before) }
    }
}

/// The cells where time was lost.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    cells: Vec<Cell>,
    /// In the order of `cells`.
    details: Vec<Details>,
    /// The place of each cell in `cells`.
    numbers: BTreeMap<Key, u32>,
    /// By robot: the cell where it lost time last. A robot that stands stays in its cell, so that
    /// it needs no search.
    last: Vec<u32>,
}

impl Cells {
    /// Adds the time that a robot loses in a frame.
    pub fn lose(&mut self, loss: &Loss, moment: &Moment) {
        if !loss.place.iter().all(|part| part.is_finite()) {
            return;
        }
        let key = loss.place.map(|part| floor(part / CELL));
        let robot = loss.robot as usize;
        let before = self.last.get(robot).map_or(u32::MAX, |number| *number);
        let number = match self.cells.get(before as usize) {
            Some(cell) if cell.key == key => before,
            _ => {
                let Some(number) = self.number(key, loss, moment.now) else { return };
                if robot >= self.last.len() {
                    self.last.resize(robot + 1, u32::MAX);
                }
                self.last[robot] = number;
                number
            }
        };
        self.add(number as usize, loss, moment);
    }

    fn add(&mut self, number: usize, loss: &Loss, moment: &Moment) {
        let cell = &mut self.cells[number];
        let is_alike = !loss.is_contact && cell.causes == Causes::StandingOn(loss.edge);
        if !is_alike {
            if let Causes::StandingOn(edge) = cell.causes {
                self.details[number].edges[0] = (edge, cell.standing_secs);
                cell.causes = Causes::Several;
            }
            self.details[number].add(loss, moment.secs);
        }
        cell.add(loss, moment);
    }

    /// The number of a cell, which is made for a loss if there is none and there is room.
    fn number(&mut self, key: Key, loss: &Loss, now: f64) -> Option<u32> {
        if let Some(number) = self.numbers.get(&key) {
            return Some(*number);
        }
        if self.cells.len() == MAX_CELLS {
            return None;
        }
        let number = self.cells.len() as u32;
        self.cells.push(Cell::new(key, loss, now));
        self.details.push(Details::new(now));
        self.numbers.insert(key, number);
        Some(number)
    }

    pub fn get(&self, key: Key) -> Option<Found<'_>> {
        self.numbers.get(&key).map(|number| self.found(*number as usize))
    }

    fn found(&self, number: usize) -> Found<'_> {
        Found { cell: &self.cells[number], details: &self.details[number] }
    }

    /// The cells with the most lost time, so many at most, the worst first; of equal ones, by
    /// place.
    pub fn worst(&self, most: usize) -> Vec<Found<'_>> {
        let ranked = (0..self.cells.len()).map(|number| {
            let found = self.found(number);
            Ranked { lost: found.lost(), key: found.cell.key, number: number as u32 }
        });
        let mut all: Vec<_> = ranked.collect();
        // To sort all of them would take longer than all the rest.
        if all.len() > most {
            all.select_nth_unstable_by(most, Ranked::worst_first);
            all.truncate(most);
        }
        all.sort_unstable_by(Ranked::worst_first);
        all.into_iter().map(|cell| self.found(cell.number as usize)).collect()
    }
}

/// A cell in a list, with all that it is sorted by.
struct Ranked {
    lost: f64,
    key: Key,
    number: u32,
}

impl Ranked {
    /// Compares two cells by their lost time, and equal ones by place.
    fn worst_first(&self, other: &Self) -> Ordering {
        other.lost.total_cmp(&self.lost).then_with(|| self.key.cmp(&other.key))
    }
}

/// A cell with its details.
#[derive(Clone, Copy)]
pub struct Found<'a> {
    pub cell: &'a Cell,
    details: &'a Details,
}

impl Found<'_> {
    /// Seconds of contacts, and of standing robots.
    pub fn secs(&self) -> [f64; 2] {
        let contact_secs = match self.cell.causes {
            Causes::StandingOn(_) => 0.0,
            Causes::Several => self.details.contact_secs,
        };
        [contact_secs, self.cell.standing_secs]
    }

    pub fn lost(&self) -> f64 {
        let [contact_secs, standing_secs] = self.secs();
        contact_secs + standing_secs
    }

    pub fn middle(&self) -> [f32; 2] {
        self.cell.places.map(|sum| (sum / self.lost().max(1e-9)) as f32)
    }

    /// The simulated times of the first and of the last loss.
    pub fn seen(&self) -> [f64; 2] {
        [self.details.first_seen, self.cell.last_seen]
    }

    /// The edges on which time was lost, and how many seconds; [`NO_EDGE`] where there are fewer.
    pub fn edges(&self) -> [(u32, f64); SPOT_EDGES] {
        let mut edges = self.details.edges;
        if let Causes::StandingOn(edge) = self.cell.causes {
            edges[0] = (edge, self.cell.standing_secs);
        }
        edges
    }
}
