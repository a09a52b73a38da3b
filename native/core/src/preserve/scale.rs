// SPDX-License-Identifier: GPL-3.0-or-later
//! Sizes below which areas and volumes of the deformed mesh are nothing but rounding.

use glam::DVec3;

/// An axis whose coefficients are smaller than this fraction of the squared extent of the lattice is flat: rounding alone
/// makes coefficients of about 1e-15 of it. A volume smaller than this fraction of the cube is zero but for rounding: it
/// has no sign, and no ratio to another.
const FLAT: f64 = 1e-12;

/// Rounding errors of coordinates, in units of the largest coordinate and of one rounding. A few dozen operations lie between
/// control points and the differences of deformed vertices, but their errors mostly cancel in sums over vertices.
const ROUNDINGS: f64 = 2.0;

/// The size of what a correction moves, and the rounding in it.
#[derive(Debug, Clone)]
pub(crate) struct Scale {
    /// Largest side of the control points' box: an upper bound for the size of what they deform.
    pub(crate) extent: f64,
    /// Rounding error of a coordinate.
    pub(crate) rounding: f64,
    /// How much longer than at rest the lattice is, if it is.
    stretch: f64,
    /// Size of what is measured, as a fraction of the lattice's: all vertices of a small body hang on the same control points by
    /// almost the same weights, and their pulls, which sum to zero, leave only so much of each other.
    fraction: f64,
}

impl Scale {
    /// `epsilon`: relative rounding error of one number in the passes over the mesh.
    pub(crate) fn new(control: &[DVec3], rest: &[DVec3], epsilon: f64) -> Self {
        let (low, high) = crate::lattice::bounds(control);
        let largest = control.iter().chain(rest).map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let (rest_low, rest_high) = crate::lattice::bounds(rest);
        let (extent, at_rest) = ((high - low).max_element(), (rest_high - rest_low).max_element());
        let stretch = if at_rest > 0.0 { (extent / at_rest).max(1.0) } else { 1.0 };
        Self { extent, rounding: ROUNDINGS * epsilon * largest, stretch, fraction: 1.0 }
    }

    /// The same for a body that is so large at rest: rounding of a small body's sums is as small as the body.
    pub(crate) fn of_body(&self, size: f64) -> Self {
        let extent = self.extent.min(size * self.stretch);
        let fraction = if self.extent > 0.0 { extent / self.extent } else { 1.0 };
        Self { extent, fraction, ..self.clone() }
    }

    /// Length of a row of coefficients that is nothing but rounding.
    pub(crate) fn no_area(&self) -> f64 {
        self.least_area() * self.fraction
    }

    /// A volume that is nothing but rounding.
    pub(crate) fn no_volume(&self) -> f64 {
        self.least_area() * (self.extent + self.rounding)
    }

    fn least_area(&self) -> f64 {
        (FLAT * self.extent + self.rounding) * (self.extent + self.rounding)
    }
}
