//! The stages of a tick, row by row: the reference that the vector code has to match bit by bit.

use super::atan2::atan2;
use super::headings::HeadingRule;
use super::profile::brake_speed;
use super::rows::Rows;
use super::rows::{BlockLists, RowList};
use crate::frame::PoseColumns;
use crate::piece::{Distance, Piece, TimeStep, slope, value};

/// Metres in one unit of [`Distance`]; a power of two, so scaling by it is exact.
pub(super) const METRES_PER_UNIT: f32 = 1.0 / (1u32 << 27) as f32;

/// Stage 1 under acceleration limits: sets new speeds, and `w += (old + new speed) / 2 · Δt`. Rows
/// that may reach the end of their leg are only listed.
pub(super) fn accelerate(rows: &mut Rows, time_step: TimeStep, lists: &mut BlockLists) {
    let Some(limits) = &rows.limits else { return };
    for row in 0..rows.w.len() {
        let (before, here, rest) = (rows.speed[row], rows.w[row], limits.rest[row]);
        let acceleration = limits.acceleration[row];
        let change = acceleration * time_step.seconds;
        let wanted = (before + change).min(limits.cruise[row]).max(before - change);
        let most = time_step.distance(before, wanted);
        if (here + most) as f32 * METRES_PER_UNIT >= rest && most > 0 {
            lists.near_leg_end.push(row);
            continue;
        }
        let ahead = here as f32 * METRES_PER_UNIT - rest;
        let now = wanted.min(brake_speed(limits.brake[row], acceleration, change, before, ahead));
        let step = time_step.distance(before, now);
        rows.speed[row] = now;
        rows.w[row] = here + step;
        if now == 0.0 && before > 0.0 {
            lists.stopped.push(row);
        }
        if here + step >= 0 && step > 0 {
            lists.arrived.push(row);
        }
    }
}

/// Stage 1: `w += speed · Δt`. Lists the rows that reach the end of their piece.
pub(super) fn advance(rows: &mut Rows, time_step: TimeStep, arrived: &mut RowList) {
    for row in 0..rows.w.len() {
        let step = (rows.speed[row] * time_step.units).round_ties_even() as i32;
        let w = rows.w[row] + step;
        rows.w[row] = w;
        if w >= 0 && step > 0 {
            arrived.push(row);
        }
    }
}

/// Stage 3: writes poses into the frame.
pub(super) fn write(rows: &Rows, table: &[Piece], columns: PoseColumns) {
    for row in 0..columns.x.len() {
        let index = rows.piece.get(row);
        let (piece, sign) = (&table[index.row()], index.sign_bit());
        let w = rows.w[row] as f32 * METRES_PER_UNIT;
        columns.x[row] = value(&piece.x, w);
        columns.y[row] = value(&piece.y, w);
        let (x, y) = direction(piece, Distance(rows.w[row]), sign);
        let tangent = atan2(y, x);
        columns.theta[row] = match &rows.headings {
            None => tangent,
            Some(headings) => {
                HeadingRule { gain: headings.gain[row], offset: headings.offset[row] }
                    .heading(tangent)
            }
        };
        columns.speed[row] = flip(rows.speed[row], sign) + 0.0;
        columns.s[row] = rows.s_end[row] + flip(w, sign);
        columns.edge[row] = rows.edge[row];
    }
    columns.state.copy_from_slice(&rows.state[..columns.state.len()]);
}

/// Returns the direction of a robot on a piece, not normalized: the derivative, negated if `sign`
/// has the sign bit.
pub(super) fn direction(piece: &Piece, w: Distance, sign: u32) -> (f32, f32) {
    let w = w.0 as f32 * METRES_PER_UNIT;
    (flip(slope(&piece.x, w), sign), flip(slope(&piece.y, w), sign))
}

/// Returns the negative of a value if `sign` has the sign bit.
#[inline]
fn flip(value: f32, sign: u32) -> f32 {
    f32::from_bits(value.to_bits() ^ sign)
}
