// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments that are one of a few words.

use isochor_core::{Accuracy, Cost, Interpolation, Limit, Method, Outside};
use pyo3::inspect::{PyStaticConstant, PyStaticExpr};
use pyo3::prelude::*;
use pyo3::types::PyString;
use pyo3::{type_hint_identifier, type_hint_subscript, type_hint_union};

use crate::arrays::Argument;
use crate::errors::{UnknownDeviceError, VolumeError};

macro_rules! literal {
    ($($word:literal),+) => {
        type_hint_subscript!(
            type_hint_identifier!("typing", "Literal"),
            $(PyStaticExpr::Constant { value: PyStaticConstant::Str($word) }),+
        )
    };
}

fn word(object: &Borrowed<'_, '_, PyAny>) -> String {
    match object.extract::<String>() {
        Ok(word) => word,
        Err(_) => object.repr().map_or_else(|_| "an object".into(), |repr| repr.to_string()),
    }
}

/// `basis`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BasisWord {
    Bernstein,
    BSpline,
    Blender,
}

impl FromPyObject<'_, '_> for BasisWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = literal!("bernstein", "bspline", "blender");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "bernstein" => Ok(Self::Bernstein),
            "bspline" => Ok(Self::BSpline),
            "blender" => Ok(Self::Blender),
            other => Err(Argument::lattice("basis")
                .error(format!("found {other:?}, expected \"bernstein\", \"bspline\" or \"blender\""))),
        }
    }
}

/// The words for how Blender's lattice goes from point to point.
const INTERPOLATIONS: [(&str, Interpolation); 4] = [
    ("linear", Interpolation::Linear),
    ("cardinal", Interpolation::Cardinal),
    ("catmull-rom", Interpolation::CatmullRom),
    ("bspline", Interpolation::BSpline),
];

/// `interpolation`: one word, or three.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct InterpolationWords(pub(crate) [Interpolation; 3]);

impl FromPyObject<'_, '_> for InterpolationWords {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_union!(
        literal!("linear", "cardinal", "catmull-rom", "bspline"),
        type_hint_subscript!(
            type_hint_identifier!("collections.abc", "Sequence"),
            type_hint_identifier!("builtins", "str")
        )
    );

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let of = |word: &str| INTERPOLATIONS.iter().find(|(known, _)| *known == word).map(|(_, kind)| *kind);
        let found = match object.extract::<String>() {
            Ok(word) => of(&word).map(|kind| [kind; 3]),
            Err(_) => object.extract::<[String; 3]>().ok().and_then(|words| match words.map(|w| of(&w)) {
                [Some(s), Some(t), Some(u)] => Some([s, t, u]),
                _ => None,
            }),
        };
        found.map(Self).ok_or_else(|| {
            Argument::lattice("interpolation").error(format!(
                "found {}, expected \"linear\", \"cardinal\", \"catmull-rom\" or \"bspline\", or three of them",
                object.repr().map_or_else(|_| "an object".into(), |repr| repr.to_string())
            ))
        })
    }
}

impl Default for InterpolationWords {
    fn default() -> Self {
        Self([Interpolation::BSpline; 3])
    }
}

impl InterpolationWords {
    /// The words along s, t, u.
    pub(crate) fn names(self) -> [&'static str; 3] {
        self.0.map(|kind| {
            INTERPOLATIONS.iter().find(|(_, known)| *known == kind).map_or("bspline", |(name, _)| name)
        })
    }
}

/// `knots`: a word, or three arrays.
pub(crate) enum KnotsWord<'py> {
    Uniform,
    Clamped,
    Given(Vec<Bound<'py, PyAny>>),
}

