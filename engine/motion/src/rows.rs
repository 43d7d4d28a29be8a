//! Consecutive rows of the fleet's columns, as the stages of a tick read and write them, the memory
//! of a column, and lists of rows.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
use regatta_base::graph::{EdgeIndex, Leg};

use super::pieces::{PieceIndex, PieceRows};
use super::routes::Route;
use crate::frame::{Line, NO_EDGE, RobotState};

/// Makes two structs of columns from the two halves of each column.
macro_rules! split_fields {
    ($($field:ident: $halves:expr),* $(,)?) => {{
        $(let $field = $halves;)*
        (Self { $($field: $field.0),* }, Self { $($field: $field.1),* })
    }};
}

pub(crate) use split_fields;

/// The columns from row `first` on. All have the same length, a multiple of 64; rows that hold no
/// robot are inert.
#[derive(Debug)]
pub struct Rows<'fleet> {
    /// Robot id of the first row.
    pub first: u32,
    /// The piece that the robot is on, and its gear.
    pub piece: PieceRows<'fleet>,
    /// Distance from the end of the piece, in units of
    /// [`Distance`](crate::piece::Distance); ≤ 0.
    pub w: &'fleet mut [i32],
    /// Metres per second in the driving direction; ≥ 0.
    pub speed: &'fleet mut [f32],
    /// Metres along the edge from its origin to the end of the piece.
    pub s_end: &'fleet mut [f32],
    /// Index of the edge, or [`NO_EDGE`] on a node.
    pub edge: &'fleet mut [u32],
    /// A [`RobotState`].
    pub state: &'fleet mut [u8],
    /// The robot's position on its route.
    pub route: &'fleet mut [Route],
    /// Index of the robot type.
    pub robot_type: &'fleet mut [u16],
    /// `None` in fleets where no robot type limits its acceleration, and no base has ended within a
    /// leg.
    pub limits: Option<LimitRows<'fleet>>,
    /// `None` in fleets where every heading is that of an edge.
    pub headings: Option<HeadingRows<'fleet>>,
}

/// The columns that only fleets with acceleration limits, or with bases that end within a leg,
/// have; [`profile`](super::profile) has the equations.
#[derive(Debug)]
pub struct LimitRows<'fleet> {
    /// Metres per second squared; [`UNLIMITED`](super::profile::UNLIMITED) for types without a
    /// limit.
    pub acceleration: &'fleet mut [f32],
    /// The speed to accelerate or brake to, in metres per second.
    pub cruise: &'fleet mut [f32],
    /// Square of the speed from which the robot can brake for everything beyond the end of its leg
    /// or base, in m²/s².
    pub brake: &'fleet mut [f32],
    /// Metres from the end of the piece to the place where the base ends on the leg; to the leg's
    /// end, if it doesn't.
    pub rest: &'fleet mut [f32],
    /// Metres from that place to the end of the leg; 0 if the base doesn't end on the leg.
    pub stop: &'fleet mut [f32],
}

/// The columns that only fleets have whose robots turn on the spot, or drive edges with an
/// orientation; [`headings`](super::headings) has the equation.
#[derive(Debug)]
pub struct HeadingRows<'fleet> {
    /// 1 or 0: whether the heading follows the edge's tangent.
    pub gain: &'fleet mut [f32],
    /// Radians.
    pub offset: &'fleet mut [f32],
    /// Radians per second at which a robot turns on the spot; ≥ 0.
    pub rate: &'fleet mut [f32],
}

impl LimitRows<'_> {
    /// Whether any of these robots has a limit of acceleration, or a base that ends on its leg.
    pub fn any(&self) -> bool {
        self.brake.iter().any(|brake| brake.is_finite())
    }
}

impl Rows<'_> {
    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.piece.len()
    }

    /// Splits into the first `count` rows (all, if there are fewer) and the others.
    pub fn split_at(self, count: usize) -> (Self, Self) {
        let count = count.min(self.len());
        split_fields! {
            first: (self.first, self.first + count as u32),
            piece: self.piece.split_at(count),
            w: self.w.split_at_mut(count),
            speed: self.speed.split_at_mut(count),
            s_end: self.s_end.split_at_mut(count),
            edge: self.edge.split_at_mut(count),
            state: self.state.split_at_mut(count),
            route: self.route.split_at_mut(count),
            robot_type: self.robot_type.split_at_mut(count),
            limits: self.limits.map(|limits| limits.split_at(count)).unzip(),
            headings: self.headings.map(|headings| headings.split_at(count)).unzip(),
        }
    }

    /// Returns the robot id of a row.
    pub fn robot(&self, row: usize) -> u32 {
        self.first + row as u32
    }

    /// Whether a robot is in a state.
    pub fn is(&self, row: usize, state: RobotState) -> bool {
        self.state[row] == state as u8
    }

    /// Whether a robot may not drive: it is held, stalled or broken.
    pub fn is_stopped(&self, row: usize) -> bool {
        RobotState::is_stopped(self.state[row])
    }

    /// Returns the leg that a robot is on; `None` on a node.
    pub fn leg(&self, row: usize) -> Option<Leg> {
        leg_of(self.piece.get(row), self.edge[row])
    }
}

