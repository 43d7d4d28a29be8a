//! Instruction sets of the kernel.

use std::fmt;
use std::str::FromStr;

/// An instruction set that the kernel has code for. All of them give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Isa {
    /// Row by row in plain Rust: the reference.
    Scalar,
    /// Four rows at a time with what every machine of this architecture has (SSE2 on x86-64, NEON
    /// on 64-bit Arm).
    Baseline,
    /// Eight rows at a time.
    Avx2,
    /// Sixteen rows at a time (AVX-512 F and DQ).
    Avx512,
}

impl Isa {
    /// All instruction sets, slowest first.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Baseline, Self::Avx2, Self::Avx512];

    /// Returns the fastest instruction set that this machine can run.
    pub fn detect() -> Self {
        *Self::ALL
            .iter()
            .rfind(|isa| isa.is_supported())
            .expect("every machine runs the scalar kernel")
    }

    /// Whether this machine can run it.
    pub fn is_supported(self) -> bool {
        match self {
            Self::Scalar | Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }

    /// Name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The error of parsing an [`Isa`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown instruction set {0:?}; use scalar, baseline, avx2 or avx512")]
pub struct ParseIsaError(String);

impl FromStr for Isa {
    type Err = ParseIsaError;

    fn from_str(text: &str) -> Result<Self, ParseIsaError> {
        Self::ALL
            .into_iter()
            .find(|isa| isa.name() == text)
            .ok_or_else(|| ParseIsaError(text.to_owned()))
    }
}

/// An instruction set that this machine was found to have. The kernel's vector code is called with
/// nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportedIsa(KernelVariant);

/// The variants of the kernel that are compiled for this architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KernelVariant {
    Scalar,
    Portable,
    #[cfg(target_arch = "aarch64")]
    Neon,
    #[cfg(target_arch = "x86_64")]
    Sse2,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl SupportedIsa {
    /// The variant for machines with neither SSE2 nor NEON, which runs on every machine.
    pub const PORTABLE: Self = Self(KernelVariant::Portable);

    /// Detects whether this machine has an instruction set; `None` if not.
    pub fn detect(isa: Isa) -> Option<Self> {
        let variant = match isa {
            Isa::Scalar => KernelVariant::Scalar,
            #[cfg(target_arch = "x86_64")]
            Isa::Baseline => KernelVariant::Sse2,
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => KernelVariant::Avx2,
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => KernelVariant::Avx512,
            #[cfg(target_arch = "aarch64")]
            Isa::Baseline | Isa::Avx2 | Isa::Avx512 => KernelVariant::Neon,
            #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
            Isa::Baseline | Isa::Avx2 | Isa::Avx512 => KernelVariant::Portable,
        };
        isa.is_supported().then_some(Self(variant))
    }

    pub(super) fn variant(self) -> KernelVariant {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_parse_back() {
        for isa in Isa::ALL {
            assert_eq!(isa.to_string().parse(), Ok(isa));
        }
        assert!("sse9".parse::<Isa>().unwrap_err().to_string().contains("sse9"));
    }

    #[test]
    fn the_detected_instruction_set_is_supported() {
        assert!(Isa::detect().is_supported());
        assert!(Isa::detect() >= Isa::Baseline);
    }

    #[test]
    fn only_supported_instruction_sets_reach_the_kernel() {
        for isa in Isa::ALL {
            assert_eq!(SupportedIsa::detect(isa).is_some(), isa.is_supported(), "{isa}");
        }
    }
}