impl<'py> FromPyObject<'_, 'py> for KnotsWord<'py> {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_union!(
        literal!("uniform", "clamped"),
        type_hint_subscript!(
            type_hint_identifier!("collections.abc", "Sequence"),
            type_hint_identifier!("numpy.typing", "ArrayLike")
        )
    );

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let expected = "expected \"uniform\", \"clamped\" or three arrays";
        if let Ok(word) = object.extract::<String>() {
            return match word.as_str() {
                "uniform" => Ok(Self::Uniform),
                "clamped" => Ok(Self::Clamped),
                other => Err(Argument::lattice("knots").error(format!("found {other:?}, {expected}"))),
            };
        }
        let items: PyResult<Vec<_>> = object.try_iter().and_then(Iterator::collect);
        match items {
            Ok(items) if items.len() == 3 => Ok(Self::Given(items)),
            Ok(items) => {
                Err(Argument::lattice("knots").error(format!("found {} items, {expected}", items.len())))
            }
            Err(_) => Err(Argument::lattice("knots").error(format!("found {}, {expected}", word(&object)))),
        }
    }
}

/// `outside`.
pub(crate) struct OutsideWord(pub(crate) Outside);

impl FromPyObject<'_, '_> for OutsideWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = literal!("keep", "extend");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "keep" => Ok(Self(Outside::Keep)),
            "extend" => Ok(Self(Outside::Extend)),
            other => Err(Argument::lattice("outside")
                .error(format!("found {other:?}, expected \"keep\" or \"extend\""))),
        }
    }
}

/// `method`.
pub(crate) struct MethodWord(pub(crate) Method);

impl FromPyObject<'_, '_> for MethodWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = literal!("balanced", "sweep", "gradient", "nearest");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "sweep" => Ok(Self(Method::Sweep)),
            "balanced" => Ok(Self(Method::Balanced)),
            "gradient" => Ok(Self(Method::Gradient)),
            "nearest" => Ok(Self(Method::Nearest)),
            other => Err(VolumeError::new_err(format!(
                "method: found {other:?}, expected \"balanced\", \"sweep\", \"gradient\" or \"nearest\""
            ))),
        }
    }
}

/// The word for a method.
pub(crate) fn method_name(method: Method) -> &'static str {
    match method {
        Method::Sweep => "sweep",
        Method::Balanced => "balanced",
        Method::Gradient => "gradient",
        Method::Nearest => "nearest",
    }
}

/// `cost`.
pub(crate) struct CostWord(pub(crate) Cost);

impl FromPyObject<'_, '_> for CostWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = literal!("points", "surface", "bending");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "points" => Ok(Self(Cost::Points)),
            "surface" => Ok(Self(Cost::Surface)),
            "bending" => Ok(Self(Cost::Bending)),
            other => Err(VolumeError::new_err(format!(
                "cost: found {other:?}, expected \"points\", \"surface\" or \"bending\""
            ))),
        }
    }
}

/// `accuracy`.
pub(crate) struct AccuracyWord(pub(crate) Accuracy);

impl FromPyObject<'_, '_> for AccuracyWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = literal!("exact", "finished", "rough");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "exact" => Ok(Self(Accuracy::Exact)),
            "finished" => Ok(Self(Accuracy::Finished)),
            "rough" => Ok(Self(Accuracy::Rough)),
            other => Err(VolumeError::new_err(format!(
                "accuracy: found {other:?}, expected \"exact\", \"finished\" or \"rough\""
            ))),
        }
    }
}

/// `limit`.
pub(crate) struct LimitWord(pub(crate) Limit);

impl FromPyObject<'_, '_> for LimitWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = literal!("unfolded");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "unfolded" => Ok(Self(Limit::Unfolded)),
            other => {
                Err(VolumeError::new_err(format!("limit: found {other:?}, expected None or \"unfolded\"")))
            }
        }
    }
}

/// `device`: a word, or the name of an adapter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum DeviceWord {
    Auto,
    Cpu,
    Gpu,
    Adapter(String),
}

impl FromPyObject<'_, '_> for DeviceWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr =
        type_hint_union!(literal!("auto", "cpu", "gpu"), type_hint_identifier!("builtins", "str"));

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match word(&object).as_str() {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "gpu" => Ok(Self::Gpu),
            other if object.is_instance_of::<PyString>() && isochor_gpu::is_adapter(other) => {
                Ok(Self::Adapter(other.to_owned()))
            }
            other => Err(UnknownDeviceError::new_err(format!(
                "device: found {other:?}, expected \"auto\", \"cpu\", \"gpu\" or the name of an adapter in isochor.devices()"
            ))),
        }
    }
}
