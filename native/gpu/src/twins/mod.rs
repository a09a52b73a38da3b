// SPDX-License-Identifier: GPL-3.0-or-later
//! The kernels once more, on the CPU, in float32 and in the order of the WGSL of the same name. They are what the kernels
//! are tested against, stage by stage, and are themselves tested against the float64 core.
//!
//! A GPU may fuse a product and a sum into one rounding where a twin rounds twice; that is all they may differ by.

pub mod basis;
pub mod deform;
pub mod gather;
pub mod gradient;
pub mod reduce;
pub mod shift;
pub mod solve;
pub mod two_float;
pub mod write;

/// Adds 2n items pairwise, the second half to the first, until one is left: the tree of a group's threads.
pub(crate) fn tree<T: Copy>(mut parts: Vec<T>, add: impl Fn(T, T) -> T) -> Option<T> {
    let mut half = parts.len() / 2;
    while half > 0 {
        for lane in 0..half {
            parts[lane] = add(parts[lane], parts[lane + half]);
        }
        half /= 2;
    }
    parts.first().copied()
}
