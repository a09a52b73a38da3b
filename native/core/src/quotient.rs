// SPDX-License-Identifier: GPL-3.0-or-later
//! The derivative of a lattice that is no plain spline, in each of its cells, as Bernstein coefficients of what has its sign.
//!
//! With `x = base + Q/W`, numerator and denominator splines over inner control points and `W` positive,
//! `W^2 dx/ds_a = W (W dbase/ds_a + dQ/ds_a) - Q dW/ds_a` is a polynomial of twice the degree in each cell, and the determinant of these
//! three has the sign of the map's: it is `W^2` times the determinant of the four homogeneous vectors `(X, W)` and their derivatives, of
//! degree `4 d - 1`, whose quotient by `W^4` is the map's. Products of Bernstein forms are convex combinations, so rounding stays
//! bounded by products of the largest coefficients.

use glam::{DMat3, DVec3};

use crate::jacobian::{AxisCell, spread, window};
use crate::lattice::Lattice;
use crate::net::Net;
use crate::pieces::indices;

/// Errors of what inner control points carry, as a multiple of the largest: sums of a few terms on each axis.
const OF_INNER: f64 = 4.0;

/// Roundings before the splines' own: a difference from the mean, a weight, sums of three terms on each axis.
const INNER_ROUNDINGS: f64 = 16.0;

/// Roundings of one product of Bernstein coefficients beside the sum's.
const PRODUCT_ROUNDINGS: f64 = 8.0;

/// What inner control points carry, and differences of it along each axis over the knots'.
struct Carried {
    values: Vec<DVec3>,
    slopes: [Vec<DVec3>; 3],
    /// No error of a slope is larger, in the units of rounding.
    bounds: [Vec<DVec3>; 3],
}

/// A lattice's shape as a quotient of two splines over a linear map.
pub(crate) struct Quotient {
    shape: [usize; 3],
    numerator: Carried,
    /// The same number in all three places.
    denominator: Option<Carried>,
    base: DMat3,
}

/// The derivative in one cell, scaled by the square of the denominator.
pub(crate) struct Scaled {
    pub(crate) taps: [usize; 3],
    pub(crate) columns: [Vec<DVec3>; 3],
    pub(crate) largest: DMat3,
    /// Roundings in it, given those of a spline.
    pub(crate) roundings: f64,
}

impl Quotient {
    /// `control`: checked to fit the lattice. `is_displaced`: the form in which bound vertices move ([`Net`]).
    pub(crate) fn new(lattice: &Lattice, control: &[DVec3], is_displaced: bool) -> Self {
        let mut moved = control.to_vec();
        if is_displaced {
            moved.iter_mut().zip(lattice.rest()).for_each(|(point, rest)| *point -= rest);
        }
        // A lattice far away has the same derivative.
        let mean = moved.iter().sum::<DVec3>() / moved.len() as f64;
        moved.iter_mut().for_each(|point| *point -= mean);
        let net = Net::new(lattice, &moved, is_displaced);
        let base = net.base_slope();
        let largest = net.values.iter().fold(DVec3::ZERO, |most, value| most.max(value.abs()));
        let largest = largest.max(base.x_axis.abs() + base.y_axis.abs() + base.z_axis.abs());
        // A power of two for each coordinate changes no digit, and keeps products of three away from the ends of float64.
        let scale = largest.to_array().map(|size| (-size.log2().floor()).exp2());
        let scale = DVec3::from_array(scale.map(|s| if s.is_normal() { s } else { 1.0 }));
        let values = net.values.iter().map(|value| *value * scale).collect();
        let weights = net.weights.map(|all| all.iter().map(|&weight| DVec3::splat(weight)).collect());
        Self {
            shape: lattice.map().inner_shape(),
            numerator: Carried::new(lattice, values),
            denominator: weights.map(|weights| Carried::new(lattice, weights)),
            base: DMat3::from_diagonal(scale) * base,
        }
    }

    /// The derivative in a cell. `roundings`: those of a spline's derivative there.
    pub(crate) fn cell(&self, axes: [&AxisCell; 3], degrees: [usize; 3], roundings: f64) -> Scaled {
        let taps = degrees.map(|degree| degree + 1);
        let roundings = roundings + INNER_ROUNDINGS;
        let base = [0, 1, 2].map(|axis| self.base.col(axis));
        let (slopes, bounds) = self.numerator.slopes(axes, taps, self.shape);
        let Some(denominator) = &self.denominator else {
            let largest = std::array::from_fn(|axis| base[axis].abs() + bounds[axis]);
            let columns = std::array::from_fn(|axis| slopes[axis].iter().map(|&s| s + base[axis]).collect());
            return Scaled { taps, columns, largest: matrix(largest), roundings };
        };
        let (whole_slopes, whole_bounds) = denominator.slopes(axes, taps, self.shape);
        let [value, whole] = [&self.numerator, denominator].map(|of| of.values(axes, taps, self.shape));
        let most =
            [&value, &whole].map(|all| all.iter().fold(DVec3::ZERO, |most, value| most.max(value.abs())));
        let tables = degrees.map(shares);
        let columns = std::array::from_fn(|axis| {
            let own: Vec<DVec3> =
                slopes[axis].iter().zip(&whole).map(|(&slope, &w)| slope + w * base[axis]).collect();
            let mut column = product(&whole, &own, taps, &tables);
            let other = product(&value, &whole_slopes[axis], taps, &tables);
            column.iter_mut().zip(other).for_each(|(column, other)| *column -= other);
            column
        });
        let largest = std::array::from_fn(|axis| {
            most[1] * (most[1] * base[axis].abs() + bounds[axis]) + most[0] * whole_bounds[axis]
        });
        let terms: usize = taps.iter().product();
        Scaled {
            taps: degrees.map(|degree| 2 * degree + 1),
            columns,
            largest: matrix(largest),
            roundings: 2.0 * roundings + terms as f64 + PRODUCT_ROUNDINGS,
        }
    }
}

