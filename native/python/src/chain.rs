// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Chain`.

use std::sync::{Mutex, MutexGuard, PoisonError};

use isochor_core::{Before, Bind, Chain as Core, DVec3, Lattice as CoreLattice, Scalar};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyDict, PyList, PyTuple};
use pyo3::{type_hint_identifier, type_hint_subscript};

use crate::arrays::{Argument, ArrayLike, NdArray, OfVertices};
use crate::binding::{Binding, Precise, VertexRows, changed_precision, indices, influences, orders, rest_of};
use crate::bodies::BodiesLike;
use crate::errors::to_python;
use crate::lattice::LatticeLike;
use crate::preserved::Preserved;
use crate::surface::SurfaceLike;
use crate::words::{DeviceWord, OutsideWord};

/// Several lattices on one mesh, one after the other: each takes what leaves the one before, so they may overlap or lie one within
/// another's result (Ferrier's local and hierarchical deformations).
///
/// lattices: pairs (lattice, options) in the order in which they act; options, a dict, are those of `Lattice.bind` that say how vertices
/// are embedded: outside, influence, rest, continuity, and for the last lattice bodies, caps and surface too. A lattice alone has none.
/// vertices (V, 3), triangles (F, 3), device: as in `Lattice.bind`; the last lattice alone is computed on a GPU.
///
/// The volume is corrected by the last lattice, exactly for the whole chain. Lattices before the first whose control points changed since
/// the last call cost nothing. May be used from several threads, one at a time.
///
/// Raises LatticeError, MeshError and DeviceError.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Chain {
    before: Mutex<PreciseBefore>,
    last: Py<Binding>,
    shapes: Vec<[usize; 3]>,
}

/// All lattices but the last, by the type of the vertices.
enum PreciseBefore {
    Single(Before<f32>),
    Double(Before<f64>),
}

/// `lattices`: pairs of a lattice and its options.
pub(crate) struct LinksLike(Vec<(CoreLattice, Bind)>);

impl<'py> FromPyObject<'_, 'py> for LinksLike {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_subscript!(
        type_hint_identifier!("collections.abc", "Sequence"),
        type_hint_identifier!("typing", "Any")
    );

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let wrong = || {
            Argument::lattice("lattices")
                .error(format!("found {object:?}, expected a list of pairs (lattice, options)"))
        };
        let mut links = Vec::new();
        for item in object.try_iter().map_err(|_| wrong())? {
            let item = item?;
            let (lattice, options) = match item.cast::<PyTuple>() {
                Ok(pair) if pair.len() == 2 => (pair.get_item(0)?, Some(pair.get_item(1)?)),
                Ok(_) => return Err(wrong()),
                Err(_) => (item, None),
            };
            let lattice = lattice.extract::<LatticeLike<'_>>()?.0.core.clone();
            let options = match options {
                Some(options) => {
                    let options = options.cast::<PyDict>().map_err(|_| wrong())?;
                    binding_options(options, &lattice)?
                }
                None => Bind::default(),
            };
            links.push((lattice, options));
        }
        Ok(Self(links))
    }
}

/// The options of one lattice, those of `Lattice.bind`.
fn binding_options(options: &Bound<'_, PyDict>, lattice: &CoreLattice) -> PyResult<Bind> {
    let mut bind = Bind::default();
    for (key, value) in options.iter().filter(|(_, value)| !value.is_none()) {
        let key: String = key.extract()?;
        let Ok(array) = value.extract::<ArrayLike<'_>>();
        match key.as_str() {
            "outside" => bind.outside = value.extract::<OutsideWord>()?.0,
            "influence" => bind.influence = Some(influences(&array)?),
            "rest" => bind.rest = Some(rest_of(&array, lattice.shape())?),
            "bodies" => bind.bodies = value.extract::<BodiesLike>()?.0,
            "caps" => bind.caps = value.extract()?,
            "continuity" => bind.continuity = Some(orders(&array)?),
            "surface" => bind.surface = Some(value.extract::<SurfaceLike>()?.0),
            other => {
                return Err(Argument::lattice("options").error(format!(
                    "found {other:?}, expected outside, influence, rest or continuity; for the last lattice bodies, caps or surface too"
                )));
            }
        }
    }
    Ok(bind)
}

