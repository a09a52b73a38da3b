// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's coefficients (10)-(12), times six: every control point adds what the runs of its cells found, in a fixed order.
// One group a control point.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> starts: array<u32>; // Of every control point's entries.
@group(0) @binding(2) var<storage, read> entries: array<u32>; // Indices into partials.
@group(0) @binding(3) var<storage, read> partials: array<f32>;
@group(0) @binding(4) var<storage, read_write> coefficients: array<vec2f>;

var<workgroup> parts: array<vec2f, 64>;

@compute @workgroup_size(64)
fn gather(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let point = flat_index(group, groups);
    if point >= arrayLength(&coefficients) {
        return;
    }
    let end = starts[point + 1u];
    var sum = vec2f(0.0);
    for (var entry = starts[point] + lane; entry < end; entry += 64u) {
        sum = add_float(sum, partials[entries[entry]]);
    }
    parts[lane] = sum;
    for (var half = 32u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            parts[lane] = add(parts[lane], parts[lane + half]);
        }
    }
    if lane == 0u {
        coefficients[point] = parts[0];
    }
}