impl Carried {
    fn new(lattice: &Lattice, values: Vec<DVec3>) -> Self {
        let largest = values.iter().fold(DVec3::ZERO, |most, value| most.max(value.abs()));
        let shape = lattice.map().inner_shape();
        let rated: [Vec<(DVec3, f64)>; 3] =
            std::array::from_fn(|axis| differences(lattice, &values, shape, axis));
        let slopes =
            rated.each_ref().map(|all| all.iter().map(|(difference, rate)| *difference * *rate).collect());
        let bounds = rated.map(|all| all.into_iter().map(|(_, rate)| largest * (OF_INNER * rate)).collect());
        Self { values, slopes, bounds }
    }

    /// Bernstein coefficients of the values in a cell.
    fn values(&self, axes: [&AxisCell; 3], taps: [usize; 3], shape: [usize; 3]) -> Vec<DVec3> {
        spread(window(&self.values, shape, axes, taps), axes, taps, None)
    }

    /// The same of the slopes along each axis, and the bounds of their errors.
    fn slopes(
        &self,
        axes: [&AxisCell; 3],
        taps: [usize; 3],
        shape: [usize; 3],
    ) -> ([Vec<DVec3>; 3], [DVec3; 3]) {
        let part = |along: usize, of: &[DVec3]| {
            let (mut shape, mut taps) = (shape, taps);
            shape[along] = (shape[along] - 1).max(1);
            taps[along] = axes[along].slope[0].len();
            (window(of, shape, axes, taps), taps)
        };
        let slopes = std::array::from_fn(|along| {
            let (values, taps) = part(along, &self.slopes[along]);
            spread(values, axes, taps, Some(along))
        });
        let bounds = std::array::from_fn(|along| {
            part(along, &self.bounds[along]).0.iter().fold(DVec3::ZERO, |most, bound| most.max(*bound))
        });
        (slopes, bounds)
    }
}

/// Differences along an axis, each with what makes it a coefficient of the derivative; nothing on an axis with one control point.
fn differences(lattice: &Lattice, values: &[DVec3], shape: [usize; 3], along: usize) -> Vec<(DVec3, f64)> {
    let basis = &lattice.axes()[along];
    let (degree, stride) = (basis.degree(), shape[along + 1..].iter().product::<usize>());
    let mut count = shape;
    count[along] = (shape[along] - 1).max(1);
    let of = |index: [usize; 3]| {
        if degree == 0 {
            return (DVec3::ZERO, 0.0);
        }
        let at = (index[0] * shape[1] + index[1]) * shape[2] + index[2];
        (values[at + stride] - values[at], basis.slope_rate(index[along]))
    };
    indices(count).map(of).collect()
}

/// `C(d, i) C(d, j) / C(2 d, i + j)`: how much a product of Bernstein coefficients adds to one of twice the degree. They sum to 1.
fn shares(degree: usize) -> Vec<Vec<f64>> {
    let row = |n: usize| -> Vec<f64> {
        let next = |last: &mut f64, i: usize| {
            let value = *last;
            *last *= (n - i) as f64 / (i + 1) as f64;
            Some(value)
        };
        (0..=n).scan(1.0, next).collect()
    };
    let (single, double) = (row(degree), row(2 * degree));
    (0..=degree).map(|i| (0..=degree).map(|j| single[i] * single[j] / double[i + j]).collect()).collect()
}

/// The product of two Bernstein forms of one degree, number by number.
fn product(a: &[DVec3], b: &[DVec3], taps: [usize; 3], shares: &[Vec<Vec<f64>>; 3]) -> Vec<DVec3> {
    let out_taps = taps.map(|taps| 2 * taps - 1);
    let mut out = vec![DVec3::ZERO; out_taps.iter().product()];
    for (p, &left) in indices(taps).zip(a) {
        for (q, &right) in indices(taps).zip(b) {
            let share: f64 = (0..3).map(|axis| shares[axis][p[axis]][q[axis]]).product();
            let at = ((p[0] + q[0]) * out_taps[1] + p[1] + q[1]) * out_taps[2] + p[2] + q[2];
            out[at] += left * right * share;
        }
    }
    out
}

fn matrix(columns: [DVec3; 3]) -> DMat3 {
    DMat3::from_cols(columns[0], columns[1], columns[2])
}
