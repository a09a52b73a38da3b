// SPDX-License-Identifier: GPL-3.0-or-later
//! Eight vertices at a time, compiled for the widest vector unit at hand.
//!
//! Everything that runs inside a kernel is a plain loop in an `#[inline(always)]` function: closures handed to the standard
//! library (`array::from_fn`, `map`) are compiled outside the kernel, without its vector unit.

/// Vertices that one step of a kernel works on: one AVX-512 register of float64, two AVX ones, four NEON ones.
pub(crate) const LANES: usize = 8;

/// One number for each of [`LANES`] vertices.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// Lane by lane product.
    #[inline(always)]
    pub(crate) fn times(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] *= other.0[lane];
        }
        self
    }

    /// Lane by lane difference.
    #[inline(always)]
    pub(crate) fn minus(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] -= other.0[lane];
        }
        self
    }

    /// `self * factor + term`, lane by lane, rounded once where `FUSED`.
    #[inline(always)]
    pub(crate) fn multiply_add<const FUSED: bool>(mut self, factor: Self, term: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] = multiply_add::<FUSED>(self.0[lane], factor.0[lane], term.0[lane]);
        }
        self
    }

    /// Sum over the lanes, pairwise.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
}

/// `a * b + c`, in one instruction where the target has it. Without it `mul_add` would be a slow library call.
#[inline(always)]
pub(crate) fn multiply_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

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
