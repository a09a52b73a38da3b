// SPDX-License-Identifier: GPL-3.0-or-later
//! What an axis' basis functions and their derivatives are at an end of its domain.

use crate::basis::AxisBasis;

/// Derivatives up to an order of all basis functions of an axis at 0 or, if `upper`, at 1: orders x control points.
///
/// By the functions of lower degree: the derivative of one of degree `q` is `q (N_i / (k_i+q - k_i) - N_i+1 / (k_i+q+1 - k_i+1))`.
pub(crate) fn end_derivatives(basis: &AxisBasis, upper: bool, orders: usize) -> Vec<Vec<f64>> {
    (0..=orders).map(|order| derivative(basis, upper, order)).collect()
}

fn derivative(basis: &AxisBasis, upper: bool, order: usize) -> Vec<f64> {
    let inner = inner_derivative(basis, upper, order);
    let Some(rows) = basis.rows() else { return inner };
    let mut row = vec![0.0; basis.count()];
    for (value, sum) in inner.iter().zip(rows) {
        sum.iter().for_each(|(point, share)| row[*point] += share * value);
    }
    row
}

/// The same of the spline's own functions.
fn inner_derivative(basis: &AxisBasis, upper: bool, order: usize) -> Vec<f64> {
    let (degree, knots) = (basis.degree(), basis.knots());
    let mut row = vec![0.0; basis.inner_count()];
    if order > degree {
        return row;
    }
    let cells = basis.domain_cells();
    let (t, cell) = if upper { (1.0, cells.end - 1) } else { (0.0, cells.start) };
    // Knots k_m and k_m+1 around the cell.
    let m = basis.first_point(cell) + degree;
    let mut values = vec![1.0];
    for q in 1..=degree - order {
        values = raised(
            &values,
            q,
            |i, function| {
                let (start, end) = (knots[i], knots[i + q]);
                [function * (end - t) / (end - start), function * (t - start) / (end - start)]
            },
            m,
        );
    }
    for q in degree - order + 1..=degree {
        values = raised(
            &values,
            q,
            |i, function| {
                let slope = q as f64 * function / (knots[i + q] - knots[i]);
                [-slope, slope]
            },
            m,
        );
    }
    row[m - degree..=m].copy_from_slice(&values);
    row
}

/// Functions of degree `q` in the cell from knot `m` by those of degree `q - 1`, each of which gives a part to the one that starts a knot
/// before it and to the one that starts with it. `parts`: of function `i`.
fn raised(values: &[f64], q: usize, parts: impl Fn(usize, f64) -> [f64; 2], m: usize) -> Vec<f64> {
    let mut sums = vec![0.0; q + 1];
    for (at, &function) in values.iter().enumerate() {
        let [before, own] = parts(m + 1 - q + at, function);
        sums[at] += before;
        sums[at + 1] += own;
    }
    sums
}
