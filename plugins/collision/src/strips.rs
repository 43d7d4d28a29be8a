//! Which boxes overlap: sort and sweep, in strips.
//!
//! The plane is cut into strips from west to east. A box is entered in every strip that it reaches into, and the boxes
//! of a strip are sorted by their western sides: from there, those that it overlaps from west to east come right
//! behind it. The strips are twice as high as the mean box, so that on average a box is entered one and a half times,
//! however small and large ones are mixed and however far apart they lie.

use std::ops::ControlFlow;

use crate::radix;

/// West, south, east and north, in metres.
pub(crate) type Bounds = [f32; 4];

/// Robots that can be told apart: more than fit any frame.
pub(crate) const MAX_ROBOTS: usize = 1 << 28;

/// Bits for how far to the east a box starts.
const COLUMN_BITS: u32 = 20;

/// A strip's height over that of the mean box.
const STRIP_HEIGHT: f32 = 2.0;
/// A column's width, which is how exactly boxes are sorted, over that of the mean box.
const COLUMN_WIDTH: f32 = 0.125;

/// What a sweep may cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Boxes that are looked at for each box, at most.
    pub looks_each: usize,
    /// Overlaps that are told for each box, at most.
    pub checks_each: usize,
    /// Looks in all.
    pub looks: usize,
    /// Overlaps in all.
    pub checks: usize,
}

/// The boxes of a frame, sorted. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Strips {
    keys: Vec<u64>,
    scratch: Vec<u64>,
    entries: Vec<Entry>,
}

/// A box in a strip.
#[derive(Clone, Copy, Debug)]
struct Entry {
    bounds: Bounds,
    /// Strip and column of the box's western side, and of its eastern side.
    start: u64,
    end: u64,
    robot: u32,
    /// Whether this is the southernmost strip of the box.
    is_first: bool,
}

/// From metres to strips and columns. Monotonous, whatever rounding does, which is all that is needed of it.
#[derive(Clone, Copy, Debug, Default)]
struct Scale {
    origin: [f32; 2],
    /// Columns and strips a metre.
    per_metre: [f32; 2],
    column_bits: u32,
    strip_bits: u32,
    robot_bits: u32,
}

impl Scale {
    /// `None` if there are no boxes.
    fn of(boxes: &[Bounds]) -> Option<Self> {
        let mut all: Bounds = [f32::INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY];
        let (mut sum, mut count) = ([0.0, 0.0], 0.0);
        for bounds in boxes.iter().filter(|bounds| !bounds[0].is_nan()) {
            all = [all[0].min(bounds[0]), all[1].min(bounds[1]), all[2].max(bounds[2]), all[3].max(bounds[3])];
            sum = [sum[0] + f64::from(bounds[2] - bounds[0]), sum[1] + f64::from(bounds[3] - bounds[1])];
            count += 1.0;
        }
        let robot_bits = radix::bits_below(boxes.len());
        let per_metre = |axis: usize, part: f32, bits: u32| {
            let mean = (sum[axis] / count) as f32;
            let most = ((1_u64 << bits) - 2) as f32 / (all[axis + 2] - all[axis]);
            (1.0 / (part * mean)).min(most).min(f32::MAX)
        };
        let strip_bits = (64 - COLUMN_BITS - robot_bits).min(COLUMN_BITS);
        let per_metre = [per_metre(0, COLUMN_WIDTH, COLUMN_BITS), per_metre(1, STRIP_HEIGHT, strip_bits)];
        let scale = Self { origin: [all[0], all[1]], per_metre, column_bits: 0, strip_bits: 0, robot_bits };
        let bits = |last: u64| radix::bits_below(last as usize + 1);
        let (column_bits, strip_bits) = (bits(scale.column(all[2])), bits(scale.strip(all[3])));
        (count > 0.0).then_some(Self { column_bits, strip_bits, ..scale })
    }

    fn column(&self, x: f32) -> u64 {
        ((x - self.origin[0]) * self.per_metre[0]) as u64
    }

    fn strip(&self, y: f32) -> u64 {
        ((y - self.origin[1]) * self.per_metre[1]) as u64
    }

    /// What boxes are sorted by.
    fn place(&self, strip: u64, x: f32) -> u64 {
        strip << self.column_bits | self.column(x)
    }
}

impl Strips {
    /// Takes the boxes of a frame, by robot; those that start at NaN are none.
    pub(crate) fn sort(&mut self, boxes: &[Bounds]) {
        let boxes = &boxes[..boxes.len().min(MAX_ROBOTS)];
        self.keys.clear();
        self.entries.clear();
        let Some(scale) = Scale::of(boxes) else { return };
        for (robot, bounds) in boxes.iter().enumerate().filter(|(_, bounds)| !bounds[0].is_nan()) {
            for strip in scale.strip(bounds[1])..=scale.strip(bounds[3]) {
                self.keys.push(scale.place(strip, bounds[0]) << scale.robot_bits | robot as u64);
            }
        }
        let bits = scale.robot_bits..scale.robot_bits + scale.column_bits + scale.strip_bits;
        radix::sort(&mut self.keys, &mut self.scratch, bits);
        self.entries.extend(self.keys.iter().map(|key| {
            let robot = (key & ((1 << scale.robot_bits) - 1)) as u32;
            let (start, bounds) = (key >> scale.robot_bits, boxes[robot as usize]);
            let strip = start >> scale.column_bits;
            let (end, is_first) = (scale.place(strip, bounds[2]), scale.strip(bounds[1]) == strip);
            Entry { bounds, start, end, robot, is_first }
        }));
    }

    /// Tells each pair of boxes that overlap once. Breaks off if that is too much for the limits in all, or if
    /// `overlap` does; the limits for each box just leave pairs out.
    pub(crate) fn sweep(
        &self,
        limits: Limits,
        mut overlap: impl FnMut(u32, u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (mut looks, mut checks) = (0, 0);
        for (index, entry) in self.entries.iter().enumerate() {
            let (mut looks_here, mut checks_here) = (0, 0);
            for other in &self.entries[index + 1..] {
                if other.start > entry.end || looks_here >= limits.looks_each || checks_here >= limits.checks_each {
                    break;
                }
                looks_here += 1;
                if entry.overlaps(other) {
                    overlap(entry.robot, other.robot)?;
                    checks_here += 1;
                }
            }
            (looks, checks) = (looks + looks_here, checks + checks_here);
            if looks > limits.looks || checks > limits.checks {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}

impl Entry {
    /// Whether the boxes overlap and this is the first strip that both are in.
    fn overlaps(&self, other: &Self) -> bool {
        let (a, b) = (&self.bounds, &other.bounds);
        (a[0] <= b[2]) & (b[0] <= a[2]) & (a[1] <= b[3]) & (b[1] <= a[3]) & (self.is_first | other.is_first)
    }
}
