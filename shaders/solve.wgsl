// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest step of the control points along one axis that gives the volume wanted of this turn: equation (17), weighted
// (Remark 2): delta = change W c / (c W c). One group.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> index: Index;
@group(0) @binding(2) var<storage, read> volumes: array<vec2f>;
@group(0) @binding(3) var<storage, read> coefficients: array<vec2f>;
@group(0) @binding(4) var<storage, read> controls: array<vec4f>; // Displacement, and mobility.
@group(0) @binding(5) var<storage, read_write> delta: array<f32>; // One row of control points a turn.
@group(0) @binding(6) var<storage, read_write> status: array<Status, 3>;

var<workgroup> volume_parts: array<vec2f, 256>;
var<workgroup> steep_parts: array<vec2f, 256>;
var<workgroup> factor: f32;

// How far the volume must change in this turn; the second number is 1 where the CPU must see to it.
fn change(volume: vec2f) -> vec2f {
    let turn = frame.turns[index.turn];
    var before = status[0].volume;
    if index.turn == 0u {
        before = volume;
    }
    var target_volume = frame.wanted;
    if frame.amount != 1.0 {
        let way = add(frame.wanted, -before);
        target_volume = add_float(before, frame.amount * (way.x + way.y));
    }
    let missing = add(target_volume, -before);
    if abs(missing.x) <= frame.negligible {
        return vec2f(0.0);
    }
    let ratio = target_volume.x / before.x;
    let signless = abs(before.x) <= frame.no_volume || ratio <= 0.0;
    if frame.balanced == 1u && signless {
        return vec2f(0.0, 1.0);
    }
    // The last turn aims at the target itself: shares add up to 1 only to rounding, and the power is not exact.
    var goal = target_volume;
    if turn.last == 0u {
        if frame.balanced == 1u {
            goal = vec2f(before.x * pow(ratio, turn.done), 0.0);
        } else {
            goal = add_float(before, turn.done * (missing.x + missing.y));
        }
    }
    let left = add(goal, -volume);
    return vec2f(left.x + left.y, 0.0);
}

@compute @workgroup_size(256)
fn solve(@builtin(local_invocation_index) lane: u32) {
    let points = arrayLength(&coefficients);
    var volume = vec2f(0.0);
    for (var i = lane; i < arrayLength(&volumes); i += 256u) {
        volume = add(volume, volumes[i]);
    }
    var steep = vec2f(0.0);
    for (var i = lane; i < points; i += 256u) {
        steep = add_float(steep, coefficients[i].x * coefficients[i].x * controls[i].w);
    }
    volume_parts[lane] = volume;
    steep_parts[lane] = steep;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            volume_parts[lane] = add(volume_parts[lane], volume_parts[lane + half]);
            steep_parts[lane] = add(steep_parts[lane], steep_parts[lane + half]);
        }
    }
    if lane == 0u {
        let found = change(volume_parts[0]);
        // Where nothing is to change, it does not matter that nothing can.
        let flat_axis = sqrt(steep_parts[0].x) <= frame.flat_axis && found.x != 0.0;
        factor = 0.0;
        if !flat_axis && found.x != 0.0 {
            factor = found.x / steep_parts[0].x;
        }
        status[index.turn] = Status(volume_parts[0], steep_parts[0].x, select(u32(found.y), 1u, flat_axis));
    }
    workgroupBarrier();
    for (var i = lane; i < points; i += 256u) {
        delta[index.turn * points + i] = factor * coefficients[i].x * controls[i].w;
    }
}
