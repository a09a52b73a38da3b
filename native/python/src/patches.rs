// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Patches` and `isochor.Tessellation`.

use isochor_core::{NO_CORNER, Patches as Core, Tessellation as CoreTessellation};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, Numbers, converted};
use crate::errors::to_python;
use crate::surface::Surface;

/// Bézier patches that share control points: a lattice moves the points, the surface follows (Ferrier).
///
/// points (K, 3): the control points. patches (P, m, n) integers: the points of each patch, m along u and n along v, 2 to 64 each:
/// degrees m - 1 and n - 1. Patches that name the same points along an edge, in either direction, are joined there; an edge that names
/// one point all along is collapsed to it.
///
/// Raises MeshError.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Patches {
    core: Core,
}

/// Places on patches: patch (N,) and uv (N, 2), one patch for all if it is a number.
fn places(patch: &ArrayLike<'_>, uv: &ArrayLike<'_>) -> PyResult<Vec<(u32, [f64; 2])>> {
    let uv = Argument::mesh("uv").floats(uv, Numbers::FloatsOrIntegers, &[None, Some(2)])?;
    let uv = uv.as_chunks::<2>().0;
    let argument = Argument::mesh("patch");
    let patches: Vec<i64> = match argument.array(patch, Numbers::Integers, &[]) {
        Ok(one) => vec![converted::<i64>(&one, "int64")?[0]; uv.len()],
        Err(_) => converted(&argument.array(patch, Numbers::Integers, &[Some(uv.len())])?, "int64")?,
    };
    // What does not fit is out of range too.
    let index = |patch: i64| u32::try_from(patch).unwrap_or(u32::MAX);
    Ok(patches.into_iter().map(index).zip(uv.iter().copied()).collect())
}

#[pymethods]
impl Patches {
    #[new]
    fn new(points: ArrayLike<'_>, patches: ArrayLike<'_>) -> PyResult<Self> {
        let points = Argument::mesh("points").points(&points)?;
        let argument = Argument::mesh("patches");
        let array = argument.array(&patches, Numbers::Integers, &[None, None, None])?;
        let [_, m, n] = argument.dimensions(&array)?;
        let wide: Vec<i64> = converted(&array, "int64")?;
        let indices = wide.into_iter().map(|index| u32::try_from(index).unwrap_or(u32::MAX)).collect();
        Ok(Self { core: Core::new(points, [m, n], indices).map_err(to_python)? })
    }

    /// Control points, float64 (K, 3).
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, self.core.points(), &[self.core.points().len(), 3])
    }

    /// Points of each patch, int32 (P, m, n).
    #[getter]
    fn patches<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, i32>> {
        let [m, n] = self.core.shape();
        let indices = self.core.indices().iter().map(|&point| point as i32).collect();
        NdArray::table(py, indices, [self.core.len(), m, n])
    }

    /// Degrees along u and v.
    #[getter]
    fn degree(&self) -> (usize, usize) {
        self.core.shape().map(|count| count - 1).into()
    }

    /// Positions, float64 (N, 3), at parameters uv (N, 2) in [0, 1] of patches (N,), or of one patch. Raises MeshError.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        patch: ArrayLike<'py>,
        uv: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let places = places(&patch, &uv)?;
        let found = py.detach(|| self.core.evaluate(&places)).map_err(to_python)?;
        NdArray::points(py, &found, &[found.len(), 3])
    }

    /// Derivatives along u and v there, float64 (N, 2, 3). Raises MeshError.
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        patch: ArrayLike<'py>,
        uv: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let places = places(&patch, &uv)?;
        let found = py.detach(|| self.core.derivatives(&places)).map_err(to_python)?;
        NdArray::points(py, found.as_flattened(), &[found.len(), 2, 3])
    }

    /// Unit normals there, float64 (N, 3), on the side from which u and v turn counter-clockwise; at a collapsed edge the limit from
    /// within the patch, and zero where a patch has no area at all. Raises MeshError.
    fn normals<'py>(
        &self,
        py: Python<'py>,
        patch: ArrayLike<'py>,
        uv: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let places = places(&patch, &uv)?;
        let found = py.detach(|| self.core.normals(&places)).map_err(to_python)?;
        NdArray::points(py, &found, &[found.len(), 3])
    }

    /// The mesh of `level` segments, 1 to 1024, along every edge of every patch. Samples that patches share are one vertex, so a closed
    /// model gives a closed mesh at every level; patches are wound as the first of those that hang together.
    ///
    /// To deform the model, bind its points with triangles and surface of the result:
    /// `lattice.bind(patches.points, mesh.triangles, surface=mesh.surface)`. Raises MeshError.
    fn tessellate(&self, py: Python<'_>, level: usize) -> PyResult<Tessellation> {
        let core = py.detach(|| self.core.tessellate(level)).map_err(to_python)?;
        let surface = Py::new(py, Surface { core: core.surface.clone() })?;
        Ok(Tessellation { core, surface })
    }

    fn __len__(&self) -> usize {
        self.core.len()
    }

    fn __repr__(&self) -> String {
        format!("Patches({} of degree {:?})", self.core.len(), self.degree())
    }
}

/// Patches as a mesh: the result of `Patches.tessellate`.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Tessellation {
    core: CoreTessellation,
    surface: Py<Surface>,
}

#[pymethods]
impl Tessellation {
    /// The vertices as combinations of the patches' points.
    #[getter]
    fn surface(&self, py: Python<'_>) -> Py<Surface> {
        self.surface.clone_ref(py)
    }

    /// Triangles, int32 (F, 3), counter-clockwise seen from the side of the normals.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, i32>> {
        let flat = self.core.triangles.as_flattened().iter().map(|&v| v as i32).collect();
        NdArray::table(py, flat, [self.core.triangles.len(), 3])
    }

    /// The cells that the triangles halve, int32 (Q, 4); the last corner of a cell with three, at a collapsed edge, is -1.
    #[getter]
    fn quads<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, i32>> {
        let corner = |&v: &u32| if v == NO_CORNER { -1 } else { v as i32 };
        let flat = self.core.quads.as_flattened().iter().map(corner).collect();
        NdArray::table(py, flat, [self.core.quads.len(), 4])
    }

    /// Patch of each cell, int32 (Q,).
    #[getter]
    fn patch_of_quad<'py>(&self, py: Python<'py>) -> NdArray<'py, i32> {
        let patches: Vec<i32> = self.core.patch_of_quad.iter().map(|&patch| patch as i32).collect();
        NdArray::numbers(py, &patches)
    }

    /// A patch that each vertex is on, int32 (T,).
    #[getter]
    fn patch_of_vertex<'py>(&self, py: Python<'py>) -> NdArray<'py, i32> {
        let patches: Vec<i32> = self.core.patch_of_vertex.iter().map(|&patch| patch as i32).collect();
        NdArray::numbers(py, &patches)
    }

    /// Parameters u, v of each vertex on that patch, float64 (T, 2).
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let flat = self.core.parameters.as_flattened().to_vec();
        NdArray::table(py, flat, [self.core.parameters.len(), 2])
    }

    fn __repr__(&self) -> String {
        let (vertices, triangles) = (self.core.surface.len(), self.core.triangles.len());
        format!("Tessellation({vertices} vertices, {triangles} triangles)")
    }
}
