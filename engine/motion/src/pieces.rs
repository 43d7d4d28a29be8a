//! Indices of pieces, and the column that holds one per robot.
//!
//! The vector code reads the piece of every robot on every tick, without a bounds check. That is
//! sound because of one invariant, which only this module can affect: a [`PieceColumn`] is made for
//! a table of a certain length, and every value in it is the index of a piece below that length.
//! Writes check it; they happen only when a robot comes to another piece. A lookup checks once per
//! block that the table is at least as long as the column's.
#![allow(
    unsafe_code,
    reason = "reads of pieces without a bounds check; this module upholds their invariant"
)]

use regatta_base::graph::Gear;

use super::rows::AlignedVec;
use crate::piece::Piece;

/// Bit of a [`PieceIndex`] that is set in reverse gear. It is also the sign bit of an `f32`, which
/// the kernel makes use of.
pub(super) const REVERSE: u32 = 1 << 31;

/// Bits of a [`PieceIndex`] that hold the row: so few that the row's offset in bytes fits 32 bits.
const ROW_BITS: u32 = (1 << 27) - 1;

/// The maximum number of pieces for a [`PieceIndex`].
pub const MAX_PIECES: usize = ROW_BITS as usize + 1;

/// Row of a piece in a [`LegTable`](super::leg_table::LegTable), and the gear in which a robot
/// drives it. Only the table makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PieceIndex(u32);

impl PieceIndex {
    /// Makes the index of a row; the table checks that it has the row.
    ///
    /// # Panics
    /// If the row doesn't fit the bits for it.
    pub(super) fn new(row: u32, gear: Gear) -> Self {
        assert!(row <= ROW_BITS, "piece {row} doesn't fit a piece index");
        Self(row | if gear == Gear::Reverse { REVERSE } else { 0 })
    }

    /// The row in the table.
    pub(super) fn row(self) -> usize {
        (self.0 & ROW_BITS) as usize
    }

    /// The gear in which a robot drives the piece.
    pub fn gear(self) -> Gear {
        if self.0 & REVERSE == 0 { Gear::Forward } else { Gear::Reverse }
    }

    /// The sign bit of values that change their sign in reverse gear.
    pub(super) fn sign_bit(self) -> u32 {
        self.0 & REVERSE
    }
}

/// The piece that each robot is on: a column whose values are indices of one table.
#[derive(Debug)]
pub struct PieceColumn {
    /// The rows of all, without [`REVERSE`], are less than `table_len`.
    values: AlignedVec<u32>,
    table_len: usize,
}

impl PieceColumn {
    /// Makes a column without rows for a table with that many pieces.
    pub const fn new(table_len: usize) -> Self {
        Self { values: AlignedVec::new(), table_len }
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Reserves memory for that many groups of rows.
    pub fn reserve(&mut self, groups: usize) {
        self.values.reserve(groups);
    }

    /// Resizes to that many groups of rows; new rows are on the first piece.
    ///
    /// # Panics
    /// If the table has no pieces.
    pub fn resize(&mut self, groups: usize) {
        assert!(self.table_len > 0, "a graph without pieces has no robots");
        self.values.resize(groups, 0);
    }

    /// Returns the piece of a row.
    pub fn get(&self, row: usize) -> PieceIndex {
        PieceIndex(self.values[row])
    }

    /// Puts a row on the first piece.
    pub fn reset(&mut self, row: usize) {
        self.values[row] = 0;
    }

    /// Returns all rows.
    pub fn rows(&mut self) -> PieceRows<'_> {
        PieceRows { values: &mut self.values, table_len: self.table_len }
    }
}

/// Consecutive rows of a [`PieceColumn`].
#[derive(Debug)]
pub struct PieceRows<'column> {
    /// As in [`PieceColumn`].
    values: &'column mut [u32],
    table_len: usize,
}

