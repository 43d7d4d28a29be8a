//! SIMD registers of each instruction set, as the same operations on lanes.

/// Declares inlined functions that all need the same instructions.
macro_rules! ops {
    (
        #$feature:tt
        $($(#[$doc:meta])* fn $name:ident($($arg:ident: $type:ty),*) -> $result:ty $body:block)*
    ) => {$(
        $(#[$doc])*
        #[inline]
        #$feature
        pub fn $name($($arg: $type),*) -> $result $body
    )*};
}

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(super) mod avx512;
#[cfg(target_arch = "aarch64")]
pub(super) mod neon;
pub(super) mod portable;
#[cfg(target_arch = "x86_64")]
pub(super) mod sse2;
