// SPDX-License-Identifier: GPL-3.0-or-later
// sum influence * B * pull over the vertices of a run, for each of its cell's control points: a small dense product. A thread owns the
// control points of one (v, w) and sums every GROUPS-th vertex; the groups are then added in their order. Runs go along the
// first two dimensions of the dispatch; the cell's (v, w) go along the third where there are more than 256.

@group(0) @binding(0) var<storage, read> runs: array<Tile>;
@group(0) @binding(1) var<storage, read> knots: array<vec4f>;
@group(0) @binding(2) var<storage, read> places: array<vec4f>;
@group(0) @binding(3) var<storage, read> pull: array<f32>;
@group(0) @binding(4) var<storage, read_write> partials: array<f32>;

const COLUMNS = TAPS_V * TAPS_W;
const WIDTH = min(COLUMNS, 256u);
const GROUPS = 256u / WIDTH;
const WEIGHTS = TAPS_U + TAPS_V + TAPS_W;
// Vertices whose basis functions stand in workgroup memory at a time: 12 KiB of it.
const BATCH = min(3072u / WEIGHTS, 256u);

var<workgroup> weights: array<f32, BATCH * WEIGHTS>;
var<workgroup> parts: array<f32, 256>;

fn stage_weights(run: Tile, batch: u32, lane: u32) {
    let slot = run.first_slot + batch + lane;
    if lane >= BATCH || batch + lane >= run.slots {
        return;
    }
    let place = places[slot];
    let own = place.w * pull[slot];
    let wu = basis(run.knots_u, TAPS_U, place.x);
    for (var i = 0u; i < TAPS_U; i++) {
        weights[lane * WEIGHTS + i] = own * wu[i];
    }
    let wv = basis(run.knots_v, TAPS_V, place.y);
    for (var j = 0u; j < TAPS_V; j++) {
        weights[lane * WEIGHTS + TAPS_U + j] = wv[j];
    }
    let ww = basis(run.knots_w, TAPS_W, place.z);
    for (var k = 0u; k < TAPS_W; k++) {
        weights[lane * WEIGHTS + TAPS_U + TAPS_V + k] = ww[k];
    }
}

@compute @workgroup_size(256)
fn reduce(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = flat_index(group, groups);
    if number >= arrayLength(&runs) {
        return;
    }
    let run = runs[number];
    let column = group.z * 256u + lane % WIDTH;
    let owner = lane / WIDTH;
    let busy = owner < GROUPS && column < COLUMNS;
    var sums: array<f32, TAPS_U>;
    for (var batch = 0u; batch < run.slots; batch += BATCH) {
        workgroupBarrier();
        stage_weights(run, batch, lane);
        workgroupBarrier();
        if busy {
            let count = min(BATCH, run.slots - batch);
            for (var vertex = owner; vertex < count; vertex += GROUPS) {
                let at = vertex * WEIGHTS;
                let across = weights[at + TAPS_U + column / TAPS_W] * weights[at + TAPS_U + TAPS_V + column % TAPS_W];
                for (var i = 0u; i < TAPS_U; i++) {
                    sums[i] += weights[at + i] * across;
                }
            }
        }
    }
    for (var i = 0u; i < TAPS_U; i++) {
        workgroupBarrier();
        parts[lane] = sums[i];
        workgroupBarrier();
        if busy && owner == 0u {
            var sum = 0.0;
            for (var other = 0u; other < GROUPS; other++) {
                sum += parts[other * WIDTH + lane];
            }
            partials[number * TAPS + i * COLUMNS + column] = sum;
        }
    }
}
