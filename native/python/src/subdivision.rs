// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.tessellate` and `isochor.bent_edges`.

use isochor_core::{DVec3, Deformation, Lattice, Outside, Refined as Core, Scalar, Surface as CoreSurface};
use numpy::{Element, PyArray1, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, NumberLike, Numbers, OfVertices, converted};
use crate::binding::{VertexRows, indices, influences};
use crate::errors::to_python;
use crate::lattice::LatticeLike;
use crate::surface::Surface;
use crate::words::OutsideWord;

/// Levels if not given: each makes four triangles of one at most.
const LEVELS: usize = 6;

/// How space is deformed, from arguments.
struct Deforming {
    lattice: Lattice,
    control: Vec<DVec3>,
    outside: Outside,
    influence: Option<Vec<f64>>,
    rest: Option<Vec<DVec3>>,
    tolerance: f64,
}

impl Deforming {
    fn new(
        lattice: LatticeLike<'_>,
        control: &ArrayLike<'_>,
        tolerance: &NumberLike<'_>,
        outside: OutsideWord,
        influence: Option<ArrayLike<'_>>,
        rest: Option<ArrayLike<'_>>,
    ) -> PyResult<Self> {
        let lattice = lattice.0.core.clone();
        let shape = lattice.shape();
        Ok(Self {
            control: Argument::lattice("control").control(control, shape)?,
            outside: outside.0,
            influence: influence.map(|influence| influences(&influence)).transpose()?,
            rest: rest.map(|rest| Argument::lattice("rest").control(&rest, shape)).transpose()?,
            tolerance: Argument::mesh("tolerance").number(tolerance)?,
            lattice,
        })
    }

    fn deformation(&self) -> Deformation<'_> {
        let (control, rest) = (&self.control, self.rest.as_deref());
        Deformation { lattice: &self.lattice, control, outside: self.outside, rest }
    }
}

/// Splits the edges of a mesh where a lattice bends them, until the deformed mesh is within `tolerance` of the deformed space: at a
/// quarter, a half and three quarters of every edge, and in the middle of every face.
///
/// vertices (V, 3), triangles (F, 3), before the deformation; control (nu, nv, nw, 3); tolerance: a distance after it. levels: how often
/// an edge is halved at most, up to 12. outside, influence (V,) and rest (nu, nv, nw, 3): as in `Lattice.bind`; influence runs from end
/// to end of an edge. With float32 vertices no tolerance below a millionth of the lattice's size is reached.
///
/// There are no cracks: whether an edge is split does not depend on the face that one looks at. In a face with a split edge the longest is
/// split too, so triangles do not become ever sharper. The same input gives the same mesh on any number of threads.
///
/// Raises MeshError and LatticeError.
#[pyfunction]
#[pyo3(signature = (lattice, vertices, triangles, control, tolerance, levels=LEVELS, *, outside=OutsideWord(Outside::Keep), influence=None, rest=None))]
#[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
pub(crate) fn tessellate(
    py: Python<'_>,
    lattice: LatticeLike<'_>,
    vertices: ArrayLike<'_>,
    triangles: ArrayLike<'_>,
    control: ArrayLike<'_>,
    tolerance: NumberLike<'_>,
    levels: usize,
    outside: OutsideWord,
    influence: Option<ArrayLike<'_>>,
    rest: Option<ArrayLike<'_>>,
) -> PyResult<Refined> {
    let vertices = VertexRows::extract(&vertices)?;
    let triangles = indices(&triangles)?;
    let deforming = Deforming::new(lattice, &control, &tolerance, outside, influence, rest)?;
    match vertices {
        VertexRows::Single(rows) => refined(py, &deforming, &rows, &triangles, levels),
        VertexRows::Double(rows) => refined(py, &deforming, &rows, &triangles, levels),
    }
}

fn refined<T: Scalar + Element>(
    py: Python<'_>,
    deforming: &Deforming,
    vertices: &[[T; 3]],
    triangles: &[[u32; 3]],
    levels: usize,
) -> PyResult<Refined> {
    let (deformation, influence) = (deforming.deformation(), deforming.influence.as_deref());
    let found =
        py.detach(|| deformation.tessellate(vertices, triangles, influence, deforming.tolerance, levels));
    Refined::new(py, found.map_err(to_python)?, deforming.tolerance)
}

