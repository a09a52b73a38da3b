// SPDX-License-Identifier: GPL-3.0-or-later
//! One axis of a lattice with more control points, and the matrix that takes the old ones there.

use crate::basis::{AxisBasis, MAX_POINTS};
use crate::error::{Error, Result};
use crate::refine::rows::{Rows, acting, after, inserting_rows, raised_knots, raising_rows};
use crate::words::number;

/// Parameters nearer to a knot than this fraction of the domain mean that knot: a basis has no shorter span.
const SAME_KNOT: f64 = 1e-12;

/// What to make of an axis.
#[derive(Debug, Clone, Default)]
pub struct RefineAxis {
    /// Degree to raise it to; `None` to keep it.
    pub degree: Option<usize>,
    /// Parameters in (0, 1), in any order, at which to insert a knot, after the degree was raised.
    pub insert: Vec<f64>,
    /// Number of control points to reach by further knots in the middles of the longest spans; `None` for no more knots.
    pub count: Option<usize>,
}

/// The refined axis, and the rows that take the old control points to the new; `None` where nothing changes. `name`: of the
/// axis, for messages.
pub(super) fn refined(basis: &AxisBasis, to: &RefineAxis, name: &str) -> Result<(AxisBasis, Option<Rows>)> {
    check(basis, to, name)?;
    if basis.count() == 1 {
        return Ok((basis.clone(), None));
    }
    let mut rows = None;
    let mut raised = basis.clone();
    for degree in basis.degree()..to.degree.unwrap_or(basis.degree()) {
        let knots = raised_knots(raised.knots(), degree);
        let next = AxisBasis::with_knots(knots.len() - degree - 2, degree + 1, knots)?;
        let step = raising_rows(raised.knots(), degree, next.knots());
        rows = Some(composed(step, rows));
        raised = next;
    }
    let inner = inner_knots(&raised, to, name)?;
    if inner.len() == raised.count() - raised.degree() - 1 {
        return Ok((raised, rows));
    }
    let finer = with_inner(&raised, &inner)?;
    let step = inserting_rows(raised.knots(), raised.degree(), finer.knots());
    Ok((finer, Some(composed(step, rows))))
}

fn composed(step: Rows, rows: Option<Rows>) -> Rows {
    match rows {
        Some(rows) => after(&step, &rows),
        None => step,
    }
}

fn check(basis: &AxisBasis, to: &RefineAxis, name: &str) -> Result<()> {
    let outside = |t: &&f64| !(**t > 0.0 && **t < 1.0);
    if let Some(&found) = to.insert.iter().find(outside) {
        return Err(Error::Lattice(format!(
            "insert: found {} on axis {name}, expected parameters between 0 and 1, both excluded",
            number(found)
        )));
    }
    if basis.count() == 1 {
        let asked = to.count.is_some_and(|count| count != 1) || !to.insert.is_empty();
        return if asked { Err(single(name)) } else { Ok(()) };
    }
    let degree = to.degree.unwrap_or(basis.degree());
    if degree < basis.degree() {
        return Err(Error::Lattice(format!(
            "degree: found {degree} on axis {name}, expected at least the lattice's own {}; refinement raises a degree, a lower one would change the shape",
            basis.degree()
        )));
    }
    if degree >= MAX_POINTS || to.count.is_some_and(|count| count > MAX_POINTS) {
        return Err(Error::Lattice(format!(
            "shape: found more than {MAX_POINTS} control points asked for on axis {name}, expected at most that many"
        )));
    }
    Ok(())
}

fn single(name: &str) -> Error {
    Error::Lattice(format!(
        "refine: axis {name} has one control point, along which nothing deforms, and more were asked for; expected it to stay at one, or make a lattice with more points there"
    ))
}

/// The knots inside the domain: those that are there, those to insert, and as many in the middles of the longest spans as are
/// missing.
fn inner_knots(raised: &AxisBasis, to: &RefineAxis, name: &str) -> Result<Vec<f64>> {
    let degree = raised.degree();
    let mut inner: Vec<f64> = raised.knots()[degree + 1..raised.count()].to_vec();
    for &t in &to.insert {
        let near = inner.iter().find(|knot| (**knot - t).abs() < SAME_KNOT);
        let knot = near.copied().unwrap_or(t);
        inner.insert(inner.partition_point(|&other| other <= knot), knot);
    }
    let Some(count) = to.count else { return Ok(inner) };
    let reached = inner.len() + degree + 1;
    if count < reached {
        return Err(Error::Lattice(format!(
            "shape: found {count} control points on axis {name}, expected at least {reached}, which the lattice has of degree {degree} with the knots inserted; refinement takes no control points away"
        )));
    }
    while inner.len() + degree + 1 < count {
        let knot = middle_of_longest(&inner);
        inner.insert(inner.partition_point(|&other| other <= knot), knot);
    }
    Ok(inner)
}

/// Middle of the longest span; of several the one nearest to the middle of the domain, so that what is even stays so.
fn middle_of_longest(inner: &[f64]) -> f64 {
    let starts = std::iter::once(0.0).chain(inner.iter().copied());
    let spans = starts.zip(inner.iter().copied().chain([1.0]));
    let (mut best, mut longest) = (0.5, 0.0);
    for (start, end) in spans {
        let (middle, length) = (start + (end - start) / 2.0, end - start);
        let alike = (length - longest).abs() < SAME_KNOT;
        let nearer = (middle - 0.5_f64).abs() < (best - 0.5_f64).abs() - SAME_KNOT;
        if if alike { nearer } else { length > longest } {
            (best, longest) = (middle, length);
        }
    }
    best
}

/// The axis with these knots inside its domain. Those beyond stay, but where every span of a uniform axis was divided alike,
/// it is uniform again.
fn with_inner(basis: &AxisBasis, inner: &[f64]) -> Result<AxisBasis> {
    let degree = basis.degree();
    let count = inner.len() + degree + 1;
    if *basis == AxisBasis::uniform(basis.count(), degree)? && (inner.len() + 1).is_multiple_of(basis.cells())
    {
        let uniform = AxisBasis::uniform(count, degree)?;
        let even = uniform.knots()[degree + 1..count].iter().zip(inner);
        if even.into_iter().all(|(even, knot)| (even - knot).abs() < SAME_KNOT) {
            return Ok(uniform);
        }
    }
    let knots = basis.knots();
    let lower = knots.partition_point(|&knot| knot <= 0.0);
    let upper = knots.partition_point(|&knot| knot < 1.0);
    let knots = acting(&[&knots[..lower], inner, &knots[upper..]].concat(), degree);
    AxisBasis::with_knots(count, degree, knots)
}
