// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `gradient.wgsl`.

use isochor_core::layout::BLOCK;

use super::tree;
use super::two_float::{TwoFloat, add};
use crate::kernels::GROUP;
use crate::pack::Packed;
use crate::types::Frame;

/// Six times the gradient along the turn's axis, and the volume's share of each group.
pub fn gradient(packed: &Packed<'_>, frame: &Frame, turn: usize, state: &[f32]) -> (Vec<f32>, Vec<TwoFloat>) {
    let slots = packed.slots();
    let axis = frame.turns[turn].axis as usize;
    let column = |axis: usize| &state[axis % 3 * slots..][..slots];
    let mut pull = vec![0.0; slots];
    let mut volumes = Vec::with_capacity(packed.groups());
    for group in 0..packed.groups() {
        let mut parts = vec![[0.0; 2]; GROUP];
        for (lane, part) in parts.iter_mut().enumerate() {
            let slot = group * GROUP + lane;
            if slot < slots {
                let six = gradient_at(packed, slot, column(axis + 1), column(axis + 2));
                pull[slot] = six;
                *part = [(column(axis)[slot] - frame.middle[axis]) * six, 0.0];
            }
        }
        volumes.extend(tree(parts, add));
    }
    (pull, volumes)
}

fn gradient_at(packed: &Packed<'_>, slot: usize, p: &[f32], q: &[f32]) -> f32 {
    let (block, lane) = (slot / BLOCK, slot % BLOCK);
    let walk = &packed.steps[packed.offsets[block] as usize..packed.offsets[block + 1] as usize];
    let (Some(first), Some(last)) = (walk.first(), walk.last()) else { return 0.0 };
    let own = p[slot];
    let start = q[first[lane] as usize];
    let (mut before, mut here) = (q[last[lane] as usize], start);
    let mut arm = p[first[lane] as usize] - own;
    let mut sum = 0.0;
    for step in &walk[1..] {
        let after = q[step[lane] as usize];
        sum += arm * (after - before);
        (before, here) = (here, after);
        arm = p[step[lane] as usize] - own;
    }
    sum + arm * (start - before)
}
