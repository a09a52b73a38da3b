// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Elastic`.

use std::sync::{Mutex, MutexGuard, PoisonError};

use isochor_core::elastic::{Carried, Ground, Material, Start, Totals};
use isochor_core::{DVec3, Elastic as Core, Outside};
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, NdArray, NumberLike, Numbers};
use crate::binding::{indices, influences};
use crate::errors::to_python;
use crate::lattice::LatticeLike;
use crate::words::OutsideWord;

/// A lattice as a damped elastic body under gravity, above a ground plane, that carries a surface and keeps its volume.
///
/// Its rest shape is the lattice's; lengths are the lattice's units, times are seconds, and masses are for a density of one.
///
/// vertices (V, 3), triangles (F, 3): the surface, where the lattice is at rest. Its vertices meet the ground; control points may
/// go below. With triangles, which must be closed, the volume inside is kept. A few thousand vertices are plenty.
/// control (nu, nv, nw, 3): where the control points start; the rest shape if None. velocity, the same shape: how they move then,
/// in lengths a second; not at all if None. A start of another volume comes to it over the time of an oscillation.
/// pinned (nu, nv, nw) of bool: control points that `step` leads instead of forces.
/// frequency: oscillations a second of the slowest stretch of the free lattice along its longest side L. It stands for stiffness:
/// Young's modulus is density (2 L frequency)^2, Poisson's ratio 0 but for the volume.
/// damping: damping ratio of that oscillation; 0 for none, 1 for critical.
/// gravity (3,): acceleration.
/// ground (2, 3): a point of the plane and its normal, away from the ground; None for no ground.
/// friction: coefficient of Coulomb friction on the ground.
/// volume: factor of the volume at rest that is kept.
/// influence (V,), outside: as in `Lattice.bind`.
/// substeps: steps that a call of `step` is cut into at least; stiff lattices take more.
///
/// The corotated strain energy of McAdams et al. (2011) on the cells of the grid, integrated by symplectic Euler steps short enough
/// for the fastest oscillation, with volume and ground by position-based dynamics (Müller et al., 2006). The same bits on every
/// run and any number of threads. Raises ElasticError, LatticeError and MeshError.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Elastic {
    core: Mutex<Core>,
    shape: [usize; 3],
}

