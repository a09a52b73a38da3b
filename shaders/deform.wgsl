// SPDX-License-Identifier: GPL-3.0-or-later
// state = to_frame (rest + influence * sum B displacement): the volume paper's equation (1), in displacement form, so that the
// rest lattice moves nothing. One group a tile, one thread a slot.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> tiles: array<Tile>;
@group(0) @binding(2) var<storage, read> knots: array<vec4f>;
@group(0) @binding(3) var<storage, read> places: array<vec4f>; // Parameters in the cell, and influence.
@group(0) @binding(4) var<storage, read> rest: array<f32>;
@group(0) @binding(5) var<storage, read> controls: array<vec4f>; // Displacement, and mobility.
@group(0) @binding(6) var<storage, read_write> state: array<f32>;

const STAGE = select(1u, TAPS, STAGED);
var<workgroup> staged: array<vec4f, STAGE>;

fn displacement(tile: Tile, tap: u32) -> vec3f {
    if STAGED {
        return staged[tap].xyz;
    }
    return controls[point_of_tap(tile, tap, frame.shape)].xyz;
}

fn moved(tile: Tile, place: vec4f) -> vec3f {
    let wu = basis(tile.knots_u, TAPS_U, place.x);
    let wv = basis(tile.knots_v, TAPS_V, place.y);
    let ww = basis(tile.knots_w, TAPS_W, place.z);
    var sum = vec3f(0.0);
    var tap = 0u;
    for (var i = 0u; i < TAPS_U; i++) {
        var plane = vec3f(0.0);
        for (var j = 0u; j < TAPS_V; j++) {
            var row = vec3f(0.0);
            for (var k = 0u; k < TAPS_W; k++) {
                row += ww[k] * displacement(tile, tap);
                tap++;
            }
            plane += wv[j] * row;
        }
        sum += wu[i] * plane;
    }
    return sum;
}

@compute @workgroup_size(256)
fn deform(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = flat_index(group, groups);
    if index >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index];
    if STAGED {
        for (var tap = lane; tap < TAPS; tap += 256u) {
            staged[tap] = controls[point_of_tap(tile, tap, frame.shape)];
        }
        workgroupBarrier();
    }
    if lane >= tile.slots {
        return;
    }
    let slot = tile.first_slot + lane;
    let slots = arrayLength(&places);
    let place = places[slot];
    let at = vec3f(rest[slot], rest[slots + slot], rest[2u * slots + slot]) + place.w * moved(tile, place);
    let mapped = frame.to_frame[0].xyz * at.x + frame.to_frame[1].xyz * at.y + frame.to_frame[2].xyz * at.z;
    state[slot] = mapped.x;
    state[slots + slot] = mapped.y;
    state[2u * slots + slot] = mapped.z;
}
