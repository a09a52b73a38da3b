// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Folds`, where a lattice folds over.

use isochor_core::{DEPTH, Folds as Core, MOST_DEPTH, Verdict};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray};

/// Where a shaped lattice folds over, or that it does not: the result of `Lattice.folds`. True where it is known to fold.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Folds(pub(crate) Core);

#[pymethods]
impl Folds {
    /// "unfolded": proved to fold nowhere, locally; "folded": there are points; "undecided": neither proved nor found, because the
    /// determinant comes too near to zero somewhere, as in a shape that is flat in a place.
    #[getter]
    fn verdict(&self) -> &'static str {
        match self.0.verdict {
            Verdict::Unfolded => "unfolded",
            Verdict::Folded => "folded",
            Verdict::Undecided => "undecided",
        }
    }

    /// Parameters (s, t, u), float64 (K, 3), where the determinant has the wrong sign: in each cell that folds, those of a regular grid
    /// of at least sixteen along each axis of the domain; or one, where the fold is too small for that.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &self.0.parameters, &[self.0.parameters.len(), 3])
    }

    /// Where the lattice takes them, float64 (K, 3).
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &self.0.points, &[self.0.points.len(), 3])
    }

    /// Where it is undecided, float64 (K, 3): for each such cell of the lattice, where it takes the middle of a piece left open.
    #[getter]
    fn undecided<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &self.0.undecided, &[self.0.undecided.len(), 3])
    }

    fn __bool__(&self) -> bool {
        self.0.verdict == Verdict::Folded
    }

    fn __repr__(&self) -> String {
        format!(
            "Folds(verdict={:?}, points={}, undecided={})",
            self.verdict(),
            self.0.points.len(),
            self.0.undecided.len()
        )
    }
}

/// The argument `depth`.
pub(crate) fn halvings(depth: Option<&ArrayLike<'_>>) -> PyResult<u32> {
    let Some(depth) = depth else { return Ok(DEPTH) };
    let argument = Argument::lattice("depth");
    let [count, ..] = argument.counts(depth, true)?;
    u32::try_from(count)
        .ok()
        .filter(|count| *count <= MOST_DEPTH)
        .ok_or_else(|| argument.error(format!("found {count}, expected 0 to {MOST_DEPTH}")))
}
