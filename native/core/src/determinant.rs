// SPDX-License-Identifier: GPL-3.0-or-later
//! The sign of a determinant, at a place and throughout a piece of a lattice, guarded against rounding.

use glam::{DMat3, DVec3};

use crate::jacobian::{Cell, Tensor};

/// Errors of the three factors of a determinant, and of the arithmetic on them, in units of one entry's.
const OF_THREE: f64 = 4.0;
/// The same of `X J Y`, two sums of three products.
const OF_PRODUCT: f64 = 2.0;

/// Decides signs in one cell.
pub(crate) struct Signs {
    largest: DMat3,
    rounding: f64,
    /// Whether coefficients are multiples of the derivative's that change from place to place.
    is_scaled: bool,
    /// Rounding alone may make a determinant this large.
    noise: f64,
}

impl Signs {
    pub(crate) fn new(cell: &Cell) -> Self {
        let noise = OF_THREE * cell.rounding * permanent(&cell.largest);
        Self { largest: cell.largest, rounding: cell.rounding, is_scaled: cell.is_scaled, noise }
    }

    /// 1 or -1, or `None` where rounding leaves it open.
    pub(crate) fn of(&self, matrix: &DMat3) -> Option<f64> {
        let determinant = matrix.determinant();
        (determinant.abs() > self.noise).then(|| determinant.signum())
    }

    /// Whether `det J` is proved to have one sign throughout a piece, where `middle` is a value of `J` in it.
    ///
    /// With `X middle Y = 1` and `X J Y = 1 + N`, `det(X J Y) = 1 + tr N + (the 2 x 2 minors of N) + det N`. The Bernstein coefficients of
    /// `1 + tr N` are exact; those of the minors and of `det N` are bounded by products of the largest of the entries. Where
    /// the sum is positive for all coefficients, so is the determinant everywhere in the piece. What is bounded shrinks with
    /// the square of the piece, as the distance between a function and its Bernstein coefficients does.
    ///
    /// A coefficient of the determinant is a convex combination of those with three coefficients of `J` for its three factors, all of
    /// which the bound holds for; so each coefficient may be scaled by any positive number of its own. Where `J` comes with a factor that
    /// changes from place to place, all are scaled to the trace that 1 has, and the factor is gone.
    pub(crate) fn is_one(&self, tensor: &Tensor, middle: &DMat3) -> bool {
        let Some((x, y)) = pivoted(middle) else { return false };
        let mut error = absolute(&x) * self.largest * absolute(&y) * (OF_PRODUCT * self.rounding);
        let (mut most, mut lowest, mut scale) = (DMat3::ZERO, f64::INFINITY, 1.0f64);
        for coefficient in &tensor.coefficients {
            let mut product = x * *coefficient * y;
            if self.is_scaled {
                let third = trace(&product) / 3.0;
                // Without a positive one there is nothing to scale by, and no proof.
                if third.is_nan() || third <= 0.0 {
                    return false;
                }
                product *= third.recip();
                scale = scale.max(third.recip());
            }
            let n = product - DMat3::IDENTITY;
            most = largest(&most, &absolute(&n));
            lowest = lowest.min(trace(&n));
        }
        if self.is_scaled {
            // Of the product, and of what it was divided by.
            let by_third = (DMat3::IDENTITY + most) * (trace(&error) / 3.0);
            error = (error + by_third) * scale;
        }
        most += error;
        1.0 + lowest - trace(&error) > minors(&most) + permanent(&most)
    }
}

/// `X` and `Y` with `X A Y = 1`, by elimination with complete pivoting: nearly flat directions get rows of their own, so that
/// only they are scaled up. `None` where a pivot is zero or not a number.
fn pivoted(matrix: &DMat3) -> Option<(DMat3, DMat3)> {
    // Rows of A and X, and columns of Y.
    let mut a = matrix.transpose().to_cols_array_2d().map(DVec3::from_array);
    let (mut x, mut y) = (DVec3::AXES, DVec3::AXES);
    for k in 0..3 {
        let below = (k..3).flat_map(|i| (k..3).map(move |j| (i, j)));
        let (i, j) = below.max_by(|&p, &q| a[p.0][p.1].abs().total_cmp(&a[q.0][q.1].abs()))?;
        a.swap(k, i);
        x.swap(k, i);
        a.iter_mut().for_each(|row| {
            let kept = row[k];
            row[k] = row[j];
            row[j] = kept;
        });
        y.swap(k, j);
        let pivot = a[k][k];
        if !pivot.is_normal() {
            return None;
        }
        for other in k + 1..3 {
            let (of_row, of_column) = (a[other][k] / pivot, a[k][other] / pivot);
            a[other] -= a[k] * of_row;
            x[other] -= x[k] * of_row;
            y[other] -= y[k] * of_column;
        }
        x[k] /= pivot;
    }
    Some((DMat3::from_cols(x[0], x[1], x[2]).transpose(), DMat3::from_cols(y[0], y[1], y[2])))
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

fn absolute(matrix: &DMat3) -> DMat3 {
    DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
}

/// Entry by entry.
fn largest(a: &DMat3, b: &DMat3) -> DMat3 {
    DMat3::from_cols(a.x_axis.max(b.x_axis), a.y_axis.max(b.y_axis), a.z_axis.max(b.z_axis))
}

/// The determinant's six products, all added.
fn permanent(m: &DMat3) -> f64 {
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
    a.x * (b.y * c.z + b.z * c.y) + a.y * (b.x * c.z + b.z * c.x) + a.z * (b.x * c.y + b.y * c.x)
}

/// The products of the three principal minors, all added.
fn minors(m: &DMat3) -> f64 {
    let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis];
    a.x * b.y + b.x * a.y + a.x * c.z + c.x * a.z + b.y * c.z + c.y * b.z
}
