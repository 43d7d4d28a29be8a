//! The tally of a frame: how many robots are where, and what they do there.

use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

use crate::routes::EdgeRoutes;

/// The counts of an edge: in a frame, or added up over robots and seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// The counts of every fleet.
    pub driving: Driving,
    /// The counts of some fleets.
    pub extra: Extra,
}

/// The counts of robots on an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))] // An edge lies within one cache line.
pub struct Driving {
    /// Robots on the edge; robot seconds.
    pub robots: f32,
    /// Robots that have entered it.
    pub entered: f32,
    /// Their speeds, in metres per second; metres driven.
    pub metres: f32,
    /// Robots that wait there to drive on; seconds.
    pub waiting: f32,
}

/// The counts that need a collision checker, or routes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extra {
    /// Robots on the edge that touch others; seconds.
    pub touching: f32,
    /// Robots whose released route leads over it; robot seconds.
    pub released: f32,
    /// Other robots whose planned route leads over it; robot seconds.
    pub planned: f32,
}

/// Counts that are added up over time.
pub(crate) trait Sum: Copy + Default {
    /// Adds the counts of a frame that lasted for some seconds; with 1, counts that are added up.
    fn add(&mut self, frame: &Self, secs: f32);
}

impl Sum for Driving {
    fn add(&mut self, frame: &Self, secs: f32) {
        self.robots += frame.robots * secs;
        self.entered += frame.entered;
        self.metres += frame.metres * secs;
        self.waiting += frame.waiting * secs;
    }
}

impl Sum for Extra {
    fn add(&mut self, frame: &Self, secs: f32) {
        self.touching += frame.touching * secs;
        self.released += frame.released * secs;
        self.planned += frame.planned * secs;
    }
}

/// Edges are counted in blocks of this many. Only blocks in use cost time: most blocks of a large
/// layout have no robot.
pub(crate) const BLOCK: usize = 16;

/// Counts of edges, in blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks<T> {
    /// By edge.
    counts: Vec<T>,
    /// By block: whether its counts may differ from zero.
    in_use: Vec<bool>,
}

impl<T: Sum> Blocks<T> {
    fn new(edges: usize) -> Self {
        Self { counts: vec![T::default(); edges], in_use: vec![false; edges.div_ceil(BLOCK)] }
    }

    fn clear(&mut self) {
        for (counts, in_use) in self.counts.chunks_mut(BLOCK).zip(&mut self.in_use) {
            if std::mem::take(in_use) {
                counts.fill(T::default());
            }
        }
    }

    /// Returns the counts of an edge to add to; `None` if there is no such edge.
    pub(crate) fn get_mut(&mut self, edge: usize) -> Option<&mut T> {
        let counts = self.counts.get_mut(edge)?;
        self.in_use[edge / BLOCK] = true;
        Some(counts)
    }

    fn add(&mut self, frame: &Self, secs: f32) {
        for (block, counts) in frame.in_use() {
            self.in_use[block] = true;
            for (sum, counts) in self.counts[block * BLOCK..].iter_mut().zip(counts) {
                sum.add(counts, secs);
            }
        }
    }

    /// Returns the blocks in use with their numbers.
    pub(crate) fn in_use(&self) -> impl Iterator<Item = (usize, &[T])> {
        let blocks = self.counts.chunks(BLOCK).zip(&self.in_use).enumerate();
        blocks.filter(|(_, (_, in_use))| **in_use).map(|(block, (counts, _))| (block, counts))
    }

    /// Returns the counts of a block, if it is in use.
    pub(crate) fn block(&self, block: usize) -> Option<&[T]> {
        let counts = self.counts.get(block * BLOCK..)?;
        self.in_use[block].then(|| &counts[..counts.len().min(BLOCK)])
    }
}

/// The counts of all edges.
#[derive(Clone, Debug, Default)]
pub struct EdgeCounts {
    pub(crate) driving: Blocks<Driving>,
    pub(crate) extra: Blocks<Extra>,
}

impl EdgeCounts {
    /// Returns counts of zero for a number of edges.
    pub fn new(edges: usize) -> Self {
        Self { driving: Blocks::new(edges), extra: Blocks::new(edges) }
    }

    /// Sets all counts to zero.
    pub fn clear(&mut self) {
        self.driving.clear();
        self.extra.clear();
    }

    /// Returns the counts of an edge; zero if there is no such edge.
    pub fn get(&self, edge: usize) -> Counts {
        let driving = self.driving.counts.get(edge).copied().unwrap_or_default();
        let extra = self.extra.counts.get(edge).copied().unwrap_or_default();
        Counts { driving, extra }
    }

    /// Whether the counts of a block of edges may differ from zero.
    pub(crate) fn is_in_use(&self, block: usize) -> bool {
        self.driving.in_use[block] || self.extra.in_use[block]
    }

    /// Adds the counts of a frame that lasted for some seconds; with 1, counts that are added up.
    pub fn add(&mut self, frame: &Self, secs: f32) {
        self.driving.add(&frame.driving, secs);
        self.extra.add(&frame.extra, secs);
    }
}

