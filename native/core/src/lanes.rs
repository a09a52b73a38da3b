// SPDX-License-Identifier: GPL-3.0-or-later
//! Eight vertices at a time, compiled for the widest vector unit at hand.
//!
//! Everything that runs inside a kernel is a plain loop in an `#[inline(always)]` function: closures handed to the standard
//! library (`array::from_fn`, `map`) are compiled outside the kernel, without its vector unit.

use bytemuck::{Pod, Zeroable};

use crate::vertices::Scalar;

/// Vertices that one step of a kernel works on: in float64 one AVX-512 register, two AVX ones or four NEON ones, in float32
/// half of that.
pub(crate) const LANES: usize = 8;

/// One number for each of [`LANES`] vertices.
pub(crate) trait Lanes: Copy + Send + Sync + Pod {
    /// The type of the numbers.
    type Real: Scalar;
    /// Zero in every lane.
    const ZERO: Self;

    /// These numbers.
    fn of(numbers: [Self::Real; LANES]) -> Self;
    /// Float64 numbers, rounded.
    fn rounded(exact: F64x8) -> Self;
    /// The numbers in float64.
    fn exact(self) -> F64x8;
    /// The same number in every lane.
    fn splat(value: Self::Real) -> Self;
    /// Lane by lane product.
    fn times(self, other: Self) -> Self;
    /// Lane by lane difference.
    fn minus(self, other: Self) -> Self;
    /// `self * factor + term`, lane by lane, rounded once where `FUSED`. Without the instruction `mul_add` would be a slow
    /// library call.
    fn multiply_add<const FUSED: bool>(self, factor: Self, term: Self) -> Self;

    /// Sum over the lanes in float64, pairwise.
    #[inline(always)]
    fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.exact().0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
}

macro_rules! lanes {
    ($name:ident, $real:ty, $align:literal) => {
        /// One number for each of [`LANES`] vertices.
        #[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
        #[repr(C, align($align))]
        pub(crate) struct $name(pub(crate) [$real; LANES]);

        impl Lanes for $name {
            type Real = $real;
            const ZERO: Self = Self([0.0; LANES]);

            #[inline(always)]
            fn of(numbers: [$real; LANES]) -> Self {
                Self(numbers)
            }

            #[inline(always)]
            fn rounded(exact: F64x8) -> Self {
                let mut found = Self::ZERO;
                for lane in 0..LANES {
                    found.0[lane] = exact.0[lane] as $real;
                }
                found
            }

            #[inline(always)]
            fn exact(self) -> F64x8 {
                let mut found = F64x8::ZERO;
                for lane in 0..LANES {
                    found.0[lane] = self.0[lane] as f64;
                }
                found
            }

            #[inline(always)]
            fn splat(value: $real) -> Self {
                Self([value; LANES])
            }

            #[inline(always)]
            fn times(mut self, other: Self) -> Self {
                for lane in 0..LANES {
                    self.0[lane] *= other.0[lane];
                }
                self
            }

            #[inline(always)]
            fn minus(mut self, other: Self) -> Self {
                for lane in 0..LANES {
                    self.0[lane] -= other.0[lane];
                }
                self
            }

            #[inline(always)]
            fn multiply_add<const FUSED: bool>(mut self, factor: Self, term: Self) -> Self {
                for lane in 0..LANES {
                    let (a, b, c) = (self.0[lane], factor.0[lane], term.0[lane]);
                    self.0[lane] = if FUSED { a.mul_add(b, c) } else { a * b + c };
                }
                self
            }
        }
    };
}

lanes!(F32x8, f32, 32);
lanes!(F64x8, f64, 64);

/// A loop over vertices that is worth compiling for each vector unit. `run` must be `#[inline(always)]`.
pub(crate) trait Kernel {
    type Output;
    fn run<const FUSED: bool>(self) -> Self::Output;
}

/// Runs a kernel compiled for the best vector unit that this processor has.
#[cfg(target_arch = "x86_64")]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
    fn avx512<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<true>()
    }
    #[target_feature(enable = "avx2,fma")]
    fn avx2<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<true>()
    }
    let fused = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    if fused
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
    {
        // SAFETY: every feature that `avx512` enables was detected on this processor just above.
        unsafe { avx512(kernel) }
    } else if fused {
        // SAFETY: AVX2 and FMA were detected on this processor just above.
        unsafe { avx2(kernel) }
    } else {
        kernel.run::<false>()
    }
}

/// Runs a kernel; every 64-bit Arm processor has fused multiply-add and 128-bit vectors.
#[cfg(target_arch = "aarch64")]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<true>()
}

/// Runs a kernel without assuming anything of the processor.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<false>()
}
