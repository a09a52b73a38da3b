// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Lattice2D`.

use isochor_core::{AxisBasis, DMat2, DVec2, DVec3, Lattice as Core, Outside};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, Numbers};
use crate::binding_2d::Binding2D;
use crate::errors::to_python;
use crate::plane::{PlaneKnots, axes, control, flattened, points};
use crate::words::{BasisWord, DeviceWord, OutsideWord};

/// A free-form deformation lattice of the plane: a parallelogram with a spline over it.
///
/// shape: number of control points (nu, nv) along s, t; 1 to 64 each, 1 for an axis that does not deform.
/// basis, degree, knots: as of `isochor.Lattice`; degree one number or two, knots a word or two arrays.
/// origin (2,), edges (2, 2) rows: the domain's corner and edge vectors; there (s, t) runs over [0, 1]^2.
/// weights (nu, nv): positive: the lattice is rational, as `isochor.Lattice` with weights.
///
/// Raises LatticeError. See Sederberg, CAGD, sections 14.1 to 14.3.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Lattice2D {
    core: Core,
    basis: BasisWord,
}

#[pymethods]
impl Lattice2D {
    #[new]
    #[pyo3(signature = (shape=None, basis=BasisWord::Bernstein, degree=None, knots=PlaneKnots::Uniform, origin=None, edges=None, weights=None))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    fn new<'py>(
        py: Python<'py>,
        shape: Option<ArrayLike<'py>>,
        basis: BasisWord,
        degree: Option<ArrayLike<'py>>,
        knots: PlaneKnots<'py>,
        origin: Option<ArrayLike<'py>>,
        edges: Option<ArrayLike<'py>>,
        weights: Option<ArrayLike<'py>>,
    ) -> PyResult<Self> {
        let axes = axes(py, shape, basis, degree, knots)?;
        let numbers = |name, object: &ArrayLike<'py>, shape: &[Option<usize>]| {
            Argument::lattice(name).floats(object, Numbers::FloatsOrIntegers, shape)
        };
        let origin = origin.map(|origin| numbers("origin", &origin, &[Some(2)])).transpose()?;
        let edges = edges.map(|edges| numbers("edges", &edges, &[Some(2), Some(2)])).transpose()?;
        let origin = origin.map_or(DVec2::ZERO, |at| DVec2::from_slice(&at));
        let edges = edges.map_or(DMat2::IDENTITY, |rows| DMat2::from_cols_slice(&rows));
        let mut core = Core::planar(axes, origin, edges).map_err(to_python)?;
        if let Some(weights) = weights {
            let [nu, nv, _] = core.shape().map(Some);
            let weights = numbers("weights", &weights, &[nu, nv])?;
            core = core.with_weights(weights).map_err(to_python)?;
        }
        Ok(Self { core, basis })
    }

    /// Number of control points along s, t.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        let [nu, nv, _] = self.core.shape();
        (nu, nv)
    }

    /// Polynomial degree along s, t.
    #[getter]
    fn degree(&self) -> (usize, usize) {
        let [s, t, _] = self.core.axes().each_ref().map(AxisBasis::degree);
        (s, t)
    }

    /// "bernstein" or "bspline".
    #[getter]
    fn basis(&self) -> &'static str {
        self.basis.name()
    }

    /// Knots along s, t, each float64 (points + degree + 1,), rescaled so that the domain is [0, 1].
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> (NdArray<'py, f64>, NdArray<'py, f64>) {
        let [s, t, _] = self.core.axes();
        (NdArray::numbers(py, s.knots()), NdArray::numbers(py, t.knots()))
    }

    /// Weights of the control points as given, float64 (nu, nv), or None.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<NdArray<'py, f64>>> {
        let [nu, nv, _] = self.core.shape();
        let shaped = |weights: &[f64]| -> PyResult<NdArray<'py, f64>> {
            Ok(NdArray::of(PyArray1::from_slice(py, weights).reshape([nu, nv])?.as_untyped().clone()))
        };
        self.core.weights().map(shaped).transpose()
    }

    /// Corner of the domain, float64 (2,).
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        flattened(py, &[self.core.origin()], &[])
    }

    /// Edge vectors of the domain as rows, float64 (2, 2).
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let edges = self.core.edges();
        flattened(py, &[edges.x_axis, edges.y_axis], &[2])
    }

    /// Control points at rest, float64 (nu, nv, 2), index [i, j] along s, t: there the lattice is the identity map.
    #[getter]
    fn rest<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let [nu, nv, _] = self.core.shape();
        flattened(py, &self.core.rest(), &[nu, nv])
    }

    /// Parameters (s, t) of points (V, 2), float64 (V, 2); in [0, 1] inside the domain.
    fn parameters<'py>(&self, py: Python<'py>, points: ArrayLike<'py>) -> PyResult<NdArray<'py, f64>> {
        let points = self::points(Argument::mesh("points"), &points)?;
        let parameters: Vec<DVec3> = points.iter().map(|p| self.core.parameter(p.extend(0.0))).collect();
        flattened(py, &parameters, &[parameters.len()])
    }

    /// Positions, float64 (V, 2), that control points (nu, nv, 2) give to parameters (V, 2). Parameters outside [0, 1] follow the nearest
    /// ones inside. Raises LatticeError.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        parameters: ArrayLike<'py>,
        control: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let parameters = points(Argument::lattice("parameters"), &parameters)?;
        let control = self::control(Argument::lattice("control"), &control, self.core.shape())?;
        let parameters: Vec<DVec3> = parameters.iter().map(|p| p.extend(0.5)).collect();
        let found = py.detach(|| self.core.evaluate(&parameters, &control)).map_err(to_python)?;
        flattened(py, &found, &[found.len()])
    }

    /// Embeds points of the plane, or a flat mesh.
    ///
    /// vertices (V, 2) float32 or float64; results have the same type. triangles (F, 3) integers, or None; only areas need them: they wind
    /// one way, and use each edge once in each direction at most. Holes, and several parts, are allowed.
    /// device, influence: as of `Lattice.bind`. outside: points beyond the domain stay ("keep": Sederberg) or move with the
    /// nearest point of the domain ("extend").
    ///
    /// Raises MeshError, and DeviceError for an unknown device.
    #[pyo3(signature = (vertices, triangles=None, device=DeviceWord::Auto, outside=OutsideWord(Outside::Keep), influence=None))]
    fn bind(
        &self,
        py: Python<'_>,
        vertices: ArrayLike<'_>,
        triangles: Option<ArrayLike<'_>>,
        device: DeviceWord,
        outside: OutsideWord,
        influence: Option<ArrayLike<'_>>,
    ) -> PyResult<Binding2D> {
        Binding2D::new(py, &self.core, &vertices, triangles, device, outside.0, influence)
    }

    fn __repr__(&self) -> String {
        format!("Lattice2D(shape={:?}, basis={:?}, degree={:?})", self.shape(), self.basis(), self.degree())
    }
}
