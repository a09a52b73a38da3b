// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `basis.wgsl`: the Cox-de Boor recurrence.

/// Basis functions of one axis at `t` in the cell whose steps start at `first`.
pub fn basis(knots: &[[f32; 4]], first: u32, taps: usize, t: f32) -> Vec<f32> {
    let mut weights = vec![0.0; taps];
    weights[0] = 1.0;
    let mut at = first as usize;
    for order in 1..taps {
        let mut carried = 0.0;
        for weight in &mut weights[..order] {
            let [left, right, inverse, _] = knots[at];
            let part = *weight * inverse;
            *weight = carried + (right - t) * part;
            carried = (t - left) * part;
            at += 1;
        }
        weights[order] = carried;
    }
    weights
}

/// Basis functions of the three axes.
pub(crate) fn weights(
    packed: &crate::pack::Packed<'_>,
    tile: &crate::types::Tile,
    slot: usize,
) -> [Vec<f32>; 3] {
    let knots = [tile.knots_u, tile.knots_v, tile.knots_w];
    std::array::from_fn(|axis| {
        basis(&packed.knots, knots[axis], packed.taps[axis], packed.places[slot][axis])
    })
}
