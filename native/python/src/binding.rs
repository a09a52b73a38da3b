// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Binding`.

use std::borrow::Cow;
use std::sync::{Arc, PoisonError, RwLock};

use isochor_core::{Bind, Binding as Core, Lattice as CoreLattice, Measure, Outside, Preserve};
use numpy::{Element, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, NumberLike, Numbers, OfVertices, converted};
use crate::backend::Backend;
use crate::bodies::{BodiesLike, TargetLike};
use crate::errors::{to_python, warn};
use crate::lattice::LatticeLike;
use crate::pins::PinsLike;
use crate::preserved::Preserved;
use crate::surface::SurfaceLike;
use crate::words::{AccuracyWord, CostWord, DeviceWord, LimitWord, MethodWord};

/// A binding of the core for either precision, shared with the results that measure on it.
pub(crate) type Shared = Arc<RwLock<Precise>>;

/// The core's binding by the type of the vertices.
pub(crate) enum Precise {
    Single(Core<f32>),
    Double(Core<f64>),
}

macro_rules! either {
    ($precise:expr, $core:ident => $value:expr) => {
        match $precise {
            Precise::Single($core) => $value,
            Precise::Double($core) => $value,
        }
    };
}

/// A mesh embedded in a lattice, made by `Lattice.bind`. May be used from several threads.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Binding {
    shared: Shared,
    backend: Backend,
    vertex_count: usize,
}

/// Vertices (V, 3) of either precision as they came in.
pub(crate) enum VertexRows {
    Single(Vec<[f32; 3]>),
    Double(Vec<[f64; 3]>),
}

impl VertexRows {
    pub(crate) fn extract(object: &ArrayLike<'_>) -> PyResult<Self> {
        let argument = Argument::mesh("vertices");
        let array = argument.array(object, Numbers::Floats, &[None, Some(3)])?;
        match array.dtype().to_string().as_str() {
            "float32" => Ok(Self::Single(rows(converted(&array, "float32")?))),
            "float64" => Ok(Self::Double(rows(converted(&array, "float64")?))),
            other => Err(argument.error(format!("found dtype {other}, expected float32 or float64"))),
        }
    }

    /// Those of a result.
    fn of(vertices: &Bound<'_, PyUntypedArray>) -> PyResult<Self> {
        Ok(match vertices.cast::<PyArrayDyn<f32>>() {
            Ok(array) => Self::Single(rows(array.readonly().as_slice()?.to_vec())),
            Err(_) => Self::Double(rows(vertices.cast::<PyArrayDyn<f64>>()?.readonly().as_slice()?.to_vec())),
        })
    }
}

impl Binding {
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    pub(crate) fn new(
        py: Python<'_>,
        lattice: &CoreLattice,
        vertices: ArrayLike<'_>,
        triangles: Option<ArrayLike<'_>>,
        device: DeviceWord,
        outside: Outside,
        influence: Option<ArrayLike<'_>>,
        rest: Option<ArrayLike<'_>>,
        bodies: Option<BodiesLike>,
        caps: bool,
        surface: Option<SurfaceLike>,
        continuity: Option<ArrayLike<'_>>,
    ) -> PyResult<Self> {
        let vertices = VertexRows::extract(&vertices)?;
        let triangles = triangles.map_or(Ok(Vec::new()), |triangles| indices(&triangles))?;
        let influence = influence.map(|influence| influences(&influence)).transpose()?;
        let rest = rest.map(|rest| rest_of(&rest, lattice.shape())).transpose()?;
        let bodies = bodies.map(|bodies| bodies.0).unwrap_or_default();
        let continuity = continuity.as_ref().map(orders).transpose()?;
        let surface = surface.map(|surface| surface.0);
        let (lattice, options) =
            (lattice.clone(), Bind { influence, outside, rest, bodies, caps, surface, continuity });
        let bound = py.detach(|| match vertices {
            VertexRows::Single(rows) => Core::with(lattice, rows, triangles, options).map(Precise::Single),
            VertexRows::Double(rows) => Core::with(lattice, rows, triangles, options).map(Precise::Double),
        });
        Self::of(py, bound.map_err(to_python)?, device)
    }

