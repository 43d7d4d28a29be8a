//! The tally of a frame: the number of robots on each edge, by state.

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
pub(crate) const BLOCK: usize = 8;

/// Counts of edges, in blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks<T> {
    /// By edge.
    counts: Vec<T>,
    /// A bit for each block: whether its counts may differ from zero.
    in_use: Vec<u64>,
}

impl<T: Sum> Blocks<T> {
    fn new(edges: usize) -> Self {
        let words = edges.div_ceil(BLOCK * u64::BITS as usize);
        Self { counts: vec![T::default(); edges], in_use: vec![0; words] }
    }

    fn clear(&mut self) {
        for block in set_bits(&self.in_use) {
            let first = block * BLOCK;
            let end = (first + BLOCK).min(self.counts.len());
            self.counts[first..end].fill(T::default());
        }
        self.in_use.fill(0);
    }

    /// Returns the counts of an edge to add to; `None` if there is no such edge.
    pub(crate) fn get_mut(&mut self, edge: usize) -> Option<&mut T> {
        let counts = self.counts.get_mut(edge)?;
        let (word, bit) = bit(edge / BLOCK);
        self.in_use[word] |= bit;
        Some(counts)
    }

    fn add(&mut self, frame: &Self, secs: f32) {
        for (all, in_use) in self.in_use.iter_mut().zip(&frame.in_use) {
            *all |= in_use;
        }
        for (block, counts) in frame.in_use() {
            for (sum, counts) in self.counts[block * BLOCK..].iter_mut().zip(counts) {
                sum.add(counts, secs);
            }
        }
    }

    /// Returns the blocks in use with their numbers.
    pub(crate) fn in_use(&self) -> impl Iterator<Item = (usize, &[T])> {
        set_bits(&self.in_use).map(|block| (block, self.counts_of(block)))
    }

    /// Returns the counts of a block, if it is in use.
    pub(crate) fn block(&self, block: usize) -> Option<&[T]> {
        let (word, bit) = bit(block);
        (self.in_use[word] & bit != 0).then(|| self.counts_of(block))
    }

    fn counts_of(&self, block: usize) -> &[T] {
        let counts = &self.counts[block * BLOCK..];
        &counts[..counts.len().min(BLOCK)]
    }
}

/// Returns the index of the word of a bit, and the bit in it.
fn bit(number: usize) -> (usize, u64) {
    (number / u64::BITS as usize, 1 << (number % u64::BITS as usize))
}

/// Returns the numbers of the bits that are set, in ascending order.
fn set_bits(words: &[u64]) -> impl Iterator<Item = usize> {
    words.iter().enumerate().flat_map(|(word, bits)| {
        let mut bits = *bits;
        std::iter::from_fn(move || {
            let lowest = bits.trailing_zeros();
            bits &= bits.wrapping_sub(1);
            (lowest < u64::BITS).then(|| word * u64::BITS as usize + lowest as usize)
        })
    })
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
        self.driving.block(block).is_some() || self.extra.block(block).is_some()
    }

    /// Adds the counts of a frame that lasted for some seconds; with 1, counts that are added up.
    pub fn add(&mut self, frame: &Self, secs: f32) {
        self.driving.add(&frame.driving, secs);
        self.extra.add(&frame.extra, secs);
    }
}

/// The blocks of edges that robots are on.
#[derive(Clone, Debug, Default)]
struct Occupied {
    /// By block: the number of robots on its edges.
    robots: Vec<u32>,
    /// A bit for each block: whether there are any.
    blocks: Vec<u64>,
}

impl Occupied {
    fn new(edges: usize) -> Self {
        let blocks = edges.div_ceil(BLOCK);
        Self { robots: vec![0; blocks], blocks: vec![0; blocks.div_ceil(u64::BITS as usize)] }
    }

    fn enter(&mut self, edge: u32) {
        let block = edge as usize / BLOCK;
        if let Some(robots) = self.robots.get_mut(block) {
            *robots += 1;
            let (word, bit) = bit(block);
            self.blocks[word] |= bit;
        }
    }

