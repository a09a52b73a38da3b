// SPDX-License-Identifier: GPL-3.0-or-later
//! A closed model of Bézier patches.

use isochor_core::{DVec3, Patches};

use super::noise;

/// A closed body of `4 x rows` patches of degree `degree` around an axis, with poles where whole edges are one point, every other
/// patch numbered along its edges the other way round, and control points that no symmetry explains.
pub fn urn(degree: usize, rows: usize) -> Patches {
    let (around, down) = (4 * degree, rows * degree);
    let mut random = noise(17);
    let mut points = vec![DVec3::new(0.1, -0.05, 1.0)];
    for r in 1..down {
        let height = 1.0 - 2.0 * r as f64 / down as f64;
        for k in 0..around {
            let angle = std::f64::consts::TAU * k as f64 / around as f64;
            let radius = 0.4 + 0.5 * (1.0 - height * height).sqrt() + 0.05 * random();
            points.push(DVec3::new(radius * angle.cos(), radius * angle.sin(), height + 0.05 * random()));
        }
    }
    points.push(DVec3::new(-0.05, 0.1, -1.0));
    let last = points.len() as u32 - 1;
    let at = |r: usize, k: usize| match r {
        0 => 0,
        _ if r == down => last,
        _ => (1 + (r - 1) * around + k % around) as u32,
    };
    let mut indices = Vec::new();
    for row in 0..rows {
        for sector in 0..4 {
            for i in 0..=degree {
                // Down and around is clockwise seen from outside; from below and around it is not.
                for j in 0..=degree {
                    let r = if (row + sector) % 2 == 0 { degree - i } else { i };
                    indices.push(at(row * degree + r, sector * degree + j));
                }
            }
        }
    }
    Patches::new(points, [degree + 1; 2], indices).unwrap()
}
