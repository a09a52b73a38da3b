// SPDX-License-Identifier: GPL-3.0-or-later
//! `isochor.Tie`.

use isochor_core::{FACES, Face, Side, Tie as Core};
use pyo3::inspect::{PyStaticConstant, PyStaticExpr};
use pyo3::prelude::*;
use pyo3::{type_hint_identifier, type_hint_subscript};

use crate::arrays::{Argument, ArrayLike, NdArray};
use crate::errors::to_python;
use crate::lattice::LatticeLike;

/// Two adjacent lattices that stay joined across a common face: the control points of one follow those of the other (Ferrier's blocks side
/// by side).
///
/// face_a, face_b: "s0", "s1", "t0", "t1", "u0" or "u1": where that parameter is 0 or 1. At rest they must coincide; axes along them may
/// be numbered and run otherwise in the two lattices, but must have the same points, degrees and knots. continuity: 0 for joined places (if not given),
/// 1 for joined tangents, 2 for joined curvature; from 1 on the edges across the face must be parallel.
///
/// Raises LatticeError, with how far apart the faces are where they do not coincide.
#[pyclass(frozen, module = "isochor")]
pub(crate) struct Tie {
    core: Core,
    faces: [Face; 2],
    shapes: [[usize; 3]; 2],
}

/// A face as an argument.
pub(crate) struct FaceWord(Face);

impl FromPyObject<'_, '_> for FaceWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_identifier!("builtins", "str");

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let word = object.extract::<String>().unwrap_or_default();
        Face::named(&word).map(Self).ok_or_else(|| {
            Argument::lattice("face").error(format!("found {object:?}, expected one of {}", FACES.join(", ")))
        })
    }
}

/// `leader`.
pub(crate) struct SideWord(Side);

impl FromPyObject<'_, '_> for SideWord {
    type Error = PyErr;
    const INPUT_TYPE: PyStaticExpr = type_hint_subscript!(
        type_hint_identifier!("typing", "Literal"),
        PyStaticExpr::Constant { value: PyStaticConstant::Str("a") },
        PyStaticExpr::Constant { value: PyStaticConstant::Str("b") }
    );

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        match object.extract::<String>().as_deref() {
            Ok("a") => Ok(Self(Side::A)),
            Ok("b") => Ok(Self(Side::B)),
            _ => Err(Argument::lattice("leader").error(format!("found {object:?}, expected \"a\" or \"b\""))),
        }
    }
}

#[pymethods]
impl Tie {
    #[new]
    #[pyo3(signature = (lattice_a, face_a, lattice_b, face_b, continuity=None))]
    fn new(
        lattice_a: LatticeLike<'_>,
        face_a: FaceWord,
        lattice_b: LatticeLike<'_>,
        face_b: FaceWord,
        continuity: Option<ArrayLike<'_>>,
    ) -> PyResult<Self> {
        let continuity = Argument::lattice("continuity").count(continuity.as_ref(), 0)?;
        let [a, b] = [&lattice_a.0.core, &lattice_b.0.core];
        let core = Core::new(a, face_a.0, b, face_b.0, continuity).map_err(to_python)?;
        Ok(Self { core, faces: [face_a.0, face_b.0], shapes: [a.shape(), b.shape()] })
    }

    /// The continuity that the joint gets.
    #[getter]
    fn continuity(&self) -> usize {
        self.core.continuity()
    }

    /// The follower's control points, float64 (nu, nv, nw, 3), changed least such that the joint is C^continuity:
    /// sqrt(sum of squared distances). Only its outer layers at the face change: continuity + 1 of a Bernstein or clamped axis, as many
    /// as its degree of a uniform one.
    ///
    /// leader_control, follower_control (nu, nv, nw, 3): those of lattice_a and lattice_b if leader is "a", else the other way round.
    /// Raises LatticeError.
    #[pyo3(signature = (leader_control, follower_control, leader=SideWord(Side::A)))]
    fn apply<'py>(
        &self,
        py: Python<'py>,
        leader_control: ArrayLike<'py>,
        follower_control: ArrayLike<'py>,
        leader: SideWord,
    ) -> PyResult<NdArray<'py, f64>> {
        let [lead, follow] = if leader.0 == Side::A { [0, 1] } else { [1, 0] };
        let leading = Argument::lattice("leader_control").control(&leader_control, self.shapes[lead])?;
        let following =
            Argument::lattice("follower_control").control(&follower_control, self.shapes[follow])?;
        let both: [&[_]; 2] = if lead == 0 { [&leading, &following] } else { [&following, &leading] };
        let found = py.detach(|| self.core.apply(both, leader.0)).map_err(to_python)?;
        let [nu, nv, nw] = self.shapes[follow];
        NdArray::points(py, &found, &[nu, nv, nw, 3])
    }

    /// How far the joint is from C^0, C^1 and so on, float64 (continuity + 1,): the largest difference of derivatives of that order
    /// across the face, measured in lattice_a's edge across it. control_a, control_b (nu, nv, nw, 3). Raises LatticeError.
    fn gaps<'py>(
        &self,
        py: Python<'py>,
        control_a: ArrayLike<'py>,
        control_b: ArrayLike<'py>,
    ) -> PyResult<NdArray<'py, f64>> {
        let a = Argument::lattice("control_a").control(&control_a, self.shapes[0])?;
        let b = Argument::lattice("control_b").control(&control_b, self.shapes[1])?;
        Ok(NdArray::numbers(py, &self.core.gaps([&a, &b]).map_err(to_python)?))
    }

    fn __repr__(&self) -> String {
        let [a, b] = self.faces.map(Face::name);
        format!("Tie({a:?}, {b:?}, continuity={})", self.core.continuity())
    }
}
