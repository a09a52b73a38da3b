// SPDX-License-Identifier: GPL-3.0-or-later
//! numpy arrays at the border: what comes in is checked and named, what goes out carries its type.

use std::convert::Infallible;
use std::marker::PhantomData;

use isochor_core::DVec3;
use numpy::{
    Element, PyArray1, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::{type_hint_identifier, type_hint_subscript, type_hint_union};

use crate::errors::Family;

/// Any object that numpy turns into an array.
pub(crate) struct ArrayLike<'py>(Bound<'py, PyAny>);

impl<'py> FromPyObject<'_, 'py> for ArrayLike<'py> {
    type Error = Infallible;
    const INPUT_TYPE: PyStaticExpr = type_hint_identifier!("numpy.typing", "ArrayLike");

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> Result<Self, Infallible> {
        Ok(Self(object.to_owned()))
    }
}

/// Any object that may be a real number.
pub(crate) enum NumberLike<'py> {
    /// What a signature has where the caller gives nothing.
    Default(f64),
    Given(Bound<'py, PyAny>),
}

impl<'py> FromPyObject<'_, 'py> for NumberLike<'py> {
    type Error = Infallible;
    const INPUT_TYPE: PyStaticExpr = f64::INPUT_TYPE;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> Result<Self, Infallible> {
        Ok(Self::Given(object.to_owned()))
    }
}

/// Kinds of numbers that an argument takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Numbers {
    Floats,
    FloatsOrIntegers,
    Integers,
    Booleans,
}

impl Numbers {
    fn allows(self, kind: u8) -> bool {
        match self {
            Self::Floats => kind == b'f',
            Self::FloatsOrIntegers => matches!(kind, b'f' | b'i' | b'u'),
            Self::Integers => matches!(kind, b'i' | b'u'),
            Self::Booleans => kind == b'b',
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Floats => "floating-point numbers",
            Self::FloatsOrIntegers => "real numbers",
            Self::Integers => "integers",
            Self::Booleans => "true or false",
        }
    }
}

/// An argument by name, with the exception to raise about it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Argument {
    pub(crate) name: &'static str,
    pub(crate) family: Family,
}

impl Argument {
    pub(crate) const fn lattice(name: &'static str) -> Self {
        Self { name, family: Family::Lattice }
    }

    pub(crate) const fn mesh(name: &'static str) -> Self {
        Self { name, family: Family::Mesh }
    }

    pub(crate) const fn volume(name: &'static str) -> Self {
        Self { name, family: Family::Volume }
    }

    pub(crate) const fn pins(name: &'static str) -> Self {
        Self { name, family: Family::Pin }
    }

    pub(crate) const fn elastic(name: &'static str) -> Self {
        Self { name, family: Family::Elastic }
    }

    /// The exception about this argument.
    pub(crate) fn error(self, message: impl std::fmt::Display) -> PyErr {
        self.family.error(format!("{}: {message}", self.name))
    }

