// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Binding2D` and `isochor.Preserved2D`.

use isochor_core::{
    Cost, DVec3, Error, Lattice as Core, Method, Outside, PinPoint, Pins, Planar, Preserve, Scalar,
};
use numpy::{Element, PyUntypedArray};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, NumberLike, Numbers, OfVertices};
use crate::backend::{Backend, Ran};
use crate::binding::{indices, influences};
use crate::errors::{to_python, warn};
use crate::plane::{PlaneRows, control, flattened, points, vertices};
use crate::words::{CostWord, DeviceWord, MethodWord, method_name};

/// A flat mesh of the core in either precision.
enum Precise {
    Single(Planar<f32>),
    Double(Planar<f64>),
}

macro_rules! either {
    ($precise:expr, $planar:ident => $value:expr) => {
        match $precise {
            Precise::Single($planar) => $value,
            Precise::Double($planar) => $value,
        }
    };
}

/// Points of the plane, or a flat mesh, embedded in a lattice, made by `Lattice2D.bind`.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Binding2D {
    precise: Precise,
    backend: Backend,
}

impl Binding2D {
    pub(crate) fn new(
        py: Python<'_>,
        lattice: &Core,
        vertices: &ArrayLike<'_>,
        triangles: Option<ArrayLike<'_>>,
        device: DeviceWord,
        outside: Outside,
        influence: Option<ArrayLike<'_>>,
    ) -> PyResult<Self> {
        let vertices = PlaneRows::extract(vertices)?;
        let triangles = triangles.map_or(Ok(Vec::new()), |triangles| indices(&triangles))?;
        let influence = influence.map(|influence| influences(&influence)).transpose()?;
        let lattice = lattice.clone();
        let bound = py.detach(|| match vertices {
            PlaneRows::Single(rows) => {
                Planar::new(lattice, &rows, triangles, influence, outside).map(Precise::Single)
            }
            PlaneRows::Double(rows) => {
                Planar::new(lattice, &rows, triangles, influence, outside).map(Precise::Double)
            }
        });
        let (backend, warning) = py.detach(|| Backend::new(device));
        warn(py, warning)?;
        Ok(Self { precise: bound.map_err(to_python)?, backend })
    }

    fn shape(&self) -> [usize; 3] {
        either!(&self.precise, planar => planar.binding().lattice().shape())
    }

    fn height(&self) -> f64 {
        either!(&self.precise, planar => planar.height())
    }

    fn control(&self, object: &ArrayLike<'_>) -> PyResult<Vec<DVec3>> {
        control(Argument::lattice("control"), object, self.shape())
    }

    fn pins(&self, pins: (ArrayLike<'_>, ArrayLike<'_>)) -> PyResult<Pins> {
        let argument = Argument::pins("indices of pins");
        let vertex = |index: i64| {
            let wrong = |_| argument.error(format!("found {index}, expected the index of a vertex"));
            u32::try_from(index).map(PinPoint::Vertex).map_err(wrong)
        };
        let points = argument.integers(&pins.0, &[None])?.into_iter().map(vertex);
        let targets = self::points(Argument::pins("targets of pins"), &pins.1)?;
        let lifted = targets.into_iter().map(|at| either!(&self.precise, planar => planar.lifted(at)));
        Ok(Pins { points: points.collect::<PyResult<_>>()?, targets: lifted.collect() })
    }
}

/// What `work` writes into room for the prism's vertices: those of the mesh, and what it returned.
fn flat<T: Scalar, R>(
    planar: &Planar<T>,
    work: impl FnOnce(&mut [[T; 3]]) -> isochor_core::Result<R>,
) -> isochor_core::Result<(Vec<[T; 2]>, R)> {
    let mut rows = vec![[T::from_f64(0.0); 3]; planar.binding().vertices().len()];
    let result = work(&mut rows)?;
    Ok((rows[..planar.count()].iter().map(|&[x, y, _]| [x, y]).collect(), result))
}

