//! Hot spots: places where robots touch, or stand and can't drive on, ranked by the time that they
//! have cost. All of the run is kept from the first frame on that was seen.

use std::collections::{BTreeMap, BTreeSet};

use regatta_plugin::contact::ContactRecord;
use regatta_plugin::frame::{Frame, NO_EDGE};
use regatta_plugin::history::{HotSpot, SPOT_EDGES, Trend};

mod cells;
mod losses;

use cells::{CELL, Cells, Key, Moment, RECENT, USUAL};

/// Cells are part of a spot up to this distance from its worst cell, in metres: a platoon of four
/// is one spot.
const REACH: f32 = 5.0;
/// The distance to the outermost cell of a spot, in cells.
const REACH_CELLS: i32 = (REACH / CELL) as i32 + 1;
/// The largest number of spots of a list.
const MAX_SPOTS: usize = 200;
/// All cells of a list of spots are among this number of the worst cells, as a spot has at most the
/// cells around its worst cell.
const MAX_LISTED_CELLS: usize = MAX_SPOTS * (2 * REACH_CELLS as usize + 1).pow(2);
/// A sample covers at most this many simulated seconds.
const LONGEST_GAP: f64 = 60.0;

/// Adds up lost time by place.
#[derive(Clone, Debug, Default)]
pub struct Spots {
    run: u64,
    /// The simulated time of the newest frame, in seconds, and the jumps before it.
    newest: Option<(f64, u64)>,
    began: f64,
    cells: Cells,
}

impl Spots {
    /// The run that is counted, and the simulated time of its first frame that is, in seconds.
    pub fn began(&self) -> (u64, f64) {
        (self.run, self.began)
    }

    /// Adds a frame and its pairs of touching robots. The frame covers the time since the previous
    /// frame, unless there is a jump between them. Another run, or a step back in time, resets the
    /// spots.
    pub fn add(&mut self, frame: &Frame<'_>, pairs: &[ContactRecord]) {
        let now = frame.sim_time().as_secs_f64();
        if self.run != frame.run_id() || self.newest.is_some_and(|(before, _)| now < before) {
            *self = Self { run: frame.run_id(), began: now, ..Self::default() };
        }
        let (before, jumps) = self.newest.replace((now, frame.jumps())).unwrap_or((now, 0));
        if now > before && jumps == frame.jumps() {
            let moment = Moment::new(before, now, (now - before).min(LONGEST_GAP));
            for loss in losses::losses(frame, &losses::touching(frame, pairs)) {
                self.cells.lose(&loss, &moment);
            }
        }
    }

    /// Returns the spots, the most costly first: the spot around the worst cell, then the spot
    /// around the worst remaining cell, and so on.
    pub fn list(&self) -> Vec<HotSpot> {
        let mut taken = BTreeSet::new();
        let mut spots = Vec::new();
        for worst in self.cells.worst(MAX_LISTED_CELLS) {
            if spots.len() == MAX_SPOTS {
                break;
            }
            let key = worst.cell.key;
            if !taken.contains(&key) {
                let cells = self.around(key, worst.middle(), &taken);
                spots.push(self.spot(&cells));
                taken.extend(cells);
            }
        }
        spots.sort_by(|a, b| b.lost_secs().total_cmp(&a.lost_secs()));
        spots
    }

    /// The cells within reach that belong to no other spot.
    fn around(&self, [x, y]: Key, middle: [f32; 2], taken: &BTreeSet<Key>) -> Vec<Key> {
        let reach = -REACH_CELLS..=REACH_CELLS;
        let near = reach.clone().flat_map(|dx| {
            reach.clone().map(move |dy| [x.saturating_add(dx), y.saturating_add(dy)])
        });
        let within = near.filter(|key| {
            let cell = self.cells.get(*key).filter(|_| !taken.contains(key));
            cell.is_some_and(|cell| distance(cell.middle(), middle) <= REACH)
        });
        within.collect()
    }

    fn spot(&self, cells: &[Key]) -> HotSpot {
        let (mut secs, mut places, mut seen) = ([0.0; 2], [0.0; 2], [f64::INFINITY, 0.0]);
        let (mut fading, mut edges) = ([0.0; 2], BTreeMap::<u32, f64>::new());
        let now = self.newest.unwrap_or_default().0;
        for found in cells.iter().filter_map(|key| self.cells.get(*key)) {
            add(&mut secs, found.secs());
            add(&mut places, found.cell.places);
            add(&mut fading, found.cell.fading_at(now));
            let [first, last] = found.seen();
            seen = [seen[0].min(first), seen[1].max(last)];
            for (edge, secs) in found.edges().into_iter().filter(|(edge, _)| *edge != NO_EDGE) {
                *edges.entry(edge).or_default() += secs;
            }
        }
        let mut edges: Vec<_> = edges.into_iter().collect();
        edges.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut worst = [NO_EDGE; SPOT_EDGES];
        for (place, (edge, _)) in worst.iter_mut().zip(edges) {
            *place = edge;
        }
        let [contact_secs, standing_secs] = secs;
        let [x, y] = places.map(|sum| (sum / (contact_secs + standing_secs).max(1e-9)) as f32);
        HotSpot {
            contact_secs,
            standing_secs,
            seen,
            x,
            y,
            edges: worst,
            trend: trend(fading, now - self.began) as u32,
            reserved: 0,
        }
    }
}

/// Compares the recent loss with the usual one, both as robots that lose time at a time. Little of
/// `watched` seconds is usual at first.
fn trend([recent, usual]: [f64; 2], watched: f64) -> Trend {
    match (rate(recent, RECENT, watched), rate(usual, USUAL, watched)) {
        (recent, _) if recent < 0.05 => Trend::Over,
        (recent, usual) if recent > 1.3 * usual => Trend::Growing,
        (recent, usual) if recent < 0.8 * usual => Trend::Easing,
        _ => Trend::Steady,
    }
}

/// Returns the robots that lose time at a time, given a loss that fades with a time constant.
fn rate(sum: f64, constant: f64, watched: f64) -> f64 {
    sum / (constant * (1.0 - (-watched / constant).exp())).max(1e-9)
}

fn add(sum: &mut [f64; 2], other: [f64; 2]) {
    for (part, other) in sum.iter_mut().zip(other) {
        *part += other;
    }
}

fn distance(one: [f32; 2], other: [f32; 2]) -> f32 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
mod tests;