impl PieceRows<'_> {
    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    pub(super) fn split_at(self, count: usize) -> (Self, Self) {
        let (first, second) = self.values.split_at_mut(count);
        let table_len = self.table_len;
        (Self { values: first, table_len }, Self { values: second, table_len })
    }

    #[inline]
    pub(super) fn get(&self, row: usize) -> PieceIndex {
        PieceIndex(self.values[row])
    }

    /// Puts a row's robot on a piece.
    ///
    /// # Panics
    /// If the column's table has no such piece, which then is another table's.
    #[inline]
    pub(super) fn set(&mut self, row: usize, piece: PieceIndex) {
        assert!(((piece.0 & !REVERSE) as usize) < self.table_len, "a piece of another table");
        self.values[row] = piece.0;
    }

    /// Puts a row's robot on the next piece of its leg if `moves`, without a branch on it.
    ///
    /// # Panics
    /// If the table has no next piece.
    #[inline]
    pub(super) fn advance_if(&mut self, row: usize, moves: bool) {
        self.set(row, PieceIndex(self.values[row] + u32::from(moves)));
    }

    /// The pieces of the first `chunks` times `N` rows, which are read without a bounds check.
    ///
    /// # Panics
    /// If the column's table is longer than this one, or there are fewer rows.
    #[inline]
    pub(super) fn lookup<'rows, const N: usize>(
        &'rows self,
        table: &'rows [Piece],
        chunks: usize,
    ) -> PieceLookup<'rows, N> {
        assert!(self.table_len <= table.len(), "the column holds pieces of a longer table");
        PieceLookup { table, indices: &self.values.as_chunks().0[..chunks] }
    }
}

/// The pieces that robots are on, in chunks of `N` rows.
#[derive(Clone, Copy)]
pub(super) struct PieceLookup<'rows, const N: usize> {
    table: &'rows [Piece],
    /// The rows of all, without [`REVERSE`], are less than the length of `table`.
    indices: &'rows [[u32; N]],
}

impl<'rows, const N: usize> PieceLookup<'rows, N> {
    /// The indices of a chunk as they are stored, with [`REVERSE`] in the sign bit.
    #[inline]
    pub fn signs(&self, chunk: usize) -> &'rows [u32; N] {
        &self.indices[chunk]
    }

    /// The pieces of a chunk.
    #[inline]
    pub fn pieces(&self, chunk: usize) -> [&'rows Piece; N] {
        let mut pieces = [&self.table[0]; N];
        for (piece, &index) in pieces.iter_mut().zip(&self.indices[chunk]) {
            let row = (index & ROW_BITS) as usize;
            debug_assert!(row < self.table.len());
            // SAFETY: `indices` come from a column whose rows are less than its `table_len`, and
            // `lookup` has checked that this table is not shorter. The mask only makes a number
            // smaller.
            *piece = unsafe { self.table.get_unchecked(row) };
        }
        pieces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(table_len: usize) -> PieceColumn {
        let mut column = PieceColumn::new(table_len);
        column.resize(1);
        column
    }

    #[test]
    fn an_index_holds_row_and_gear() {
        let index = PieceIndex::new(ROW_BITS, Gear::Reverse);
        assert_eq!(
            (index.row(), index.gear(), index.sign_bit()),
            (MAX_PIECES - 1, Gear::Reverse, REVERSE)
        );
        let index = PieceIndex::new(7, Gear::Forward);
        assert_eq!((index.row(), index.gear(), index.sign_bit()), (7, Gear::Forward, 0));
    }

    #[test]
    #[should_panic(expected = "doesn't fit")]
    fn a_row_beyond_the_mask_is_refused() {
        PieceIndex::new(ROW_BITS + 1, Gear::Forward);
    }

    #[test]
    #[should_panic(expected = "another table")]
    fn an_index_of_a_longer_table_is_refused() {
        column(3).rows().set(0, PieceIndex::new(3, Gear::Reverse));
    }

    #[test]
    #[should_panic(expected = "another table")]
    fn a_row_doesnt_advance_beyond_the_table() {
        column(1).rows().advance_if(0, true);
    }

    #[test]
    #[should_panic(expected = "longer table")]
    fn a_lookup_in_a_shorter_table_is_refused() {
        let _ = column(3).rows().lookup::<4>(&[Piece::default(); 2], 1);
    }

    #[test]
    fn a_lookup_gives_the_pieces_of_both_gears() {
        let mut column = column(3);
        let table = [1.0, 2.0, 3.0].map(|x| Piece { x: [x; 4], ..Piece::default() });
        let mut rows = column.rows();
        rows.set(4, PieceIndex::new(2, Gear::Reverse));
        rows.set(5, PieceIndex::new(1, Gear::Forward));
        let lookup = rows.lookup::<4>(&table, 2);
        assert_eq!(lookup.pieces(1).map(|piece| piece.x[0]), [3.0, 2.0, 1.0, 1.0]);
        assert_eq!(lookup.signs(1)[0], REVERSE | 2);
    }
}
