// SPDX-License-Identifier: GPL-3.0-or-later
//! The rotation nearest to a matrix, whatever the matrix.

use glam::{DMat3, DQuat};

/// Rounds at most; a start next to the answer needs two or three.
const ROUNDS: usize = 60;

/// Turn, in radians, below which the search ends.
const SMALLEST_TURN: f64 = 1e-13;

/// The rotation nearest to `matrix`, searched for from `start` (M. Müller, J. Bender, N. Chentanez, M. Macklin, "A robust
/// method to extract the rotational part of deformations", 2016, algorithm 1). It is a rotation for flat and inverted
/// matrices too; for zero it is `start`.
pub(super) fn nearest(matrix: DMat3, start: DQuat) -> DQuat {
    let scale = matrix.to_cols_array().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if scale <= 0.0 {
        return start;
    }
    let mut rotation = start;
    for _ in 0..ROUNDS {
        let r = DMat3::from_quat(rotation);
        let across =
            r.x_axis.cross(matrix.x_axis) + r.y_axis.cross(matrix.y_axis) + r.z_axis.cross(matrix.z_axis);
        let turn = across / (along(r, matrix).abs() + 1e-9 * scale);
        let angle = turn.length();
        if angle < SMALLEST_TURN {
            break;
        }
        rotation = (DQuat::from_axis_angle(turn / angle, angle) * rotation).normalize();
    }
    rotation
}

/// The same without a start to trust: a search from a half turn away would stand still, so that four starts are compared.
pub(super) fn nearest_of_all(matrix: DMat3) -> DQuat {
    let halves =
        [DQuat::IDENTITY, DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0), DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0)];
    let fit = |q: DQuat| along(DMat3::from_quat(q), matrix);
    let mut best = DQuat::IDENTITY;
    for start in halves.into_iter().chain([DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0)]) {
        if fit(start) > fit(best) {
            best = start;
        }
    }
    nearest(matrix, best)
}

/// Trace of the product of the rotation's transpose with the matrix: largest for the nearest rotation.
fn along(rotation: DMat3, matrix: DMat3) -> f64 {
    rotation.x_axis.dot(matrix.x_axis)
        + rotation.y_axis.dot(matrix.y_axis)
        + rotation.z_axis.dot(matrix.z_axis)
}
