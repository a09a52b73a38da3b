// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Preserved`, the result of a correction.

use numpy::PyUntypedArray;
use pyo3::prelude::*;

use crate::arrays::{NdArray, OfVertices};
use crate::backend::Ran;
use crate::binding::{Shared, surface_over, volumes};
use crate::words::method_name;

/// A mesh deformed with its volume corrected: the result of `Binding.preserve`.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Preserved {
    binding: Shared,
    control: Py<PyUntypedArray>,
    vertices: Py<PyUntypedArray>,
    targets: Vec<f64>,
    /// What computed, after any fall-back: "cpu" or "gpu".
    #[pyo3(get)]
    device: &'static str,
    /// Seconds that the GPU's kernels took by its own clock, or None.
    #[pyo3(get)]
    device_seconds: Option<f64>,
    /// What ran, after any fall-back: "balanced", "sweep", "gradient" or "nearest".
    #[pyo3(get)]
    method: &'static str,
    /// Rounds over the axes: 1, more where an axis was flat and passed its share on, 0 where nothing was to do. Of "gradient" steps to
    /// its root, of "nearest" iterations.
    #[pyo3(get)]
    iterations: u32,
    /// How far the correction moved the control points, pins' part included: sqrt(sum of weight times squared distance), where
    /// the lightest weight counts as 1.
    #[pyo3(get)]
    distance: f64,
    /// Volume, of all bodies together, that limit="unfolded" left missing from the target: target - volume. 0.0 otherwise.
    #[pyo3(get)]
    missing: f64,
}

impl Preserved {
    pub(crate) fn new(
        py: Python<'_>,
        binding: Shared,
        vertices: Bound<'_, PyUntypedArray>,
        ran: &Ran,
        shape: [usize; 3],
    ) -> PyResult<Self> {
        let (outcome, [nu, nv, nw]) = (&ran.preserved, shape);
        let control: NdArray<'_, f64> = NdArray::points(py, &outcome.control, &[nu, nv, nw, 3])?;
        let Ok(control) = control.into_pyobject(py);
        Ok(Self {
            binding,
            control: control.unbind(),
            vertices: vertices.unbind(),
            targets: outcome.targets.clone(),
            distance: outcome.distance,
            missing: outcome.missing,
            device: ran.device,
            device_seconds: ran.seconds,
            method: method_name(outcome.method),
            iterations: outcome.iterations,
        })
    }

    fn measured(&self, py: Python<'_>) -> PyResult<Vec<f64>> {
        volumes(py, &self.binding, self.vertices.bind(py))
    }
}

#[pymethods]
impl Preserved {
    /// Corrected control points, float64 (nu, nv, nw, 3). Coordinates along axes without a share are those given, bit for
    /// bit.
    #[getter]
    fn control<'py>(&self, py: Python<'py>) -> NdArray<'py, f64> {
        NdArray::of(self.control.bind(py).clone())
    }

    /// Deformed vertices (V, 3), in the type of those bound.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> NdArray<'py, OfVertices> {
        NdArray::of(self.vertices.bind(py).clone())
    }

    /// Where the mesh was bound with a surface, its vertices, float64 (T, 3), over `vertices`: those that volumes are measured on. None
    /// otherwise.
    #[getter]
    fn surface<'py>(&self, py: Python<'py>) -> PyResult<Option<NdArray<'py, f64>>> {
        surface_over(py, &self.binding, self.vertices.bind(py))
    }

    /// Signed volume of `vertices`, of all bodies together, measured in float64 when asked for.
    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.measured(py)?.iter().fold(0.0, |sum, volume| sum + volume))
    }

    /// Signed volume of each body, float64 (bodies,), measured on `vertices` in float64 when asked for.
    #[getter]
    fn volumes<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        Ok(NdArray::numbers(py, &self.measured(py)?))
    }

    /// Volume that was aimed at, after `amount`; 0 where pins alone were wanted of a mesh that encloses nothing.
    #[getter]
    fn target(&self) -> f64 {
        self.targets.iter().fold(0.0, |sum, target| sum + target)
    }

    /// Volume of each body that was aimed at, after `amount`, float64 (bodies,).
    #[getter]
    fn targets<'py>(&self, py: Python<'py>) -> NdArray<'py, f64> {
        NdArray::numbers(py, &self.targets)
    }

    /// |volume - target| / |target|, the largest over the bodies, measured on `vertices` in float64 when asked for.
    #[getter]
    fn error(&self, py: Python<'_>) -> PyResult<f64> {
        let of_body = |(volume, target): (f64, &f64)| (volume - target).abs() / target.abs();
        Ok(self.measured(py)?.into_iter().zip(&self.targets).map(of_body).fold(0.0, f64::max))
    }

    fn __repr__(&self) -> String {
        format!(
            "Preserved(target={:?}, method={:?}, iterations={}, device={:?})",
            self.target(),
            self.method,
            self.iterations,
            self.device
        )
    }
}
