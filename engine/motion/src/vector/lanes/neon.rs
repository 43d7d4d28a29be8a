//! Four lanes of NEON, which every 64-bit Arm machine has.

use std::arch::aarch64::*;

use crate::piece::Piece;

/// Number of lanes: rows at a time.
pub const N: usize = 4;
/// A register of floats.
pub type F = float32x4_t;
/// A register of integers.
pub type I = int32x4_t;
/// A mask: in each lane all bits are set, or none.
pub type M = uint32x4_t;

ops! {
    #[target_feature(enable = "neon")]
    fn splat(a: f32) -> F { vdupq_n_f32(a) }
    fn add(a: F, b: F) -> F { vaddq_f32(a, b) }
    fn sub(a: F, b: F) -> F { vsubq_f32(a, b) }
    fn mul(a: F, b: F) -> F { vmulq_f32(a, b) }
    fn div(a: F, b: F) -> F { vdivq_f32(a, b) }
    fn min(a: F, b: F) -> F { vminq_f32(a, b) }
    fn max(a: F, b: F) -> F { vmaxq_f32(a, b) }
    fn sqrt(a: F) -> F { vsqrtq_f32(a) }
    fn abs(a: F) -> F { vabsq_f32(a) }
    /// Returns `a`, negated where bit 31 of `sign` is set.
    fn flip(a: F, sign: I) -> F {
        let sign_bit = vandq_u32(vreinterpretq_u32_s32(sign), vdupq_n_u32(1 << 31));
        vreinterpretq_f32_u32(veorq_u32(vreinterpretq_u32_f32(a), sign_bit))
    }
    fn lt(a: F, b: F) -> M { vcltq_f32(a, b) }
    fn select(mask: M, yes: F, no: F) -> F { vbslq_f32(mask, yes, no) }
    fn to_float(a: I) -> F { vcvtq_f32_s32(a) }
    /// Rounds to the nearest integer, ties to even.
    fn round(a: F) -> I { vcvtnq_s32_f32(a) }
    fn add_int(a: I, b: I) -> I { vaddq_s32(a, b) }
    /// Returns a bit per lane: `a` ≥ 0 and `b` > 0.
    fn arrives(a: I, b: I) -> u32 { bits(vandq_u32(vcgezq_s32(a), vcgtzq_s32(b))) }
    fn select_int(mask: M, yes: I, no: I) -> I { vbslq_s32(mask, yes, no) }
    /// Returns a bit per lane.
    fn bits(mask: M) -> u32 { vaddvq_u32(vandq_u32(mask, bytemuck::cast([1_u32, 2, 4, 8]))) }
    /// Returns a mask: `a` ≥ `b` and `moved` > 0.
    fn reaches(a: F, b: F, moved: I) -> M { vandq_u32(vcgeq_f32(a, b), vcgtzq_s32(moved)) }
    /// Returns a bit per lane: `now` is 0 and `before` > 0.
    fn stops(now: F, before: F) -> u32 { bits(vandq_u32(vceqzq_f32(now), vcgtzq_f32(before))) }
    /// Returns the coefficients of x and of y, by power.
    fn coefficients(rows: [&Piece; N]) -> [[F; 4]; 2] {
        let [a, b, c, d] = rows;
        [
            transpose([row(a.x), row(b.x), row(c.x), row(d.x)]),
            transpose([row(a.y), row(b.y), row(c.y), row(d.y)]),
        ]
    }
    fn row(row: [f32; 4]) -> F { bytemuck::cast(row) }
    fn transpose(rows: [F; 4]) -> [F; 4] {
        let [a, b, c, d] = rows;
        let (ab_even, cd_even) = (vtrn1q_f32(a, b), vtrn1q_f32(c, d));
        let (ab_odd, cd_odd) = (vtrn2q_f32(a, b), vtrn2q_f32(c, d));
        [low(ab_even, cd_even), low(ab_odd, cd_odd), high(ab_even, cd_even), high(ab_odd, cd_odd)]
    }
    /// Returns the lower halves of both.
    fn low(a: F, b: F) -> F {
        vreinterpretq_f32_f64(vtrn1q_f64(vreinterpretq_f64_f32(a), vreinterpretq_f64_f32(b)))
    }
    /// Returns the upper halves of both.
    fn high(a: F, b: F) -> F {
        vreinterpretq_f32_f64(vtrn2q_f64(vreinterpretq_f64_f32(a), vreinterpretq_f64_f32(b)))
    }
}
