//! Which boxes of a strip overlap: sort and sweep.
//!
//! The boxes of a strip are sorted by their western sides: from there, those that each overlaps from west to east come
//! right behind it. They are looked at some at a time, without a branch for each: of a few near ones, nobody could guess
//! which overlap.

use std::ops::ControlFlow;

use crate::bounds::Bounds;
use crate::grid::Packing;
use crate::radix;
use crate::strips::{Mover, Strip};

/// Boxes that are looked at before it is asked whether there are more: about as many as there are in most cases.
const LOOKS: usize = 4;
/// Candidates that are collected before they are checked, if there are as many: so that the checks run on without a
/// break.
const BATCH: usize = 512;

/// What a sweep may cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Boxes that are looked at for each box, about at most.
    pub looks_each: usize,
    /// Overlaps that are told for each box, at most.
    pub checks_each: usize,
    /// Looks in all.
    pub looks: usize,
    /// Overlaps in all.
    pub checks: usize,
}

/// Robots whose boxes overlap, by their places in a strip.
pub(crate) type Candidates<'list> = &'list [[u32; 2]];

/// A strip's boxes in order.
#[derive(Debug, Default)]
pub(crate) struct Order {
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
    /// Strip and column of the box's western side, and of its eastern side.
    start: u32,
    end: u32,
    /// Of its robot in the strip.
    place: u32,
}

/// Behind the last one, so that there is always a full number to look at.
const NOBODY: Entry = Entry { bounds: Bounds::NOTHING, start: u32::MAX, end: 0, place: 0 };

impl Order {
    /// Takes the boxes of a strip. Without ways, they have these bounds.
    pub(crate) fn sort(&mut self, packing: &Packing, strip: &Strip, bounds: impl Fn(&Mover) -> Bounds) {
        let entry = |(place, mover): (u32, &Mover)| {
            let bounds = strip.ways.get(place as usize).map_or_else(|| bounds(mover), |way| way.bounds);
            let [start, end] = [bounds.west(), bounds.east()].map(|x| packing.pack(mover.strip(), x));
            Entry { bounds, start, end, place }
        };
        self.unsorted.clear();
        self.unsorted.extend((0..).zip(&strip.movers).map(entry));
        self.keys.clear();
        self.keys.extend(self.unsorted.iter().map(|entry| u64::from(entry.start) << 32 | u64::from(entry.place)));
        radix::sort(&mut self.keys, &mut self.scratch, 32..32 + packing.bits, |key| *key);
        self.entries.clear();
        self.entries.extend(self.keys.iter().map(|key| self.unsorted[*key as u32 as usize]));
        self.entries.extend([NOBODY; LOOKS]);
    }

    /// Tells which overlap.
    pub(crate) fn sweep(
        &mut self,
        left: &mut Limits,
        mut check: impl FnMut(Candidates) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Self { entries, candidates, .. } = self;
        candidates.resize(BATCH, [0; 2]);
        let mut filled = 0;
        for (index, entry) in entries[..entries.len() - LOOKS].iter().enumerate() {
            let (mut looks, mut checks) = (0, 0);
            for others in entries[index + 1..].as_chunks::<LOOKS>().0 {
                if filled + LOOKS > candidates.len() {
                    check(&candidates[..filled])?;
                    filled = 0;
                }
                let overlaps = overlaps(entry, others, &mut candidates[filled..]);
                (looks, checks, filled) = (looks + LOOKS, checks + overlaps, filled + overlaps);
                if checks >= left.checks_each {
                    filled -= checks - left.checks_each;
                    checks = left.checks_each;
                    break;
                }
                if others[LOOKS - 1].start > entry.end || looks >= left.looks_each {
                    break;
                }
            }
            if looks > left.looks || checks > left.checks {
                return ControlFlow::Break(());
            }
            (left.looks, left.checks) = (left.looks - looks, left.checks - checks);
        }
        check(&candidates[..filled])
    }
}

/// Writes down which of these boxes one overlaps, and returns how many. Each is written, and written over unless it
/// overlaps: a guess whether it does would often be wrong.
fn overlaps(entry: &Entry, others: &[Entry; LOOKS], room: &mut [[u32; 2]]) -> usize {
    let Some(room) = room.first_chunk_mut::<LOOKS>() else { return 0 };
    let (place, reach) = (entry.place, entry.bounds.reach());
    let mut filled = 0;
    for other in others {
        // It is never more than fits.
        room[filled % LOOKS] = [place, other.place];
        filled += usize::from(other.bounds.overlaps(reach));
    }
    filled
}