/// Counts robots frame by frame.
#[derive(Debug, Default)]
pub struct Tally {
    counts: EdgeCounts,
    /// By robot: the edge it was on in the frame before; [`NO_EDGE`] if it is unknown.
    edges: Vec<u32>,
}

impl Tally {
    /// Begins a run on a number of edges.
    pub fn begin(&mut self, edges: usize) {
        self.counts = EdgeCounts::new(edges);
        self.edges.clear();
    }

    /// Forgets where robots were: none enters an edge in the next frame.
    pub fn forget_places(&mut self) {
        self.edges.fill(NO_EDGE);
    }

    /// Adds the robots whose routes lead over each edge to the counts of a frame.
    pub fn count_routes(&mut self, routes: &[EdgeRoutes]) -> &EdgeCounts {
        for (edge, routes) in routes.iter().enumerate() {
            if *routes != EdgeRoutes::default()
                && let Some(counts) = self.counts.extra.get_mut(edge)
            {
                (counts.released, counts.planned) = (routes.released as f32, routes.planned as f32);
            }
        }
        &self.counts
    }

    /// Counts the robots of a frame. `contacts` has a [`ContactLevel`] for each robot, or is empty
    /// without a collision checker. Robots on edges that the world doesn't have are left out.
    pub fn count(&mut self, columns: &Columns<'_>, contacts: &[f32]) -> &EdgeCounts {
        self.counts.clear();
        self.edges.resize(columns.edge.len(), NO_EDGE);
        let rows = columns.edge.iter().zip(columns.speed).zip(columns.state);
        for (((&edge, &speed), &state), before) in rows.zip(&mut self.edges) {
            // An absent robot is on no edge.
            let edge = if state == RobotState::Absent as u8 { NO_EDGE } else { edge };
            let mut entered = false;
            // Most robots stay on their edge. To write it anew would take longer.
            if edge != *before {
                entered = *before != NO_EDGE;
                *before = edge;
            }
            if let Some(counts) = self.counts.driving.get_mut(edge as usize) {
                counts.robots += 1.0;
                counts.entered += f32::from(u8::from(entered));
                counts.metres += speed.abs();
                counts.waiting += f32::from(u8::from(state == RobotState::Waiting as u8));
            }
        }
        for (&edge, &level) in self.edges.iter().zip(contacts) {
            if level == ContactLevel::Touching as u32 as f32
                && let Some(counts) = self.counts.extra.get_mut(edge as usize)
            {
                counts.touching += 1.0;
            }
        }
        &self.counts
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};

    use super::*;

    /// Robots by edge, speed and state, as columns of a frame.
    fn count(
        tally: &mut Tally,
        robots: &[(u32, f32, RobotState)],
        contacts: &[f32],
    ) -> Vec<Counts> {
        let mut lines = vec![Line::default(); frame_lines(robots.len())];
        let columns = ColumnsMut::split(&mut lines, robots.len());
        for (row, (edge, speed, state)) in robots.iter().enumerate() {
            (columns.edge[row], columns.speed[row], columns.state[row]) =
                (*edge, *speed, *state as u8);
        }
        let columns = Columns::split(&lines, robots.len()).expect("lines");
        let counts = tally.count(&columns, contacts);
        (0..3).map(|edge| counts.get(edge)).collect()
    }

    #[test]
    fn robots_count_where_they_are() {
        let mut tally = Tally::default();
        tally.begin(3);
        let (driving, waiting, absent) =
            (RobotState::Driving, RobotState::Waiting, RobotState::Absent);
        let robots = [
            (0, 2.0, driving),
            (0, -1.0, driving),
            (1, 0.0, waiting),
            (2, 1.0, absent),
            (NO_EDGE, 0.0, driving),
        ];
        let counts = count(&mut tally, &robots, &[0.0, 2.0, 1.0, 2.0, 2.0]);
        assert_eq!(
            counts[0],
            Counts {
                driving: Driving { robots: 2.0, metres: 3.0, ..Driving::default() },
                extra: Extra { touching: 1.0, ..Extra::default() },
            }
        );
        assert_eq!(
            counts[1],
            Counts {
                driving: Driving { robots: 1.0, waiting: 1.0, ..Driving::default() },
                extra: Extra::default(),
            },
            "a possible contact is none"
        );
        assert_eq!(counts[2], Counts::default());
        let counts =
            count(&mut tally, &[(1, 2.0, driving), (0, 1.0, driving), (9, 0.0, driving)], &[]);
        let entered = [counts[0], counts[1]].map(|counts| counts.driving.entered);
        assert_eq!(entered, [0.0, 1.0], "robot 0 has driven on");
        let counts = count(
            &mut tally,
            &[(1, 2.0, driving), (NO_EDGE, 1.0, driving), (1, 0.0, driving)],
            &[],
        );
        assert_eq!(
            counts[1].driving,
            Driving { robots: 2.0, metres: 2.0, entered: 1.0, waiting: 0.0 }
        );
    }
}