    /// A bound mesh.
    pub(crate) fn of(py: Python<'_>, bound: Precise, device: DeviceWord) -> PyResult<Self> {
        let vertex_count = either!(&bound, core => core.vertices().len());
        let (backend, warning) = py.detach(|| Backend::new(device));
        warn(py, warning)?;
        Ok(Self { shared: Arc::new(RwLock::new(bound)), backend, vertex_count })
    }

    /// Changes what is bound; `f` tells whether it did. Without the interpreter.
    pub(crate) fn written(
        &self,
        f: impl FnOnce(&mut Precise) -> isochor_core::Result<bool>,
    ) -> isochor_core::Result<()> {
        let mut precise = self.shared.write().unwrap_or_else(PoisonError::into_inner);
        if f(&mut precise)? {
            self.backend.reset();
        }
        Ok(())
    }

    /// Reads what is bound. Without the interpreter.
    pub(crate) fn reading<R>(&self, f: impl FnOnce(&Precise) -> R) -> R {
        f(&self.shared.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Vertices that control points give.
    pub(crate) fn deformed<'py>(
        &self,
        py: Python<'py>,
        control: &ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, OfVertices>> {
        let control = Argument::lattice("control").control(control, self.shape(py))?;
        let (array, warning) = self.with_output(
            py,
            |core, out| self.backend.deform(core, &control, out),
            |core, out| self.backend.deform(core, &control, out),
        )?;
        warn(py, warning)?;
        Ok(NdArray::of(array))
    }

    /// Volume of these.
    pub(crate) fn volume_of(&self, py: Python<'_>, control: &ArrayLike<'_>) -> PyResult<f64> {
        let control = Argument::lattice("control").control(control, self.shape(py))?;
        self.read(py, |precise| either!(precise, core => core.volume(&control))).map_err(to_python)
    }

    /// Leaves the interpreter and reads the binding.
    fn read<R: Send>(&self, py: Python<'_>, f: impl FnOnce(&Precise) -> R + Send) -> R {
        read(py, &self.shared, f)
    }

    fn shape(&self, py: Python<'_>) -> [usize; 3] {
        self.read(py, |precise| either!(precise, core => core.lattice().shape()))
    }

    /// Runs `f` on room for the vertices, in their type, and returns the array with what `f` returned.
    fn with_output<'py, R: Send>(
        &self,
        py: Python<'py>,
        single: impl FnOnce(&Core<f32>, &mut [[f32; 3]]) -> isochor_core::Result<R> + Send,
        double: impl FnOnce(&Core<f64>, &mut [[f64; 3]]) -> isochor_core::Result<R> + Send,
    ) -> PyResult<(Bound<'py, PyUntypedArray>, R)> {
        let is_single = self.read(py, |precise| matches!(precise, Precise::Single(_)));
        if is_single {
            self.filled(py, |precise, out| match precise {
                Precise::Single(core) => single(core, out),
                Precise::Double(_) => Err(changed_precision()),
            })
        } else {
            self.filled(py, |precise, out| match precise {
                Precise::Double(core) => double(core, out),
                Precise::Single(_) => Err(changed_precision()),
            })
        }
    }

    fn filled<'py, T: Element + Copy, R: Send>(
        &self,
        py: Python<'py>,
        f: impl FnOnce(&Precise, &mut [[T; 3]]) -> isochor_core::Result<R> + Send,
    ) -> PyResult<(Bound<'py, PyUntypedArray>, R)> {
        let array = PyArray2::<T>::zeros(py, [self.vertex_count, 3], false);
        let mut writable = array.readwrite();
        let out = writable.as_slice_mut()?.as_chunks_mut().0;
        let result = self.read(py, |precise| f(precise, out)).map_err(to_python)?;
        drop(writable);
        Ok((array.as_untyped().clone(), result))
    }
}

