// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes that stand any way in space (Hoff), and a small one around points.
//!
//! The box is searched for, for what crates offer is the box along the principal axes, which around a plank with uneven
//! vertices is far from the smallest. What the search finds is the smallest box for a box however turned; elsewhere it may miss the
//! very smallest by a little.

mod outline;
mod search;

use glam::{DMat3, DVec3};

use crate::basis::AxisBasis;
use crate::error::{Error, Result};
use crate::lattice::{Lattice, bounds, check_around, unit_columns, widened};
use crate::oriented::search::{nearest_order, smallest};
use crate::words::{bracketed, number};

/// Directions count as independent where their unit columns enclose more than this volume.
const INDEPENDENT: f64 = 1e-12;

/// A box by its centre, its axes and how far it reaches along them (Hoff).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Middle of the box.
    pub centre: DVec3,
    /// Unit vectors along its sides, as columns.
    pub axes: DMat3,
    /// Half of each side's length.
    pub half_widths: DVec3,
}

impl OrientedBox {
    /// The smallest box that the search finds around points. Its axes are orthonormal and right-handed, in the order and pointing the way
    /// that is nearest to the columns of `like` (the coordinate axes where that is `None`); where no box is smaller than the one along
    /// those, it is that. Flat points have a flat box, a single one a box of size 0.
    ///
    /// # Errors
    /// [`Error::Lattice`] without points or with non-finite ones, and for directions `like` that lie in one plane.
    pub fn around(points: &[DVec3], like: Option<DMat3>) -> Result<Self> {
        check_around(points, 0.0)?;
        let like = orthonormal(like.unwrap_or(DMat3::IDENTITY))?;
        let (low, high) = bounds(points);
        let middle = low * 0.5 + high * 0.5;
        let reach = (high - middle).max_element();
        let scale = if reach > 0.0 { reach } else { 1.0 };
        let offsets: Vec<DVec3> = points.iter().map(|p| (p - middle) / scale).collect();
        let axes = nearest_order(smallest(&offsets, like), like);
        let along: Vec<DVec3> = offsets.iter().map(|p| axes.transpose() * *p).collect();
        let (low, high) = bounds(&along);
        let centre = middle + axes * (low + high) * (0.5 * scale);
        Ok(Self { centre, axes, half_widths: (high - low) * (0.5 * scale) })
    }
}

impl Lattice {
    /// A lattice whose domain is a box: its origin is the centre less all half-widths along the axes, which need not be of length 1, nor
    /// orthogonal.
    ///
    /// # Errors
    /// [`Error::Lattice`] for a centre that is not finite, for half-widths that are not positive, and for axes of length 0, in one plane, or not finite.
    pub fn boxed(axes: [AxisBasis; 3], domain: OrientedBox) -> Result<Self> {
        let OrientedBox { centre, axes: directions, half_widths } = domain;
        if !centre.is_finite() {
            return Err(Error::Lattice(format!(
                "centre: found {}, expected finite numbers",
                bracketed(centre.to_array())
            )));
        }
        if let Some(axis) = (0..3).find(|&axis| !(half_widths[axis] > 0.0 && half_widths[axis].is_finite())) {
            return Err(Error::Lattice(format!(
                "half_widths: found {} along axis {}, expected a positive number",
                number(half_widths[axis]),
                ["s", "t", "u"][axis]
            )));
        }
        let unit = unit_columns(directions);
        if !independent(unit) {
            return Err(dependent("axes", directions));
        }
        let halves = unit * DMat3::from_diagonal(half_widths);
        Self::new(axes, centre - halves * DVec3::ONE, halves * 2.0)
    }

    /// A lattice over the box that [`OrientedBox::around`] finds, widened as [`Lattice::around`] widens its own.
    ///
    /// # Errors
    /// As [`Lattice::around`].
    pub fn around_oriented(axes: [AxisBasis; 3], points: &[DVec3], margin: f64) -> Result<Self> {
        check_around(points, margin)?;
        let found = OrientedBox::around(points, None)?;
        let (low, size) = widened(-found.half_widths, found.half_widths, margin);
        Self::new(axes, found.centre + found.axes * low, found.axes * DMat3::from_diagonal(size))
    }
}

/// The directions made orthonormal, in order (Gram, Schmidt).
fn orthonormal(directions: DMat3) -> Result<DMat3> {
    let unit = unit_columns(directions);
    if !independent(unit) {
        return Err(dependent("like", directions));
    }
    let one = unit.x_axis;
    let other = (unit.y_axis - one * one.dot(unit.y_axis)).normalize();
    let last = one.cross(other);
    Ok(DMat3::from_cols(one, other, last * last.dot(unit.z_axis).signum()))
}

/// Never for NaN.
fn independent(unit: DMat3) -> bool {
    unit.determinant().abs() > INDEPENDENT
}

fn dependent(name: &str, directions: DMat3) -> Error {
    let rows = [directions.x_axis, directions.y_axis, directions.z_axis].map(|d| bracketed(d.to_array()));
    Error::Lattice(format!(
        "{name}: found {}, expected three finite, independent directions",
        rows.join(", ")
    ))
}
