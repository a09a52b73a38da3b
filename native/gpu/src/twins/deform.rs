// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `deform.wgsl`.

use super::basis::weights;
use crate::pack::Packed;
use crate::types::{Frame, Tile};

/// The state: all x, all y, all z of the deformed slots.
pub fn deform(packed: &Packed<'_>, frame: &Frame, controls: &[[f32; 4]]) -> Vec<f32> {
    let slots = packed.slots();
    let mut state = vec![0.0; 3 * slots];
    for tile in &packed.tiles {
        for slot in tile.first_slot as usize..(tile.first_slot + tile.slots) as usize {
            let moved = moved(packed, tile, slot, controls);
            let influence = packed.places[slot][3];
            let at: [f32; 3] =
                std::array::from_fn(|axis| packed.rest[axis * slots + slot] + influence * moved[axis]);
            let [x, y, z] = frame.to_frame;
            for row in 0..3 {
                state[row * slots + slot] = x[row] * at[0] + y[row] * at[1] + z[row] * at[2];
            }
        }
    }
    state
}

fn moved(packed: &Packed<'_>, tile: &Tile, slot: usize, controls: &[[f32; 4]]) -> [f32; 3] {
    let [wu, wv, ww] = weights(packed, tile, slot);
    let mut sum = [0.0; 3];
    let mut tap = 0;
    for wu in &wu {
        let mut plane = [0.0; 3];
        for wv in &wv {
            let mut row = [0.0; 3];
            for ww in &ww {
                let control = controls[packed.point_of_tap(tile, tap)];
                for axis in 0..3 {
                    row[axis] += ww * control[axis];
                }
                tap += 1;
            }
            for axis in 0..3 {
                plane[axis] += wv * row[axis];
            }
        }
        for axis in 0..3 {
            sum[axis] += wu * plane[axis];
        }
    }
    sum
}
