// SPDX-License-Identifier: GPL-3.0-or-later
//! How much a displacement of the control points bends space: the energy of a thin plate in three dimensions.
//!
//! `integral over the domain of the sum of all squared second derivatives by the coordinates of space` of one coordinate of the
//! displacement. It does not depend on how the domain is turned, and affine displacements cost nothing. The basis is a product, so
//! the integrals are products of integrals over one axis, which Gauss's rule gives exactly. Piecewise linear axes have no second
//! derivative but the steps of the first: those count as spread over the distance between knots, and not together with others.
//!
//! Weights of a rational lattice are left out: the energy is that of the same displacement of the control points with equal weights. So it
//! stays a product, and affine displacements cost nothing, which with the rational functions they would.

use glam::DMat3;

use crate::basis::AxisBasis;
use crate::error::Result;
use crate::lattice::Lattice;
use crate::preserve::band::Band;

/// `[r][s][i][j]`: integral of derivative `r` of basis function `i` times derivative `s` of function `j`, over one axis.
type Products = [[Vec<Vec<f64>>; 3]; 3];

/// The matrix of the energy.
pub(crate) fn bending(lattice: &Lattice) -> Result<Band> {
    // Creases of polygons couple three points in a row, which share no cell.
    let reach = |axis: &AxisBasis| if axis.degree() == 1 { 2 } else { axis.window() - 1 };
    let mut band = Band::new(lattice, lattice.axes().each_ref().map(reach))?;
    let products = lattice.axes().each_ref().map(products);
    let terms = terms(lattice.edges());
    let shape = lattice.shape();
    let mut entries = Vec::new();
    for column in 0..lattice.len() {
        entries.clear();
        let at = band.index(column);
        band.for_column(column, |row, _| {
            let to = [row / (shape[1] * shape[2]), row / shape[2] % shape[1], row % shape[2]];
            let term = |(orders, weight): &([[usize; 2]; 3], f64)| {
                let along = |axis: usize| {
                    let [r, s] = orders[axis];
                    products[axis][r][s][to[axis]][at[axis]]
                };
                weight * along(0) * along(1) * along(2)
            };
            entries.push((row, terms.iter().map(term).sum::<f64>()));
        });
        entries.iter().for_each(|&(row, value)| band.add(row, column, value));
    }
    Ok(band)
}

/// Orders of the derivatives of both factors along the three axes, with the weight of their product: the squared second
/// derivatives by the coordinates of space, written in parameters: `H_x = K' H_t K`, with `K` the inverse of the edges.
fn terms(edges: DMat3) -> Vec<([[usize; 2]; 3], f64)> {
    // In units of the largest edge, so that no power over- or underflows; a factor common to all is of no consequence.
    let largest = edges.to_cols_array().iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
    let inverse = (edges * largest.recip()).inverse();
    let metric = inverse * inverse.transpose();
    let mut terms: Vec<([[usize; 2]; 3], f64)> = Vec::new();
    for index in 0..81 {
        let [a, b, c, d] = [index % 3, index / 3 % 3, index / 9 % 3, index / 27];
        let weight = metric.col(a)[c] * metric.col(b)[d];
        let orders = std::array::from_fn(|axis| {
            [usize::from(a == axis) + usize::from(b == axis), usize::from(c == axis) + usize::from(d == axis)]
        });
        match terms.iter_mut().find(|(known, _)| *known == orders) {
            Some((_, sum)) => *sum += weight,
            None => terms.push((orders, weight)),
        }
    }
    let largest = terms.iter().fold(0.0f64, |largest, (_, weight)| largest.max(weight.abs()));
    // What rounding leaves of right angles.
    terms.retain(|(_, weight)| weight.abs() > 1e-15 * largest);
    terms
}

fn products(axis: &AxisBasis) -> Products {
    let products = inner_products(axis);
    let Some(rows) = axis.rows() else { return products };
    products.map(|row| {
        row.map(|inner| {
            let mut outer = vec![vec![0.0; axis.count()]; axis.count()];
            for (of, row) in rows.iter().zip(&inner) {
                for (with, value) in rows.iter().zip(row).filter(|(_, value)| **value != 0.0) {
                    for &(i, a) in of {
                        with.iter().for_each(|&(j, b)| outer[i][j] += a * b * value);
                    }
                }
            }
            outer
        })
    })
}

