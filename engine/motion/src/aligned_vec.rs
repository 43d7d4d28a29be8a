//! Memory of a column.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;

use crate::frame::Line;

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
