// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments and results with two coordinates, and the bases of a lattice with two axes.

use isochor_core::{AxisBasis, DVec2, DVec3};
use numpy::{Element, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::arrays::{Argument, ArrayLike, NdArray, Numbers, OfVertices};
use crate::words::{BasisWord, KnotsWord};

/// `knots` of two axes: a word, or two arrays.
pub(crate) enum PlaneKnots<'py> {
    Uniform,
    Given(Bound<'py, PyAny>),
}

impl<'py> FromPyObject<'_, 'py> for PlaneKnots<'py> {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = <KnotsWord<'py> as FromPyObject<'_, 'py>>::INPUT_TYPE;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self::Given(object.to_owned()))
    }
}

impl<'py> PlaneKnots<'py> {
    /// The same for three axes, the third with one control point.
    fn with_third(self, py: Python<'py>) -> PyResult<KnotsWord<'py>> {
        let Self::Given(object) = self else { return Ok(KnotsWord::Uniform) };
        if object.is_instance_of::<PyString>() {
            return object.extract();
        }
        let items: Vec<Bound<'py, PyAny>> = object.try_iter().and_then(Iterator::collect).unwrap_or_default();
        match <[Bound<'py, PyAny>; 2]>::try_from(items) {
            Ok([s, t]) => Ok(KnotsWord::Given(vec![s, t, PyTuple::new(py, [0.0, 1.0])?.into_any()])),
            Err(items) => Err(Argument::lattice("knots").error(format!(
                "found {} items, expected \"uniform\", \"clamped\" or two arrays",
                items.len()
            ))),
        }
    }
}

/// The bases of a lattice of the plane.
pub(crate) fn axes<'py>(
    py: Python<'py>,
    shape: Option<ArrayLike<'py>>,
    basis: BasisWord,
    degree: Option<ArrayLike<'py>>,
    knots: PlaneKnots<'py>,
) -> PyResult<[AxisBasis; 2]> {
    let shape = match shape {
        Some(shape) => with_third(py, "shape", &shape, 1)?,
        None => triple(py, [4, 4, 1])?,
    };
    // One number stands for all axes; with Bernstein there is one right answer for each.
    let is_single = degree.as_ref().is_some_and(|degree| degree.is_number());
    let degree = match degree {
        Some(degree) if is_single && basis != BasisWord::Bernstein => Some(degree),
        Some(degree) => Some(with_third(py, "degree", &degree, 0)?),
        None => None,
    };
    let [s, t, _] = crate::axes::axes(Some(shape), basis, degree, knots.with_third(py)?, None)?;
    Ok([s, t])
}

/// Two counts, or one for both, and a third.
fn with_third<'py>(
    py: Python<'py>,
    name: &'static str,
    counts: &ArrayLike<'py>,
    third: i64,
) -> PyResult<ArrayLike<'py>> {
    let argument = Argument::lattice(name);
    let counts: Vec<i64> = if counts.is_number() {
        vec![argument.integers(counts, &[])?[0]; 2]
    } else {
        argument.integers(counts, &[Some(2)])?
    };
    triple(py, [counts[0], counts[1], third])
}

fn triple(py: Python<'_>, counts: [i64; 3]) -> PyResult<ArrayLike<'_>> {
    PyTuple::new(py, counts)?.extract().map_err(|_| PyTypeError::new_err("three counts"))
}

/// Points (V, 2).
pub(crate) fn points(argument: Argument, object: &ArrayLike<'_>) -> PyResult<Vec<DVec2>> {
    let values = argument.floats(object, Numbers::FloatsOrIntegers, &[None, Some(2)])?;
    let points: Vec<DVec2> = values.as_chunks().0.iter().map(|&p| DVec2::from_array(p)).collect();
    match points.iter().position(|p| !p.is_finite()) {
        Some(i) => {
            Err(argument.error(format!("found NaN or infinity at index {i}, expected finite numbers")))
        }
        None => Ok(points),
    }
}

/// Control points (nu, nv, 2), in space.
pub(crate) fn control(argument: Argument, object: &ArrayLike<'_>, shape: [usize; 3]) -> PyResult<Vec<DVec3>> {
    let [nu, nv, _] = shape.map(Some);
    let values = argument.floats(object, Numbers::Floats, &[nu, nv, Some(2)])?;
    Ok(values.as_chunks().0.iter().map(|&p| DVec2::from_array(p).extend(0.0)).collect())
}

/// An array of points without their third coordinate: `shape` and 2.
pub(crate) fn flattened<'py>(
    py: Python<'py>,
    points: &[DVec3],
    shape: &[usize],
) -> PyResult<NdArray<'py, f64>> {
    let flat: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y]).collect();
    let shape: Vec<usize> = shape.iter().copied().chain([2]).collect();
    Ok(NdArray::of(PyArray1::from_vec(py, flat).reshape(shape)?.as_untyped().clone()))
}

/// Vertices (V, 2) in their own type.
pub(crate) fn vertices<'py, T: Element>(
    py: Python<'py>,
    rows: Vec<[T; 2]>,
) -> PyResult<NdArray<'py, OfVertices>> {
    let count = rows.len();
    let flat = PyArray1::from_vec(py, rows.into_iter().flatten().collect());
    Ok(NdArray::of(flat.reshape([count, 2])?.as_untyped().clone()))
}

/// Points (V, 2) of either precision as they come in.
pub(crate) enum PlaneRows {
    Single(Vec<[f32; 2]>),
    Double(Vec<[f64; 2]>),
}

impl PlaneRows {
    pub(crate) fn extract(object: &ArrayLike<'_>) -> PyResult<Self> {
        let argument = Argument::mesh("vertices");
        let array = argument.array(object, Numbers::Floats, &[None, Some(2)])?;
        match array.dtype().to_string().as_str() {
            "float32" => {
                Ok(Self::Single(crate::arrays::converted(&array, "float32")?.as_chunks().0.to_vec()))
            }
            "float64" => {
                Ok(Self::Double(crate::arrays::converted(&array, "float64")?.as_chunks().0.to_vec()))
            }
            other => Err(argument.error(format!("found dtype {other}, expected float32 or float64"))),
        }
    }
}