/// The same between the functions of the axis's spline.
fn inner_products(axis: &AxisBasis) -> Products {
    let (count, degree) = (axis.inner_count(), axis.degree());
    let mut products: Products =
        std::array::from_fn(|_| std::array::from_fn(|_| vec![vec![0.0; count]; count]));
    let rule = gauss(degree + 1);
    for cell in axis.domain_cells() {
        let first = axis.first_point(cell);
        let (start, end) = (axis.knots()[first + degree], axis.knots()[first + degree + 1]);
        for &(at, weight) in &rule {
            let t = start + (end - start) * at;
            let derivatives =
                [0, 1, 2].map(|order| derivatives(axis.knots(), degree, first + degree, t, order));
            for (r, left) in derivatives.iter().enumerate() {
                for (s, right) in derivatives.iter().enumerate() {
                    add_outer(&mut products[r][s], first, left, right, weight * (end - start));
                }
            }
        }
    }
    if degree == 1 {
        creases(axis.knots(), &mut products[2][2]);
    }
    products
}

fn add_outer(to: &mut [Vec<f64>], first: usize, left: &[f64], right: &[f64], weight: f64) {
    for (row, a) in to[first..].iter_mut().zip(left) {
        row[first..].iter_mut().zip(right).for_each(|(to, b)| *to += weight * a * b);
    }
}

/// The squared steps of a polygon's slope, each over half of both edges that meet there.
fn creases(knots: &[f64], to: &mut [Vec<f64>]) {
    // Function i is the hat over knots i, i + 1, i + 2.
    for i in 1..to.len() - 1 {
        let (before, after) = (knots[i + 1] - knots[i], knots[i + 2] - knots[i + 1]);
        let step = [before.recip(), -before.recip() - after.recip(), after.recip()];
        add_outer(to, i - 1, &step, &step, 2.0 / (before + after));
    }
}

/// Derivatives of an order at `t` of the `degree + 1` basis functions that act between knots `m` and `m + 1`: Cox and de Boor's
/// recurrence, its last steps in the form for derivatives.
fn derivatives(knots: &[f64], degree: usize, m: usize, t: f64, order: usize) -> Vec<f64> {
    let mut functions = vec![1.0];
    if order > degree {
        return vec![0.0; degree + 1];
    }
    for q in 1..=degree {
        let is_value = q + order <= degree;
        let mut raised = vec![0.0; q + 1];
        for (r, function) in functions.iter().enumerate() {
            let (left, right) = (knots[m + 1 + r - q], knots[m + 1 + r]);
            let part = function / (right - left);
            let [falling, rising] = if is_value {
                [(right - t) * part, (t - left) * part]
            } else {
                [-(q as f64) * part, q as f64 * part]
            };
            raised[r] += falling;
            raised[r + 1] += rising;
        }
        functions = raised;
    }
    functions
}

/// Gauss's rule on [0, 1]: places and weights, exact for polynomials of degree `2 count - 1`. The places are the zeros of Legendre's
/// polynomial, by Newton's method from Chebyshev's.
fn gauss(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let legendre = |x: f64| {
        let (mut before, mut here) = (1.0, x);
        for k in 2..=count {
            let k = k as f64;
            (before, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k);
        }
        (here, n * (x * here - before) / (x * x - 1.0))
    };
    let rule = (0..count).map(|i| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        for _ in 0..8 {
            let (value, slope) = legendre(x);
            x -= value / slope;
        }
        let slope = legendre(x).1;
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    });
    rule.collect()
}

#[cfg(test)]
mod tests {
    use super::{bending, gauss};
    use crate::basis::AxisBasis;
    use crate::lattice::Lattice;
    use glam::{DMat3, DVec3};

