// SPDX-License-Identifier: GPL-3.0-or-later
//! How the size of a correction is measured: what "smallest displacement" means.

/// A quadratic cost of the displacements along one axis, `delta' Q delta`, the same for all three axes.
///
/// Given by a square root of the inverse: with `Q = R' R`, a constraint `row . delta` becomes `(R'^-1 row) . y` for `y = R delta`, and
/// the smallest correction is the shortest `y`.
#[derive(Debug, Clone)]
pub(crate) enum Metric {
    /// `sum w delta^2`, as `1 / sqrt(w)`: 0 for control points that must not move, 1 for the lightest.
    Weighted(Vec<f64>),
}

impl Metric {
    /// The weighted distance of the control points, by reciprocal weights.
    pub(crate) fn weighted(mobility: &[f64]) -> Self {
        Self::Weighted(mobility.iter().map(|w| w.sqrt()).collect())
    }

    /// `R'^-1 row`.
    pub(crate) fn whitened(&self, row: &[f64]) -> Vec<f64> {
        match self {
            Self::Weighted(roots) => row.iter().zip(roots).map(|(c, root)| c * root).collect(),
        }
    }

    /// `y = R delta`.
    pub(crate) fn coordinates(&self, delta: &[f64]) -> Vec<f64> {
        let part = |(d, root): (&f64, &f64)| if *root == 0.0 { 0.0 } else { d / root };
        match self {
            Self::Weighted(roots) => delta.iter().zip(roots).map(part).collect(),
        }
    }

    /// `delta = R^-1 y`.
    pub(crate) fn displacement(&self, y: &[f64]) -> Vec<f64> {
        match self {
            Self::Weighted(roots) => y.iter().zip(roots).map(|(y, root)| y * root).collect(),
        }
    }
}
