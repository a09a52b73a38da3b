// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `write.wgsl`.

use crate::pack::Packed;
use crate::types::Frame;

/// How far every vertex moved, in the order bound.
pub fn write(packed: &Packed<'_>, frame: &Frame, state: &[f32]) -> Vec<[f32; 3]> {
    let slots = packed.slots();
    let [x, y, z] = frame.from_frame;
    let of_vertex = |&slot: &u32| {
        let at: [usize; 3] = std::array::from_fn(|axis| axis * slots + slot as usize);
        std::array::from_fn(|row| {
            x[row] * state[at[0]] + y[row] * state[at[1]] + z[row] * state[at[2]] - packed.rest[at[row]]
        })
    };
    packed.slot_of_vertex.iter().map(of_vertex).collect()
}
