//! Lost time by place.

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

/// The losses of a cell.
#[derive(Clone, Debug)]
pub struct Cell {
    pub key: Key,
    /// Of contacts, and of standing robots.
    pub secs: [f64; 2],
    /// Places, weighted by seconds.
    pub places: [f64; 2],
    /// The simulated times of the first and of the last loss.
    pub seen: [f64; 2],
    /// Losses that fade with the time constants [`RECENT`] and [`USUAL`], as of `seen[1]`.
    pub fading: [f64; 2],
    /// The edges on which it was lost, and how many seconds; [`NO_EDGE`] where there are fewer.
    pub edges: [(u32, f64); SPOT_EDGES],
}

impl Cell {
    fn new(key: Key, now: f64) -> Self {
        let edges = [(NO_EDGE, 0.0); SPOT_EDGES];
        Self { key, secs: [0.0; 2], places: [0.0; 2], seen: [now; 2], fading: [0.0; 2], edges }
    }

    pub fn lost(&self) -> f64 {
        self.secs[0] + self.secs[1]
    }

    pub fn middle(&self) -> [f32; 2] {
        self.places.map(|sum| (sum / self.lost().max(1e-9)) as f32)
    }

    pub fn fading_at(&self, now: f64) -> [f64; 2] {
        let [recent, usual] = fade(now - self.seen[1]);
        [self.fading[0] * recent, self.fading[1] * usual]
    }

    fn add(&mut self, loss: &Loss, moment: &Moment) {
        let Moment { now, before, secs, fade } = *moment;
        // Only the first loss of a frame fades the earlier ones.
        if self.seen[1] < now {
            self.fading = match self.seen[1] == before {
                true => [self.fading[0] * fade[0], self.fading[1] * fade[1]],
                false => self.fading_at(now),
            };
            self.seen[1] = now;
        }
        for sum in &mut self.fading {
            *sum += secs;
        }
        self.secs[usize::from(!loss.is_contact)] += secs;
        for (sum, part) in self.places.iter_mut().zip(loss.place) {
            *sum += f64::from(part) * secs;
        }
        let slot = self.edges.iter_mut().find(|(edge, _)| *edge == loss.edge || *edge == NO_EDGE);
        if let Some(slot) = slot.filter(|_| loss.edge != NO_EDGE) {
            *slot = (loss.edge, slot.1 + secs);
        }
    }
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
        let key = loss.place.map(|part| (part / CELL).floor() as i32);
        let robot = loss.robot as usize;
        let before = self.last.get(robot).map_or(u32::MAX, |number| *number);
        let number = match self.cells.get(before as usize) {
            Some(cell) if cell.key == key => before,
            _ => {
                let Some(number) = self.number(key, moment.now) else { return };
                if robot >= self.last.len() {
                    self.last.resize(robot + 1, u32::MAX);
                }
                self.last[robot] = number;
                number
            }
        };
        self.cells[number as usize].add(loss, moment);
    }

    /// The number of a cell, which is made if there is none and there is room.
    fn number(&mut self, key: Key, now: f64) -> Option<u32> {
        if let Some(number) = self.numbers.get(&key) {
            return Some(*number);
        }
        if self.cells.len() == MAX_CELLS {
            return None;
        }
        let number = self.cells.len() as u32;
        self.cells.push(Cell::new(key, now));
        self.numbers.insert(key, number);
        Some(number)
    }

    pub fn get(&self, key: Key) -> Option<&Cell> {
        self.numbers.get(&key).map(|number| &self.cells[*number as usize])
    }

    /// The cells with the most lost time, so many at most, the worst first; of equal ones, by
    /// place.
    pub fn worst(&self, most: usize) -> Vec<(Key, &Cell)> {
        let mut all: Vec<_> = self.cells.iter().map(|cell| (cell.lost(), cell)).collect();
        // To sort all of them would take longer than all the rest.
        if all.len() > most {
            all.select_nth_unstable_by(most, worst_first);
            all.truncate(most);
        }
        all.sort_unstable_by(worst_first);
        all.into_iter().map(|(_, cell)| (cell.key, cell)).collect()
    }
}

/// Compares two cells by their lost time, and equal ones by place.
fn worst_first((a_lost, a): &(f64, &Cell), (b_lost, b): &(f64, &Cell)) -> std::cmp::Ordering {
    b_lost.total_cmp(a_lost).then_with(|| a.key.cmp(&b.key))
}