/// Returns the leg of a robot on that piece and edge; `None` on a node.
pub fn leg_of(piece: PieceIndex, edge: u32) -> Option<Leg> {
    (edge != NO_EDGE).then_some(Leg { edge: EdgeIndex(edge), gear: piece.gear() })
}

impl LimitRows<'_> {
    fn split_at(self, count: usize) -> (Self, Self) {
        split_fields! {
            acceleration: self.acceleration.split_at_mut(count),
            cruise: self.cruise.split_at_mut(count),
            brake: self.brake.split_at_mut(count),
            rest: self.rest.split_at_mut(count),
            stop: self.stop.split_at_mut(count),
        }
    }
}

impl HeadingRows<'_> {
    fn split_at(self, count: usize) -> (Self, Self) {
        split_fields! {
            gain: self.gain.split_at_mut(count),
            offset: self.offset.split_at_mut(count),
            rate: self.rate.split_at_mut(count),
        }
    }
}

/// Rows by which a column grows, so that every column is a whole number of cache lines.
pub const ROW_GROUP: usize = 64;

/// A vector that starts on a cache line and grows by groups of [`ROW_GROUP`] rows.
#[derive(Debug)]
pub struct AlignedVec<T> {
    lines: Vec<Line>,
    values: PhantomData<T>,
}

impl<T: Pod> AlignedVec<T> {
    /// Makes a vector without rows.
    pub const fn new() -> Self {
        Self { lines: Vec::new(), values: PhantomData }
    }

    /// Reserves memory for that many groups in total, and no more than they need.
    pub fn reserve(&mut self, groups: usize) {
        self.lines.reserve_exact((groups * size_of::<T>()).saturating_sub(self.lines.len()));
    }

    /// Resizes to that many groups; new rows get `value`.
    pub fn resize(&mut self, groups: usize, value: T) {
        let before = self.len();
        self.lines.resize(groups * size_of::<T>(), Line::default());
        if let Some(new) = self.get_mut(before..) {
            new.fill(value);
        }
    }
}

impl<T: Pod> Default for AlignedVec<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Pod> Deref for AlignedVec<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.lines)
    }
}

impl<T: Pod> DerefMut for AlignedVec<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.lines)
    }
}

/// Rows in a block. Fixed, because events are ordered by block.
pub const BLOCK: usize = 1024;

/// Some rows of a block, in ascending order.
#[derive(Debug)]
pub(super) struct RowList {
    pub rows: [u16; BLOCK],
    pub len: usize,
}

impl RowList {
    pub const fn new() -> Self {
        Self { rows: [0; BLOCK], len: 0 }
    }

    pub fn push(&mut self, row: usize) {
        self.push_if(row, true);
    }

    /// Lists a row if `is_listed`, without a branch on it. The list must not be full.
    #[inline]
    pub fn push_if(&mut self, row: usize, is_listed: bool) {
        self.rows[self.len] = row as u16;
        self.len += usize::from(is_listed);
    }

    /// Lists a row for every bit that is set; bit 0 stands for row `first`.
    #[inline]
    pub fn push_bits(&mut self, first: usize, mut bits: u32) {
        while bits != 0 {
            self.push(first + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }

    pub fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.rows[..self.len].iter().map(|&row| usize::from(row))
    }
}

/// The rows of a block that need stage 2.
#[derive(Debug)]
pub(super) struct BlockLists {
    /// Robots that reach the end of their piece.
    pub arrived: RowList,
    /// Robots with limits that come to a stop.
    pub stopped: RowList,
    /// Robots in blocks with limits that may reach the end of their leg. Stage 1 doesn't move them.
    pub near_leg_end: RowList,
    /// Robots that turn on the spot.
    pub turning: RowList,
    /// Robots of `arrived` that are on the last piece of their leg.
    pub leaving: RowList,
}

impl BlockLists {
    pub const fn new() -> Self {
        Self {
            arrived: RowList::new(),
            stopped: RowList::new(),
            near_leg_end: RowList::new(),
            turning: RowList::new(),
            leaving: RowList::new(),
        }
    }

    pub fn clear(&mut self) {
        self.arrived.len = 0;
        self.stopped.len = 0;
        self.near_leg_end.len = 0;
        self.turning.len = 0;
        self.leaving.len = 0;
    }
}