/// The same with the area of what came out.
fn corrected<T: Scalar + Element>(
    planar: &Planar<T>,
    backend: &Backend,
    control: &[DVec3],
    options: &Preserve,
) -> isochor_core::Result<(Vec<[T; 2]>, f64, Ran)> {
    let (rows, ran) = flat(planar, |out| backend.preserve(planar.binding(), control, options, out))?;
    // Pins alone need no triangles, and leave no area to measure.
    let area = planar.area(&rows).unwrap_or(f64::NAN);
    Ok((rows, area, ran))
}

#[pymethods]
impl Binding2D {
    /// Points (V, 2), in the type of those bound, that control points (nu, nv, 2) give. Raises LatticeError.
    fn deform<'py>(&self, py: Python<'py>, control: ArrayLike<'py>) -> PyResult<NdArray<'py, OfVertices>> {
        let control = self.control(&control)?;
        either!(&self.precise, planar => {
            let deform = || flat(planar, |out| self.backend.deform(planar.binding(), &control, out));
            let (rows, warning) = py.detach(deform).map_err(to_python)?;
            warn(py, warning)?;
            vertices(py, rows)
        })
    }

    /// Signed area of the mesh that control points (nu, nv, 2) give, summed in float64 over its triangles; positive where they wind
    /// counter-clockwise. Raises LatticeError, and MeshError without triangles.
    fn area(&self, py: Python<'_>, control: ArrayLike<'_>) -> PyResult<f64> {
        let control = self.control(&control)?;
        either!(&self.precise, planar => py.detach(|| {
            planar.area(&flat(planar, |out| planar.binding().deform(&control, out))?.0)
        }))
        .map_err(to_python)
    }

    /// Signed area of the mesh as bound. Raises MeshError without triangles.
    #[getter]
    fn reference_area(&self) -> PyResult<f64> {
        either!(&self.precise, planar => {
            let bound = planar.binding().vertices()[..planar.count()].iter().map(|&[x, y, _]| [x, y]);
            planar.area(&bound.collect::<Vec<_>>())
        })
        .map_err(to_python)
    }

    /// Deforms and corrects the control points so that the area of the mesh is its target, exactly: `Binding.preserve` in the plane.
    ///
    /// control (nu, nv, 2): the control points asked for. axes: shares of x and y in the correction; (1, 1) if not given.
    /// method, cost: as of `Binding.preserve`. weights (nu, nv): positive; large keeps a control point, inf freezes it.
    /// pins: vertices (m,) and their targets (m, 2), reached exactly.
    /// target: the area to reach; None for that of the mesh as bound. amount: 0 leaves the area as deformed and pinned, 1 reaches the
    /// target.
    ///
    /// Raises VolumeError where an area cannot be reached, PinError, LatticeError, MeshError.
    #[pyo3(signature = (control, axes=None, method=MethodWord(Method::Balanced), weights=None, pins=None, target=None, amount=NumberLike::Default(1.0), cost=CostWord(Cost::Points)))]
    #[expect(clippy::too_many_arguments, reason = "the keywords of one call")]
    fn preserve<'py>(
        &self,
        py: Python<'py>,
        control: ArrayLike<'py>,
        axes: Option<ArrayLike<'py>>,
        method: MethodWord,
        weights: Option<ArrayLike<'py>>,
        pins: Option<(ArrayLike<'py>, ArrayLike<'py>)>,
        target: Option<NumberLike<'py>>,
        amount: NumberLike<'py>,
        cost: CostWord,
    ) -> PyResult<Preserved2D> {
        let (control, shape) = (self.control(&control)?, self.shape());
        let shares = |axes| Argument::volume("axes").floats(axes, Numbers::FloatsOrIntegers, &[Some(2)]);
        let shares = axes.as_ref().map_or(Ok(vec![1.0; 2]), shares)?;
        let of_points = |weights| {
            let shape = [Some(shape[0]), Some(shape[1])];
            Argument::lattice("weights").floats(weights, Numbers::FloatsOrIntegers, &shape)
        };
        let target = target.map(|target| Argument::volume("target").number(&target)).transpose()?;
        let options = Preserve {
            axes: [shares[0], shares[1], 0.0],
            method: method.0,
            weights: weights.as_ref().map(of_points).transpose()?,
            pins: pins.map(|pins| self.pins(pins)).transpose()?.unwrap_or_default(),
            target: target.map(|area| vec![area * self.height()]),
            amount: Argument::volume("amount").number(&amount)?,
            cost: cost.0,
            ..Preserve::default()
        };
        let in_plane = |error| to_python(self.in_plane(error));
        let (vertices, area, ran) = either!(&self.precise, planar => {
            let correct = || corrected(planar, &self.backend, &control, &options);
            let (rows, area, ran) = py.detach(correct).map_err(in_plane)?;
            (vertices(py, rows)?, area, ran)
        });
        warn(py, ran.warning.clone())?;
        Preserved2D::new(py, vertices, area, &ran, shape, self.height())
    }

    fn __repr__(&self) -> String {
        let [nu, nv, _] = self.shape();
        let count = either!(&self.precise, planar => planar.count());
        format!("Binding2D(vertices={count}, lattice=[{nu}, {nv}], device={:?})", self.backend.device())
    }
}

