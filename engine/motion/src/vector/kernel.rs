//! The stages of a tick over lanes, written once for every instruction set.

/// Declares a module with the stages over the lanes of one instruction set.
macro_rules! kernel {
    ($(#[$feature:meta])* $name:ident, $stream:ident) => {
        mod $name {
            use std::f32::consts::{FRAC_PI_2, PI, TAU};

            use crate::atan2::{BELOW_PI, COEFFICIENTS, LEAST};
            use crate::rows::{BLOCK, BlockLists, RowList};
            use crate::frame::{PoseColumns, WORDS_PER_LINE};
            use crate::piece::{Piece, TimeStep};
            use crate::pieces::{PieceLookup, REVERSE};
            use crate::profile::LAST_STEP;
            use crate::rows::Rows;
            use crate::scalar::METRES_PER_UNIT;
            use super::lanes::$name::*;
            use super::memory::{
                $stream, StoreMode, prefetch_later_block, prefetch_next_pages, prefetch_to_write,
            };

            #[inline]
            $(#[$feature])*
            fn load(from: &[f32; N]) -> F {
                bytemuck::cast(*from)
            }

            #[inline]
            $(#[$feature])*
            fn store(to: &mut [f32; N], value: F) {
                *to = bytemuck::cast(value);
            }

            const CHUNKS_PER_LINE: usize = WORDS_PER_LINE / N;

            /// A column of a frame. Nothing reads it before the frame's borrow ends.
            struct OutputColumn<'frame, S> {
                chunks: &'frame mut [F],
                mode: S,
                /// The chunks of the line that isn't complete yet. Stores past the cache that fill a
                /// line in parts, with other stores in between, are several times slower.
                line: [F; CHUNKS_PER_LINE],
            }

            impl<'frame, S: StoreMode<'frame>> OutputColumn<'frame, S> {
                /// Takes the first `count` chunks of a column.
                ///
                /// # Panics
                /// If it isn't a whole number of aligned chunks, or there are fewer.
                $(#[$feature])*
                fn new<T: bytemuck::Pod>(column: &'frame mut [T], count: usize, mode: S) -> Self {
                    let chunks = &mut bytemuck::cast_slice_mut(column)[..count];
                    Self { chunks, mode, line: [splat(0.0); CHUNKS_PER_LINE] }
                }

                /// Prefetches the line in the next block that `chunk` is to be followed by.
                #[inline]
                fn prefetch(&self, chunk: usize) {
                    prefetch_to_write(self.chunks[chunk..].as_ptr().wrapping_add(BLOCK / N));
                }

                #[inline]
                $(#[$feature])*
                fn put(&mut self, chunk: usize, value: F) {
                    let Some(fence) = self.mode.fence() else {
                        self.chunks[chunk] = value;
                        return;
                    };
                    let part = chunk * N % WORDS_PER_LINE / N;
                    self.line[part] = value;
                    if part + 1 == CHUNKS_PER_LINE {
                        let line = &mut self.chunks[chunk - part..][..CHUNKS_PER_LINE];
                        for (to, value) in line.iter_mut().zip(self.line) {
                            // SAFETY: `chunks` is private and only written, and its memory stays
                            // borrowed for `'frame`, which ends after the fence is dropped.
                            unsafe { $stream(fence, to, value) }
                        }
                    }
                }
            }

            /// See [`scalar::accelerate`](crate::scalar::accelerate).
            $(#[$feature])*
            pub fn accelerate(rows: &mut Rows, time_step: TimeStep, lists: &mut BlockLists) {
                let Some(limits) = &rows.limits else { return };
                let speed = rows.speed.as_chunks_mut::<N>().0;
                let count = speed.len();
                let w = &mut rows.w.as_chunks_mut::<N>().0[..count];
                let acceleration = &limits.acceleration.as_chunks::<N>().0[..count];
                let cruise = &limits.cruise.as_chunks::<N>().0[..count];
                let brake = &limits.brake.as_chunks::<N>().0[..count];
                let rest = &limits.rest.as_chunks::<N>().0[..count];
                let (units, unit) = (splat(0.5 * time_step.units), splat(METRES_PER_UNIT));
                for i in 0..count {
                    let (here, before) = (bytemuck::cast(w[i]), load(&speed[i]));
                    let rest = load(&rest[i]);
                    let a = load(&acceleration[i]);
                    let change = mul(a, splat(time_step.seconds));
                    let faster = min(add(before, change), load(&cruise[i]));
                    let wanted = max(faster, sub(before, change));
                    let most = round(mul(add(before, wanted), units));
                    let near = reaches(mul(to_float(add_int(here, most)), unit), rest, most);
                    let ahead = sub(mul(to_float(here), unit), rest);
                    let now = min(wanted, brake_speed(load(&brake[i]), a, change, before, ahead));
                    let step = round(mul(add(before, now), units));
                    let there = add_int(here, step);
                    store(&mut speed[i], select(near, before, now));
                    w[i] = bytemuck::cast(select_int(near, here, there));
                    lists.stopped.push_bits(i * N, stops(now, before) & !bits(near));
                    lists.arrived.push_bits(i * N, arrives(there, step) & !bits(near));
                    lists.near_leg_end.push_bits(i * N, bits(near));
                }
            }

            /// See [`brake_speed`](crate::profile::brake_speed).
            #[inline]
            $(#[$feature])*
            fn brake_speed(brake: F, acceleration: F, change: F, before: F, ahead: F) -> F {
                let spent = mul(change, sub(mul(splat(0.25), change), before));
                let square = add(spent, sub(brake, mul(add(acceleration, acceleration), ahead)));
                let speed = sub(sqrt(max(square, splat(0.0))), mul(splat(0.5), change));
                max(speed, mul(splat(LAST_STEP), change))
            }

            /// See [`scalar::advance`](crate::scalar::advance).
            $(#[$feature])*
            pub fn advance(rows: &mut Rows, time_step: TimeStep, arrived: &mut RowList) {
                let w = rows.w.as_chunks_mut::<N>().0;
                let count = w.len();
                let speed = &rows.speed.as_chunks::<N>().0[..count];
                for i in 0..count {
                    let step = round(mul(load(&speed[i]), splat(time_step.units)));
                    let there = add_int(bytemuck::cast(w[i]), step);
                    w[i] = bytemuck::cast(there);
                    arrived.push_bits(i * N, arrives(there, step));
                }
            }

            /// See [`scalar::write`](crate::scalar::write).
            $(#[$feature])*
            pub fn write<'frame, S: StoreMode<'frame>>(
                rows: &Rows,
                table: &[Piece],
                columns: PoseColumns<'frame>,
                mode: S,
            ) {
                match &rows.headings {
                    None => write_rows::<S, false>(rows, [&[], &[]], table, columns, mode),
                    Some(headings) => {
                        let rules = [&*headings.gain, &*headings.offset];
                        write_rows::<S, true>(rows, rules, table, columns, mode);
                    }
                }
            }

            /// Compiled once with and once without orientations: fleets without them, which are
            /// most, don't pay for them.
            $(#[$feature])*
            fn write_rows<'frame, S: StoreMode<'frame>, const ORIENTED: bool>(
                rows: &Rows,
                rules: [&[f32]; 2],
                table: &[Piece],
                columns: PoseColumns<'frame>,
                mode: S,
            ) {
                if mode.fence().is_some() {
                    prefetch_next_pages(&columns);
                }
                let count = columns.x.len() / N;
                let states = columns.state.len();
                let mut x = OutputColumn::new(columns.x, count, mode);
                let mut y = OutputColumn::new(columns.y, count, mode);
                let mut theta = OutputColumn::new(columns.theta, count, mode);
                let mut speed_out = OutputColumn::new(columns.speed, count, mode);
                let mut s_out = OutputColumn::new(columns.s, count, mode);
                let mut edge_out = OutputColumn::new(columns.edge, count, mode);
                let piece: PieceLookup<N> = rows.piece.lookup(table, count);
                let w = &rows.w.as_chunks::<N>().0[..count];
                let speed = &rows.speed.as_chunks::<N>().0[..count];
                let s_end = &rows.s_end.as_chunks::<N>().0[..count];
                let edge = &rows.edge.as_chunks::<N>().0[..count];
                let looks_ahead = rows.limits.is_none();
                let rule_count = if ORIENTED { count } else { 0 };
                let [gain, offset] = rules.map(|rule| &rule.as_chunks::<N>().0[..rule_count]);
                for i in 0..count {
                    if (i * N).is_multiple_of(WORDS_PER_LINE) {
                        prefetch_later_block(piece.signs(i).as_ptr(), looks_ahead);
                        prefetch_later_block(w[i].as_ptr(), looks_ahead);
                        prefetch_later_block(speed[i].as_ptr(), looks_ahead);
                        prefetch_later_block(s_end[i].as_ptr(), looks_ahead);
                        prefetch_later_block(edge[i].as_ptr(), looks_ahead);
                        if S::PREFETCHES {
                            x.prefetch(i);
                            y.prefetch(i);
                            theta.prefetch(i);
                            speed_out.prefetch(i);
                            s_out.prefetch(i);
                            edge_out.prefetch(i);
                        }
                    }
                    let [cx, cy] = coefficients(piece.pieces(i));
                    let sign: I = bytemuck::cast(*piece.signs(i));
                    let metres = mul(to_float(bytemuck::cast(w[i])), splat(METRES_PER_UNIT));
                    x.put(i, place(cx, metres));
                    y.put(i, place(cy, metres));
                    let (dy, dx) = (slope(cy, metres), slope(cx, metres));
                    let tangent = atan2(flip(dy, sign), flip(dx, sign));
                    let heading =
                        if ORIENTED { oriented(tangent, &gain[i], &offset[i]) } else { tangent };
                    theta.put(i, heading);
                    speed_out.put(i, add(flip(load(&speed[i]), sign), splat(0.0)));
                    s_out.put(i, add(load(&s_end[i]), flip(metres, sign)));
                    edge_out.put(i, bytemuck::cast(edge[i]));
                }
                let state: &[[u8; 4 * N]] = rows.state[..states].as_chunks().0;
                let mut state_out = OutputColumn::new(columns.state, state.len(), mode);
                for (i, from) in state.iter().enumerate() {
                    state_out.put(i, bytemuck::cast(*from));
                }
            }

            /// Fills a column of a frame.
            $(#[$feature])*
            pub fn fill<'frame, S: StoreMode<'frame>>(
                column: &'frame mut [f32],
                value: f32,
                mode: S,
            ) {
                let count = column.len() / N;
                let mut out = OutputColumn::new(column, count, mode);
                for i in 0..count {
                    out.put(i, splat(value));
                }
            }

            #[inline]
            $(#[$feature])*
            fn place(c: [F; 4], w: F) -> F {
                add(c[0], mul(w, add(c[1], mul(w, add(c[2], mul(w, c[3]))))))
            }

            #[inline]
            $(#[$feature])*
            fn slope(c: [F; 4], w: F) -> F {
                add(c[1], mul(w, add(add(c[2], c[2]), mul(w, mul(splat(3.0), c[3])))))
            }

            /// See [`HeadingRule::heading`](crate::headings::HeadingRule::heading).
            #[inline]
            $(#[$feature])*
            fn oriented(tangent: F, gain: &[f32; N], offset: &[f32; N]) -> F {
                wrap(add(mul(tangent, load(gain)), load(offset)))
            }

            /// See [`wrap`](crate::headings::wrap).
            #[inline]
            $(#[$feature])*
            fn wrap(angle: F) -> F {
                let below = select(lt(splat(PI), angle), sub(angle, splat(TAU)), angle);
                let above = select(lt(below, splat(-BELOW_PI)), add(below, splat(TAU)), below);
                min(max(above, splat(-BELOW_PI)), splat(PI))
            }

            #[inline]
            $(#[$feature])*
            fn linear(a: f32, b: f32, u: F) -> F {
                add(splat(a), mul(splat(b), u))
            }

            /// See [`atan2`](crate::atan2::atan2).
            #[inline]
            $(#[$feature])*
            fn atan2(y: F, x: F) -> F {
                let (ax, ay) = (abs(x), abs(y));
                let t = div(min(ax, ay), max(max(ax, ay), splat(f32::MIN_POSITIVE)));
                let u = max(t, splat(LEAST));
                let u = mul(u, u);
                let v = mul(u, u);
                let [c0, c1, c2, c3, c4, c5, c6] = COEFFICIENTS;
                let low = add(linear(c0, c1, u), mul(v, linear(c2, c3, u)));
                let high = add(linear(c4, c5, u), mul(v, splat(c6)));
                let octant = mul(add(low, mul(mul(v, v), high)), t);
                let quadrant = select(lt(ax, ay), sub(splat(FRAC_PI_2), octant), octant);
                let half = select(lt(x, splat(0.0)), sub(splat(PI), quadrant), quadrant);
                let negative = flip(half, bytemuck::cast([REVERSE; N]));
                let whole = select(lt(y, splat(0.0)), negative, half);
                max(whole, splat(-BELOW_PI))
            }
        }
    };
}

pub(super) use kernel;
