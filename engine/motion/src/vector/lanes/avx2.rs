//! Eight lanes of AVX2.

use std::arch::x86_64::*;

use crate::piece::Piece;

/// Number of lanes: rows at a time.
pub const N: usize = 8;
/// A register of floats.
pub type F = __m256;
/// A register of integers.
pub type I = __m256i;
/// A mask: in each lane all bits are set, or none.
pub type M = __m256;

ops! {
    #[target_feature(enable = "avx2")]
    fn splat(a: f32) -> F { _mm256_set1_ps(a) }
    fn add(a: F, b: F) -> F { _mm256_add_ps(a, b) }
    fn sub(a: F, b: F) -> F { _mm256_sub_ps(a, b) }
    fn mul(a: F, b: F) -> F { _mm256_mul_ps(a, b) }
    fn div(a: F, b: F) -> F { _mm256_div_ps(a, b) }
    fn min(a: F, b: F) -> F { _mm256_min_ps(a, b) }
    fn max(a: F, b: F) -> F { _mm256_max_ps(a, b) }
    fn sqrt(a: F) -> F { _mm256_sqrt_ps(a) }
    fn abs(a: F) -> F { _mm256_andnot_ps(splat(-0.0), a) }
    /// Returns `a`, negated where bit 31 of `sign` is set.
    fn flip(a: F, sign: I) -> F {
        _mm256_xor_ps(a, _mm256_and_ps(_mm256_castsi256_ps(sign), splat(-0.0)))
    }
    fn lt(a: F, b: F) -> M { _mm256_cmp_ps::<_CMP_LT_OQ>(a, b) }
    fn select(mask: M, yes: F, no: F) -> F { _mm256_blendv_ps(no, yes, mask) }
    fn to_float(a: I) -> F { _mm256_cvtepi32_ps(a) }
    /// Rounds to the nearest integer, ties to even.
    fn round(a: F) -> I { _mm256_cvtps_epi32(a) }
    fn add_int(a: I, b: I) -> I { _mm256_add_epi32(a, b) }
    /// Returns a bit per lane: `a` ≥ 0 and `b` > 0.
    fn arrives(a: I, b: I) -> u32 {
        let not = _mm256_cmpgt_epi32(_mm256_setzero_si256(), a);
        let moved = _mm256_cmpgt_epi32(b, _mm256_setzero_si256());
        _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_andnot_si256(not, moved))) as u32
    }
    fn select_int(mask: M, yes: I, no: I) -> I {
        _mm256_castps_si256(select(mask, _mm256_castsi256_ps(yes), _mm256_castsi256_ps(no)))
    }
    /// Returns a bit per lane.
    fn bits(mask: M) -> u32 { _mm256_movemask_ps(mask) as u32 }
    /// Returns a mask: `a` ≥ `b` and `moved` > 0.
    fn reaches(a: F, b: F, moved: I) -> M {
        let moves = _mm256_castsi256_ps(_mm256_cmpgt_epi32(moved, _mm256_setzero_si256()));
        _mm256_and_ps(_mm256_cmp_ps::<_CMP_GE_OQ>(a, b), moves)
    }
    /// Returns a bit per lane: `now` is 0 and `before` > 0.
    fn stops(now: F, before: F) -> u32 {
        let zero = splat(0.0);
        let stands = _mm256_cmp_ps::<_CMP_EQ_OQ>(now, zero);
        _mm256_movemask_ps(_mm256_and_ps(stands, lt(zero, before))) as u32
    }
    /// Returns the coefficients of x and of y, by power.
    fn coefficients(rows: [&Piece; N]) -> [[F; 4]; 2] {
        let [a, b, c, d, e, f, g, h] = rows;
        [
            transpose([pair(&a.x, &e.x), pair(&b.x, &f.x), pair(&c.x, &g.x), pair(&d.x, &h.x)]),
            transpose([pair(&a.y, &e.y), pair(&b.y, &f.y), pair(&c.y, &g.y), pair(&d.y, &h.y)]),
        ]
    }
    fn pair(low: &[f32; 4], high: &[f32; 4]) -> F {
        let low = _mm256_castps128_ps256(bytemuck::cast(*low));
        _mm256_insertf128_ps::<1>(low, bytemuck::cast(*high))
    }
    /// Transposes each half: four rows of four become four columns.
    fn transpose(rows: [F; 4]) -> [F; 4] {
        let [a, b, c, d] = rows;
        let (ab_low, cd_low) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
            _mm256_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
            _mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
            _mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
        ]
    }
}
