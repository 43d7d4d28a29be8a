//! Sixteen lanes of AVX-512 (F and DQ).

use std::arch::x86_64::*;

use crate::piece::Piece;

/// Number of lanes: rows at a time.
pub const N: usize = 16;
/// A register of floats.
pub type F = __m512;
/// A register of integers.
pub type I = __m512i;
/// A mask: one bit per lane.
pub type M = __mmask16;

ops! {
    #[target_feature(enable = "avx512f,avx512dq")]
    fn splat(a: f32) -> F { _mm512_set1_ps(a) }
    fn add(a: F, b: F) -> F { _mm512_add_ps(a, b) }
    fn sub(a: F, b: F) -> F { _mm512_sub_ps(a, b) }
    fn mul(a: F, b: F) -> F { _mm512_mul_ps(a, b) }
    fn div(a: F, b: F) -> F { _mm512_div_ps(a, b) }
    fn min(a: F, b: F) -> F { _mm512_min_ps(a, b) }
    fn max(a: F, b: F) -> F { _mm512_max_ps(a, b) }
    fn sqrt(a: F) -> F { _mm512_sqrt_ps(a) }
    fn abs(a: F) -> F { _mm512_andnot_ps(splat(-0.0), a) }
    /// Returns `a`, negated where bit 31 of `sign` is set.
    fn flip(a: F, sign: I) -> F {
        _mm512_xor_ps(a, _mm512_and_ps(_mm512_castsi512_ps(sign), splat(-0.0)))
    }
    fn lt(a: F, b: F) -> M { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b) }
    fn select(mask: M, yes: F, no: F) -> F { _mm512_mask_blend_ps(mask, no, yes) }
    fn to_float(a: I) -> F { _mm512_cvtepi32_ps(a) }
    /// Rounds to the nearest integer, ties to even.
    fn round(a: F) -> I { _mm512_cvtps_epi32(a) }
    fn add_int(a: I, b: I) -> I { _mm512_add_epi32(a, b) }
    /// Returns a bit per lane: `a` ≥ 0 and `b` > 0.
    fn arrives(a: I, b: I) -> u32 {
        let moved = _mm512_cmpgt_epi32_mask(b, _mm512_setzero_si512());
        u32::from(_mm512_mask_cmpge_epi32_mask(moved, a, _mm512_setzero_si512()))
    }
    fn select_int(mask: M, yes: I, no: I) -> I { _mm512_mask_blend_epi32(mask, no, yes) }
    /// Returns a bit per lane.
    fn bits(mask: M) -> u32 { u32::from(mask) }
    /// Returns a mask: `a` ≥ `b` and `moved` > 0.
    fn reaches(a: F, b: F, moved: I) -> M {
        let moves = _mm512_cmpgt_epi32_mask(moved, _mm512_setzero_si512());
        _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(moves, a, b)
    }
    /// Returns a bit per lane: `now` is 0 and `before` > 0.
    fn stops(now: F, before: F) -> u32 {
        let zero = splat(0.0);
        u32::from(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(now, zero) & lt(zero, before))
    }
    /// Returns the coefficients of x and of y, by power.
    fn coefficients(rows: [&Piece; N]) -> [[F; 4]; 2] {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = rows;
        let [x0, x1, x2, x3] = transpose([pair(a, i), pair(b, j), pair(c, k), pair(d, l)]);
        let [y0, y1, y2, y3] = transpose([pair(e, m), pair(f, n), pair(g, o), pair(h, p)]);
        // Quarters of the first: x of a-d, y of a-d, x of i-l, y of i-l; of the second: e-h and
        // m-p.
        [
            [merge_x(x0, y0), merge_x(x1, y1), merge_x(x2, y2), merge_x(x3, y3)],
            [merge_y(x0, y0), merge_y(x1, y1), merge_y(x2, y2), merge_y(x3, y3)],
        ]
    }
    fn pair(low: &Piece, high: &Piece) -> F {
        let low = _mm512_castps256_ps512(bytemuck::cast([low.x, low.y]));
        _mm512_insertf32x8::<1>(low, bytemuck::cast([high.x, high.y]))
    }
    /// Transposes each quarter: four rows of four become four columns.
    fn transpose(rows: [F; 4]) -> [F; 4] {
        let [a, b, c, d] = rows;
        let (ab_low, cd_low) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
        [
            _mm512_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
            _mm512_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
            _mm512_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
            _mm512_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
        ]
    }
    /// Returns the first and third quarter of each, alternately.
    fn merge_x(a: F, b: F) -> F {
        let lanes =
            _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
        _mm512_permutex2var_ps(a, lanes, b)
    }
    /// Returns the second and fourth quarter of each, alternately.
    fn merge_y(a: F, b: F) -> F {
        let lanes =
            _mm512_setr_epi32(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);
        _mm512_permutex2var_ps(a, lanes, b)
    }
}
