// SPDX-License-Identifier: GPL-3.0-or-later
// One coordinate of the state += influence * sum B delta: a turn's step of the correction. One group a tile, one thread a slot.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> index: Index;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> knots: array<vec4f>;
@group(0) @binding(4) var<storage, read> places: array<vec4f>;
@group(0) @binding(5) var<storage, read> delta: array<f32>;
@group(0) @binding(6) var<storage, read_write> state: array<f32>;

const STAGE = select(1u, TAPS, STAGED);
var<workgroup> staged: array<f32, STAGE>;

fn delta_of_point(point: u32) -> f32 {
    return delta[index.turn * (frame.shape.x * frame.shape.y * frame.shape.z) + point];
}

fn delta_of_tap(tile: Tile, tap: u32) -> f32 {
    if STAGED {
        return staged[tap];
    }
    return delta_of_point(point_of_tap(tile, tap, frame.shape));
}

fn moved(tile: Tile, place: vec4f) -> f32 {
    let wu = basis(tile.knots_u, TAPS_U, place.x);
    let wv = basis(tile.knots_v, TAPS_V, place.y);
    let ww = basis(tile.knots_w, TAPS_W, place.z);
    var sum = 0.0;
    var tap = 0u;
    for (var i = 0u; i < TAPS_U; i++) {
        var plane = 0.0;
        for (var j = 0u; j < TAPS_V; j++) {
            var row = 0.0;
            for (var k = 0u; k < TAPS_W; k++) {
                row += ww[k] * delta_of_tap(tile, tap);
                tap++;
            }
            plane += wv[j] * row;
        }
        sum += wu[i] * plane;
    }
    return sum;
}

@compute @workgroup_size(256)
fn shift(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = flat_index(group, groups);
    if number >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[number];
    if STAGED {
        for (var tap = lane; tap < TAPS; tap += 256u) {
            staged[tap] = delta_of_point(point_of_tap(tile, tap, frame.shape));
        }
        workgroupBarrier();
    }
    if lane >= tile.slots {
        return;
    }
    let slot = tile.first_slot + lane;
    let place = places[slot];
    state[frame.turns[index.turn].axis * arrayLength(&places) + slot] += place.w * moved(tile, place);
}
