// SPDX-License-Identifier: GPL-3.0-or-later
//! The bases of a lattice's axes, from the arguments that describe them.

use isochor_core::AxisBasis;
use pyo3::prelude::*;

use crate::arrays::{Argument, ArrayLike, Numbers};
use crate::errors::to_python;
use crate::words::{BasisWord, InterpolationWords, KnotsWord};

/// The arguments shape, basis, degree, knots and interpolation of `isochor.Lattice`.
pub(crate) fn axes(
    shape: Option<ArrayLike<'_>>,
    basis: BasisWord,
    degree: Option<ArrayLike<'_>>,
    knots: KnotsWord<'_>,
    interpolation: Option<InterpolationWords>,
) -> PyResult<[AxisBasis; 3]> {
    if interpolation.is_some() && basis != BasisWord::Blender {
        return Err(Argument::lattice("interpolation")
            .error("found words, but only basis=\"blender\" has them; leave them out"));
    }
    let shape = shape.map_or(Ok([4; 3]), |shape| Argument::lattice("shape").counts(&shape, false))?;
    let given = degree.map(|degree| Argument::lattice("degree").counts(&degree, true)).transpose()?;
    let [s, t, u] = match basis {
        BasisWord::Bernstein => {
            let bernstein = shape.map(|count| count.saturating_sub(1));
            if let Some(found) = given.filter(|given| *given != bernstein) {
                return Err(Argument::lattice("degree")
                    .error(format!("found {found:?}, but a Bernstein lattice of shape {shape:?} has {bernstein:?}; leave it out")));
            }
            if matches!(knots, KnotsWord::Given(_)) {
                return Err(Argument::lattice("knots")
                    .error("found arrays, but a Bernstein lattice has none; leave them out, or use basis=\"bspline\""));
            }
            shape.map(AxisBasis::bernstein)
        }
        BasisWord::Blender => {
            if given.is_some() || !matches!(knots, KnotsWord::Uniform) {
                return Err(Argument::lattice("degree")
                    .error("found degree or knots, but Blender's bases have their own; leave them out"));
            }
            let kinds = interpolation.unwrap_or_default().0;
            std::array::from_fn(|a| AxisBasis::blender(shape[a], kinds[a]))
        }
        BasisWord::BSpline => {
            let degree = given.unwrap_or([3; 3]);
            match knots {
                KnotsWord::Uniform => std::array::from_fn(|a| AxisBasis::uniform(shape[a], degree[a])),
                KnotsWord::Clamped => std::array::from_fn(|a| AxisBasis::clamped(shape[a], degree[a])),
                KnotsWord::Given(arrays) => {
                    let mut knots = Vec::with_capacity(3);
                    for array in &arrays {
                        let array: ArrayLike<'_> = array.extract()?;
                        knots.push(Argument::lattice("knots").floats(
                            &array,
                            Numbers::FloatsOrIntegers,
                            &[None],
                        )?);
                    }
                    std::array::from_fn(|a| {
                        AxisBasis::with_knots(shape[a], degree[a], std::mem::take(&mut knots[a]))
                    })
                }
            }
        }
    };
    Ok([s.map_err(to_python)?, t.map_err(to_python)?, u.map_err(to_python)?])
}
