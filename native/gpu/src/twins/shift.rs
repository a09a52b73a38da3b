// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `shift.wgsl`.

use super::basis::weights;
use crate::pack::Packed;
use crate::types::{Frame, Tile};

/// Moves the turn's coordinate of the state by its step of the control points.
pub fn shift(packed: &Packed<'_>, frame: &Frame, turn: usize, delta: &[f32], state: &mut [f32]) {
    let column = frame.turns[turn].axis as usize * packed.slots();
    for tile in &packed.tiles {
        for slot in tile.first_slot as usize..(tile.first_slot + tile.slots) as usize {
            state[column + slot] += packed.places[slot][3] * moved(packed, tile, slot, delta);
        }
    }
}

fn moved(packed: &Packed<'_>, tile: &Tile, slot: usize, delta: &[f32]) -> f32 {
    let [wu, wv, ww] = weights(packed, tile, slot);
    let mut sum = 0.0;
    let mut tap = 0;
    for wu in &wu {
        let mut plane = 0.0;
        for wv in &wv {
            let mut row = 0.0;
            for ww in &ww {
                row += ww * delta[packed.point_of_tap(tile, tap)];
                tap += 1;
            }
            plane += wv * row;
        }
        sum += wu * plane;
    }
    sum
}