#[pymethods]
impl Binding {
    /// Embeds anew what is given and keeps what is not: vertices (V, 3) of the same mesh in new positions, another lattice,
    /// another influence (V,), other control points at rest (nu, nv, nw, 3). Cheaper than a new bind, for the topology is not
    /// looked at again, and the bodies stay those that bind found. Raises MeshError, and LatticeError where control points at rest, also those kept, do not fit the
    /// lattice; then leaves the binding as it was.
    #[pyo3(signature = (vertices=None, lattice=None, influence=None, rest=None))]
    fn update(
        &self,
        py: Python<'_>,
        vertices: Option<ArrayLike<'_>>,
        lattice: Option<LatticeLike<'_>>,
        influence: Option<ArrayLike<'_>>,
        rest: Option<ArrayLike<'_>>,
    ) -> PyResult<()> {
        let vertices = vertices.map(|vertices| VertexRows::extract(&vertices)).transpose()?;
        let influence = influence.map(|influence| influences(&influence)).transpose()?;
        let lattice = lattice.map(|lattice| lattice.0.core.clone());
        let shape = lattice.as_ref().map_or_else(|| self.shape(py), |lattice| lattice.shape());
        let rest = rest.map(|rest| rest_of(&rest, shape)).transpose()?;
        py.detach(|| {
            let mut precise = self.shared.write().unwrap_or_else(PoisonError::into_inner);
            self.backend.reset();
            match (&mut *precise, vertices) {
                (Precise::Single(core), Some(VertexRows::Single(rows))) => {
                    core.update(Some(rows), lattice, influence, rest)
                }
                (Precise::Double(core), Some(VertexRows::Double(rows))) => {
                    core.update(Some(rows), lattice, influence, rest)
                }
                (Precise::Single(core), None) => core.update(None, lattice, influence, rest),
                (Precise::Double(core), None) => core.update(None, lattice, influence, rest),
                _ => Err(changed_precision()),
            }
        })
        .map_err(to_python)
    }

    /// Deforms: vertices (V, 3), in the type of those bound, that control points (nu, nv, nw, 3) give: equation (1) of the
    /// volume paper. Raises LatticeError.
    fn deform<'py>(&self, py: Python<'py>, control: ArrayLike<'py>) -> PyResult<NdArray<'py, OfVertices>> {
        self.deformed(py, &control)
    }

    /// Signed volume of the vertices that `deform` gives for control points (nu, nv, nw, 3), summed in float64, of all bodies
    /// together, caps included; positive where the triangles wind counter-clockwise seen from outside. Equation (5). Raises MeshError
    /// where the triangles enclose no volume.
    fn volume(&self, py: Python<'_>, control: ArrayLike<'_>) -> PyResult<f64> {
        self.volume_of(py, &control)
    }

    /// The same of each body, float64 (bodies,).
    fn volumes<'py>(&self, py: Python<'py>, control: ArrayLike<'py>) -> PyResult<NdArray<'py, f64>> {
        let control = Argument::lattice("control").control(&control, self.shape(py))?;
        let volumes = self.read(py, |precise| either!(precise, core => core.volumes(&control)));
        Ok(NdArray::numbers(py, &volumes.map_err(to_python)?))
    }

    /// Number of bodies that keep a volume each; 1 where bodies=None.
    #[getter]
    fn body_count(&self, py: Python<'_>) -> usize {
        self.read(py, |precise| either!(precise, core => core.body_count()))
    }

