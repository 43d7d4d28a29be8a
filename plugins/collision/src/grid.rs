//! Strips from west to east and columns from south to north, to sort boxes by.

use crate::bounds::Bounds;
use crate::chunk::Chunk;
use crate::radix;

/// A strip's height, in those of the mean box.
const STRIP_HEIGHT: f32 = 6.0;
/// Least height of a strip, in metres. So the farthest strip has a number of at most 20 bits.
const MIN_STRIP_HEIGHT: f32 = 2.0;
/// A column's width, which is how exactly boxes are sorted, in those of the mean box.
const COLUMN_WIDTH: f32 = 0.25;
/// Least width of a column, in metres. So the farthest column has a number of at most 23 bits.
const MIN_COLUMN_WIDTH: f32 = 0.25;

/// From metres to strips and columns. Monotonous, whatever rounding does, which is all that is needed of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scale {
    columns_per_metre: f32,
    strips_per_metre: f32,
}

impl Scale {
    /// For boxes like these.
    pub(crate) fn new(samples: &Chunk) -> Self {
        let (mut width, mut height) = (0.0, 0.0);
        for bounds in (0..samples.len).map(|number| samples.bounds(number)) {
            (width, height) = (width + bounds.east() - bounds.west(), height + bounds.north() - bounds.south());
        }
        let mean = |sum: f32| sum / samples.len.max(1) as f32;
        Self {
            columns_per_metre: 1.0 / (COLUMN_WIDTH * mean(width)).max(MIN_COLUMN_WIDTH),
            strips_per_metre: 1.0 / (STRIP_HEIGHT * mean(height)).max(MIN_STRIP_HEIGHT),
        }
    }

    fn column(&self, x: f32) -> i32 {
        round(x * self.columns_per_metre)
    }

    pub(crate) fn strip(&self, y: f32) -> i32 {
        round(y * self.strips_per_metre)
    }
}

/// The nearest whole number, of up to 22 bits: adding 1.5 · 2²³ moves it to the lowest bits. Unlike a conversion, that
/// is two instructions.
fn round(value: f32) -> i32 {
    const MAGIC: f32 = 12_582_912.0;
    (value + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as i32
}

/// How a strip and a column are packed into a number to sort by, among those in the same memory.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Packing {
    scale: Scale,
    first_column: i32,
    first_strip: i32,
    /// Logarithm of the number of strips that don't share their memory.
    apart: u32,
    /// By how many bits columns are less exact than the scale's, for want of room.
    coarser: u32,
    column_bits: u32,
    pub bits: u32,
}

impl Packing {
    /// For boxes within these bounds.
    pub(crate) fn new(scale: Scale, all: Bounds, strips: usize) -> Self {
        let apart = strips.ilog2();
        let bits =
            |first: i32, last: i32, shift: u32| radix::bits_below(((last.max(first) - first) >> shift) as usize + 1);
        let (first_column, first_strip) = (scale.column(all.west()), scale.strip(all.south()));
        let column_bits = bits(first_column, scale.column(all.east()), 0);
        let strip_bits = bits(first_strip, scale.strip(all.north()), apart);
        let coarser = (column_bits + strip_bits).saturating_sub(32);
        let column_bits = column_bits - coarser;
        Self { scale, first_column, first_strip, apart, coarser, column_bits, bits: column_bits + strip_bits }
    }

    pub(crate) fn pack(&self, strip: i32, x: f32) -> u32 {
        let strip = (strip.wrapping_sub(self.first_strip) as u32) >> self.apart;
        let column = (self.scale.column(x).wrapping_sub(self.first_column) as u32) >> self.coarser;
        strip << self.column_bits | column
    }
}