    fn energy(lattice: &Lattice, values: &[f64]) -> f64 {
        let band = bending(lattice).unwrap_or_else(|error| unreachable!("{error}"));
        let mut sum = 0.0;
        for column in 0..band.count() {
            band.for_column(column, |row, entry| {
                sum += if row == column { 1.0 } else { 2.0 } * entry * values[row] * values[column];
            });
        }
        sum
    }

    #[test]
    fn the_rule_is_exact() {
        for count in 1..20 {
            for power in 0..2 * count {
                let sum: f64 = gauss(count).iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                assert!((sum * (power as f64 + 1.0) - 1.0).abs() < 1e-13, "{count} {power}");
            }
        }
    }

    /// Control values of a product of squares and of a linear function: blossoms of their knots.
    fn values(lattice: &Lattice, f: impl Fn([[f64; 2]; 3]) -> f64) -> Vec<f64> {
        let blossoms = lattice.axes().each_ref().map(|axis| {
            let of = |i: usize| {
                let knots = &axis.knots()[i + 1..=i + axis.degree()];
                let (n, sum) = (knots.len() as f64, knots.iter().sum::<f64>());
                let squares: f64 = knots.iter().map(|k| k * k).sum();
                [sum / n, (sum * sum - squares) / (n * (n - 1.0))]
            };
            (0..axis.count()).map(of).collect::<Vec<_>>()
        });
        let [nu, nv, nw] = lattice.shape();
        (0..nu * nv * nw)
            .map(|p| f([blossoms[0][p / (nv * nw)], blossoms[1][p / nw % nv], blossoms[2][p % nw]]))
            .collect()
    }

    #[test]
    fn known_functions_have_their_energy_and_affine_ones_none() {
        let axes = [AxisBasis::uniform(6, 3), AxisBasis::clamped(5, 2), AxisBasis::bernstein(5)]
            .map(|axis| axis.unwrap_or_else(|error| unreachable!("{error}")));
        let cube =
            Lattice::new(axes.clone(), DVec3::ZERO, DMat3::IDENTITY).unwrap_or_else(|e| unreachable!("{e}"));
        // s^2 has 4, s t has 2, s^2 + t^2 + u^2 + s t has 12 + 2, times the volume, 1.
        assert!((energy(&cube, &values(&cube, |[s, _, _]| s[1])) - 4.0).abs() < 1e-12);
        let mixed = values(&cube, |[s, t, u]| s[1] + t[1] + u[1] + s[0] * t[0]);
        assert!((energy(&cube, &mixed) - 14.0).abs() < 1e-11);
        let affine = values(&cube, |[s, t, u]| 3.0 - s[0] + 2.0 * t[0] - 0.5 * u[0]);
        assert!(energy(&cube, &affine).abs() < 1e-11);
        // The same function of space in a slanted box of half the edges' lengths has the same energy for each volume: x^2 with
        // x = s + t / 2. The unit is the largest edge.
        let edges = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
        let slanted = Lattice::new(axes, DVec3::ZERO, edges).unwrap_or_else(|e| unreachable!("{e}"));
        let square = values(&slanted, |[s, t, _]| s[1] + s[0] * t[0] + 0.25 * t[1]);
        assert!((energy(&slanted, &square) - 4.0).abs() < 1e-11);
    }

    #[test]
    fn a_polygon_resists_creases_only() {
        let linear = || AxisBasis::clamped(4, 1).unwrap_or_else(|error| unreachable!("{error}"));
        let lattice = Lattice::new([linear(), linear(), linear()], DVec3::ZERO, DMat3::IDENTITY)
            .unwrap_or_else(|error| unreachable!("{error}"));
        let along = |p: usize| p / 16;
        let straight: Vec<f64> = (0..64).map(|p| along(p) as f64).collect();
        let creased: Vec<f64> = (0..64).map(|p| along(p).abs_diff(1) as f64).collect();
        assert!(energy(&lattice, &straight).abs() < 1e-10);
        // One step of the slope by 2 / (1/3), spread over 1/3.
        assert!((energy(&lattice, &creased) - 36.0 * 3.0).abs() < 1e-10);
    }
}