    /// Body of each triangle, int32 (F,); -1 for those of no body, which deform along.
    #[getter]
    fn body_of_triangle<'py>(&self, py: Python<'py>) -> NdArray<'py, i32> {
        NdArray::numbers(py, &self.read(py, |precise| either!(precise, core => core.body_of_triangle())))
    }

    /// Signed volume of each body as bound, float64 (bodies,). Raises MeshError where the triangles enclose no volume.
    #[getter]
    fn reference_volumes<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let volumes = |measures: &[Measure]| measures.iter().map(|body| body.volume).collect::<Vec<f64>>();
        let found = self.read(py, |precise| either!(precise, core => core.references().map(volumes)));
        Ok(NdArray::numbers(py, &found.map_err(to_python)?))
    }

    /// Signed volume of the mesh as bound, of all bodies together. Raises MeshError where the triangles enclose no volume.
    #[getter]
    fn reference_volume(&self, py: Python<'_>) -> PyResult<f64> {
        let measure = self.read(py, |precise| either!(precise, core => core.reference()));
        Ok(measure.map_err(to_python)?.volume)
    }

    /// Control points at rest, float64 (nu, nv, nw, 3): those that leave every vertex where it is.
    #[getter]
    fn rest<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        let (shape, rest) =
            self.read(py, |precise| either!(precise, core => (core.lattice().shape(), core.rest())));
        NdArray::points(py, &rest, &[shape[0], shape[1], shape[2], 3])
    }

    /// The control points that count of those given, float64 (nu, nv, nw, 3): where `continuity` was given to bind, the layers that it
    /// freezes are at rest. Raises LatticeError.
    fn held<'py>(&self, py: Python<'py>, control: ArrayLike<'py>) -> PyResult<NdArray<'py, f64>> {
        let shape = self.shape(py);
        let control = Argument::lattice("control").control(&control, shape)?;
        let held =
            self.read(py, |precise| either!(precise, core => core.held(&control).map(Cow::into_owned)));
        NdArray::points(py, &held.map_err(to_python)?, &[shape[0], shape[1], shape[2], 3])
    }

    /// Number of vertices beyond the lattice's domain, or nowhere inside the lattice where it was bound in a shape.
    #[getter]
    fn outside_count(&self, py: Python<'_>) -> usize {
        self.read(py, |precise| either!(precise, core => core.outside_count()))
    }

    /// What computes the next call, as far as is known: "cpu" or "gpu". With device="auto" that is "cpu" until a GPU was
    /// measured to be faster.
    #[getter]
    fn device(&self, py: Python<'_>) -> &'static str {
        py.detach(|| self.backend.device())
    }

    /// The same by the name it has in devices().
    #[getter]
    fn device_name(&self, py: Python<'_>) -> String {
        py.detach(|| self.backend.name())
    }

    /// Bytes that the binding takes in the memory of a GPU: 0 on the CPU, and before the first call.
    #[getter]
    fn device_bytes(&self, py: Python<'_>) -> u64 {
        py.detach(|| self.backend.bytes())
    }

    /// Sums up now what makes later corrections on the CPU independent of the number of vertices: the volume as a cubic form of the
    /// control points. It happens by itself, in the background, after some dozens of corrections of the same binding, where it pays
    /// (prepare_in_background(False) forbids it); corrections then differ by rounding only. Takes about a second for half a million
    /// vertices and a lattice of 4 x 4 x 4. Returns whether it is there: not for lattices of more than 216 control points, nor for
    /// several bodies or caps. `update` drops it. Raises MeshError where the triangles enclose no volume.
    fn prepare(&self, py: Python<'_>) -> PyResult<bool> {
        self.read(py, |precise| either!(precise, core => core.prepare())).map_err(to_python)
    }

    /// Bytes that make corrections on the CPU independent of the number of vertices; 0 while every correction goes over the mesh.
    #[getter]
    fn tensor_bytes(&self, py: Python<'_>) -> usize {
        self.read(py, |precise| either!(precise, core => core.tensor_bytes()))
    }

    /// Deforms and corrects the control points so that the volume of every body is its target, exactly: Problems 1 and 2 of the
    /// volume paper, equations (13)-(24), with one row for each body.
    ///
    /// control (nu, nv, nw, 3): the control points asked for.
    /// axes: shares of x, y, z in the correction, not negative, normalised; an axis with share 0 is not touched.
    /// frame (3, 3) rows: the directions that "axes" means; None for the coordinate axes.
    /// method: "balanced" (geometric steps; keeps round things round; falls back to "sweep" where the volume changes sign),
    /// "sweep" (the paper's), "gradient" (one exact step over all axes with a share at once, no order of axes; falls back to
    /// "balanced" where the volume turns before its target) or "nearest" (the smallest displacement over all axes with a share at
    /// once, by iteration: twenty to fifty times the time of a sweep). For the last two shares only say which axes take part.
    /// weights (nu, nv, nw): positive; large keeps a control point, inf freezes it (Remark 2).
    /// pins: isochor.Pins, or (indices (m,), targets (m, 3)) of vertices: these points land exactly on their targets, whatever the
    /// shares (Problem 2, equations (20)-(24), for any number of pins).
    /// target: the volume to reach, or one for each body (bodies,); one number with several bodies is their sum, shared in proportion
    /// to reference_volumes. None for reference_volumes.
    /// amount: 0 leaves the volume as deformed and pinned, 1 (if not given) reaches the target. Pins alone (amount 0) need no closed
    /// mesh.
    /// cost: what the correction keeps small (Remark 1): "points" (how far control points move), "surface" (how far vertices move) or
    /// "bending" (how much space is bent; stretching costs nothing). The last two are factorised at the first call after bind or
    /// update; a lattice too large for that is a LatticeError. weights count in all of them.
    /// limit: None, or "unfolded": the correction goes only so far that no cell of the lattice folds that is proved unfolded without
    /// it; result.missing says how much volume is then missing.
    /// accuracy: how a mesh of 20,000 vertices or more is corrected on the CPU: "exact" by passes over itself; "finished" by passes over a
    /// coarse copy and one exact step, twice as fast: the volume is as exact, the correction longer by a ten-thousandth or so; "rough"
    /// by passes over the copy alone, four times as fast, with what remains in the result's error. Meshes of several bodies or with
    /// caps, and what `prepare` made fast, are always "exact".
    ///
    /// Raises PinError for pins that are repeated, contradict each other or cannot move, VolumeError, LatticeError, MeshError.
    #[pyo3(signature = (control, axes=None, frame=None, method=MethodWord(isochor_core::Method::Balanced), weights=None, pins=None, target=None, amount=NumberLike::Default(1.0), cost=CostWord(isochor_core::Cost::Points), limit=None, accuracy=AccuracyWord(isochor_core::Accuracy::Exact)))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    fn preserve(
        &self,
        py: Python<'_>,
        control: ArrayLike<'_>,
        axes: Option<ArrayLike<'_>>,
        frame: Option<ArrayLike<'_>>,
        method: MethodWord,
        weights: Option<ArrayLike<'_>>,
        pins: Option<PinsLike>,
        target: Option<TargetLike<'_>>,
        amount: NumberLike<'_>,
        cost: CostWord,
        limit: Option<LimitWord>,
        accuracy: AccuracyWord,
    ) -> PyResult<Preserved> {
        let shape = self.shape(py);
        let control = Argument::lattice("control").control(&control, shape)?;
        let options = Preserve {
            axes: axes
                .map_or(Ok([1.0; 3]), |axes| Argument::volume("axes").vector(&axes).map(|a| a.to_array()))?,
            frame: frame.map(|frame| Argument::volume("frame").rows(&frame)).transpose()?,
            method: method.0,
            weights: weights.map(|weights| point_weights(&weights, shape)).transpose()?,
            pins: pins.map(|pins| pins.0).unwrap_or_default(),
            target: target.map(|target| target.numbers(self.body_count(py))).transpose()?,
            amount: Argument::volume("amount").number(&amount)?,
            cost: cost.0,
            limit: limit.map(|limit| limit.0),
            accuracy: accuracy.0,
        };
        let (vertices, ran) = self.with_output(
            py,
            |core, out| self.backend.preserve(core, &control, &options, out),
            |core, out| self.backend.preserve(core, &control, &options, out),
        )?;
        warn(py, ran.warning.clone())?;
        Preserved::new(py, Arc::clone(&self.shared), vertices, &ran, shape)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let shape = self.shape(py);
        let device = self.device(py);
        format!("Binding(vertices={}, lattice={shape:?}, device={device:?})", self.vertex_count)
    }
}

