// SPDX-License-Identifier: GPL-3.0-or-later
//! Poses of a lattice mixed by weights (Ferrier).

use glam::DVec3;

use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::words::number;

impl Lattice {
    /// `rest + sum of weight * (set - rest)` over sets of control points, each `k` fastest: relative shape keys. Weights that sum
    /// to 1 interpolate between the sets. Any finite weights are allowed.
    ///
    /// # Errors
    /// [`Error::Lattice`] for another number of weights than of sets, for a weight that is not finite, and for sets that do not
    /// fit the lattice.
    pub fn blend(&self, sets: &[&[DVec3]], weights: &[f64]) -> Result<Vec<DVec3>> {
        if weights.len() != sets.len() {
            return Err(Error::Lattice(format!(
                "weights: found {}, expected one for each of the {} sets of control points",
                weights.len(),
                sets.len()
            )));
        }
        if let Some(i) = weights.iter().position(|weight| !weight.is_finite()) {
            return Err(Error::Lattice(format!(
                "weights: found {} at index {i}, expected finite numbers",
                number(weights[i])
            )));
        }
        sets.iter().try_for_each(|set| self.check_control("sets", set))?;
        let rest = self.rest();
        let mut mixed = rest.clone();
        for (set, &weight) in sets.iter().zip(weights) {
            let moved = set.iter().zip(&rest).map(|(&point, &rest)| point - rest);
            mixed.iter_mut().zip(moved).for_each(|(sum, moved)| *sum += weight * moved);
        }
        Ok(mixed)
    }
}