    /// Checks the kind of numbers and the shape (`None`: any length) and gives the numbers as they are.
    pub(crate) fn array<'py>(
        self,
        object: &ArrayLike<'py>,
        numbers: Numbers,
        shape: &[Option<usize>],
    ) -> PyResult<Bound<'py, PyUntypedArray>> {
        let py = object.0.py();
        let array = py
            .import("numpy")?
            .call_method1("asarray", (&object.0,))
            .and_then(|array| Ok(array.cast_into::<PyUntypedArray>()?))
            .map_err(|cause| {
                self.error(format!("found {}, expected {}: {cause}", type_name(&object.0), numbers.name()))
            })?;
        if array.len() > 0 && !numbers.allows(array.dtype().kind()) {
            return Err(self.error(format!("found dtype {}, expected {}", array.dtype(), numbers.name())));
        }
        let fits = array.shape().len() == shape.len()
            && array
                .shape()
                .iter()
                .zip(shape)
                .all(|(&found, wanted)| wanted.is_none_or(|wanted| found == wanted));
        if !fits {
            let wanted: Vec<String> =
                shape.iter().map(|n| n.map_or("any".into(), |n| n.to_string())).collect();
            return Err(self.error(format!(
                "found shape {:?}, expected ({})",
                array.shape(),
                wanted.join(", ")
            )));
        }
        Ok(array)
    }

    /// The extents of an array with so many dimensions.
    pub(crate) fn dimensions<const N: usize>(
        self,
        array: &Bound<'_, PyUntypedArray>,
    ) -> PyResult<[usize; N]> {
        let found = array.shape();
        found.try_into().map_err(|_| self.error(format!("found shape {found:?}, expected {N} dimensions")))
    }

    /// All numbers as float64, in C order.
    pub(crate) fn floats(
        self,
        object: &ArrayLike<'_>,
        numbers: Numbers,
        shape: &[Option<usize>],
    ) -> PyResult<Vec<f64>> {
        converted(&self.array(object, numbers, shape)?, "float64")
    }

    /// One real number.
    pub(crate) fn number(self, object: &NumberLike<'_>) -> PyResult<f64> {
        match object {
            NumberLike::Default(number) => Ok(*number),
            NumberLike::Given(object) => object.extract().map_err(|_| {
                let shown = object.repr().map_or_else(|_| type_name(object), |repr| repr.to_string());
                self.error(format!("found {shown}, expected a real number"))
            }),
        }
    }

    /// Three numbers.
    pub(crate) fn vector(self, object: &ArrayLike<'_>) -> PyResult<DVec3> {
        let values = self.floats(object, Numbers::FloatsOrIntegers, &[Some(3)])?;
        Ok(DVec3::from_slice(&values))
    }

    /// Three rows of three numbers.
    pub(crate) fn rows(self, object: &ArrayLike<'_>) -> PyResult<[DVec3; 3]> {
        let values = self.floats(object, Numbers::FloatsOrIntegers, &[Some(3), Some(3)])?;
        Ok(std::array::from_fn(|row| DVec3::from_slice(&values[3 * row..])))
    }

    /// Finite points, (V, 3).
    pub(crate) fn points(self, object: &ArrayLike<'_>) -> PyResult<Vec<DVec3>> {
        let values = self.floats(object, Numbers::FloatsOrIntegers, &[None, Some(3)])?;
        let points: Vec<DVec3> = values.as_chunks().0.iter().map(|&p| DVec3::from_array(p)).collect();
        match points.iter().position(|p| !p.is_finite()) {
            Some(i) => {
                Err(self.error(format!("found NaN or infinity at index {i}, expected finite numbers")))
            }
            None => Ok(points),
        }
    }

    /// Control points (nu, nv, nw, 3), the last index of the lattice fastest.
    pub(crate) fn control(self, object: &ArrayLike<'_>, shape: [usize; 3]) -> PyResult<Vec<DVec3>> {
        let [nu, nv, nw] = shape.map(Some);
        let values = self.floats(object, Numbers::Floats, &[nu, nv, nw, Some(3)])?;
        Ok(values.as_chunks().0.iter().map(|&p| DVec3::from_array(p)).collect())
    }

    /// Control points (nu, nv, nw, 3), or several sets of them (K, nu, nv, nw, 3) and how many.
    pub(crate) fn sets(
        self,
        object: &ArrayLike<'_>,
        shape: [usize; 3],
    ) -> PyResult<(Option<usize>, Vec<DVec3>)> {
        let [nu, nv, nw] = shape.map(Some);
        let numpy = object.0.py().import("numpy")?;
        let dimensions: Option<usize> =
            numpy.call_method1("ndim", (&object.0,)).and_then(|found| found.extract()).ok();
        if dimensions != Some(5) {
            return Ok((None, self.control(object, shape)?));
        }
        let values = self.floats(object, Numbers::Floats, &[None, nu, nv, nw, Some(3)])?;
        let points: Vec<DVec3> = values.as_chunks().0.iter().map(|&p| DVec3::from_array(p)).collect();
        Ok((Some(points.len() / shape.iter().product::<usize>()), points))
    }

    /// One or three non-negative integers, the one repeated.
    pub(crate) fn counts(self, object: &ArrayLike<'_>, single: bool) -> PyResult<[usize; 3]> {
        let one = single && object.0.extract::<i64>().is_ok();
        let shape: &[Option<usize>] = if one { &[] } else { &[Some(3)] };
        let values: Vec<i64> = converted(&self.array(object, Numbers::Integers, shape)?, "int64")?;
        let count = |axis: usize| {
            let value = values[if one { 0 } else { axis }];
            usize::try_from(value)
                .map_err(|_| self.error(format!("found {value}, expected no negative number")))
        };
        Ok([count(0)?, count(1)?, count(2)?])
    }
}