/// Allows (True, at the start) or forbids, for the whole process, that corrections on the CPU become independent of the number of
/// vertices by themselves, as by Binding.prepare. What they give differs by rounding then, so a frame depends in its last bits on
/// how many came before: forbid it where several processes must compute the same frames to the bit.
#[pyfunction]
pub(crate) fn prepare_in_background(allowed: bool) {
    isochor_core::prepare_in_background(allowed);
}

/// Signed volume of every body of a result's vertices.
pub(crate) fn volumes(
    py: Python<'_>,
    shared: &Shared,
    vertices: &Bound<'_, PyUntypedArray>,
) -> PyResult<Vec<f64>> {
    match VertexRows::of(vertices)? {
        VertexRows::Single(rows) => measured(py, shared, |precise| match precise {
            Precise::Single(core) => core.measures(&rows),
            Precise::Double(_) => Err(changed_precision()),
        }),
        VertexRows::Double(rows) => measured(py, shared, |precise| match precise {
            Precise::Double(core) => core.measures(&rows),
            Precise::Single(_) => Err(changed_precision()),
        }),
    }
}

/// The surface's vertices over those of a result; None where the surface is theirs.
pub(crate) fn surface_over<'py>(
    py: Python<'py>,
    shared: &Shared,
    vertices: &Bound<'py, PyUntypedArray>,
) -> PyResult<Option<NdArray<'py, f64>>> {
    let found = match VertexRows::of(vertices)? {
        VertexRows::Single(rows) => read(py, shared, |precise| match precise {
            Precise::Single(core) => core.surface_over(&rows),
            Precise::Double(_) => Err(changed_precision()),
        }),
        VertexRows::Double(rows) => read(py, shared, |precise| match precise {
            Precise::Double(core) => core.surface_over(&rows),
            Precise::Single(_) => Err(changed_precision()),
        }),
    };
    let found = found.map_err(to_python)?;
    found.map(|places| NdArray::points(py, &places, &[places.len(), 3])).transpose()
}

