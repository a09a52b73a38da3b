// SPDX-License-Identifier: GPL-3.0-or-later
//! What the host and the kernels both read: the structures of `shaders/types.wgsl`, checked against it by reflection
//! (`tests/reflection.rs`).

use bytemuck::{Pod, Zeroable};

/// One turn of the correction: one axis takes its share.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Turn {
    /// Axis of the frame.
    pub axis: u32,
    /// 1 in the last turn.
    pub last: u32,
    /// Sum of the shares up to and with this turn.
    pub done: f32,
    /// Fills the structure up to the 16 bytes that arrays in uniforms ask for.
    pub unused: u32,
}

/// What changes from frame to frame, beside the control points.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Columns of the map to the coordinates in which the axes are meant.
    pub to_frame: [[f32; 4]; 3],
    /// Columns of the map back.
    pub from_frame: [[f32; 4]; 3],
    /// The turns, of which the first few are taken.
    pub turns: [Turn; 3],
    /// Origin of the volume's sum.
    pub middle: [f32; 4],
    /// Control points along u, v, w.
    pub shape: [u32; 4],
    /// Volume to reach at amount 1, as a two-float.
    pub wanted: [f32; 2],
    /// How much of the way to go.
    pub amount: f32,
    /// 1: geometric steps; 0: equal ones.
    pub balanced: u32,
    /// An axis whose coefficients have a norm no larger than this is left to the CPU.
    pub flat_axis: f32,
    /// A volume no larger than this has no sign.
    pub no_volume: f32,
    /// 0, which no compiler knows.
    pub zero: u32,
    /// A volume this close to the target needs no correction.
    pub negligible: f32,
}

/// Which of the frame's turns a dispatch does.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Index {
    /// From 0.
    pub turn: u32,
}

/// Consecutive slots in one cell of the lattice.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Tile {
    /// The first of them.
    pub first_slot: u32,
    /// Their number.
    pub slots: u32,
    /// The cell's control point with the smallest indices, flat.
    pub first_point: u32,
    /// Start of the cell's steps among the knots, along u.
    pub knots_u: u32,
    /// The same along v.
    pub knots_v: u32,
    /// The same along w.
    pub knots_w: u32,
}

/// What a turn found.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Status {
    /// Six times the volume before the turn, as a two-float.
    pub volume: [f32; 2],
    /// `c W c`, the square of the coefficients' norm.
    pub steep: f32,
    /// 1 where the axis is flat or the volumes have no ratio: the CPU must do the call.
    pub left_to_cpu: u32,
}
