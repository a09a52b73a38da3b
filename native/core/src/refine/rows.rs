// SPDX-License-Identifier: GPL-3.0-or-later
//! Matrices that take the control points of one axis to those over more knots or of a higher degree.
//!
//! A control point is the blossom of the spline at the knots inside its support (Ramshaw). Over knots that contain the old
//! ones it is a convex combination of the old control points, whose weights the Oslo algorithm finds from non-negative
//! products alone; of the next degree it is the mean of such blossoms, one of its knots left out in turn (Prautzsch). So
//! every entry is exact to a few roundings, whatever the degree.

/// One row a new control point, one column an old one.
pub(crate) type Rows = Vec<Vec<f64>>;

/// Knots of one more degree for the same spline: each once more, those beyond the domain `[0, 1]` no more than act in it.
pub(super) fn raised_knots(knots: &[f64], degree: usize) -> Vec<f64> {
    let once_more = knots.chunk_by(|a, b| a == b).flat_map(|equal| equal.iter().chain(&equal[..1]));
    acting(&once_more.copied().collect::<Vec<f64>>(), degree + 1)
}

/// Rows that raise the degree by one; `raised`: [`raised_knots`].
pub(super) fn raising_rows(knots: &[f64], degree: usize, raised: &[f64]) -> Rows {
    let order = degree + 1;
    let row = |j: usize| {
        let arguments = &raised[j + 1..=j + order];
        let mut row = vec![0.0; knots.len() - order];
        let mut start = 0;
        for equal in arguments.chunk_by(|a, b| a == b) {
            let others = arguments.iter().enumerate().filter(|(i, _)| *i != start).map(|(_, knot)| *knot);
            let share = equal.len() as f64 / order as f64;
            let blossom = blossom(knots, degree, raised[j], others);
            row.iter_mut().zip(blossom).for_each(|(sum, weight)| *sum += share * weight);
            start += equal.len();
        }
        row
    };
    (0..raised.len() - order - 1).map(row).collect()
}

/// Rows to more knots of the same degree.
pub(super) fn inserting_rows(knots: &[f64], degree: usize, refined: &[f64]) -> Rows {
    let row = |j: usize| blossom(knots, degree, refined[j], refined[j + 1..=j + degree].iter().copied());
    (0..refined.len() - degree - 1).map(row).collect()
}

/// Those of ascending knots that act in the domain `[0, 1]`: `degree + 1` at or below its start, as many at or above its
/// end, and all between.
pub(super) fn acting(knots: &[f64], degree: usize) -> Vec<f64> {
    let inner = knots.partition_point(|&knot| knot <= 0.0);
    let upper = knots.partition_point(|&knot| knot < 1.0);
    knots[inner.saturating_sub(degree + 1)..knots.len().min(upper + degree + 1)].to_vec()
}

/// The matrix that does what `first` does and then `then`.
pub(super) fn after(then: &Rows, first: &Rows) -> Rows {
    let columns = first.first().map_or(0, Vec::len);
    let combined = |row: &Vec<f64>| {
        let mut sum = vec![0.0; columns];
        for (old, &weight) in first.iter().zip(row).filter(|(_, weight)| **weight != 0.0) {
            sum.iter_mut().zip(old).for_each(|(sum, &entry)| *sum += weight * entry);
        }
        sum
    };
    then.iter().map(combined).collect()
}

/// Weights of the old control points in the blossom at `degree` ascending arguments that follow the knot `before` in a knot
/// vector which contains the old one: discrete B-splines (Cohen, Lyche, Riesenfeld 1980, algorithm 2). Weights that are zero are
/// so to the bit, for they have a difference of equal knots as a factor.
fn blossom(knots: &[f64], degree: usize, before: f64, arguments: impl Iterator<Item = f64>) -> Vec<f64> {
    let count = knots.len() - degree - 1;
    let span = knots.partition_point(|&knot| knot <= before).clamp(1, count) - 1;
    let mut weights = vec![0.0; count + 1];
    weights[span] = 1.0;
    for (order, at) in (1..=degree).zip(arguments) {
        for i in span.saturating_sub(order)..=span {
            let rising = share(weights[i], at - knots[i], knots[i + order] - knots[i]);
            let (low, high) = (knots[i + 1], knots[i + order + 1]);
            weights[i] = rising + share(weights[i + 1], high - at, high - low);
        }
    }
    weights.truncate(count);
    weights
}

/// `weight * part / whole`; zero where the weight is, whatever the knots.
fn share(weight: f64, part: f64, whole: f64) -> f64 {
    if weight == 0.0 { 0.0 } else { weight * (part / whole) }
}
