//! Hot spots: places where robots touch, or stand and can't drive on, ranked by the time that they have cost. All of the run is
//! kept from the first frame on that was seen.

use std::collections::{BTreeMap, BTreeSet};

use crate::records::contact::{ContactLevel, ContactRecord};
use crate::records::frame::{Frame, NO_EDGE, RobotState};
use crate::records::history::{HotSpot, SPOT_EDGES, Trend};

/// Width and height of the cells in which lost time is added up, in metres.
const CELL: f32 = 2.0;
/// Cells are part of a spot up to this distance from its worst cell, in metres: a platoon of four is one spot.
const REACH: f32 = 5.0;
/// The speed below which a robot stands, in metres per second.
const STANDING: f32 = 0.05;
/// The most cells; time that is lost elsewhere is counted by no spot then.
const MAX_CELLS: usize = 200_000;
/// The most spots of a list.
const MAX_SPOTS: usize = 200;
/// A sample stands for at most so many simulated seconds.
const LONGEST_GAP: f64 = 60.0;
/// The time constants of the recent and of the usual loss, in simulated seconds.
const RECENT: f64 = 60.0;
const USUAL: f64 = 300.0;

/// A robot that loses time in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Loss {
    place: [f32; 2],
    edge: u32,
    is_contact: bool,
}

/// Returns the robots that touch others, each where its footprint overlaps another one, and those that stand and can't drive
/// on. No robot is counted twice.
fn losses(frame: &Frame<'_>, pairs: &[ContactRecord]) -> Vec<Loss> {
    let mut touching = BTreeSet::new();
    let mut all = Vec::new();
    for pair in pairs.iter().filter(|pair| pair.level == ContactLevel::Touching as u32) {
        for robot in pair.robots.into_iter().filter(|robot| touching.insert(*robot)) {
            let edge = frame.edge().get(robot as usize).copied().unwrap_or(NO_EDGE);
            all.push(Loss { place: [pair.x, pair.y], edge, is_contact: true });
        }
    }
    let rows = frame.state().iter().zip(frame.speed()).enumerate();
    let standing = rows.filter(|(_, (state, speed))| stops(**state) && speed.abs() < STANDING);
    for (robot, _) in standing.filter(|(robot, _)| !touching.contains(&(*robot as u32))) {
        let place = [frame.x()[robot], frame.y()[robot]];
        all.push(Loss { place, edge: frame.edge()[robot], is_contact: false });
    }
    all
}

/// Whether a robot in a state wants to drive on but can't.
fn stops(state: u8) -> bool {
    let states = [RobotState::Waiting, RobotState::Faulted, RobotState::Stalled, RobotState::Broken];
    states.iter().any(|stop| *stop as u8 == state)
}

/// What was lost in a cell.
#[derive(Clone, Debug, Default)]
struct Cell {
    /// Of contacts, and of standing robots.
    secs: [f64; 2],
    /// Places, weighted by seconds.
    places: [f64; 2],
    seen: [f64; 2],
    /// Losses that fade with the time constants [`RECENT`] and [`USUAL`], as of `seen[1]`.
    fading: [f64; 2],
    edges: Vec<(u32, f64)>,
}

impl Cell {
    fn lost(&self) -> f64 {
        self.secs[0] + self.secs[1]
    }

    fn add(&mut self, loss: &Loss, now: f64, secs: f64) {
        if self.lost() == 0.0 {
            self.seen = [now; 2];
        }
        self.fading = self.fading_at(now).map(|sum| sum + secs);
        self.seen[1] = now;
        self.secs[usize::from(!loss.is_contact)] += secs;
        add(&mut self.places, loss.place.map(|part| f64::from(part) * secs));
        let has_room = self.edges.len() < SPOT_EDGES && loss.edge != NO_EDGE;
        match self.edges.iter_mut().find(|(edge, _)| *edge == loss.edge) {
            Some((_, sum)) => *sum += secs,
            None if has_room => self.edges.push((loss.edge, secs)),
            None => {}
        }
    }

    fn fading_at(&self, now: f64) -> [f64; 2] {
        let age = (now - self.seen[1]).max(0.0);
        [self.fading[0] * (-age / RECENT).exp(), self.fading[1] * (-age / USUAL).exp()]
    }

    fn middle(&self) -> [f32; 2] {
        self.places.map(|sum| (sum / self.lost().max(1e-9)) as f32)
    }
}

/// Adds up lost time by place.
#[derive(Clone, Debug, Default)]
pub struct Spots {
    run: u64,
    now: Option<f64>,
    began: f64,
    cells: BTreeMap<[i32; 2], Cell>,
}

impl Spots {
    /// The run that is counted, and the simulated time of its first frame that is, in seconds.
    pub fn began(&self) -> (u64, f64) {
        (self.run, self.began)
    }

