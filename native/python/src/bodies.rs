// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments about several bodies: which triangles are one, and the volumes that they are to have.

use isochor_core::Bodies;
use numpy::PyUntypedArrayMethods;
use pyo3::inspect::{PyStaticConstant, PyStaticExpr};
use pyo3::prelude::*;
use pyo3::{type_hint_identifier, type_hint_subscript, type_hint_union};

use crate::arrays::{Argument, ArrayLike, NumberLike, Numbers, converted};

/// `bodies`: a word, or a label for each triangle.
pub(crate) struct BodiesLike(pub(crate) Bodies);

impl FromPyObject<'_, '_> for BodiesLike {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_union!(
        type_hint_subscript!(
            type_hint_identifier!("typing", "Literal"),
            PyStaticExpr::Constant { value: PyStaticConstant::Str("islands") }
        ),
        type_hint_identifier!("numpy.typing", "ArrayLike")
    );

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let argument = Argument::mesh("bodies");
        if let Ok(word) = object.extract::<String>() {
            return match word.as_str() {
                "islands" => Ok(Self(Bodies::Islands)),
                other => Err(argument.error(format!(
                    "found {other:?}, expected \"islands\", a label for each triangle or None"
                ))),
            };
        }
        let Ok(labels) = object.extract::<ArrayLike<'_>>();
        let wide: Vec<i64> = converted(&argument.array(&labels, Numbers::Integers, &[None])?, "int64")?;
        let label = |(triangle, label): (usize, &i64)| {
            i32::try_from(*label).map_err(|_| {
                argument.error(format!(
                    "found the label {label} at triangle {triangle}, expected numbers of bodies from 0 on, or -1 for no body"
                ))
            })
        };
        Ok(Self(Bodies::Labels(wide.iter().enumerate().map(label).collect::<PyResult<_>>()?)))
    }
}

/// `target`: a number, or one for each body.
pub(crate) struct TargetLike<'py>(Bound<'py, PyAny>);

impl<'py> FromPyObject<'_, 'py> for TargetLike<'py> {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr =
        type_hint_union!(f64::INPUT_TYPE, type_hint_identifier!("numpy.typing", "ArrayLike"));

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(object.to_owned()))
    }
}

impl TargetLike<'_> {
    /// The numbers, checked to be one or as many as there are bodies.
    pub(crate) fn numbers(&self, bodies: usize) -> PyResult<Vec<f64>> {
        let argument = Argument::volume("target");
        let Ok(array) = self.0.extract::<ArrayLike<'_>>();
        // What numpy makes no array of is no number either.
        let dimensions =
            self.0.py().import("numpy")?.call_method1("ndim", (&self.0,)).and_then(|n| n.extract::<usize>());
        if !matches!(dimensions, Ok(1..)) {
            return argument.number(&NumberLike::Given(self.0.clone())).map(|number| vec![number]);
        }
        let found = argument.array(&array, Numbers::FloatsOrIntegers, &[None])?;
        if found.len() != bodies {
            return Err(argument.error(format!(
                "found {} volumes, expected one number for all bodies together or {bodies}, one for each body",
                found.len()
            )));
        }
        converted(&found, "float64")
    }
}
