// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Lattice`.

use isochor_core::{AxisBasis, DMat3, Lattice as Core, Outside};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, NumberLike};
use crate::axes::axes;
use crate::binding::{Binding, point_weights};
use crate::bodies::BodiesLike;
use crate::errors::to_python;
use crate::folds::{Folds, halvings};
use crate::refine::{InsertLike, blended, derivatives, refined};
use crate::surface::SurfaceLike;
use crate::words::{BasisWord, DeviceWord, InterpolationWords, KnotsWord, OutsideWord};

/// A free-form deformation lattice: a box of space, or its image under an affine map, with a spline over it.
///
/// shape: number of control points (nu, nv, nw) along s, t, u; 1 to 64 each, 1 for an axis that does not deform.
/// basis: "bernstein" (degree = points - 1 on each axis), "bspline", or "blender": Blender's own lattice, whose evenly spaced points span
/// the domain from the first to the last on each axis.
/// degree: of a B-spline, one number or three; 3 if not given.
/// knots: of a B-spline. "uniform" (the volume paper's): control points evenly spaced, (degree - 1) / 2 layers of them outside
/// the domain; "clamped": the outer layers stand on the domain's faces; or three non-decreasing arrays of points + degree + 1.
/// origin (3,), edges (3, 3) rows: the domain's corner and edge vectors, in the space of the points to deform; there (s, t, u)
/// runs over [0, 1]^3.
/// weights (nu, nv, nw): positive, the heaviest at most a million times the lightest: the lattice is rational (Sederberg 14.1), and a
/// heavy point pulls more. Equal ones are as None. Unequal ones need functions that are not negative: no "cardinal" or "catmull-rom".
/// interpolation: of Blender's basis, "linear", "cardinal", "catmull-rom" or "bspline" (if not given), or three of them. Points outside
/// the domain move on for one cell there with outside="extend", as in Blender.
///
/// Raises LatticeError. See Sederberg, CAGD, chapter 14, and Hoff, "Free-form deformation of point sets".
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Lattice {
    pub(crate) core: Core,
    basis: BasisWord,
    interpolation: Option<InterpolationWords>,
}

/// A lattice as an argument.
pub(crate) struct LatticeLike<'py>(pub(crate) PyRef<'py, Lattice>);

impl<'py> FromPyObject<'_, 'py> for LatticeLike<'py> {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = <PyRef<'py, Lattice> as FromPyObject<'_, 'py>>::INPUT_TYPE;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let wrong =
            |_| Argument::lattice("lattice").error(format!("found {object:?}, expected an isochor.Lattice"));
        object.extract().map(Self).map_err(wrong)
    }
}

impl Lattice {
    fn of(
        core: Core,
        basis: BasisWord,
        weights: Option<ArrayLike<'_>>,
        interpolation: Option<InterpolationWords>,
    ) -> PyResult<Self> {
        let interpolation = (basis == BasisWord::Blender).then(|| interpolation.unwrap_or_default());
        let core = match weights {
            Some(weights) => {
                let weights = point_weights(&weights, core.shape())?;
                core.with_weights(weights).map_err(to_python)?
            }
            None => core,
        };
        Ok(Self { core, basis, interpolation })
    }
}

