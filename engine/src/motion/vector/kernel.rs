//! The stages of a tick over lanes, written once for every instruction set.

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

            /// Stores past the cache if `PAST`, which takes columns that start on a cache line.
            #[inline]
            #$feature
            fn put<const PAST: bool>(to: &mut [f32; N], value: F) {
                if PAST {
                    $stream(to, value);
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

pub(super) use kernel;
