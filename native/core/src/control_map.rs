// SPDX-License-Identifier: GPL-3.0-or-later
//! What lies between the control points that the user sees and those that the passes over the mesh know.
//!
//! The kernels, the tensor and the GPU deform by a polynomial B-spline over *inner* control points, `x + s sum B q`. A rational
//! lattice of weights `w` is `x + s/D sum B w (P - P_rest)` with `D = sum B w` (Sederberg 14.1), so `q = w (P - P_rest)` and the
//! influence is `s/D`, fixed when a mesh is bound. On an axis of Blender's the functions of `n` points are sums of those of more
//! inner points, `N = B E` with a fixed matrix `E`; so `q = E (w (P - P_rest))`, and what is linear in `q` comes back by the
//! transposed map.

use std::borrow::Cow;
use std::ops::{Add, Mul};

use glam::DVec3;

use crate::basis::{AxisBasis, Rows};
use crate::preserve::Coefficients;

/// The fixed linear map from displacements of a lattice's control points to those of its inner ones.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlMap {
    outer: [usize; 3],
    inner: [usize; 3],
    /// Of the control points, scaled by a power of two so that the largest is between 1/2 and 1; `None` where all are equal.
    weights: Option<Vec<f64>>,
    /// The same of the inner points: `E w`.
    inner_weights: Option<Vec<f64>>,
    /// `E` of each axis; `None` for the identity.
    axes: [Option<Rows>; 3],
}

impl ControlMap {
    /// `weights`: checked; all equal ones are none.
    pub(crate) fn new(axes: &[AxisBasis; 3], weights: Option<&[f64]>) -> Self {
        let unequal = weights.filter(|all| all.iter().any(|weight| *weight != all[0]));
        let scaled = unequal.map(|all| {
            let largest = all.iter().copied().fold(0.0, f64::max);
            let scale = (-largest.log2().ceil()).exp2();
            all.iter().map(|weight| weight * scale).collect::<Vec<f64>>()
        });
        let mut map = Self {
            outer: axes.each_ref().map(AxisBasis::count),
            inner: axes.each_ref().map(AxisBasis::inner_count),
            weights: None,
            inner_weights: None,
            axes: axes.each_ref().map(|axis| axis.rows().cloned()),
        };
        map.inner_weights = scaled.as_deref().map(|weights| map.expanded(weights.to_vec()));
        map.weights = scaled;
        map
    }

    /// Whether inner control points are the lattice's own.
    pub fn is_identity(&self) -> bool {
        self.weights.is_none() && self.axes.iter().all(Option::is_none)
    }

    /// Number of inner control points along s, t, u.
    pub fn inner_shape(&self) -> [usize; 3] {
        self.inner
    }

    /// Number of inner control points.
    pub(crate) fn inner_len(&self) -> usize {
        self.inner.iter().product()
    }

    /// Weights of the control points, scaled; `None` where all are equal.
    pub(crate) fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Weights of the inner control points.
    pub(crate) fn inner_weights(&self) -> Option<&[f64]> {
        self.inner_weights.as_deref()
    }

    /// Displacements of the inner control points, `k` fastest, for those of the lattice's.
    pub fn displacement<'a>(&self, displacement: &'a [DVec3]) -> Cow<'a, [DVec3]> {
        self.to_inner(displacement)
    }

    /// The same along one axis of space.
    pub fn delta<'a>(&self, delta: &'a [f64]) -> Cow<'a, [f64]> {
        self.to_inner(delta)
    }

    /// What changes by so much with each inner control point, by how much it changes with each of the lattice's.
    pub fn row(&self, row: Vec<f64>) -> Vec<f64> {
        if self.is_identity() {
            return row;
        }
        let (mut values, mut shape) = (row, self.inner);
        for axis in 0..3 {
            if let Some(rows) = &self.axes[axis] {
                values = gathered(&values, shape, axis, rows, self.outer[axis]);
                shape[axis] = self.outer[axis];
            }
        }
        self.weighted(&mut values);
        values
    }

    /// Rows over inner control points as rows over the lattice's.
    pub(crate) fn coefficients(&self, found: Coefficients) -> Coefficients {
        Coefficients { rows: found.rows.into_iter().map(|row| self.row(row)).collect(), ..found }
    }

    fn to_inner<'a, V: Value>(&self, values: &'a [V]) -> Cow<'a, [V]> {
        if self.is_identity() {
            return Cow::Borrowed(values);
        }
        let mut values = values.to_vec();
        self.weighted(&mut values);
        Cow::Owned(self.expanded(values))
    }

    fn weighted<V: Value>(&self, values: &mut [V]) {
        if let Some(weights) = &self.weights {
            values.iter_mut().zip(weights).for_each(|(value, weight)| *value = *value * *weight);
        }
    }

    fn expanded<V: Value>(&self, mut values: Vec<V>) -> Vec<V> {
        let mut shape = self.outer;
        for axis in 0..3 {
            if let Some(rows) = &self.axes[axis] {
                values = spread(&values, shape, axis, rows);
                shape[axis] = rows.len();
            }
        }
        values
    }
}

/// What control points may carry: a number or a vector.
trait Value: Copy + Default + Add<Output = Self> + Mul<f64, Output = Self> {}
impl Value for f64 {}
impl Value for DVec3 {}

/// A tensor with one axis replaced by its products with the rows.
fn spread<V: Value>(values: &[V], shape: [usize; 3], axis: usize, rows: &Rows) -> Vec<V> {
    let stride: usize = shape[axis + 1..].iter().product();
    let mut out = Vec::with_capacity(values.len() / shape[axis] * rows.len());
    for block in values.chunks(shape[axis] * stride) {
        for row in rows {
            let at = |line: usize| {
                let terms = row.iter().map(|&(point, share)| block[point * stride + line] * share);
                terms.fold(V::default(), |sum, term| sum + term)
            };
            out.extend((0..stride).map(at));
        }
    }
    out
}

/// The transposed of [`spread`]: one axis replaced by `count` sums over the rows.
fn gathered(values: &[f64], shape: [usize; 3], axis: usize, rows: &Rows, count: usize) -> Vec<f64> {
    let stride: usize = shape[axis + 1..].iter().product();
    let mut out = vec![0.0; values.len() / rows.len() * count];
    let blocks = values.chunks(rows.len() * stride).zip(out.chunks_mut(count * stride));
    for (block, out) in blocks {
        for (row, line) in rows.iter().zip(block.chunks(stride)) {
            for &(point, share) in row {
                let to = &mut out[point * stride..(point + 1) * stride];
                to.iter_mut().zip(line).for_each(|(to, value)| *to += share * value);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::ControlMap;
    use crate::basis::AxisBasis;
    use crate::interpolation::Interpolation;

    #[test]
    fn rows_are_the_transposed_map() {
        let axes = [Interpolation::Cardinal, Interpolation::BSpline, Interpolation::Linear]
            .map(|kind| AxisBasis::blender(3, kind).unwrap_or_else(|error| unreachable!("{error}")));
        let weights: Vec<f64> = (0..27).map(|i| 1.0 + f64::from(i % 5)).collect();
        let map = ControlMap::new(&axes, Some(&weights));
        let delta: Vec<f64> = (0..27).map(|i| f64::from((i * 7) % 11) - 5.0).collect();
        let row: Vec<f64> = (0..map.inner_len()).map(|i| ((i * 5) % 13) as f64 - 6.0).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (inside, outside) = (dot(&map.delta(&delta), &row), dot(&delta, &map.row(row.clone())));
        assert!((inside - outside).abs() < 1e-11, "{inside} {outside}");
    }
}
