// SPDX-License-Identifier: GPL-3.0-or-later
// For one axis six times the gradient of the volume at every vertex, and each group's share of the volume. The gradient is twice the area that the closed walk of neighbours encloses in the plane across the axis: sum
// (p_i - p) (q_i+1 - q_i-1). One thread a slot.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> index: Index;
@group(0) @binding(2) var<storage, read> offsets: array<u32>; // Of every block's steps; blocks have 8 slots.
@group(0) @binding(3) var<storage, read> steps: array<u32>; // 8 neighbours a step, one for each slot of the block.
@group(0) @binding(4) var<storage, read> state: array<f32>;
@group(0) @binding(5) var<storage, read_write> pull: array<f32>;
@group(0) @binding(6) var<storage, read_write> volumes: array<vec2f>;

var<workgroup> parts: array<vec2f, 256>;

fn gradient_at(slot: u32, p: u32, q: u32) -> f32 {
    let lane = slot % 8u;
    let first = offsets[slot / 8u];
    let end = offsets[slot / 8u + 1u];
    if first == end {
        return 0.0;
    }
    let own = state[p + slot];
    var neighbour = steps[first * 8u + lane];
    let start = state[q + neighbour];
    var before = state[q + steps[(end - 1u) * 8u + lane]];
    var here = start;
    var arm = state[p + neighbour] - own;
    var sum = 0.0;
    for (var step = first + 1u; step < end; step++) {
        neighbour = steps[step * 8u + lane];
        let after = state[q + neighbour];
        sum += arm * (after - before);
        before = here;
        here = after;
        arm = state[p + neighbour] - own;
    }
    return sum + arm * (start - before);
}

@compute @workgroup_size(256)
fn gradient(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let slots = arrayLength(&pull);
    let number = flat_index(group, groups);
    if number >= arrayLength(&volumes) {
        return;
    }
    let slot = number * 256u + lane;
    let axis = frame.turns[index.turn].axis;
    var part = 0.0;
    if slot < slots {
        let six = gradient_at(slot, (axis + 1u) % 3u * slots, (axis + 2u) % 3u * slots);
        pull[slot] = six;
        part = (state[axis * slots + slot] - frame.middle[axis]) * six;
    }
    parts[lane] = vec2f(part, 0.0);
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            parts[lane] = add(parts[lane], parts[lane + half]);
        }
    }
    if lane == 0u {
        volumes[number] = parts[0];
    }
}
