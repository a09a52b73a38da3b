// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `reduce.wgsl`.

use super::basis::weights;
use crate::kernels::GROUP;
use crate::pack::Packed;
use crate::types::Tile;

/// Floats of workgroup memory for the basis functions of a batch of vertices.
const BATCH_FLOATS: usize = 3072;

/// `sum influence * B * pull` over each run, for each of its taps.
pub fn reduce(packed: &Packed<'_>, pull: &[f32]) -> Vec<f32> {
    packed.runs.iter().flat_map(|run| of_run(packed, run, pull)).collect()
}

fn of_run(packed: &Packed<'_>, run: &Tile, pull: &[f32]) -> Vec<f32> {
    let [nu, nv, nw] = packed.taps;
    let columns = nv * nw;
    let groups = GROUP / columns.min(GROUP);
    let batch = (BATCH_FLOATS / (nu + nv + nw)).min(GROUP);
    let mut sums = vec![vec![0.0f32; nu * columns]; groups];
    for local in 0..run.slots as usize {
        let slot = run.first_slot as usize + local;
        let [wu, wv, ww] = weights(packed, run, slot);
        let own = packed.places[slot][3] * pull[slot];
        let sums = &mut sums[local % batch % groups];
        for column in 0..columns {
            let across = wv[column / nw] * ww[column % nw];
            for i in 0..nu {
                sums[i * columns + column] += own * wu[i] * across;
            }
        }
    }
    (0..nu * columns).map(|tap| sums.iter().fold(0.0, |sum, group| sum + group[tap])).collect()
}