fn measured(
    py: Python<'_>,
    shared: &Shared,
    f: impl FnOnce(&Precise) -> isochor_core::Result<Vec<Measure>> + Send,
) -> PyResult<Vec<f64>> {
    let bodies = read(py, shared, f);
    Ok(bodies.map_err(to_python)?.iter().map(|body| body.volume).collect())
}

/// Leaves the interpreter and reads a binding.
fn read<R: Send>(py: Python<'_>, shared: &Shared, f: impl FnOnce(&Precise) -> R + Send) -> R {
    py.detach(|| f(&shared.read().unwrap_or_else(PoisonError::into_inner)))
}

fn rows<T: Copy>(flat: Vec<T>) -> Vec<[T; 3]> {
    flat.as_chunks().0.to_vec()
}

pub(crate) fn changed_precision() -> isochor_core::Error {
    isochor_core::Error::Mesh(
        "vertices: found another float type than was bound, expected the same; convert them".into(),
    )
}

/// Triangles (F, 3) of any integer type.
pub(crate) fn indices(object: &ArrayLike<'_>) -> PyResult<Vec<[u32; 3]>> {
    let argument = Argument::mesh("triangles");
    let array = argument.array(object, Numbers::Integers, &[None, Some(3)])?;
    let wide: Vec<i64> = converted(&array, "int64")?;
    let out_of_range = |&index: &i64| u32::try_from(index).is_err();
    if let Some(at) = wide.iter().position(out_of_range) {
        let count = wide.iter().filter(|i| out_of_range(i)).count();
        return Err(argument.error(format!(
            "{count} indices are out of range, the first is {} in triangle {}; expected indices of vertices",
            wide[at],
            at / 3
        )));
    }
    Ok(rows(wide.into_iter().map(|index| index as u32).collect()))
}

pub(crate) fn influences(object: &ArrayLike<'_>) -> PyResult<Vec<f64>> {
    Argument::mesh("influence").floats(object, Numbers::FloatsOrIntegers, &[None])
}

/// Control points at rest.
pub(crate) fn rest_of(object: &ArrayLike<'_>, shape: [usize; 3]) -> PyResult<Vec<isochor_core::DVec3>> {
    Argument::lattice("rest").control(object, shape)
}

/// The argument `continuity`.
pub(crate) fn orders(object: &ArrayLike<'_>) -> PyResult<usize> {
    let argument = Argument::lattice("continuity");
    let values: Vec<i64> = converted(&argument.array(object, Numbers::Integers, &[])?, "int64")?;
    let order = values.first().copied().unwrap_or_default();
    usize::try_from(order).map_err(|_| argument.error(format!("found {order}, expected no negative number")))
}

pub(crate) fn point_weights(object: &ArrayLike<'_>, shape: [usize; 3]) -> PyResult<Vec<f64>> {
    Argument::lattice("weights").floats(object, Numbers::FloatsOrIntegers, &shape.map(Some))
}
