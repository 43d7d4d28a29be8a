//! The fleet's truth: one column per fact, one row per robot.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
use regatta_plugin::frame::{Line, NO_EDGE, RobotState};

use super::Route;
use crate::motion::{LimitRows, Rows, UNLIMITED};

/// Rows come in groups of this many, so that every column is a whole number of cache lines.
const GROUP: usize = 64;

/// A vector that starts on a cache line and grows by groups of rows.
#[derive(Debug)]
pub(super) struct Column<T> {
    lines: Vec<Line>,
    values: PhantomData<T>,
}

impl<T: Pod> Column<T> {
    const fn new() -> Self {
        Self { lines: Vec::new(), values: PhantomData }
    }

    /// Takes no more memory than that many groups need, if it takes any.
    fn reserve(&mut self, groups: usize) {
        self.lines.reserve_exact((groups * size_of::<T>()).saturating_sub(self.lines.len()));
    }

    /// As many rows as that many groups hold; new ones get `value`.
    fn resize(&mut self, groups: usize, value: T) {
        let before = self.len();
        self.lines.resize(groups * size_of::<T>(), Line::default());
        if let Some(new) = self.get_mut(before..) {
            new.fill(value);
        }
    }
}

impl<T: Pod> Deref for Column<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.lines)
    }
}

impl<T: Pod> DerefMut for Column<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.lines)
    }
}

/// All columns. Rows that hold no robot are inert: they stand on the first piece and are [`RobotState::Absent`].
#[derive(Debug)]
pub(super) struct FleetColumns {
    pub piece: Column<u32>,
    pub w: Column<i32>,
    pub speed: Column<f32>,
    pub s_end: Column<f32>,
    pub edge: Column<u32>,
    pub state: Column<u8>,
    pub route: Column<Route>,
    pub kind: Column<u16>,
    limits: Option<Limits>,
}

#[derive(Debug)]
struct Limits {
    acceleration: Column<f32>,
    cruise: Column<f32>,
    brake: Column<f32>,
    rest: Column<f32>,
}

impl FleetColumns {
    /// No rows; `limited` if some robot type limits its acceleration.
    pub fn new(limited: bool) -> Self {
        let limits =
            || Limits { acceleration: Column::new(), cruise: Column::new(), brake: Column::new(), rest: Column::new() };
        Self {
            piece: Column::new(),
            w: Column::new(),
            speed: Column::new(),
            s_end: Column::new(),
            edge: Column::new(),
            state: Column::new(),
            route: Column::new(),
            kind: Column::new(),
            limits: limited.then(limits),
        }
    }

    /// Makes room for that many rows, in whole groups. Rows there are stay as they are.
    pub fn resize(&mut self, rows: usize) {
        let groups = rows.div_ceil(GROUP);
        self.piece.resize(groups, 0);
        self.w.resize(groups, 0);
        self.speed.resize(groups, 0.0);
        self.s_end.resize(groups, 0.0);
        self.edge.resize(groups, NO_EDGE);
        self.state.resize(groups, RobotState::Absent as u8);
        self.route.resize(groups, Route::PARKED);
        self.kind.resize(groups, 0);
        if let Some(limits) = &mut self.limits {
            limits.acceleration.resize(groups, UNLIMITED);
            limits.cruise.resize(groups, 0.0);
            limits.brake.resize(groups, f32::INFINITY);
            limits.rest.resize(groups, 0.0);
        }
    }

    /// Takes memory for that many rows at once, instead of bit by bit.
    pub fn reserve(&mut self, rows: usize) {
        let groups = rows.div_ceil(GROUP);
        self.piece.reserve(groups);
        self.w.reserve(groups);
        self.speed.reserve(groups);
        self.s_end.reserve(groups);
        self.edge.reserve(groups);
        self.state.reserve(groups);
        self.route.reserve(groups);
        self.kind.reserve(groups);
        if let Some(limits) = &mut self.limits {
            limits.acceleration.reserve(groups);
            limits.cruise.reserve(groups);
            limits.brake.reserve(groups);
            limits.rest.reserve(groups);
        }
    }

    /// Rows there is room for.
    pub fn capacity(&self) -> usize {
        self.piece.len()
    }

    /// Makes a row inert.
    pub fn clear(&mut self, row: usize) {
        self.piece[row] = 0;
        self.w[row] = 0;
        self.speed[row] = 0.0;
        self.s_end[row] = 0.0;
        self.edge[row] = NO_EDGE;
        self.state[row] = RobotState::Absent as u8;
        self.route[row] = Route::PARKED;
        self.set_kind(row, 0, f32::INFINITY);
        if let Some(limits) = &mut self.limits {
            limits.cruise[row] = 0.0;
            limits.rest[row] = 0.0;
        }
    }

    /// Makes a row's robot one of a type with that acceleration limit; infinity for none.
    pub fn set_kind(&mut self, row: usize, kind: u16, acceleration: f32) {
        self.kind[row] = kind;
        if let Some(limits) = &mut self.limits {
            limits.acceleration[row] = acceleration.min(UNLIMITED);
            limits.brake[row] = f32::INFINITY;
        }
    }

    /// The groups that hold the first `count` rows.
    pub fn rows(&mut self, count: usize) -> Rows<'_> {
        self.all_rows().split_at(count.next_multiple_of(GROUP)).0
    }

    /// All rows there is room for.
    pub fn all_rows(&mut self) -> Rows<'_> {
        Rows {
            first: 0,
            piece: &mut self.piece,
            w: &mut self.w,
            speed: &mut self.speed,
            s_end: &mut self.s_end,
            edge: &mut self.edge,
            state: &mut self.state,
            route: &mut self.route,
            kind: &mut self.kind,
            limits: self.limits.as_mut().map(|limits| LimitRows {
                acceleration: &mut limits.acceleration,
                cruise: &mut limits.cruise,
                brake: &mut limits.brake,
                rest: &mut limits.rest,
            }),
        }
    }

    /// Bytes that each row takes.
    pub fn bytes_per_row(&self) -> usize {
        let hot = 5 * size_of::<u32>() + size_of::<u8>();
        let cold = size_of::<Route>() + size_of::<u16>();
        hot + cold + if self.limits.is_some() { 4 * size_of::<f32>() } else { 0 }
    }
}
