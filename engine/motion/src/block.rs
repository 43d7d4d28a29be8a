//! Blocks of rows, and the lists of rows that need more than the vectorised stages of a tick.

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
