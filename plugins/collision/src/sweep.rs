//! The broad phase: sort and sweep finds the boxes of a strip that overlap.
//!
//! The boxes of a strip are sorted by their western sides, so that the boxes that one overlaps from
//! west to east follow right behind it. They are compared in groups, without a branch for each: the
//! CPU could not predict which of a few nearby boxes overlap.

use std::ops::ControlFlow;

use crate::bounds::Bounds;
use crate::grid::KeyPacking;
use crate::radix;
use crate::strip_index::{PackedRobot, Strip};

/// Number of boxes that are compared before the loop tests whether there are more: about as many as
/// one box usually has to be compared to.
const GROUP: usize = 4;
/// Number of candidates that are collected before they are checked, so that the checks run in long
/// batches.
const BATCH: usize = 512;

/// Limits on the work of a sweep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Largest number of boxes that each box is compared to, rounded up to a whole group.
    pub comparisons_per_robot: usize,
    /// Largest number of overlaps that are reported for each box.
    pub checks_per_robot: usize,
    /// Largest number of comparisons of the whole frame.
    pub comparisons: usize,
    /// Largest number of overlaps of the whole frame.
    pub checks: usize,
}

/// Pairs of robots whose boxes overlap, by their slots in a strip.
pub(crate) type Candidates<'list> = &'list [[u32; 2]];

/// The sorted boxes of a strip, with the memory that sorting needs.
#[derive(Debug, Default)]
pub(crate) struct SortAndSweep {
    keys: Vec<u64>,
    scratch: Vec<u64>,
    unsorted: Vec<Entry>,
    entries: Vec<Entry>,
    candidates: Vec<[u32; 2]>,
}

/// A box in a strip.
#[derive(Clone, Copy, Debug)]
struct Entry {
    bounds: Bounds,
    /// Packed strip and cell of the box's western side.
    start: u32,
    /// Packed strip and cell of the box's eastern side.
    end: u32,
    /// Slot of its robot in the strip.
    slot: u32,
}

/// The entry that fills up the last group.
const SENTINEL: Entry = Entry { bounds: Bounds::NOTHING, start: u32::MAX, end: 0, slot: 0 };

impl SortAndSweep {
    /// Sorts the boxes of a strip. Robots without swept paths have the boxes that `bounds` returns.
    pub(crate) fn sort(
        &mut self,
        packing: &KeyPacking,
        strip: &Strip,
        bounds: impl Fn(&PackedRobot) -> Bounds,
    ) {
        self.unsorted.clear();
        self.unsorted.extend((0..).zip(&strip.robots).map(|(slot, robot): (u32, _)| {
            let swept_path = strip.swept_paths.get(slot as usize);
            let bounds = swept_path.map_or_else(|| bounds(robot), |path| path.bounds);
            let [start, end] =
                [bounds.west(), bounds.east()].map(|x| packing.pack(robot.strip(), x));
            Entry { bounds, start, end, slot }
        }));
        self.keys.clear();
        self.keys.extend(
            self.unsorted.iter().map(|entry| u64::from(entry.start) << 32 | u64::from(entry.slot)),
        );
        radix::sort(&mut self.keys, &mut self.scratch, 32..32 + packing.bits, |key| *key);
        self.entries.clear();
        self.entries.extend(self.keys.iter().map(|key| self.unsorted[*key as u32 as usize]));
        self.entries.extend([SENTINEL; GROUP]);
    }

    /// Passes the pairs of boxes that overlap to `check`, in batches.
    pub(crate) fn sweep(
        &mut self,
        left: &mut Limits,
        mut check: impl FnMut(Candidates) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Self { entries, candidates, .. } = self;
        candidates.resize(BATCH, [0; 2]);
        let mut filled = 0;
        for (index, entry) in entries[..entries.len() - GROUP].iter().enumerate() {
            let (mut comparisons, mut checks) = (0, 0);
            for others in entries[index + 1..].as_chunks::<GROUP>().0 {
                if filled + GROUP > candidates.len() {
                    check(&candidates[..filled])?;
                    filled = 0;
                }
                let overlaps = overlaps(entry, others, &mut candidates[filled..]);
                (comparisons, checks, filled) =
                    (comparisons + GROUP, checks + overlaps, filled + overlaps);
                if checks >= left.checks_per_robot {
                    filled -= checks - left.checks_per_robot;
                    checks = left.checks_per_robot;
                    break;
                }
                if others[GROUP - 1].start > entry.end || comparisons >= left.comparisons_per_robot
                {
                    break;
                }
            }
            if comparisons > left.comparisons || checks > left.checks {
                return ControlFlow::Break(());
            }
            (left.comparisons, left.checks) =
                (left.comparisons - comparisons, left.checks - checks);
        }
        check(&candidates[..filled])
    }
}

/// Writes the pairs of a box and the boxes of a group that it overlaps, and returns their number.
/// Every pair is written, and overwritten unless it overlaps: a branch on the overlap would often
/// be mispredicted.
fn overlaps(entry: &Entry, others: &[Entry; GROUP], output: &mut [[u32; 2]]) -> usize {
    let Some(output) = output.first_chunk_mut::<GROUP>() else { return 0 };
    let (slot, limit) = (entry.slot, entry.bounds.overlap_limit());
    let mut filled = 0;
    for other in others {
        // The remainder never changes the index, and spares the bounds check.
        output[filled % GROUP] = [slot, other.slot];
        filled += usize::from(other.bounds.overlaps(limit));
    }
    filled
}
