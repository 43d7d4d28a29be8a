//! The stages of a tick, several rows at a time.
//!
//! Each is written once, over lanes, and compiled for each instruction set. The operations and their order are those
//! of [`scalar`](super::scalar), so the bits are the same.
//!
//! This is the one file of the engine with `unsafe` code: to call what the machine has been found to have, to read
//! rows of pieces without looking at the table's length each time, and to write past the cache.
#![allow(unsafe_code, reason = "calls of code for instruction sets, unchecked rows and stores past the cache")]

#[cfg(target_arch = "x86_64")]
#[path = "vector/avx2.rs"]
mod avx2_lanes;
#[cfg(target_arch = "x86_64")]
#[path = "vector/avx512.rs"]
mod avx512_lanes;
#[path = "vector/ops.rs"]
mod ops;
#[cfg(any(test, not(target_arch = "x86_64")))]
#[path = "vector/portable.rs"]
mod portable_lanes;
#[cfg(target_arch = "x86_64")]
#[path = "vector/sse2.rs"]
mod sse2_lanes;

use regatta_plugin::frame::{ColumnsMut, WORDS_PER_LINE};

use super::atan2::{BELOW_PI, COEFFICIENTS, LEAST};
use super::profile::LAST_STEP;
use super::{BLOCK, Isa, Listed, Lists, METRES_PER_UNIT, Motion, PIECE, Pace, REVERSE, Rows, scalar};
use crate::graph::arc_length::Piece;

