// SPDX-License-Identifier: GPL-3.0-or-later
//! Boxes that stand any way in space: the arguments of `isochor.Lattice.box` and `isochor.oriented_box`.

use isochor_core::{DMat3, OrientedBox};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray};
use crate::errors::to_python;

/// A box from the arguments centre (3,), axes (3, 3) rows and half_widths (3,).
pub(crate) fn given(
    centre: &ArrayLike<'_>,
    axes: Option<&ArrayLike<'_>>,
    half_widths: &ArrayLike<'_>,
) -> PyResult<OrientedBox> {
    Ok(OrientedBox {
        centre: Argument::lattice("centre").vector(centre)?,
        axes: axes.map_or(Ok(DMat3::IDENTITY), |axes| columns("axes", axes))?,
        half_widths: Argument::lattice("half_widths").vector(half_widths)?,
    })
}

fn columns(name: &'static str, rows: &ArrayLike<'_>) -> PyResult<DMat3> {
    let [one, other, last] = Argument::lattice(name).rows(rows)?;
    Ok(DMat3::from_cols(one, other, last))
}

/// The smallest box that a search finds around points (V, 3): its centre (3,), its axes as orthonormal, right-handed rows (3, 3), and
/// its half-widths along them (3,), all float64.
///
/// like: directions as rows (3, 3). The axes come in the order, and point the way, that is nearest to them, and where no box is smaller
/// than the one along them, that is it. None for the coordinate axes.
///
/// About a given axis the smallest box has a side along an edge of the points' outline as seen along it: the search turns the box so
/// about each of its axes in turn until it gets no smaller, from the given directions, the principal axes, and directions spread over the
/// sphere. It finds the smallest box for a box however turned; elsewhere it may miss the very smallest by a little. Flat points have a
/// flat box, a single point one of size 0: `Lattice.around` with fit="oriented" widens those.
///
/// Raises LatticeError.
#[pyfunction]
#[pyo3(signature = (points, like=None))]
pub(crate) fn oriented_box<'py>(
    py: Python<'py>,
    points: ArrayLike<'py>,
    like: Option<ArrayLike<'py>>,
) -> PyResult<(NdArray<'py, f64>, NdArray<'py, f64>, NdArray<'py, f64>)> {
    let points = Argument::lattice("points").points(&points)?;
    let like = like.map(|like| columns("like", &like)).transpose()?;
    let found = py.detach(|| OrientedBox::around(&points, like)).map_err(to_python)?;
    let rows = [found.axes.x_axis, found.axes.y_axis, found.axes.z_axis];
    Ok((
        NdArray::points(py, &[found.centre], &[3])?,
        NdArray::points(py, &rows, &[3, 3])?,
        NdArray::points(py, &[found.half_widths], &[3])?,
    ))
}
