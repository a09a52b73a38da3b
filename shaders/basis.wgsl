// SPDX-License-Identifier: GPL-3.0-or-later
// Basis functions of one axis by the Cox-de Boor recurrence, whose steps stand in `knots` as (left, right, 1 / (right - left)),
// relative to the cell and in units of its length. Expects `knots` to be bound.

fn basis(first: u32, taps: u32, t: f32) -> array<f32, MAX_TAPS> {
    var weights: array<f32, MAX_TAPS>;
    weights[0] = 1.0;
    var at = first;
    for (var order = 1u; order < taps; order++) {
        var carried = 0.0;
        for (var r = 0u; r < order; r++) {
            let knot = knots[at];
            let part = weights[r] * knot.z;
            weights[r] = carried + (knot.y - t) * part;
            carried = (t - knot.x) * part;
            at++;
        }
        weights[order] = carried;
    }
    return weights;
}

// Index of a cell's control point, by its number among the cell's taps, w fastest.
fn point_of_tap(tile: Tile, tap: u32, shape: vec4u) -> u32 {
    let i = tap / (TAPS_V * TAPS_W);
    let j = (tap / TAPS_W) % TAPS_V;
    return tile.first_point + (i * shape.y + j) * shape.z + tap % TAPS_W;
}