/// The array's numbers in C order, converted by numpy.
pub(crate) fn converted<T: Element + Copy>(
    array: &Bound<'_, PyUntypedArray>,
    dtype: &str,
) -> PyResult<Vec<T>> {
    let contiguous = contiguous(array, dtype)?;
    let typed = contiguous.cast::<PyArrayDyn<T>>()?.readonly();
    Ok(typed.as_slice()?.to_vec())
}

/// The array itself where it is C-contiguous, aligned and of the type already, else a copy.
fn contiguous<'py>(array: &Bound<'py, PyUntypedArray>, dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    array.py().import("numpy")?.call_method1("require", (array, dtype, ["C", "A"]))
}

fn type_name(object: &Bound<'_, PyAny>) -> String {
    object.get_type().name().map_or_else(|_| "an object".into(), |name| name.to_string())
}

/// A numpy array on its way out, with the type hint of `T`.
pub(crate) struct NdArray<'py, T>(Bound<'py, PyUntypedArray>, PhantomData<T>);

/// What a type hint says about the numbers of an array.
pub(crate) trait Hint {
    const HINT: PyStaticExpr;
}

impl Hint for f64 {
    const HINT: PyStaticExpr = type_hint_identifier!("numpy", "float64");
}

impl Hint for i32 {
    const HINT: PyStaticExpr = type_hint_identifier!("numpy", "int32");
}

impl Hint for i64 {
    const HINT: PyStaticExpr = type_hint_identifier!("numpy", "int64");
}

impl Hint for bool {
    const HINT: PyStaticExpr = type_hint_identifier!("numpy", "bool_");
}

/// The float type of the bound vertices.
pub(crate) struct OfVertices;

impl Hint for OfVertices {
    const HINT: PyStaticExpr = type_hint_union!(
        type_hint_identifier!("numpy", "float32"),
        type_hint_identifier!("numpy", "float64")
    );
}

impl<'py, T: Hint> NdArray<'py, T> {
    /// An array that exists already.
    pub(crate) fn of(array: Bound<'py, PyUntypedArray>) -> Self {
        Self(array, PhantomData)
    }

    /// One number for each of something.
    pub(crate) fn numbers(py: Python<'py>, numbers: &[T]) -> Self
    where
        T: Element + Copy,
    {
        Self::of(PyArray1::from_slice(py, numbers).as_untyped().clone())
    }

    /// Numbers in C order, in rows and columns or a box.
    pub(crate) fn table<const N: usize>(py: Python<'py>, flat: Vec<T>, shape: [usize; N]) -> PyResult<Self>
    where
        T: Element,
    {
        Ok(Self::of(PyArray1::from_vec(py, flat).reshape(shape.as_slice())?.as_untyped().clone()))
    }

    /// Points (V, 3) or control points (nu, nv, nw, 3).
    pub(crate) fn points(py: Python<'py>, points: &[DVec3], shape: &[usize]) -> PyResult<Self> {
        let flat: Vec<f64> = points.iter().flat_map(|p| p.to_array()).collect();
        Ok(Self::of(PyArray1::from_vec(py, flat).reshape(shape)?.as_untyped().clone()))
    }

    /// One number for each control point, (nu, nv, nw).
    pub(crate) fn lattice(py: Python<'py>, numbers: Vec<f64>, shape: [usize; 3]) -> PyResult<Self> {
        Ok(Self::of(PyArray1::from_vec(py, numbers).reshape(shape)?.as_untyped().clone()))
    }
}

impl<'py, T: Hint> IntoPyObject<'py> for NdArray<'py, T> {
    type Target = PyUntypedArray;
    type Output = Bound<'py, PyUntypedArray>;
    type Error = Infallible;
    const OUTPUT_TYPE: PyStaticExpr =
        type_hint_subscript!(type_hint_identifier!("numpy.typing", "NDArray"), T::HINT);

    fn into_pyobject(self, _: Python<'py>) -> Result<Self::Output, Infallible> {
        Ok(self.0)
    }
}