/// Which edges (E, 2) of vertices (V, 3) a lattice bends by more than `tolerance`, bool (E,): the deformed edge, at a quarter, a half and
/// three quarters of its way, is farther than that from the straight one between its deformed ends. The other arguments are those of
/// `tessellate`. Raises MeshError and LatticeError.
#[pyfunction]
#[pyo3(signature = (lattice, vertices, edges, control, tolerance, *, outside=OutsideWord(Outside::Keep), influence=None, rest=None))]
#[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
pub(crate) fn bent_edges<'py>(
    py: Python<'py>,
    lattice: LatticeLike<'py>,
    vertices: ArrayLike<'py>,
    edges: ArrayLike<'py>,
    control: ArrayLike<'py>,
    tolerance: NumberLike<'py>,
    outside: OutsideWord,
    influence: Option<ArrayLike<'py>>,
    rest: Option<ArrayLike<'py>>,
) -> PyResult<NdArray<'py, bool>> {
    let vertices = VertexRows::extract(&vertices)?;
    let argument = Argument::mesh("edges");
    let wide: Vec<i64> = converted(&argument.array(&edges, Numbers::Integers, &[None, Some(2)])?, "int64")?;
    // What does not fit is out of range too.
    let flat: Vec<u32> = wide.into_iter().map(|index| u32::try_from(index).unwrap_or(u32::MAX)).collect();
    let edges = flat.as_chunks::<2>().0;
    let deforming = Deforming::new(lattice, &control, &tolerance, outside, influence, rest)?;
    let (deformation, influence) = (deforming.deformation(), deforming.influence.as_deref());
    let found = py.detach(|| match &vertices {
        VertexRows::Single(rows) => deformation.bent_edges(rows, influence, edges, deforming.tolerance),
        VertexRows::Double(rows) => deformation.bent_edges(rows, influence, edges, deforming.tolerance),
    });
    Ok(NdArray::of(PyArray1::from_vec(py, found.map_err(to_python)?).as_untyped().clone()))
}

/// A mesh that is split where deformed space bends: the result of `tessellate`.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Refined {
    vertices: Py<PyUntypedArray>,
    triangles: Vec<[u32; 3]>,
    parent_triangle: Vec<u32>,
    parents: Py<Surface>,
    /// Largest distance from the deformed space as given, over edges and faces.
    #[pyo3(get)]
    before: f64,
    /// The same of what came out; above the tolerance where the levels did not suffice.
    #[pyo3(get)]
    after: f64,
    /// Levels that it took.
    #[pyo3(get)]
    levels: usize,
    /// Whether the tolerance is met.
    #[pyo3(get)]
    reached: bool,
}

impl Refined {
    fn new<T: Scalar + Element>(py: Python<'_>, found: Core<T>, tolerance: f64) -> PyResult<Self> {
        let parents: CoreSurface = found.parents;
        let vertices = PyArray1::from_slice(py, found.vertices.as_flattened());
        let vertices = vertices.reshape([found.vertices.len(), 3])?;
        Ok(Self {
            vertices: vertices.as_untyped().clone().unbind(),
            triangles: found.triangles,
            parent_triangle: found.parent_triangle,
            parents: Py::new(py, Surface { core: parents })?,
            before: found.before,
            after: found.after,
            levels: found.levels,
            reached: found.after <= tolerance,
        })
    }
}

#[pymethods]
impl Refined {
    /// Vertices before the deformation, in the type of those given: these first, then new ones.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> NdArray<'py, OfVertices> {
        NdArray::of(self.vertices.bind(py).clone())
    }

    /// Triangles, int32 (F', 3), wound as those given.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, i32>> {
        let flat = self.triangles.as_flattened().iter().map(|&v| v as i32).collect();
        NdArray::table(py, flat, [self.triangles.len(), 3])
    }

    /// The given triangle that each is a part of, int32 (F',).
    #[getter]
    fn parent_triangle<'py>(&self, py: Python<'py>) -> NdArray<'py, i32> {
        let parents: Vec<i32> = self.parent_triangle.iter().map(|&parent| parent as i32).collect();
        NdArray::numbers(py, &parents)
    }

    /// The vertices as combinations of the given ones, three at most, those of the parent triangle: `parents.apply` carries whatever
    /// vertices have.
    #[getter]
    fn parents(&self, py: Python<'_>) -> Py<Surface> {
        self.parents.clone_ref(py)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let vertices = self.vertices.bind(py).shape().first().copied().unwrap_or_default();
        format!("Refined({vertices} vertices, {} triangles, after={:?})", self.triangles.len(), self.after)
    }
}