impl Binding2D {
    /// An error about volumes, which are areas times the height of the prism.
    fn in_plane(&self, error: Error) -> Error {
        match error {
            Error::Volume(message) => {
                Error::Volume(format!("area (as the volume of a plate {:?} thick): {message}", self.height()))
            }
            other => other,
        }
    }
}

/// A flat mesh deformed with its area corrected: the result of `Binding2D.preserve`.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Preserved2D {
    control: Py<PyUntypedArray>,
    vertices: Py<PyUntypedArray>,
    /// Signed area, measured on `vertices` in float64; NaN where no triangles were bound.
    #[pyo3(get)]
    area: f64,
    /// Area that was aimed at, after `amount`.
    #[pyo3(get)]
    target: f64,
    /// |area - target| / |target|.
    #[pyo3(get)]
    error: f64,
    /// How far the correction moved the control points: sqrt(sum of weight times squared distance).
    #[pyo3(get)]
    distance: f64,
    /// What ran, after any fall-back: "balanced", "sweep", "gradient" or "nearest".
    #[pyo3(get)]
    method: &'static str,
    /// Rounds over the axes, steps or iterations, as of `Preserved`.
    #[pyo3(get)]
    iterations: u32,
    /// What computed: "cpu" or "gpu".
    #[pyo3(get)]
    device: &'static str,
}

impl Preserved2D {
    fn new(
        py: Python<'_>,
        vertices: NdArray<'_, OfVertices>,
        area: f64,
        ran: &Ran,
        [nu, nv, _]: [usize; 3],
        height: f64,
    ) -> PyResult<Self> {
        let outcome = &ran.preserved;
        let Ok(control) = flattened(py, &outcome.control, &[nu, nv])?.into_pyobject(py);
        let Ok(vertices) = vertices.into_pyobject(py);
        let target = outcome.targets.iter().sum::<f64>() / height;
        Ok(Self {
            control: control.unbind(),
            vertices: vertices.unbind(),
            area,
            target,
            error: (area - target).abs() / target.abs(),
            distance: outcome.distance,
            method: method_name(outcome.method),
            iterations: outcome.iterations,
            device: ran.device,
        })
    }
}

#[pymethods]
impl Preserved2D {
    /// Corrected control points, float64 (nu, nv, 2).
    #[getter]
    fn control<'py>(&self, py: Python<'py>) -> NdArray<'py, f64> {
        NdArray::of(self.control.bind(py).clone())
    }

    /// Deformed points (V, 2), in the type of those bound.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> NdArray<'py, OfVertices> {
        NdArray::of(self.vertices.bind(py).clone())
    }

    fn __repr__(&self) -> String {
        format!("Preserved2D(area={:?}, target={:?}, method={:?})", self.area, self.target, self.method)
    }
}
