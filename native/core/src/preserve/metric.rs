// SPDX-License-Identifier: GPL-3.0-or-later
//! How the size of a correction is measured: what "smallest displacement" means.

use std::sync::Arc;

use crate::preserve::factor::Factor;

/// A quadratic cost of the displacements along one axis, `delta' Q delta`, the same for all three axes.
///
/// Given by a square root: with `Q = R' R`, a constraint `row . delta` becomes `(R'^-1 row) . y` for `y = R delta`, and the smallest
/// correction is the shortest `y`.
#[derive(Debug, Clone)]
pub(crate) struct Metric {
    /// `1 / sqrt(w)`: 0 for control points that must not move, 1 for the lightest.
    roots: Vec<f64>,
    /// Of a cost that couples control points, the root of the unweighted: `Q = sqrt(W) R' R sqrt(W)`. Points that must not move are
    /// not coupled with others in it: their displacements are zero in what the cost measures, not free.
    factor: Option<Arc<Factor>>,
}

impl Metric {
    /// `sum w delta^2`, the weighted distance of the control points, by reciprocal weights.
    pub(crate) fn weighted(mobility: &[f64]) -> Self {
        Self { roots: mobility.iter().map(|w| w.sqrt()).collect(), factor: None }
    }

    /// A cost by its factor, weighted.
    pub(crate) fn factored(factor: Arc<Factor>, mobility: &[f64]) -> Self {
        Self { factor: Some(factor), ..Self::weighted(mobility) }
    }

    /// Whether it is the control points' distance, which no rounding of a factor touches.
    pub(crate) fn is_weighted(&self) -> bool {
        self.factor.is_none()
    }

    /// `R'^-1 row`.
    pub(crate) fn whitened(&self, row: &[f64]) -> Vec<f64> {
        match &self.factor {
            None => row.iter().zip(&self.roots).map(|(c, root)| c * root).collect(),
            Some(factor) => factor.whitened(|point| row[point] * self.roots[point]),
        }
    }

    /// `y = R delta`.
    pub(crate) fn coordinates(&self, delta: &[f64]) -> Vec<f64> {
        let part = |d: f64, root: f64| if root == 0.0 { 0.0 } else { d / root };
        match &self.factor {
            None => delta.iter().zip(&self.roots).map(|(d, root)| part(*d, *root)).collect(),
            Some(factor) => factor.coordinates(|point| part(delta[point], self.roots[point])),
        }
    }

    /// `delta = R^-1 y`.
    pub(crate) fn displacement(&self, y: &[f64]) -> Vec<f64> {
        let weighted = |delta: &[f64]| delta.iter().zip(&self.roots).map(|(d, root)| d * root).collect();
        match &self.factor {
            None => weighted(y),
            Some(factor) => weighted(&factor.displacement(y)),
        }
    }
}