/// `controls`: control points of each lattice.
pub(crate) struct ControlsLike<'py>(Vec<ArrayLike<'py>>);

impl<'py> FromPyObject<'_, 'py> for ControlsLike<'py> {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_subscript!(
        type_hint_identifier!("collections.abc", "Sequence"),
        type_hint_identifier!("numpy.typing", "ArrayLike")
    );

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let items: PyResult<Vec<_>> = object.try_iter().and_then(Iterator::collect);
        let items = items.map_err(|_| {
            Argument::lattice("controls")
                .error(format!("found {object:?}, expected a list with the control points of each lattice"))
        })?;
        let mut sets = Vec::with_capacity(items.len());
        for item in &items {
            let Ok(set) = item.extract::<ArrayLike<'py>>();
            sets.push(set);
        }
        Ok(Self(sets))
    }
}

/// Binds rows of either type.
fn bound<T: Scalar>(
    py: Python<'_>,
    links: Vec<(CoreLattice, Bind)>,
    rows: Vec<[T; 3]>,
    triangles: Vec<[u32; 3]>,
) -> PyResult<(Before<T>, isochor_core::Binding<T>)> {
    py.detach(|| Core::new(links, rows, triangles)).map(Core::into_parts).map_err(to_python)
}

impl Chain {
    /// The control points of each lattice.
    fn controls(&self, controls: &ControlsLike<'_>) -> PyResult<Vec<Vec<DVec3>>> {
        let argument = Argument::lattice("controls");
        if controls.0.len() != self.shapes.len() {
            return Err(argument.error(format!(
                "found {} sets of control points, expected {}, one for each lattice",
                controls.0.len(),
                self.shapes.len()
            )));
        }
        controls.0.iter().zip(&self.shapes).map(|(set, shape)| argument.control(set, *shape)).collect()
    }

    /// Waits for other threads' calls, without the interpreter.
    fn locked(&self, py: Python<'_>) -> MutexGuard<'_, PreciseBefore> {
        self.before.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    /// Brings what leaves the lattices before to the last; it stays so while the guard lives.
    fn fed<'a>(
        &'a self,
        py: Python<'_>,
        controls: &ControlsLike<'_>,
    ) -> PyResult<MutexGuard<'a, PreciseBefore>> {
        let controls = self.controls(controls)?;
        let mut guard = self.locked(py);
        let before = &mut *guard;
        let last = self.last.get();
        py.detach(|| {
            last.written(|precise| match (precise, before) {
                (Precise::Single(last), PreciseBefore::Single(before)) => {
                    before.feed(&controls, last).map(|fed| fed.is_new)
                }
                (Precise::Double(last), PreciseBefore::Double(before)) => {
                    before.feed(&controls, last).map(|fed| fed.is_new)
                }
                _ => Err(changed_precision()),
            })
        })
        .map_err(to_python)?;
        Ok(guard)
    }

    /// Volume of each body of the vertices that enter.
    fn given_volumes(&self, py: Python<'_>, before: &PreciseBefore) -> PyResult<Vec<f64>> {
        let last = self.last.get();
        let volumes = py.detach(|| {
            last.reading(|precise| match (precise, before) {
                (Precise::Single(last), PreciseBefore::Single(before)) => {
                    before.volumes(last).map(<[f64]>::to_vec)
                }
                (Precise::Double(last), PreciseBefore::Double(before)) => {
                    before.volumes(last).map(<[f64]>::to_vec)
                }
                _ => Err(changed_precision()),
            })
        });
        volumes.map_err(to_python)
    }
}

#[pymethods]
impl Chain {
    #[new]
    #[pyo3(signature = (lattices, vertices, triangles=None, device=DeviceWord::Auto))]
    fn new(
        py: Python<'_>,
        lattices: LinksLike,
        vertices: ArrayLike<'_>,
        triangles: Option<ArrayLike<'_>>,
        device: DeviceWord,
    ) -> PyResult<Self> {
        let links = lattices.0;
        let shapes = links.iter().map(|(lattice, _)| lattice.shape()).collect();
        let triangles = triangles.map_or(Ok(Vec::new()), |triangles| indices(&triangles))?;
        let (before, last) = match VertexRows::extract(&vertices)? {
            VertexRows::Single(rows) => {
                let (before, last) = bound(py, links, rows, triangles)?;
                (PreciseBefore::Single(before), Precise::Single(last))
            }
            VertexRows::Double(rows) => {
                let (before, last) = bound(py, links, rows, triangles)?;
                (PreciseBefore::Double(before), Precise::Double(last))
            }
        };
        let last = Py::new(py, Binding::of(py, last, device)?)?;
        Ok(Self { before: Mutex::new(before), last, shapes })
    }

