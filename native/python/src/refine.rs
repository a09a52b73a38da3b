// SPDX-License-Identifier: GPL-3.0-or-later
//! More control points for the same shape, blends of shapes and their derivatives: the arguments of `isochor.Lattice`'s methods.

use isochor_core::{DVec3, Lattice as Core, RefineAxis};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::{type_hint_identifier, type_hint_subscript, type_hint_union};

use crate::arrays::{Argument, ArrayLike, NdArray, Numbers};
use crate::errors::to_python;

/// `insert`: three sequences of parameters, or None for an axis.
pub(crate) struct InsertLike([Vec<f64>; 3]);

impl<'py> FromPyObject<'_, 'py> for InsertLike {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_subscript!(
        type_hint_identifier!("collections.abc", "Sequence"),
        type_hint_union!(
            type_hint_identifier!("numpy.typing", "ArrayLike"),
            type_hint_identifier!("builtins", "None")
        )
    );

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let argument = Argument::lattice("insert");
        let wrong =
            || argument.error("expected three sequences of parameters along s, t, u, or None in their place");
        let items: Vec<Option<ArrayLike<'py>>> = object.extract().map_err(|_| wrong())?;
        let Ok(items) = <[Option<ArrayLike<'py>>; 3]>::try_from(items) else { return Err(wrong()) };
        let mut knots: [Vec<f64>; 3] = Default::default();
        for (knots, item) in knots.iter_mut().zip(items) {
            if let Some(item) = item {
                *knots = argument.floats(&item, Numbers::FloatsOrIntegers, &[None])?;
            }
        }
        Ok(Self(knots))
    }
}

/// The refined lattice, whether knots were inserted, and the control points, with sets of them in front where there were several.
pub(crate) fn refined<'py>(
    py: Python<'py>,
    lattice: &Core,
    is_bernstein: bool,
    control: &ArrayLike<'py>,
    to: [Option<ArrayLike<'py>>; 2],
    insert: Option<InsertLike>,
) -> PyResult<(Core, bool, NdArray<'py, f64>)> {
    let (sets, control) = Argument::lattice("control").sets(control, lattice.shape())?;
    let [shape, degree] = to;
    let shape = shape.map(|shape| Argument::lattice("shape").counts(&shape, false)).transpose()?;
    let degree = degree.map(|degree| Argument::lattice("degree").counts(&degree, true)).transpose()?;
    let insert = insert.map(|insert| insert.0).unwrap_or_default();
    let has_knots = insert.iter().any(|knots| !knots.is_empty());
    let mut axes: [RefineAxis; 3] = Default::default();
    for (axis, (to, insert)) in axes.iter_mut().zip(insert).enumerate() {
        let (count, degree) = (shape.map(|shape| shape[axis]), degree.map(|degree| degree[axis]));
        let raises = is_bernstein && insert.is_empty() && lattice.shape()[axis] > 1;
        *to = RefineAxis { degree, insert, count };
        if let (true, Some(count)) = (raises, count) {
            *to = RefineAxis { degree: Some(raised_degree(count, degree)?), ..RefineAxis::default() };
        }
    }
    let refinement = py.detach(|| lattice.refine(&axes)).map_err(to_python)?;
    let finer: isochor_core::Result<Vec<Vec<DVec3>>> =
        py.detach(|| control.chunks(lattice.len()).map(|set| refinement.control(set)).collect());
    let fine = refinement.lattice().clone();
    let [nu, nv, nw] = fine.shape();
    let all: Vec<usize> = sets.into_iter().chain([nu, nv, nw, 3]).collect();
    let finer = NdArray::points(py, &finer.map_err(to_python)?.concat(), &all)?;
    Ok((fine, has_knots, finer))
}

/// The degree of a Bernstein axis with `count` points.
fn raised_degree(count: usize, degree: Option<usize>) -> PyResult<usize> {
    let raised = count.saturating_sub(1);
    match degree {
        Some(degree) if degree != raised => Err(Argument::lattice("degree").error(format!(
            "found {degree}, but a Bernstein axis with {count} points has degree {raised}; leave degree or shape out"
        ))),
        _ => Ok(raised),
    }
}

/// Sets of control points mixed by weights.
pub(crate) fn blended<'py>(
    py: Python<'py>,
    lattice: &Core,
    sets: &ArrayLike<'py>,
    weights: &ArrayLike<'py>,
) -> PyResult<NdArray<'py, f64>> {
    let shape = lattice.shape();
    let [nu, nv, nw] = shape.map(Some);
    let flat = Argument::lattice("sets").floats(sets, Numbers::Floats, &[None, nu, nv, nw, Some(3)])?;
    let weights = Argument::lattice("weights").floats(weights, Numbers::FloatsOrIntegers, &[None])?;
    let points: Vec<DVec3> = flat.as_chunks().0.iter().map(|&p| DVec3::from_array(p)).collect();
    let sets: Vec<&[DVec3]> = points.chunks(lattice.len()).collect();
    let mixed = py.detach(|| lattice.blend(&sets, &weights)).map_err(to_python)?;
    NdArray::points(py, &mixed, &[shape[0], shape[1], shape[2], 3])
}

/// Derivatives as rows, (V, 3, 3).
pub(crate) fn derivatives<'py>(
    py: Python<'py>,
    lattice: &Core,
    parameters: &ArrayLike<'py>,
    control: &ArrayLike<'py>,
) -> PyResult<NdArray<'py, f64>> {
    let parameters = Argument::lattice("parameters").points(parameters)?;
    let control = Argument::lattice("control").control(control, lattice.shape())?;
    let found = py.detach(|| lattice.derivative(&parameters, &control)).map_err(to_python)?;
    let rows: Vec<DVec3> = found.iter().flat_map(|m| [m.x_axis, m.y_axis, m.z_axis]).collect();
    NdArray::points(py, &rows, &[found.len(), 3, 3])
}
