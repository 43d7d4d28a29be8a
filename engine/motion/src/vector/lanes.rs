//! SIMD registers of each instruction set, as the same operations on lanes.

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512;
#[cfg(target_arch = "aarch64")]
pub(super) mod neon;
mod ops;
pub(super) mod portable;
#[cfg(target_arch = "x86_64")]
pub(super) mod sse2;
