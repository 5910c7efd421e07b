//! The choice of instructions, at run time.

use std::str::FromStr;

use fearless_simd::{Level, Simd};

/// Which instructions the kernels use. All give the same bits.
#[derive(Clone, Copy, Debug)]
pub struct SimdLevel(Level);

impl PartialEq for SimdLevel {
    fn eq(&self, other: &Self) -> bool {
        std::mem::discriminant(&self.0) == std::mem::discriminant(&other.0)
    }
}

impl Eq for SimdLevel {}

/// A kernel: one body for all instruction sets. What it calls must be inlined into it, since only
/// what is inside is compiled for the instructions chosen.
pub trait Kernel {
    /// What it comes to.
    type Output;

    /// The body; marked `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

impl Default for SimdLevel {
    /// The widest instructions that the machine has.
    fn default() -> Self {
        Self(Level::new())
    }
}

/// A name that is none of an instruction set, or of one that the machine lacks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not an instruction set of this machine, expected one of {available}")]
pub struct UnknownInstructions {
    name: String,
    available: String,
}

impl SimdLevel {
    /// Those of this machine with their names, the widest first.
    pub fn available() -> Vec<(&'static str, Self)> {
        let level = Level::new();
        #[cfg(target_arch = "x86_64")]
        let levels = [
            ("avx512", level.as_avx512().map(Simd::level)),
            ("avx2", level.as_avx2().map(Simd::level)),
            ("sse2", level.as_sse2().map(Simd::level)),
        ];
        #[cfg(target_arch = "aarch64")]
        let levels = [("neon", level.as_neon().map(Simd::level))];
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let levels = [("scalar", Some(level))];
        levels
            .into_iter()
            .filter_map(|(name, level)| Some((name, Self(level?))))
            .collect()
    }

    /// Runs a kernel, compiled for these instructions.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // Not by the crate's `dispatch!` where it can be helped: it would compile every kernel also
        // for the levels in between.
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = self.0.as_avx512() {
            simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            )
        } else if let Some(simd) = self.0.as_avx2() {
            simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            )
        } else {
            let simd = self.0.as_sse2().expect("every x86-64 has SSE2");
            simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            )
        }
        #[cfg(not(target_arch = "x86_64"))]
        fearless_simd::dispatch!(self.0, simd => kernel.run(simd))
    }
}

impl FromStr for SimdLevel {
    type Err = UnknownInstructions;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let available = Self::available();
        let found = available.iter().find(|(known, _)| *known == name);
        found.map(|(_, level)| *level).ok_or_else(|| {
            let names: Vec<&str> = available.iter().map(|(name, _)| *name).collect();
            UnknownInstructions {
                name: name.to_owned(),
                available: names.join(", "),
            }
        })
    }
}
