//! Integer coordinates to sort boxes by: the plane is divided into strips from south to north, and
//! each strip into cells from west to east.

use crate::bounds::Bounds;
use crate::radix;

/// Height of a strip, in heights of the mean box.
const STRIP_HEIGHT: f32 = 6.0;
/// Least height of a strip, in metres. It keeps the number of the farthest strip within 20 bits.
const MIN_STRIP_HEIGHT: f32 = 2.0;
/// Width of a cell, in widths of the mean box: the resolution of the sort.
const CELL_WIDTH: f32 = 0.25;
/// Least width of a cell, in metres. It keeps the number of the farthest cell within 23 bits.
const MIN_CELL_WIDTH: f32 = 0.25;

/// The conversion from metres to strips and cells. It is monotonic whatever rounding does, which is
/// all that sorting needs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scale {
    cells_per_metre: f32,
    strips_per_metre: f32,
}

impl Scale {
    /// Returns the scale that suits boxes like these samples.
    pub(crate) fn new(samples: impl ExactSizeIterator<Item = Bounds>) -> Self {
        let (count, mut width, mut height) = (samples.len(), 0.0, 0.0);
        for bounds in samples {
            (width, height) =
                (width + bounds.east() - bounds.west(), height + bounds.north() - bounds.south());
        }
        let [width, height] = [width, height].map(|sum: f32| sum / count.max(1) as f32);
        Self {
            cells_per_metre: 1.0 / (CELL_WIDTH * width).max(MIN_CELL_WIDTH),
            strips_per_metre: 1.0 / (STRIP_HEIGHT * height).max(MIN_STRIP_HEIGHT),
        }
    }

    fn cell(&self, x: f32) -> i32 {
        round(x * self.cells_per_metre)
    }

    pub(crate) fn strip(&self, y: f32) -> i32 {
        round(y * self.strips_per_metre)
    }
}

/// Rounds to the nearest integer of up to 22 bits: adding 1.5 · 2²³ moves it to the lowest bits of
/// the mantissa. Unlike a conversion, this takes two instructions.
fn round(value: f32) -> i32 {
    const MAGIC: f32 = 12_582_912.0;
    (value + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as i32
}

/// The packing of a strip and a cell into one sort key, unique among the strips of a bucket.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KeyPacking {
    scale: Scale,
    first_cell: i32,
    first_strip: i32,
    /// Binary logarithm of the number of buckets: the lowest bits of a strip's number, which are
    /// equal in a bucket.
    bucket_bits: u32,
    /// Lowest bits of a cell's number that are dropped because the key has no room for them.
    dropped_bits: u32,
    cell_bits: u32,
    /// Number of bits of a key, at most 32.
    pub bits: u32,
}

impl KeyPacking {
    /// Returns the packing for boxes within the bounds `all`.
    pub(crate) fn new(scale: Scale, all: Bounds, buckets: usize) -> Self {
        let bucket_bits = buckets.ilog2();
        let (first_cell, first_strip) = (scale.cell(all.west()), scale.strip(all.south()));
        let cells = scale.cell(all.east()).max(first_cell) - first_cell;
        let strips = (scale.strip(all.north()).max(first_strip) - first_strip) >> bucket_bits;
        let [cell_bits, strip_bits] =
            [cells, strips].map(|last| radix::bits_below(last as usize + 1));
        let dropped_bits = (cell_bits + strip_bits).saturating_sub(32);
        let cell_bits = cell_bits - dropped_bits;
        Self {
            scale,
            first_cell,
            first_strip,
            bucket_bits,
            dropped_bits,
            cell_bits,
            bits: cell_bits + strip_bits,
        }
    }

    pub(crate) fn pack(&self, strip: i32, x: f32) -> u32 {
        let strip = (strip.wrapping_sub(self.first_strip) as u32) >> self.bucket_bits;
        let cell = (self.scale.cell(x).wrapping_sub(self.first_cell) as u32) >> self.dropped_bits;
        strip << self.cell_bits | cell
    }
}