#[pymethods]
impl Lattice {
    #[new]
    #[pyo3(signature = (shape=None, basis=BasisWord::Bernstein, degree=None, knots=KnotsWord::Uniform, origin=None, edges=None, weights=None, interpolation=None))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    fn new(
        shape: Option<ArrayLike<'_>>,
        basis: BasisWord,
        degree: Option<ArrayLike<'_>>,
        knots: KnotsWord<'_>,
        origin: Option<ArrayLike<'_>>,
        edges: Option<ArrayLike<'_>>,
        weights: Option<ArrayLike<'_>>,
        interpolation: Option<InterpolationWords>,
    ) -> PyResult<Self> {
        let axes = axes(shape, basis, degree, knots, interpolation)?;
        let origin =
            origin.map_or(Ok(isochor_core::DVec3::ZERO), |o| Argument::lattice("origin").vector(&o))?;
        let edges = match edges {
            Some(edges) => {
                let [s, t, u] = Argument::lattice("edges").rows(&edges)?;
                DMat3::from_cols(s, t, u)
            }
            None => DMat3::IDENTITY,
        };
        Self::of(Core::new(axes, origin, edges).map_err(to_python)?, basis, weights, interpolation)
    }

    /// A lattice whose domain is the axis-aligned box of points (V, 3), widened by `margin` times its size on every side.
    /// Where the points are flat the box gets their largest extent. Raises LatticeError.
    #[staticmethod]
    #[pyo3(signature = (vertices, shape=None, basis=BasisWord::Bernstein, margin=NumberLike::Default(0.0), degree=None, knots=KnotsWord::Uniform, weights=None, interpolation=None))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    fn around(
        vertices: ArrayLike<'_>,
        shape: Option<ArrayLike<'_>>,
        basis: BasisWord,
        margin: NumberLike<'_>,
        degree: Option<ArrayLike<'_>>,
        knots: KnotsWord<'_>,
        weights: Option<ArrayLike<'_>>,
        interpolation: Option<InterpolationWords>,
    ) -> PyResult<Self> {
        let axes = axes(shape, basis, degree, knots, interpolation)?;
        let points = Argument::lattice("vertices").points(&vertices)?;
        let margin = Argument::lattice("margin").number(&margin)?;
        Self::of(Core::around(axes, &points, margin).map_err(to_python)?, basis, weights, interpolation)
    }

    /// Number of control points along s, t, u.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        self.core.shape().into()
    }

    /// Polynomial degree along s, t, u: of Blender's basis that of its pieces.
    #[getter]
    fn degree(&self) -> (usize, usize, usize) {
        self.core.axes().each_ref().map(AxisBasis::degree).into()
    }

    /// Knots along s, t, u, each float64 (points + degree + 1,), rescaled so that the domain is [0, 1]; those of a Bernstein lattice stand
    /// at its ends.
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> (NdArray<'py, f64>, NdArray<'py, f64>, NdArray<'py, f64>) {
        self.core.axes().each_ref().map(|axis| NdArray::numbers(py, axis.knots())).into()
    }

    /// "bernstein", "bspline" or "blender".
    #[getter]
    fn basis(&self) -> &'static str {
        match self.basis {
            BasisWord::Bernstein => "bernstein",
            BasisWord::BSpline => "bspline",
            BasisWord::Blender => "blender",
        }
    }

    /// Of Blender's basis the interpolation along s, t, u; None for others.
    #[getter]
    fn interpolation(&self) -> Option<(&'static str, &'static str, &'static str)> {
        self.interpolation.map(|words| words.names().into())
    }

    /// Weights of the control points as given, float64 (nu, nv, nw), or None.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<NdArray<'py, f64>>> {
        let weights = self.core.weights();
        weights.map(|weights| NdArray::lattice(py, weights.to_vec(), self.core.shape())).transpose()
    }

    /// Corner of the domain, float64 (3,).
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &[self.core.origin()], &[3])
    }

    /// Edge vectors of the domain as rows, float64 (3, 3).
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let edges = self.core.edges();
        NdArray::points(py, &[edges.x_axis, edges.y_axis, edges.z_axis], &[3, 3])
    }

    /// Control points at rest, float64 (nu, nv, nw, 3), index [i, j, k] along s, t, u: there the lattice moves nothing that is bound to it.
    #[getter]
    fn rest<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let [nu, nv, nw] = self.core.shape();
        NdArray::points(py, &self.core.rest(), &[nu, nv, nw, 3])
    }

    /// Parameters (s, t, u) of points (V, 3), float64 (V, 3); in [0, 1] inside the domain.
    fn parameters<'py>(&self, py: Python<'py>, points: ArrayLike<'py>) -> PyResult<NdArray<'py, f64>> {
        let points = Argument::mesh("points").points(&points)?;
        let parameters: Vec<_> = py.detach(|| points.iter().map(|&p| self.core.parameter(p)).collect());
        NdArray::points(py, &parameters, &[parameters.len(), 3])
    }

    /// Positions, float64 (V, 3), that control points (nu, nv, nw, 3) give to parameters (V, 3): equation (1) of the volume
    /// paper. Parameters outside [0, 1] follow the nearest ones inside (of Blender's basis, within one cell beyond).
    ///
    /// With unequal weights it is the rational map, sum w B control / sum w B, which gives conics exactly, and does not leave the
    /// lattice at rest where it is: a bound mesh moves by sum w B (control - rest) / sum w B instead. With one control point on an axis
    /// the lattice keeps its thickness along it. Blender's basis moves points by the latter form always. Raises LatticeError.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        parameters: ArrayLike<'py>,
        control: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let parameters = Argument::lattice("parameters").points(&parameters)?;
        let control = Argument::lattice("control").control(&control, self.core.shape())?;
        let points = py.detach(|| self.core.evaluate(&parameters, &control)).map_err(to_python)?;
        NdArray::points(py, &points, &[points.len(), 3])
    }

    /// Derivatives of `evaluate`, float64 (V, 3, 3): rows d/ds, d/dt, d/du for each of parameters (V, 3). Where a basis has a kink, those
    /// of the cell above; beyond the domain on an axis, where points follow the nearest one inside, that axis' edge. Raises LatticeError.
    fn derivative<'py>(
        &self,
        py: Python<'py>,
        parameters: ArrayLike<'py>,
        control: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        derivatives(py, &self.core, &parameters, &control)
    }

    /// Sets of control points (K, nu, nv, nw, 3) mixed by weights (K,), float64 (nu, nv, nw, 3): rest + sum of weight (set - rest), as
    /// relative shape keys are. Weights that sum to 1 interpolate between the sets; any finite ones are allowed (Ferrier). Raises
    /// LatticeError.
    fn blend<'py>(
        &self,
        py: Python<'py>,
        sets: ArrayLike<'py>,
        weights: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        blended(py, &self.core, &sets, &weights)
    }

    /// The lattice with more control points, and those for the shape that control (nu, nv, nw, 3) gives to this one: `evaluate` takes
    /// every parameter where it was, to rounding. Of several sets, (K, nu, nv, nw, 3), each is taken over, as shape keys are.
    ///
    /// degree: to raise it to, one number or three.
    /// insert: three sequences of parameters in (0, 1), each None for an axis without: knots to insert, after the degree was raised.
    /// They make a Bernstein lattice a B-spline.
    /// shape: number of control points to reach: along a Bernstein axis by its degree, unless knots are inserted there; otherwise
    /// by knots in the middles of the longest spans.
    ///
    /// A uniform axis whose spans are all divided alike stays uniform, and its outer layers move in; otherwise knots beyond the domain
    /// stay. Axes with one control point stay. Raises LatticeError. See Sederberg, CAGD, chapters 2 and 6.
    #[pyo3(signature = (control, shape=None, degree=None, insert=None))]
    fn refine<'py>(
        &self,
        py: Python<'py>,
        control: ArrayLike<'py>,
        shape: Option<ArrayLike<'py>>,
        degree: Option<ArrayLike<'py>>,
        insert: Option<InsertLike>,
    ) -> PyResult<(Self, NdArray<'py, f64>)> {
        let is_bernstein = self.basis == BasisWord::Bernstein;
        let (core, has_knots, control) =
            refined(py, &self.core, is_bernstein, &control, [shape, degree], insert)?;
        let basis = if has_knots { BasisWord::BSpline } else { self.basis };
        Ok((Self { core, basis, interpolation: self.interpolation }, control))
    }

    /// The way back of `evaluate`: for points (V, 3) the parameters, float64 (V, 3), at which the lattice shaped by control points
    /// (nu, nv, nw, 3) takes them, and whether each point is inside the shaped lattice, bool (V,).
    ///
    /// `evaluate` takes the parameters of an inside point, which lie in [0, 1] to within 1e-9, to that point: to rounding, a thousand
    /// of float64's epsilon times the lattice's size at most (more where its edges all but lie in one plane). Where the lattice folds
    /// over itself and has several, one of them is given; or, for one point in some hundreds, none is found, and it counts as
    /// outside. Any other point gets the nearest parameters found. Newton's method, point by point: points do not depend on each
    /// other.
    ///
    /// Raises LatticeError, and MeshError for points that are not finite.
    fn invert<'py>(
        &self,
        py: Python<'py>,
        points: ArrayLike<'py>,
        control: ArrayLike<'py>,
    ) -> PyResult<(NdArray<'py, f64>, NdArray<'py, bool>)> {
        let points = Argument::mesh("points").points(&points)?;
        let control = Argument::lattice("control").control(&control, self.core.shape())?;
        let found = py.detach(|| self.core.invert(&points, &control)).map_err(to_python)?;
        let parameters: Vec<_> = found.iter().map(|found| found.parameter).collect();
        let inside: Vec<_> = found.iter().map(|found| found.inside).collect();
        Ok((
            NdArray::points(py, &parameters, &[found.len(), 3])?,
            NdArray::of(PyArray1::from_vec(py, inside).as_untyped().clone()),
        ))
    }

    /// Whether the lattice shaped by control points (nu, nv, nw, 3) folds over, and where: where the determinant of the map's derivative
    /// has another sign than that of the lattice's frame.
    ///
    /// rest (nu, nv, nw, 3): the shape that the lattice was bound in, from which the map is measured; None for `Lattice.rest`. In a cell in
    /// which that shape itself is not proved to be unfolded, the answer is undecided.
    /// depth: how often each cell of the lattice is halved along each axis at most, 0 to 24; 12 if not given. Only what the coarser
    /// pieces leave open is halved.
    ///
    /// "unfolded" is a proof, for every parameter in the domain: by Bernstein coefficients, with bounds on rounding. It is a local one. A lattice
    /// bent round by more than 360 degrees overlaps itself without folding anywhere, and is unfolded.
    ///
    /// Raises LatticeError.
    #[pyo3(signature = (control, rest=None, depth=None))]
    fn folds(
        &self,
        py: Python<'_>,
        control: ArrayLike<'_>,
        rest: Option<ArrayLike<'_>>,
        depth: Option<ArrayLike<'_>>,
    ) -> PyResult<Folds> {
        let shape = self.core.shape();
        let control = Argument::lattice("control").control(&control, shape)?;
        let rest = rest.map(|rest| Argument::lattice("rest").control(&rest, shape)).transpose()?;
        let depth = halvings(depth.as_ref())?;
        let folds = py.detach(|| self.core.folds(&control, rest.as_deref(), depth));
        Ok(Folds(folds.map_err(to_python)?))
    }

    /// Weights for `Binding.preserve`, float64 (nu, nv, nw), that keep the correction near points (m, 3): exp(d / distance), where d is a
    /// control point's distance from the nearest of them (figure 7 of the volume paper). control (nu, nv, nw, 3): where the control
    /// points stand; None for `rest`.
    ///
    /// Where all weights were above exp(600) they are divided by one factor, which changes no correction; those that are infinite even
    /// so freeze their control points. Raises LatticeError.
    #[pyo3(signature = (points, distance, control=None))]
    fn falloff<'py>(
        &self,
        py: Python<'py>,
        points: ArrayLike<'py>,
        distance: NumberLike<'py>,
        control: Option<ArrayLike<'py>>,
    ) -> PyResult<NdArray<'py, f64>> {
        let points = Argument::lattice("points").points(&points)?;
        let distance = Argument::lattice("distance").number(&distance)?;
        let shape = self.core.shape();
        let control = control.map(|c| Argument::lattice("control").control(&c, shape)).transpose()?;
        let weights = py.detach(|| self.core.falloff(&points, distance, control.as_deref()));
        NdArray::lattice(py, weights.map_err(to_python)?, shape)
    }

    /// Weights for `Binding.preserve`, float64 (nu, nv, nw), with which the correction goes where the volume went: small where the lattice
    /// shaped by control (nu, nv, nw, 3) has another local volume than at rest, or than shaped by rest (nu, nv, nw, 3).
    ///
    /// The change e of a control point is |integral of B (det J - det J at rest)| / integral of B |det J at rest|, with J the map's
    /// derivative and B the point's basis function; its weight is 1 / (floor + (1 - floor) e / (largest e)), from 1 where most
    /// changed to 1 / floor where nothing did. Without any change all weights are 1. floor: above 0, up to 1. Raises LatticeError.
    #[pyo3(signature = (control, rest=None, floor=NumberLike::Default(0.01)))]
    fn loss_weights<'py>(
        &self,
        py: Python<'py>,
        control: ArrayLike<'py>,
        rest: Option<ArrayLike<'py>>,
        floor: NumberLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let shape = self.core.shape();
        let control = Argument::lattice("control").control(&control, shape)?;
        let rest = rest.map(|rest| Argument::lattice("rest").control(&rest, shape)).transpose()?;
        let floor = Argument::lattice("floor").number(&floor)?;
        let weights = py.detach(|| self.core.loss_weights(&control, rest.as_deref(), floor));
        NdArray::lattice(py, weights.map_err(to_python)?, shape)
    }

    /// Embeds a mesh: everything that stays fixed while the control points move is computed here.
    ///
    /// vertices (V, 3) float32 or float64, in the lattice's space; results have the same type.
    /// triangles (F, 3) integers, or None; only volumes need them, and then they must form a closed surface.
    /// device: "cpu"; "gpu", a software rasteriser where there is no graphics card; the name of an adapter in devices(); or
    /// "auto": a graphics card where measuring shows it to be faster, else the CPU. Where a GPU is missing or fails, the CPU
    /// computes in the same call, with one RuntimeWarning.
    /// outside: vertices beyond the domain stay ("keep", and the correction holds the layers of control points that act on
    /// that face) or move with the nearest point of the domain ("extend").
    /// influence (V,) in [0, 1]: how much of the deformation each vertex takes; None for all of it.
    /// rest (nu, nv, nw, 3): control points that leave every vertex where it is, to the bit; None for `Lattice.rest`. With others,
    /// the lattice is bound in that shape: each vertex inside is embedded at the parameters that `invert` gives, and moves by
    /// influence * sum B (control - rest), so that an affine motion of the shape is that motion of the mesh. Vertices not inside the
    /// shape are outside.
    ///
    /// bodies: None where all triangles enclose one volume; "islands": every piece that is connected by shared vertices and closed
    /// keeps a volume of its own, and open and flat ones have none and deform along; or (F,) integers, the body of each triangle, 0 to
    /// count - 1, -1 for those of none. The border of a labelled region is closed by caps.
    /// caps: True closes every hole by a virtual fan of triangles about the mean of the vertices around it; with False a hole is a
    /// MeshError where a volume is asked for.
    ///
    /// surface: an isochor.Surface, or None. With one, triangles, bodies and pins name the surface's vertices, which are fixed
    /// combinations of `vertices`: the control points of a patch model (`Patches.tessellate`), the coarse points of a subdivision
    /// surface. The lattice moves `vertices` alone, and volumes are those of the surface, exactly; `Preserved.surface` has its vertices. The CPU
    /// computes then, whatever the device. cost="surface" still counts how far `vertices` move.
    ///
    /// Raises MeshError, LatticeError for a wrong rest, and DeviceError for an unknown device.
    #[pyo3(signature = (vertices, triangles=None, device=DeviceWord::Auto, outside=OutsideWord(Outside::Keep), influence=None, rest=None, bodies=None, caps=false, surface=None))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    fn bind(
        &self,
        py: Python<'_>,
        vertices: ArrayLike<'_>,
        triangles: Option<ArrayLike<'_>>,
        device: DeviceWord,
        outside: OutsideWord,
        influence: Option<ArrayLike<'_>>,
        rest: Option<ArrayLike<'_>>,
        bodies: Option<BodiesLike>,
        caps: bool,
        surface: Option<SurfaceLike>,
    ) -> PyResult<Binding> {
        Binding::new(
            py, &self.core, vertices, triangles, device, outside.0, influence, rest, bodies, caps, surface,
        )
    }

    fn __repr__(&self) -> String {
        format!("Lattice(shape={:?}, basis={:?}, degree={:?})", self.shape(), self.basis(), self.degree())
    }
}
