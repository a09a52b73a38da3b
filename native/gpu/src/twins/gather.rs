// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `gather.wgsl`.

use super::tree;
use super::two_float::{TwoFloat, add, add_float};
use crate::pack::Packed;

/// Threads of a group.
const THREADS: usize = 64;

/// The coefficients of all control points.
pub fn gather(packed: &Packed<'_>, partials: &[f32]) -> Vec<TwoFloat> {
    let of_point = |point: usize| {
        let entries = &packed.entries[packed.starts[point] as usize..packed.starts[point + 1] as usize];
        let of_lane = |lane: usize| {
            let own = entries.iter().skip(lane).step_by(THREADS);
            own.fold([0.0; 2], |sum, &entry| add_float(sum, partials[entry as usize]))
        };
        tree((0..THREADS).map(of_lane).collect(), add)
    };
    (0..packed.points()).filter_map(of_point).collect()
}