    /// Adds a frame and the pairs of robots that touch in it. It stands for the time since the one before. Another run, or a
    /// time that goes back, begins anew.
    pub fn add(&mut self, frame: &Frame<'_>, pairs: &[ContactRecord]) {
        let now = frame.sim_time().as_secs_f64();
        if self.run != frame.run_id() || self.now.is_some_and(|before| now < before) {
            *self = Self { run: frame.run_id(), began: now, ..Self::default() };
        }
        let secs = self.now.map_or(0.0, |before| (now - before).min(LONGEST_GAP));
        self.now = Some(now);
        if secs > 0.0 {
            losses(frame, pairs).iter().for_each(|loss| self.lose(loss, now, secs));
        }
    }

    fn lose(&mut self, loss: &Loss, now: f64, secs: f64) {
        if !loss.place.iter().all(|part| part.is_finite()) {
            return;
        }
        let key = loss.place.map(|part| (part / CELL).floor() as i32);
        if self.cells.len() < MAX_CELLS || self.cells.contains_key(&key) {
            self.cells.entry(key).or_default().add(loss, now, secs);
        }
    }

    /// Returns the spots, the one that has cost the most time first: around the worst cell, then around the worst one of the
    /// rest, and so on.
    pub fn list(&self) -> Vec<HotSpot> {
        let mut order: Vec<_> = self.cells.iter().collect();
        order.sort_by(|(_, a), (_, b)| b.lost().total_cmp(&a.lost()));
        let mut taken = BTreeSet::new();
        let mut spots = Vec::new();
        for (key, worst) in order {
            if spots.len() == MAX_SPOTS {
                break;
            }
            if !taken.contains(key) {
                let cells = self.around(*key, worst.middle(), &taken);
                spots.push(self.spot(&cells));
                taken.extend(cells);
            }
        }
        spots.sort_by(|a, b| b.lost_secs().total_cmp(&a.lost_secs()));
        spots
    }

    /// The cells within reach that belong to no other spot.
    fn around(&self, [x, y]: [i32; 2], middle: [f32; 2], taken: &BTreeSet<[i32; 2]>) -> Vec<[i32; 2]> {
        let reach = (REACH / CELL).ceil() as i32;
        let near = (-reach..=reach)
            .flat_map(|dx| (-reach..=reach).map(move |dy| [x.saturating_add(dx), y.saturating_add(dy)]));
        let within = |key: &[i32; 2]| {
            self.cells.get(key).is_some_and(|cell| distance(cell.middle(), middle) <= REACH) && !taken.contains(key)
        };
        near.filter(within).collect()
    }

    fn spot(&self, cells: &[[i32; 2]]) -> HotSpot {
        let mut all = Cell { seen: [f64::INFINITY, 0.0], ..Cell::default() };
        let (mut fading, mut edges) = ([0.0; 2], BTreeMap::<u32, f64>::new());
        let now = self.now.unwrap_or_default();
        for cell in cells.iter().filter_map(|key| self.cells.get(key)) {
            all.secs = [all.secs[0] + cell.secs[0], all.secs[1] + cell.secs[1]];
            add(&mut all.places, cell.places);
            all.seen = [all.seen[0].min(cell.seen[0]), all.seen[1].max(cell.seen[1])];
            let [recent, usual] = cell.fading_at(now);
            fading = [fading[0] + recent, fading[1] + usual];
            cell.edges.iter().for_each(|(edge, secs)| *edges.entry(*edge).or_default() += secs);
        }
        let mut edges: Vec<_> = edges.into_iter().collect();
        edges.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut worst = [NO_EDGE; SPOT_EDGES];
        worst.iter_mut().zip(edges).for_each(|(place, (edge, _))| *place = edge);
        let [x, y] = all.middle();
        HotSpot {
            contact_secs: all.secs[0],
            standing_secs: all.secs[1],
            seen: all.seen,
            x,
            y,
            edges: worst,
            trend: trend(fading, now - self.began) as u32,
            reserved: 0,
        }
    }
}

/// Compares the recent loss with the usual one, both as robots that lose time at a time. Little of `watched` seconds is usual
/// at first.
fn trend([recent, usual]: [f64; 2], watched: f64) -> Trend {
    let rate = |sum: f64, span: f64| sum / (span * (1.0 - (-watched / span).exp())).max(1e-9);
    match (rate(recent, RECENT), rate(usual, USUAL)) {
        (recent, _) if recent < 0.05 => Trend::Over,
        (recent, usual) if recent > 1.3 * usual => Trend::Growing,
        (recent, usual) if recent < 0.8 * usual => Trend::Easing,
        _ => Trend::Steady,
    }
}

fn add(sum: &mut [f64; 2], other: [f64; 2]) {
    sum.iter_mut().zip(other).for_each(|(part, other)| *part += other);
}

fn distance(one: [f32; 2], other: [f32; 2]) -> f32 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
mod tests;