/// The stages over the lanes of one instruction set.
macro_rules! kernel {
    ($name:ident, $lanes:ident, #$feature:tt, $stream:expr) => {
        mod $name {
            use std::f32::consts::{FRAC_PI_2, PI};

            use super::$lanes::*;
            use super::*;

            #[inline]
            #$feature
            fn load(from: &[f32; N]) -> F {
                bytemuck::cast(*from)
            }

            #[inline]
            #$feature
            fn store(to: &mut [f32; N], value: F) {
                *to = bytemuck::cast(value);
            }

            /// Stores past the cache if `PAST`.
            #[inline]
            #$feature
            fn put<const PAST: bool>(to: &mut [f32; N], value: F) {
                if PAST {
                    // SAFETY: `to` has room for a vector, and lies on a multiple of its size: the caller of `write`
                    // asks for `PAST` only with columns that start on a cache line.
                    unsafe { $stream(to.as_mut_ptr(), value) }
                } else {
                    store(to, value);
                }
            }

            /// See [`scalar::accelerate`].
            #$feature
            pub fn accelerate(rows: &mut Rows, pace: Pace, lists: &mut Lists) {
                let Some(limits) = &rows.limits else { return };
                let speed = rows.speed.as_chunks_mut::<N>().0;
                let count = speed.len();
                let w = &mut rows.w.as_chunks_mut::<N>().0[..count];
                let acceleration = &limits.acceleration.as_chunks::<N>().0[..count];
                let cruise = &limits.cruise.as_chunks::<N>().0[..count];
                let brake = &limits.brake.as_chunks::<N>().0[..count];
                let rest = &limits.rest.as_chunks::<N>().0[..count];
                let (units, unit) = (splat(0.5 * pace.units), splat(METRES_PER_UNIT));
                for i in 0..count {
                    let (here, before, rest) = (bytemuck::cast(w[i]), load(&speed[i]), load(&rest[i]));
                    let a = load(&acceleration[i]);
                    let change = mul(a, splat(pace.seconds));
                    let wanted = max(min(add(before, change), load(&cruise[i])), sub(before, change));
                    let most = round(mul(add(before, wanted), units));
                    let near = reaches(mul(to_float(add_int(here, most)), unit), rest, most);
                    let ahead = sub(mul(to_float(here), unit), rest);
                    let now = min(wanted, brake_speed(load(&brake[i]), a, change, before, ahead));
                    let step = round(mul(add(before, now), units));
                    let there = add_int(here, step);
                    store(&mut speed[i], select(near, before, now));
                    w[i] = bytemuck::cast(select_int(near, here, there));
                    lists.stood.push_bits(i * N, stood(now, before) & !bits(near));
                    lists.arrived.push_bits(i * N, arrived(there, step) & !bits(near));
                    lists.near.push_bits(i * N, bits(near));
                }
            }

            /// See [`brake_speed`](super::super::profile::brake_speed).
            #[inline]
            #$feature
            fn brake_speed(brake: F, acceleration: F, change: F, before: F, ahead: F) -> F {
                let spent = mul(change, sub(mul(splat(0.25), change), before));
                let square = add(spent, sub(brake, mul(add(acceleration, acceleration), ahead)));
                let speed = sub(sqrt(max(square, splat(0.0))), mul(splat(0.5), change));
                max(speed, mul(splat(LAST_STEP), change))
            }

            /// See [`scalar::advance`].
            #$feature
            pub fn advance(rows: &mut Rows, pace: Pace, listed: &mut Listed) {
                let w = rows.w.as_chunks_mut::<N>().0;
                let count = w.len();
                let speed = &rows.speed.as_chunks::<N>().0[..count];
                for i in 0..count {
                    let step = round(mul(load(&speed[i]), splat(pace.units)));
                    let there = add_int(bytemuck::cast(w[i]), step);
                    w[i] = bytemuck::cast(there);
                    listed.push_bits(i * N, arrived(there, step));
                }
            }

            /// See [`scalar::write`].
            #$feature
            pub fn write<const PAST: bool>(rows: &Rows, pieces: &[Piece], columns: ColumnsMut) {
                if PAST {
                    fetch_pages_ahead(&columns);
                }
                let x = columns.x.as_chunks_mut::<N>().0;
                let count = x.len();
                let y = &mut columns.y.as_chunks_mut::<N>().0[..count];
                let theta = &mut columns.theta.as_chunks_mut::<N>().0[..count];
                let speed_out = &mut columns.speed.as_chunks_mut::<N>().0[..count];
                let s_out = &mut columns.s.as_chunks_mut::<N>().0[..count];
                let edge_out: &mut [f32] = bytemuck::cast_slice_mut(columns.edge);
                let edge_out = &mut edge_out.as_chunks_mut::<N>().0[..count];
                let piece = &rows.piece.as_chunks::<N>().0[..count];
                let w = &rows.w.as_chunks::<N>().0[..count];
                let speed = &rows.speed.as_chunks::<N>().0[..count];
                let s_end = &rows.s_end.as_chunks::<N>().0[..count];
                let edge = &rows.edge.as_chunks::<N>().0[..count];
                for i in 0..count {
                    if (i * N).is_multiple_of(WORDS_PER_LINE) {
                        fetch_ahead(piece[i].as_ptr());
                        fetch_ahead(w[i].as_ptr());
                        fetch_ahead(speed[i].as_ptr());
                        fetch_ahead(s_end[i].as_ptr());
                        fetch_ahead(edge[i].as_ptr());
                    }
                    let [cx, cy] = coefficients(table_rows(pieces, &piece[i]));
                    let sign: I = bytemuck::cast(piece[i]);
                    let metres = mul(to_float(bytemuck::cast(w[i])), splat(METRES_PER_UNIT));
                    put::<PAST>(&mut x[i], place(cx, metres));
                    put::<PAST>(&mut y[i], place(cy, metres));
                    let heading = atan2(flip(slope(cy, metres), sign), flip(slope(cx, metres), sign));
                    put::<PAST>(&mut theta[i], heading);
                    put::<PAST>(&mut speed_out[i], add(flip(load(&speed[i]), sign), splat(0.0)));
                    put::<PAST>(&mut s_out[i], add(load(&s_end[i]), flip(metres, sign)));
                    put::<PAST>(&mut edge_out[i], bytemuck::cast(edge[i]));
                }
                let state: &[f32] = bytemuck::cast_slice(&rows.state[..columns.state.len()]);
                let state_out: &mut [f32] = bytemuck::cast_slice_mut(columns.state);
                for (to, from) in state_out.as_chunks_mut::<N>().0.iter_mut().zip(state.as_chunks::<N>().0) {
                    put::<PAST>(to, load(from));
                }
            }

            #[inline]
            #$feature
            fn place(c: [F; 4], w: F) -> F {
                add(c[0], mul(w, add(c[1], mul(w, add(c[2], mul(w, c[3]))))))
            }

            #[inline]
            #$feature
            fn slope(c: [F; 4], w: F) -> F {
                add(c[1], mul(w, add(add(c[2], c[2]), mul(w, mul(splat(3.0), c[3])))))
            }

            /// See [`atan2`](super::super::atan2::atan2).
            #[inline]
            #$feature
            fn atan2(y: F, x: F) -> F {
                let (ax, ay) = (abs(x), abs(y));
                let t = div(min(ax, ay), max(max(ax, ay), splat(f32::MIN_POSITIVE)));
                let u = max(t, splat(LEAST));
                let u = mul(u, u);
                let v = mul(u, u);
                let [c0, c1, c2, c3, c4, c5, c6] = COEFFICIENTS;
                let pair = |a: f32, b: f32| add(splat(a), mul(splat(b), u));
                let low = add(pair(c0, c1), mul(v, pair(c2, c3)));
                let high = add(pair(c4, c5), mul(v, splat(c6)));
                let octant = mul(add(low, mul(mul(v, v), high)), t);
                let quadrant = select(lt(ax, ay), sub(splat(FRAC_PI_2), octant), octant);
                let half = select(lt(x, splat(0.0)), sub(splat(PI), quadrant), quadrant);
                let whole = select(lt(y, splat(0.0)), flip(half, bytemuck::cast([REVERSE; N])), half);
                max(whole, splat(-BELOW_PI))
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
kernel!(baseline, sse2_lanes, #[target_feature(enable = "sse2")], std::arch::x86_64::_mm_stream_ps);
#[cfg(target_arch = "x86_64")]
kernel!(avx2, avx2_lanes, #[target_feature(enable = "avx2")], std::arch::x86_64::_mm256_stream_ps);
#[cfg(target_arch = "x86_64")]
kernel!(
    avx512,
    avx512_lanes,
    #[target_feature(enable = "avx512f,avx512dq")],
    std::arch::x86_64::_mm512_stream_ps
);
#[cfg(any(test, not(target_arch = "x86_64")))]
kernel!(portable, portable_lanes, #[allow(unused_unsafe, reason = "nothing here needs it")], store_plainly);

/// Stands in where there are no stores past the cache.
#[cfg(any(test, not(target_arch = "x86_64")))]
unsafe fn store_plainly(to: *mut f32, value: [f32; 4]) {
    // SAFETY: the caller's `to` has room for a vector.
    unsafe { to.cast::<[f32; 4]>().write(value) }
}

impl Listed {
    /// Lists a row per bit, from row `first` on.
    #[inline]
    fn push_bits(&mut self, first: usize, mut bits: u32) {
        while bits != 0 {
            self.push(first + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }
}

/// The rows of the table that the robots are on.
#[inline]
fn table_rows<'table, const N: usize>(pieces: &'table [Piece], numbers: &[u32; N]) -> [&'table Piece; N] {
    let mut rows = [&pieces[0]; N];
    for (row, &number) in rows.iter_mut().zip(numbers) {
        let number = (number & PIECE) as usize;
        debug_assert!(number < pieces.len());
        // SAFETY: what stands in the column comes from the table's own tracks, and the table has no more rows than
        // `PIECE` can tell apart.
        *row = unsafe { pieces.get_unchecked(number) };
    }
    rows
}

/// Calls a stage in the kernel of an instruction set.
macro_rules! dispatch {
    ($isa:expr, $scalar:expr, $stage:ident $(::<$past:literal>)? ($($argument:expr),*)) => {
        match $isa {
            Isa::Scalar => $scalar,
            // SAFETY: a fleet is set up only with an instruction set that this machine has been found to have.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => unsafe { avx2::$stage$(::<$past>)?($($argument),*) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => unsafe { avx512::$stage$(::<$past>)?($($argument),*) },
            // SAFETY: every x86-64 machine has SSE2.
            #[cfg(target_arch = "x86_64")]
            Isa::Baseline => unsafe { baseline::$stage$(::<$past>)?($($argument),*) },
            #[cfg(not(target_arch = "x86_64"))]
            _ => portable::$stage$(::<$past>)?($($argument),*),
        }
    };
}

impl Motion {
    /// Stage 1 under acceleration limits.
    pub(super) fn accelerate(&self, block: &mut Rows, lists: &mut Lists) {
        let pace = self.pace;
        dispatch!(self.isa, scalar::accelerate(block, pace, lists), accelerate(block, pace, lists));
    }

    /// Stage 1.
    pub(super) fn advance(&self, block: &mut Rows, arrived: &mut Listed) {
        let pace = self.pace;
        dispatch!(self.isa, scalar::advance(block, pace, arrived), advance(block, pace, arrived));
    }

    /// Stage 3; past the cache if `past`, which must be followed by [`settle`].
    pub(super) fn write_block(&self, block: &Rows, columns: ColumnsMut, past: bool) {
        let pieces = self.roads.pieces();
        if past && starts_lines(&columns) {
            dispatch!(self.isa, scalar::write(block, pieces, columns), write::<true>(block, pieces, columns));
        } else {
            dispatch!(self.isa, scalar::write(block, pieces, columns), write::<false>(block, pieces, columns));
        }
    }
}

impl Motion {
    /// Has what the hand-over of these rows will look up on its way to the cache.
    pub(super) fn fetch(&self, block: &Rows, listed: &Listed) {
        for row in listed.rows() {
            fetch(&self.roads.stretches()[(block.piece[row] & PIECE) as usize]);
            fetch(&block.route[row]);
            fetch(&block.kind[row]);
            fetch(&block.s_end[row]);
        }
    }
}

/// Has the value that stands in the same column and place of the next block on its way to the cache: the machine's
/// own look-ahead ends with the page.
#[inline]
fn fetch_ahead<T>(value: *const T) {
    fetch(value.wrapping_add(BLOCK));
}

/// Has the machine look up the pages that the next block will be written to, one line of each, while there is time.
fn fetch_pages_ahead(columns: &ColumnsMut) {
    const LAST_OF_NEXT: usize = 2 * BLOCK - 1;
    for column in [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s] {
        fetch(column.as_ptr().wrapping_add(LAST_OF_NEXT));
    }
    fetch(columns.edge.as_ptr().wrapping_add(LAST_OF_NEXT));
    fetch(columns.state.as_ptr().wrapping_add(LAST_OF_NEXT));
}

/// Has a value on its way to the cache.
#[inline]
fn fetch<T>(value: *const T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 machine has SSE, and a prefetch of any address only hints.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(value.cast()) }
    }
}

/// Whether every column starts on a cache line.
fn starts_lines(columns: &ColumnsMut) -> bool {
    let metres = [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s];
    let starts = metres.map(|column| column.as_ptr().addr());
    let others = [columns.edge.as_ptr().addr(), columns.state.as_ptr().addr()];
    starts.iter().chain(&others).all(|start| start % 64 == 0)
}

/// Makes stores past the cache visible before any store that follows.
pub(super) fn settle() {
    // SAFETY: every x86-64 machine has SSE.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::testing::*;
    use crate::fleet::{Fleet, Placement, RouteSource};
    use crate::graph::NodeIndex;

    /// The first two stages.
    fn move_on(
        fleet: &mut Fleet,
        accelerate: fn(&mut Rows, Pace, &mut Lists),
        advance: fn(&mut Rows, Pace, &mut Listed),
    ) {
        let (motion, mut rows) = fleet.parts();
        let mut lists = Lists::new();
        if rows.limits.is_some() {
            accelerate(&mut rows, motion.pace, &mut lists);
        } else {
            advance(&mut rows, motion.pace, &mut lists.arrived);
        }
        lists.near.rows().for_each(|row| motion.hand_over_limited(&mut rows, row, &mut events()));
        lists.arrived.rows().for_each(|row| motion.hand_over(&mut rows, row, &mut events()));
    }

    /// The lanes of machines without SSE2, here too.
    #[test]
    fn portable_lanes_give_the_bits_of_the_reference() {
        let graph = town(4, 6.0);
        for acceleration in [0.7, f32::INFINITY] {
            let types = vec![robot_type(f32::INFINITY, f32::INFINITY), robot_type(1.0, acceleration)];
            let [mut plain, mut lanes] = [(); 2].map(|()| fleet(&graph, config(types.clone())));
            for robot in 0..100 {
                let (place, kind) = (Placement::Node(NodeIndex(robot % 16)), robot as u16 % 2);
                for fleet in [&mut plain, &mut lanes] {
                    fleet.spawn(place, kind, RouteSource::Random, 0, &mut events()).expect("a node");
                }
            }
            for _ in 0..2000 {
                move_on(&mut plain, scalar::accelerate, scalar::advance);
                move_on(&mut lanes, portable::accelerate, portable::advance);
                let [mut one, mut other] = [Frame::of(&plain), Frame::of(&lanes)];
                let (motion, rows) = plain.parts();
                scalar::write(&rows, motion.roads.pieces(), one.columns_mut());
                let (motion, rows) = lanes.parts();
                portable::write::<false>(&rows, motion.roads.pieces(), other.columns_mut());
                assert_eq!(bits(&one), bits(&other));
            }
        }
    }
}
