//! Four lanes in plain Rust, which the compiler vectorises: the baseline of machines with neither
//! SSE2 nor NEON.

use crate::piece::Piece;

/// Number of lanes: rows at a time.
pub const N: usize = 4;
/// A register of floats.
pub type F = [f32; N];
/// A register of integers.
pub type I = [i32; N];
/// A mask: one boolean per lane.
pub type M = [bool; N];

/// Builds a register lane by lane.
macro_rules! each {
    ($k:ident => $value:expr) => {
        std::array::from_fn(|$k| $value)
    };
}

ops! {
    #[allow(clippy::needless_pass_by_value, reason = "the signatures of vector registers")]
    fn splat(a: f32) -> F { [a; N] }
    fn add(a: F, b: F) -> F { each!(k => a[k] + b[k]) }
    fn sub(a: F, b: F) -> F { each!(k => a[k] - b[k]) }
    fn mul(a: F, b: F) -> F { each!(k => a[k] * b[k]) }
    fn div(a: F, b: F) -> F { each!(k => a[k] / b[k]) }
    fn min(a: F, b: F) -> F { each!(k => a[k].min(b[k])) }
    fn max(a: F, b: F) -> F { each!(k => a[k].max(b[k])) }
    fn sqrt(a: F) -> F { each!(k => a[k].sqrt()) }
    fn abs(a: F) -> F { each!(k => a[k].abs()) }
    /// Returns `a`, negated where bit 31 of `sign` is set.
    fn flip(a: F, sign: I) -> F { each!(k => if sign[k] < 0 { -a[k] } else { a[k] }) }
    fn lt(a: F, b: F) -> M { each!(k => a[k] < b[k]) }
    fn select(mask: M, yes: F, no: F) -> F { each!(k => if mask[k] { yes[k] } else { no[k] }) }
    fn to_float(a: I) -> F { each!(k => a[k] as f32) }
    /// Rounds to the nearest integer, ties to even.
    fn round(a: F) -> I { each!(k => a[k].round_ties_even() as i32) }
    fn add_int(a: I, b: I) -> I { each!(k => a[k] + b[k]) }
    /// Returns a bit per lane: `a` ≥ 0 and `b` > 0.
    fn arrives(a: I, b: I) -> u32 { (0..N).map(|k| u32::from(a[k] >= 0 && b[k] > 0) << k).sum() }
    fn select_int(mask: M, yes: I, no: I) -> I { each!(k => if mask[k] { yes[k] } else { no[k] }) }
    /// Returns a bit per lane.
    fn bits(mask: M) -> u32 { (0..N).map(|k| u32::from(mask[k]) << k).sum() }
    /// Returns a mask: `a` ≥ `b` and `moved` > 0.
    fn reaches(a: F, b: F, moved: I) -> M { each!(k => a[k] >= b[k] && moved[k] > 0) }
    /// Returns a bit per lane: `now` is 0 and `before` > 0.
    fn stops(now: F, before: F) -> u32 {
        (0..N).map(|k| u32::from(now[k] == 0.0 && before[k] > 0.0) << k).sum()
    }
    /// Returns the coefficients of x and of y, by power.
    fn coefficients(rows: [&Piece; N]) -> [[F; 4]; 2] {
        [each!(power => each!(k => rows[k].x[power])), each!(power => each!(k => rows[k].y[power]))]
    }
}
