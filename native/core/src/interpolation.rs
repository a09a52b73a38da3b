// SPDX-License-Identifier: GPL-3.0-or-later
//! The bases of Blender's own lattice, each as a spline over inner control points.
//!
//! Blender's lattice has `n` evenly spaced points an axis. At a distance `t` from point `i`, in units of their spacing, four act,
//! `i - 1` to `i + 2`, with cubics of `t` as factors; beyond the ends the *indices* are clamped, so the first and the last point
//! stand for those that are missing, and the lattice goes on for one cell on each side before it is constant.

use crate::basis::{AxisBasis, Rows, Sums, check_count};
use crate::error::Result;

/// How Blender's lattice goes from point to point along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Piecewise linear.
    Linear,
    /// Through the points, with tangents of 0.71 times the way between a point's neighbours.
    Cardinal,
    /// The same with half of that way.
    CatmullRom,
    /// The uniform cubic B-spline.
    BSpline,
}

impl AxisBasis {
    /// An axis of Blender's own lattice, with `count` points evenly spaced over `[0, 1]`.
    ///
    /// # Errors
    /// `count` is 0 or above [`crate::MAX_POINTS`].
    pub fn blender(count: usize, interpolation: Interpolation) -> Result<Self> {
        check_count(count)?;
        match interpolation {
            _ if count == 1 => Self::bernstein(1),
            Interpolation::Linear => Self::clamped(count, 1),
            Interpolation::BSpline => Ok(uniform(count)),
            Interpolation::Cardinal => Ok(through_points(count, 0.71)),
            Interpolation::CatmullRom => Ok(through_points(count, 0.5)),
        }
    }
}

/// The uniform cubic over the points, with the first and the last one repeated twice: it is constant from the second cell beyond on.
fn uniform(count: usize) -> AxisBasis {
    let inner = count + 4;
    let knots = (0..inner + 4).map(|i| (i as f64 - 4.0) / (count - 1) as f64).collect();
    let rows = (0..inner).map(|j| vec![(j.saturating_sub(2).min(count - 1), 1.0)]).collect();
    summed(count, knots, rows)
}

/// Piecewise cubics through the points. With every knot twice, control points are the inner two of each cell in Bernstein's form:
/// a third of the tangent from each end.
fn through_points(count: usize, tension: f64) -> AxisBasis {
    let last = count as i64;
    let ends = |at: i64| [at; 4];
    let knots: Vec<i64> =
        ends(-1).into_iter().chain((0..last).flat_map(|i| [i, i])).chain(ends(last)).collect();
    let knots = knots.into_iter().map(|knot| knot as f64 / (count - 1) as f64).collect();
    let point = |i: i64| i.clamp(0, last - 1) as usize;
    let from = |i: i64, way: f64| {
        merged([(point(i), 1.0), (point(i + 1), way * tension / 3.0), (point(i - 1), -way * tension / 3.0)])
    };
    let cells = (-1..last).flat_map(|i| [from(i, 1.0), from(i + 1, -1.0)]);
    let rows = [from(-1, 0.0)].into_iter().chain(cells).chain([from(last, 0.0)]).collect();
    summed(count, knots, rows)
}

fn summed(count: usize, knots: Vec<f64>, rows: Rows) -> AxisBasis {
    AxisBasis::of_spline(rows.len(), 3, knots, Some(Sums { count, rows, beyond: 1 }))
}

/// Entries of one row, those of one column added up.
fn merged(entries: [(usize, f64); 3]) -> Vec<(usize, f64)> {
    let mut row: Vec<(usize, f64)> = Vec::with_capacity(3);
    for (point, share) in entries {
        match row.iter_mut().find(|(known, _)| *known == point) {
            Some((_, sum)) => *sum += share,
            None => row.push((point, share)),
        }
    }
    row
}
