// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Pins`: points of the surface that must land on targets.

use isochor_core::{DVec3, PinPoint};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::{type_hint_identifier, type_hint_subscript, type_hint_union};

use crate::arrays::{Argument, ArrayLike, Numbers, converted};

/// Points of the surface and where the deformed surface must have them, for `Binding.preserve`: direct manipulation, Problem 2
/// of the volume paper.
///
/// indices (m,): vertices; or with barycentric (m, 3), triangles of the binding, each with coordinates of its corners that sum
/// to 1. targets (m, 3): positions in the lattice's space.
///
/// Raises PinError for negative indices, other shapes, NaN or infinity.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Pins {
    core: isochor_core::Pins,
}

#[pymethods]
impl Pins {
    #[new]
    #[pyo3(signature = (indices, targets, barycentric=None))]
    fn new(
        indices: ArrayLike<'_>,
        targets: ArrayLike<'_>,
        barycentric: Option<ArrayLike<'_>>,
    ) -> PyResult<Self> {
        let argument = Argument::pins("indices of pins");
        let wide: Vec<i64> = converted(&argument.array(&indices, Numbers::Integers, &[None])?, "int64")?;
        let count = Some(wide.len());
        let targets = Argument::pins("targets of pins").floats(
            &targets,
            Numbers::FloatsOrIntegers,
            &[count, Some(3)],
        )?;
        let barycentric = barycentric
            .map(|b| Argument::pins("barycentric").floats(&b, Numbers::FloatsOrIntegers, &[count, Some(3)]))
            .transpose()?;
        let point = |(i, index): (usize, i64)| {
            let index = u32::try_from(index).map_err(|_| {
                argument
                    .error(format!("found {index} for pin {i}, expected the index of a vertex or triangle"))
            })?;
            Ok(match &barycentric {
                Some(all) => PinPoint::Face(index, [all[3 * i], all[3 * i + 1], all[3 * i + 2]]),
                None => PinPoint::Vertex(index),
            })
        };
        let core = isochor_core::Pins {
            points: wide.into_iter().enumerate().map(point).collect::<PyResult<_>>()?,
            targets: targets.as_chunks().0.iter().map(|&target| DVec3::from_array(target)).collect(),
        };
        Ok(Self { core })
    }

    fn __len__(&self) -> usize {
        self.core.points.len()
    }

    fn __repr__(&self) -> String {
        format!("Pins({} points)", self.core.points.len())
    }
}

/// `pins`: `isochor.Pins`, or vertices and their targets.
pub(crate) struct PinsLike(pub(crate) isochor_core::Pins);

impl<'py> FromPyObject<'_, 'py> for PinsLike {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_union!(
        <PyRef<'py, Pins> as FromPyObject<'_, 'py>>::INPUT_TYPE,
        type_hint_subscript!(
            type_hint_identifier!("builtins", "tuple"),
            type_hint_identifier!("numpy.typing", "ArrayLike"),
            type_hint_identifier!("numpy.typing", "ArrayLike")
        )
    );

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(pins) = object.extract::<PyRef<'_, Pins>>() {
            return Ok(Self(pins.core.clone()));
        }
        let parts: Vec<ArrayLike<'py>> = object.extract().unwrap_or_default();
        match <[ArrayLike<'_>; 2]>::try_from(parts) {
            Ok([indices, targets]) => Ok(Self(Pins::new(indices, targets, None)?.core)),
            Err(_) => Err(Argument::pins("pins")
                .error("expected isochor.Pins, or a pair of vertex indices (m,) and targets (m, 3)")),
        }
    }
}
