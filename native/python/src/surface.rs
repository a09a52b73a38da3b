// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Surface`.

use isochor_core::Surface as Core;
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, Numbers, converted};
use crate::errors::{to_python, warn};

/// Vertices that are fixed linear combinations of points, vertex = sum weight point: a sparse matrix by rows, as scipy's csr_matrix
/// has them.
///
/// offsets (T + 1,): row i has the entries offsets[i] to offsets[i + 1] of columns and weights. columns: points. weights: their shares,
/// which need not sum to 1; a RuntimeWarning says which rows do not, for they do not follow when everything is moved.
/// point_count: number of points; the largest column and one more if None.
///
/// Raises MeshError for offsets that do not rise, rows without entries, columns out of range and weights that are not finite.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Surface {
    pub(crate) core: Core,
}

/// A surface as an argument.
pub(crate) struct SurfaceLike(pub(crate) Core);

impl<'py> FromPyObject<'_, 'py> for SurfaceLike {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = <PyRef<'py, Surface> as FromPyObject<'_, 'py>>::INPUT_TYPE;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let surface = object.extract::<PyRef<'_, Surface>>();
        surface.map(|surface| Self(surface.core.clone())).map_err(|_| {
            Argument::mesh("surface").error(format!("found {object:?}, expected an isochor.Surface or None"))
        })
    }
}

/// Indices that are not negative.
fn counted(name: &'static str, object: &ArrayLike<'_>) -> PyResult<Vec<usize>> {
    let argument = Argument::mesh(name);
    let wide: Vec<i64> = converted(&argument.array(object, Numbers::Integers, &[None])?, "int64")?;
    let index = |(at, &value): (usize, &i64)| {
        usize::try_from(value)
            .map_err(|_| argument.error(format!("found {value} at index {at}, expected no negative number")))
    };
    wide.iter().enumerate().map(index).collect()
}

#[pymethods]
impl Surface {
    #[new]
    #[pyo3(signature = (offsets, columns, weights, point_count=None))]
    fn new(
        py: Python<'_>,
        offsets: ArrayLike<'_>,
        columns: ArrayLike<'_>,
        weights: ArrayLike<'_>,
        point_count: Option<usize>,
    ) -> PyResult<Self> {
        let offsets = counted("offsets", &offsets)?;
        let columns = counted("columns", &columns)?;
        let weights = Argument::mesh("weights").floats(&weights, Numbers::FloatsOrIntegers, &[None])?;
        let count = point_count.unwrap_or_else(|| columns.iter().max().map_or(0, |&largest| largest + 1));
        // What does not fit is out of range too.
        let columns = columns.into_iter().map(|column| u32::try_from(column).unwrap_or(u32::MAX)).collect();
        let core = Core::new(count, offsets, columns, weights).map_err(to_python)?;
        let unbalanced = core.unbalanced().map(|(rows, first, sum)| {
            format!("surface: the weights of {rows} rows do not sum to 1, those of row {first} to {sum}; such vertices do not follow when everything is moved")
        });
        warn(py, unbalanced)?;
        Ok(Self { core })
    }

    /// Number of points that the vertices are combined of.
    #[getter]
    fn point_count(&self) -> usize {
        self.core.point_count()
    }

    /// Start of each row, int64 (T + 1,).
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> NdArray<'py, i64> {
        let offsets: Vec<i64> = self.core.offsets().iter().map(|&start| start as i64).collect();
        NdArray::numbers(py, &offsets)
    }

    /// Points of all rows, int32.
    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> NdArray<'py, i32> {
        let columns: Vec<i32> = self.core.columns().iter().map(|&point| point as i32).collect();
        NdArray::numbers(py, &columns)
    }

    /// Their weights, float64.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> NdArray<'py, f64> {
        NdArray::numbers(py, self.core.weights())
    }

    /// The vertices, float64 (T, k), of points (P, k): positions, or whatever else points have, colours, weights, texture coordinates.
    /// Raises MeshError for another number of points.
    fn apply<'py>(&self, py: Python<'py>, points: ArrayLike<'py>) -> PyResult<NdArray<'py, f64>> {
        let argument = Argument::mesh("points");
        let array = argument.array(&points, Numbers::FloatsOrIntegers, &[None, None])?;
        let [count, width] = argument.dimensions(&array)?;
        let values: Vec<f64> = converted(&array, "float64")?;
        if count != self.core.point_count() {
            return Err(argument.error(format!("found {count}, expected {}", self.core.point_count())));
        }
        let carried = py.detach(|| self.core.carry(&values, width)).map_err(to_python)?;
        NdArray::table(py, carried, [self.core.len(), width])
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    fn __repr__(&self) -> String {
        format!("Surface({} vertices over {} points)", self.core.len(), self.core.point_count())
    }
}
