//! Compressed sparse rows: lists of values by a dense index, one after the other in memory.
//!
//! ```
//! use regatta_base::rows::Rows;
//!
//! let exits = Rows::by_row(3, vec![(2, 'd'), (0, 'b'), (2, 'a')]);
//! assert_eq!([exits.row(0), exits.row(1), exits.row(2)], [&['b'][..], &[], &['d', 'a']]);
//! ```

use std::ops::Range;

/// A list of values for each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows<T> {
    /// Values of row r: `values[starts[r]..starts[r + 1]]`.
    starts: Vec<u32>,
    values: Vec<T>,
}

impl<T> Rows<T> {
    /// Makes `count` rows of pairs of a row and a value. The values of a row are sorted.
    ///
    /// # Panics
    /// If a pair is of another row.
    pub fn new(count: usize, mut pairs: Vec<(u32, T)>) -> Self
    where
        T: Ord,
    {
        pairs.sort_unstable();
        Self::of_sorted(count, pairs)
    }

    /// Makes `count` rows of pairs of a row and a value. The values of a row stay in their order.
    ///
    /// # Panics
    /// If a pair is of another row.
    pub fn by_row(count: usize, mut pairs: Vec<(u32, T)>) -> Self {
        pairs.sort_by_key(|(row, _)| *row);
        Self::of_sorted(count, pairs)
    }

    /// Makes `count` rows of pairs of a row and a value, which are in ascending order of their
    /// rows.
    ///
    /// # Panics
    /// If a pair is of another row.
    pub fn of_sorted(count: usize, pairs: impl IntoIterator<Item = (u32, T)>) -> Self {
        let (mut starts, mut values) = (vec![0; count + 1], Vec::new());
        for (row, value) in pairs {
            starts[row as usize + 1] += 1;
            values.push(value);
        }
        for row in 0..count {
            starts[row + 1] += starts[row];
        }
        Self { starts, values }
    }

    /// Makes rows of their [starts](Self::starts) and all values.
    pub fn of_parts(starts: Vec<u32>, values: Vec<T>) -> Self {
        Self { starts, values }
    }

    /// The values of a row.
    pub fn row(&self, row: u32) -> &[T] {
        &self.values[self.range(row)]
    }

    /// The indices of a row's values among all values.
    pub fn range(&self, row: u32) -> Range<usize> {
        self.starts[row as usize] as usize..self.starts[row as usize + 1] as usize
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// For each row the index of its first value, and the number of values.
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// All values, row by row.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values, row by row, to be changed.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }
}
