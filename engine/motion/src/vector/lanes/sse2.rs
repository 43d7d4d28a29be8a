//! Four lanes of SSE2, which every x86-64 machine has.

use std::arch::x86_64::*;

use crate::piece::Piece;

/// Number of lanes: rows at a time.
pub const N: usize = 4;
/// A register of floats.
pub type F = __m128;
/// A register of integers.
pub type I = __m128i;
/// A mask: in each lane all bits are set, or none.
pub type M = __m128;

ops! {
    #[target_feature(enable = "sse2")]
    fn splat(a: f32) -> F { _mm_set1_ps(a) }
    fn add(a: F, b: F) -> F { _mm_add_ps(a, b) }
    fn sub(a: F, b: F) -> F { _mm_sub_ps(a, b) }
    fn mul(a: F, b: F) -> F { _mm_mul_ps(a, b) }
    fn div(a: F, b: F) -> F { _mm_div_ps(a, b) }
    fn min(a: F, b: F) -> F { _mm_min_ps(a, b) }
    fn max(a: F, b: F) -> F { _mm_max_ps(a, b) }
    fn sqrt(a: F) -> F { _mm_sqrt_ps(a) }
    fn abs(a: F) -> F { _mm_andnot_ps(splat(-0.0), a) }
    /// Returns `a`, negated where bit 31 of `sign` is set.
    fn flip(a: F, sign: I) -> F { _mm_xor_ps(a, _mm_and_ps(_mm_castsi128_ps(sign), splat(-0.0))) }
    fn lt(a: F, b: F) -> M { _mm_cmplt_ps(a, b) }
    fn select(mask: M, yes: F, no: F) -> F {
        _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no))
    }
    fn to_float(a: I) -> F { _mm_cvtepi32_ps(a) }
    /// Rounds to the nearest integer, ties to even.
    fn round(a: F) -> I { _mm_cvtps_epi32(a) }
    fn add_int(a: I, b: I) -> I { _mm_add_epi32(a, b) }
    /// Returns a bit per lane: `a` ≥ 0 and `b` > 0.
    fn arrives(a: I, b: I) -> u32 {
        let not = _mm_cmpgt_epi32(_mm_setzero_si128(), a);
        let moved = _mm_cmpgt_epi32(b, _mm_setzero_si128());
        _mm_movemask_ps(_mm_castsi128_ps(_mm_andnot_si128(not, moved))) as u32
    }
    fn select_int(mask: M, yes: I, no: I) -> I {
        _mm_castps_si128(select(mask, _mm_castsi128_ps(yes), _mm_castsi128_ps(no)))
    }
    /// Returns a bit per lane.
    fn bits(mask: M) -> u32 { _mm_movemask_ps(mask) as u32 }
    /// Returns a mask: `a` ≥ `b` and `moved` > 0.
    fn reaches(a: F, b: F, moved: I) -> M {
        let moves = _mm_castsi128_ps(_mm_cmpgt_epi32(moved, _mm_setzero_si128()));
        _mm_and_ps(_mm_cmpge_ps(a, b), moves)
    }
    /// Returns a bit per lane: `now` is 0 and `before` > 0.
    fn stops(now: F, before: F) -> u32 {
        let zero = splat(0.0);
        _mm_movemask_ps(_mm_and_ps(_mm_cmpeq_ps(now, zero), _mm_cmplt_ps(zero, before))) as u32
    }
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
        let (ab_low, cd_low) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
        [
            _mm_movelh_ps(ab_low, cd_low),
            _mm_movehl_ps(cd_low, ab_low),
            _mm_movelh_ps(ab_high, cd_high),
            _mm_movehl_ps(cd_high, ab_high),
        ]
    }
}