    /// Vertices (V, 3), in the type of those given, that control points of each lattice, a list of (nu, nv, nw, 3), give: each deforms what
    /// leaves the one before. Raises LatticeError.
    fn deform<'py>(
        &self,
        py: Python<'py>,
        controls: ControlsLike<'py>,
    ) -> PyResult<NdArray<'py, OfVertices>> {
        let fed = self.fed(py, &controls)?;
        let found = self.last.get().deformed(py, controls.last()?);
        drop(fed);
        found
    }

    /// Signed volume of what `deform` gives, summed in float64. Raises LatticeError, and MeshError where the triangles enclose none.
    fn volume(&self, py: Python<'_>, controls: ControlsLike<'_>) -> PyResult<f64> {
        let fed = self.fed(py, &controls)?;
        let volume = self.last.get().volume_of(py, controls.last()?);
        drop(fed);
        volume
    }

    /// Deforms, and corrects the last lattice's control points so that the volume of what leaves the chain is that of the vertices given, or
    /// `target`. options: those of `Binding.preserve`, for the last lattice; so are `control` and all else of the result. Raises as
    /// `Binding.preserve` does.
    #[pyo3(signature = (controls, **options: "Any"))]
    fn preserve<'py>(
        &self,
        py: Python<'py>,
        controls: ControlsLike<'py>,
        options: Option<Bound<'py, PyDict>>,
    ) -> PyResult<Py<Preserved>> {
        let options = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
        let fed = self.fed(py, &controls)?;
        let target = options.get_item("target")?.filter(|target| !target.is_none());
        // Pins alone need no volume, and no closed mesh.
        let has_pins = options.get_item("pins")?.is_some_and(|pins| !pins.is_none());
        let amount = options.get_item("amount")?.and_then(|amount| amount.extract::<f64>().ok());
        if target.is_none() && !(has_pins && amount == Some(0.0)) {
            options.set_item("target", PyList::new(py, self.given_volumes(py, &fed)?)?)?;
        }
        let found = self.last.bind(py).call_method("preserve", (controls.last()?.object(),), Some(&options));
        drop(fed);
        Ok(found?.cast_into::<Preserved>()?.unbind())
    }

    /// New positions (V, 3) of the vertices that enter, in the same order and type. Raises MeshError and leaves the chain as it was.
    fn update(&self, py: Python<'_>, vertices: ArrayLike<'_>) -> PyResult<()> {
        let rows = VertexRows::extract(&vertices)?;
        let mut guard = self.locked(py);
        let before = &mut *guard;
        let last = self.last.get();
        let updated = py.detach(|| {
            last.written(|precise| match (precise, before, rows) {
                (Precise::Single(last), PreciseBefore::Single(before), VertexRows::Single(rows)) => {
                    before.update(rows, last).map(|()| true)
                }
                (Precise::Double(last), PreciseBefore::Double(before), VertexRows::Double(rows)) => {
                    before.update(rows, last).map(|()| true)
                }
                _ => Err(changed_precision()),
            })
        });
        updated.map_err(to_python)
    }

    /// Signed volume of the vertices that enter, of all bodies together. Raises MeshError where the triangles enclose no volume.
    #[getter]
    fn reference_volume(&self, py: Python<'_>) -> PyResult<f64> {
        let guard = self.locked(py);
        Ok(self.given_volumes(py, &guard)?.iter().sum())
    }

    fn __len__(&self) -> usize {
        self.shapes.len()
    }

    fn __repr__(&self) -> String {
        format!("Chain({} lattices)", self.shapes.len())
    }
}

impl<'py> ControlsLike<'py> {
    fn last(&self) -> PyResult<&ArrayLike<'py>> {
        self.0.last().ok_or_else(|| Argument::lattice("controls").error("found none"))
    }
}