    fn leave(&mut self, edge: u32) {
        let block = edge as usize / BLOCK;
        if let Some(robots) = self.robots.get_mut(block) {
            *robots -= 1;
            if *robots == 0 {
                let (word, bit) = bit(block);
                self.blocks[word] &= !bit;
            }
        }
    }
}

/// Counts robots frame by frame.
#[derive(Debug, Default)]
pub struct Tally {
    counts: EdgeCounts,
    /// By robot: the edge it was on in the frame before; [`NO_EDGE`] if it is unknown.
    edges: Vec<u32>,
    /// The places of robots in the frame before.
    occupied: Occupied,
}

impl Tally {
    /// Begins a run on a number of edges.
    pub fn begin(&mut self, edges: usize) {
        self.counts = EdgeCounts::new(edges);
        self.occupied = Occupied::new(edges);
        self.edges.clear();
    }

    /// Forgets where robots were: none enters an edge in the next frame.
    pub fn forget_places(&mut self) {
        for edge in &mut self.edges {
            self.occupied.leave(std::mem::replace(edge, NO_EDGE));
        }
    }

    fn resize(&mut self, robots: usize) {
        for edge in self.edges.drain(robots.min(self.edges.len())..) {
            self.occupied.leave(edge);
        }
        self.edges.resize(robots, NO_EDGE);
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
        self.resize(columns.edge.len());
        let (counts, occupied) = (&mut self.counts.driving, &mut self.occupied);
        let rows = columns.edge.iter().zip(columns.speed).zip(columns.state);
        for (((&edge, &speed), &state), before) in rows.zip(&mut self.edges) {
            // An absent robot isn't on an edge.
            let edge = if state == RobotState::Absent as u8 { NO_EDGE } else { edge };
            let mut entered = false;
            // Most robots stay on their edge.
            if edge != *before {
                entered = *before != NO_EDGE;
                occupied.leave(*before);
                occupied.enter(edge);
                *before = edge;
            }
            if let Some(counts) = counts.counts.get_mut(edge as usize) {
                counts.robots += 1.0;
                counts.entered += f32::from(u8::from(entered));
                counts.metres += speed.abs();
                counts.waiting += f32::from(u8::from(state == RobotState::Waiting as u8));
            }
        }
        counts.in_use.copy_from_slice(&occupied.blocks);
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
    use proptest::prelude::*;
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

    proptest! {
        /// Robots come, leave, jump, and drive to edges that the world has or doesn't have.
        #[test]
        fn blocks_that_robots_have_left_are_empty(
            frames in prop::collection::vec(
                (prop::collection::vec((0_u32..70, 0_u32..3), 0..6), any::<bool>()),
                1..30,
            ),
        ) {
            const EDGES: usize = 60;
            let mut tally = Tally::default();
            tally.begin(EDGES);
            for (robots, jumps) in &frames {
                if *jumps {
                    tally.forget_places();
                }
                let states = [RobotState::Driving, RobotState::Waiting, RobotState::Absent];
                let rows: Vec<_> = robots
                    .iter()
                    .map(|(edge, state)| (*edge, 1.0, states[*state as usize]))
                    .collect();
                count(&mut tally, &rows, &[]);
                for edge in 0..EDGES {
                    let on_edge = rows.iter().filter(|(on, ..)| *on as usize == edge);
                    let present = on_edge.filter(|(.., state)| *state != RobotState::Absent);
                    let robots = present.count() as f32;
                    prop_assert_eq!(tally.counts.get(edge).driving.robots, robots);
                }
                let in_use = tally.counts.driving.in_use();
                let used: f32 = in_use.flat_map(|(_, counts)| counts).map(|edge| edge.robots).sum();
                let all: f32 = (0..EDGES).map(|edge| tally.counts.get(edge).driving.robots).sum();
                prop_assert_eq!(used, all, "all robots are in blocks in use");
            }
        }
    }
}