#[pymethods]
impl Elastic {
    #[new]
    #[pyo3(signature = (
        lattice, vertices=None, triangles=None, *, control=None, velocity=None, pinned=None,
        frequency=NumberLike::Default(2.0), damping=NumberLike::Default(0.1), gravity=None, ground=None,
        friction=NumberLike::Default(0.5), volume=NumberLike::Default(1.0), influence=None,
        outside=OutsideWord(Outside::Keep), substeps=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "keywords in Python")]
    fn new(
        py: Python<'_>,
        lattice: LatticeLike<'_>,
        vertices: Option<ArrayLike<'_>>,
        triangles: Option<ArrayLike<'_>>,
        control: Option<ArrayLike<'_>>,
        velocity: Option<ArrayLike<'_>>,
        pinned: Option<ArrayLike<'_>>,
        frequency: NumberLike<'_>,
        damping: NumberLike<'_>,
        gravity: Option<ArrayLike<'_>>,
        ground: Option<ArrayLike<'_>>,
        friction: NumberLike<'_>,
        volume: NumberLike<'_>,
        influence: Option<ArrayLike<'_>>,
        outside: OutsideWord,
        substeps: Option<ArrayLike<'_>>,
    ) -> PyResult<Self> {
        let lattice = &lattice.0.core;
        let shape = lattice.shape();
        let vertices =
            vertices.map_or(Ok(Vec::new()), |vertices| Argument::mesh("vertices").points(&vertices))?;
        let vertices: Vec<[f64; 3]> = vertices.iter().map(DVec3::to_array).collect();
        let triangles = triangles.map_or(Ok(Vec::new()), |triangles| indices(&triangles))?;
        let influence = influence.map(|influence| influences(&influence)).transpose()?;
        let places = |name, given: &Option<ArrayLike<'_>>| {
            given.as_ref().map(|given| Argument::lattice(name).control(given, shape)).transpose()
        };
        let start = Start {
            control: places("control", &control)?.unwrap_or_else(|| lattice.rest()),
            velocity: places("velocity", &velocity)?.unwrap_or_else(|| vec![DVec3::ZERO; lattice.len()]),
            pinned: pinned.map_or(Ok(vec![false; lattice.len()]), |pinned| flags(py, &pinned, shape))?,
        };
        let material = Material {
            frequency: Argument::elastic("frequency").number(&frequency)?,
            damping: Argument::elastic("damping").number(&damping)?,
            gravity: match gravity {
                Some(gravity) => Argument::elastic("gravity").vector(&gravity)?,
                None => DVec3::new(0.0, 0.0, -9.81),
            },
            ground: ground.map(|ground| plane(&ground, &friction)).transpose()?,
            volume: Argument::elastic("volume").number(&volume)?,
            substeps: substeps.map_or(Ok(8), |substeps| whole(&substeps))?,
        };
        let core = py.detach(|| {
            let carried = Carried {
                vertices: &vertices,
                triangles: &triangles,
                influence: influence.as_deref(),
                outside: outside.0,
            };
            Core::new(lattice, material, carried, start)
        });
        Ok(Self { core: Mutex::new(core.map_err(to_python)?), shape })
    }

    /// Moves on by that many seconds. Pinned control points move evenly to their places in targets (nu, nv, nw, 3), or stay
    /// without; targets of the others do not count. A billionth of a second at least. Raises ElasticError and LatticeError, and
    /// then nothing has moved.
    #[pyo3(signature = (seconds, targets=None))]
    fn step(&self, py: Python<'_>, seconds: NumberLike<'_>, targets: Option<ArrayLike<'_>>) -> PyResult<()> {
        let seconds = Argument::elastic("seconds").number(&seconds)?;
        let targets =
            targets.map(|targets| Argument::lattice("targets").control(&targets, self.shape)).transpose()?;
        py.detach(|| self.lock().step(seconds, targets.as_deref())).map_err(to_python)
    }

    /// Control points now, float64 (nu, nv, nw, 3).
    #[getter]
    fn control<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        self.points(py, |core| core.control().to_vec())
    }

    /// Their velocities, float64 (nu, nv, nw, 3).
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        self.points(py, |core| core.velocity().to_vec())
    }

    /// Seconds since the start.
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.read(py, Core::time)
    }

    /// Volume inside the surface over the volume that is kept, or None where there is none.
    #[getter]
    fn volume_ratio(&self, py: Python<'_>) -> Option<f64> {
        self.read(py, Core::volume_ratio)
    }

    /// Height of the lowest vertex above the ground, or None without a ground or vertices.
    #[getter]
    fn lowest(&self, py: Python<'_>) -> Option<f64> {
        self.read(py, Core::lowest)
    }

    /// Kinetic, elastic and potential energy; the potential is that of height above the origin.
    #[getter]
    fn energy(&self, py: Python<'_>) -> (f64, f64, f64) {
        self.totals(py).energy.into()
    }

    /// Mass of the control points.
    #[getter]
    fn mass(&self, py: Python<'_>) -> f64 {
        self.totals(py).mass
    }

    /// Their centre of mass, float64 (3,).
    #[getter]
    fn centre<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &[self.totals(py).centre], &[3])
    }

    /// Their momentum, float64 (3,).
    #[getter]
    fn momentum<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &[self.totals(py).momentum], &[3])
    }

    /// Their angular momentum about the centre of mass, float64 (3,).
    #[getter]
    fn angular_momentum<'py>(&self, py: Python<'py>) -> PyResult<NdArray<'py, f64>> {
        NdArray::points(py, &[self.totals(py).angular_momentum], &[3])
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("Elastic(shape={:?}, time={:?})", self.shape, self.read(py, Core::time))
    }
}

impl Elastic {
    fn lock(&self) -> MutexGuard<'_, Core> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Leaves the interpreter and reads the body.
    fn read<R: Send>(&self, py: Python<'_>, f: impl FnOnce(&Core) -> R + Send) -> R {
        py.detach(|| f(&self.lock()))
    }

    fn totals(&self, py: Python<'_>) -> Totals {
        self.read(py, Core::totals)
    }

    fn points<'py>(
        &self,
        py: Python<'py>,
        f: impl FnOnce(&Core) -> Vec<DVec3> + Send,
    ) -> PyResult<NdArray<'py, f64>> {
        let [nu, nv, nw] = self.shape;
        NdArray::points(py, &self.read(py, f), &[nu, nv, nw, 3])
    }
}

fn plane(ground: &ArrayLike<'_>, friction: &NumberLike<'_>) -> PyResult<Ground> {
    let values =
        Argument::elastic("ground").floats(ground, Numbers::FloatsOrIntegers, &[Some(2), Some(3)])?;
    let [point, normal] = [0, 3].map(|start| DVec3::from_slice(&values[start..]));
    Ok(Ground { point, normal, friction: Argument::elastic("friction").number(friction)? })
}

fn flags(py: Python<'_>, pinned: &ArrayLike<'_>, shape: [usize; 3]) -> PyResult<Vec<bool>> {
    let argument = Argument::lattice("pinned");
    let array = argument.array(pinned, Numbers::Booleans, &shape.map(Some))?;
    let contiguous = py.import("numpy")?.call_method1("ascontiguousarray", (array,))?;
    Ok(contiguous.cast::<PyArrayDyn<bool>>()?.readonly().as_slice()?.to_vec())
}

fn whole(substeps: &ArrayLike<'_>) -> PyResult<u32> {
    let argument = Argument::elastic("substeps");
    let [count, ..] = argument.counts(substeps, true)?;
    u32::try_from(count)
        .ok()
        .filter(|count| (1..=100_000).contains(count))
        .ok_or_else(|| argument.error(format!("found {count}, expected 1 to 100000")))
}
