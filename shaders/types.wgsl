// SPDX-License-Identifier: GPL-3.0-or-later
// What the kernels share. Coordinates are relative to the lattice's centre, in units of a power of two near its size;
// volumes are six times the volume, in cubic units.
//
// In front of this file stand constants of the lattice: TAPS_U, TAPS_V, TAPS_W (degree + 1 of each axis), MAX_TAPS (the
// largest of them), TAPS (their product) and STAGED (whether a cell's control points fit in workgroup memory).

// One turn of the correction: one axis takes its share.
struct Turn {
    axis: u32,
    last: u32,
    done: f32, // Sum of the shares up to and with this turn.
    unused: u32,
}

// What changes from frame to frame, beside the control points.
struct Frame {
    to_frame: array<vec4f, 3>,   // Columns of the map to the coordinates in which the axes are meant.
    from_frame: array<vec4f, 3>, // Columns of the map back.
    turns: array<Turn, 3>,
    middle: vec4f,    // Origin of the volume's sum.
    shape: vec4u,     // Control points along u, v, w.
    wanted: vec2f,    // Volume to reach at amount 1, as a two-float.
    amount: f32,
    balanced: u32,    // 1: geometric steps; 0: equal ones.
    flat_axis: f32,   // An axis with coefficients no larger than this is left to the CPU.
    no_volume: f32,   // A volume no larger than this has no sign.
    zero: u32,        // 0, which no compiler knows: see two_float.wgsl.
    negligible: f32,  // A volume this close to the target needs no correction.
}

// Which of frame.turns a dispatch does.
struct Index {
    turn: u32,
}

// Consecutive slots in one cell of the lattice.
struct Tile {
    first_slot: u32,
    slots: u32,
    first_point: u32, // The cell's control point with the smallest indices.
    knots_u: u32,     // Start of the cell's steps in knots, for each axis.
    knots_v: u32,
    knots_w: u32,
}

// What a turn found.
struct Status {
    volume: vec2f, // Before the turn, as a two-float.
    steep: f32,    // c W c.
    left_to_cpu: u32,
}

// A dispatch of more groups than fit along x goes on along y.
fn flat_index(group: vec3u, groups: vec3u) -> u32 {
    return group.y * groups.x + group.x;
}
