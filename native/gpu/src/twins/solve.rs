// SPDX-License-Identifier: GPL-3.0-or-later
//! Twin of `solve.wgsl`.

use super::tree;
use super::two_float::{TwoFloat, add, add_float};
use crate::kernels::GROUP;
use crate::types::{Frame, Status};

/// The step of the control points in a turn, and what the turn found. `before`: the volume that the first turn found, `None`
/// in the first.
pub fn solve(
    frame: &Frame,
    turn: usize,
    volumes: &[TwoFloat],
    coefficients: &[TwoFloat],
    controls: &[[f32; 4]],
    before: Option<TwoFloat>,
) -> (Vec<f32>, Status) {
    let lanes = |f: &dyn Fn(usize) -> TwoFloat| tree((0..GROUP).map(f).collect(), add).unwrap_or_default();
    let volume =
        lanes(&|lane| volumes.iter().skip(lane).step_by(GROUP).fold([0.0; 2], |sum, &part| add(sum, part)));
    let steep = lanes(&|lane| {
        let own = coefficients.iter().zip(controls).skip(lane).step_by(GROUP);
        own.fold([0.0; 2], |sum, (c, control)| add_float(sum, c[0] * c[0] * control[3]))
    });
    let (change, left_to_cpu) = change(frame, turn, volume, before.unwrap_or(volume));
    let flat = steep[0].sqrt() <= frame.flat_axis && change != 0.0;
    let factor = if flat || change == 0.0 { 0.0 } else { change / steep[0] };
    let delta = coefficients.iter().zip(controls).map(|(c, control)| factor * c[0] * control[3]).collect();
    (delta, Status { volume, steep: steep[0], left_to_cpu: u32::from(flat || left_to_cpu) })
}

/// How far the volume must change in this turn, and whether the CPU must see to it.
fn change(frame: &Frame, turn: usize, volume: TwoFloat, before: TwoFloat) -> (f32, bool) {
    let turn = frame.turns[turn];
    let less = |a: TwoFloat, b: TwoFloat| add(a, [-b[0], -b[1]]);
    let target = if frame.amount == 1.0 {
        frame.wanted
    } else {
        let way = less(frame.wanted, before);
        add_float(before, frame.amount * (way[0] + way[1]))
    };
    let missing = less(target, before);
    if missing[0].abs() <= frame.negligible {
        return (0.0, false);
    }
    let ratio = target[0] / before[0];
    if frame.balanced == 1 && (before[0].abs() <= frame.no_volume || ratio <= 0.0) {
        return (0.0, true);
    }
    let goal = if turn.last == 1 {
        target
    } else if frame.balanced == 1 {
        [before[0] * ratio.powf(turn.done), 0.0]
    } else {
        add_float(before, turn.done * (missing[0] + missing[1]))
    };
    let left = less(goal, volume);
    (left[0] + left[1], false)
}
