// SPDX-License-Identifier: GPL-3.0-or-later
// How far every vertex moved, in the order bound: from_frame state - rest. The CPU adds it to the position as bound, in
// float64, so that what does not move comes back bit for bit. One thread a vertex.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> slot_of_vertex: array<u32>;
@group(0) @binding(2) var<storage, read> rest: array<f32>;
@group(0) @binding(3) var<storage, read> state: array<f32>;
@group(0) @binding(4) var<storage, read_write> moved: array<f32>;

@compute @workgroup_size(256)
fn write(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let vertex = flat_index(group, groups) * 256u + lane;
    if vertex >= arrayLength(&slot_of_vertex) {
        return;
    }
    let slots = arrayLength(&rest) / 3u;
    let slot = slot_of_vertex[vertex];
    let y = slots + slot;
    let z = slots + y;
    let at = frame.from_frame[0].xyz * state[slot] + frame.from_frame[1].xyz * state[y] + frame.from_frame[2].xyz * state[z];
    moved[3u * vertex] = at.x - rest[slot];
    moved[3u * vertex + 1u] = at.y - rest[y];
    moved[3u * vertex + 2u] = at.z - rest[z];
}
