// SPDX-License-Identifier: GPL-3.0-or-later
//! A lattice in one shape, as what its inner control points carry: a spline, or a quotient of two, over what no control point moves.

use glam::{DMat3, DVec3};

use crate::error::Result;
use crate::lattice::Lattice;

/// The map `base(p) + sum B(p) values / sum B(p) weights`, over the lattice's inner control points.
///
/// In the *displaced* form, `base` is the undeformed point and values are displacements: how the vertices of a mesh move that was bound
/// to the lattice at rest. Where weights are unequal, values are `w P` in the other form, the rational map itself, and `base` only
/// what lies beyond the domain, or along an axis with one control point.
pub(crate) struct Net<'a> {
    lattice: &'a Lattice,
    pub(crate) values: Vec<DVec3>,
    pub(crate) weights: Option<&'a [f64]>,
    pub(crate) is_displaced: bool,
}

impl<'a> Net<'a> {
    /// The displaced form of a lattice with displaced control points (`control - rest`).
    pub(crate) fn displaced(lattice: &'a Lattice, displacement: &[DVec3]) -> Self {
        Self::new(lattice, displacement, true)
    }

    /// Of displacements, or of control points for the other form.
    pub(crate) fn new(lattice: &'a Lattice, carried: &[DVec3], is_displaced: bool) -> Self {
        let values = lattice.map().displacement(carried).into_owned();
        Self { lattice, values, weights: lattice.map().inner_weights(), is_displaced }
    }

    /// The map that the lattice shaped by `control` is.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for another number of control points, or ones that are not finite.
    pub(crate) fn of(lattice: &'a Lattice, control: &[DVec3]) -> Result<Self> {
        if !lattice.is_rational_map() {
            return Ok(Self::displaced(lattice, &lattice.displacement(control)?));
        }
        lattice.check_control("control", control)?;
        Ok(Self::new(lattice, control, false))
    }

    /// Where the map takes parameters; those beyond reach follow the nearest within.
    pub(crate) fn at(&self, parameter: DVec3) -> DVec3 {
        let lattice = self.lattice;
        let sum = lattice.interpolated(&self.values, parameter);
        let moved = match self.weights {
            Some(weights) => sum / lattice.interpolated(weights, parameter),
            None => sum,
        };
        if self.is_displaced {
            return lattice.point(parameter) + moved;
        }
        moved + lattice.edges() * self.base(parameter)
    }

    /// Of the rational map itself, in parameters, what no control point moves.
    pub(crate) fn base(&self, parameter: DVec3) -> DVec3 {
        let left = |axis: usize| {
            let t = parameter[axis];
            if self.lattice.axes()[axis].count() > 1 { t - t.clamp(0.0, 1.0) } else { t - 0.5 }
        };
        DVec3::new(left(0), left(1), left(2))
    }

    /// The derivative, by parameters inside the domain, of what no control point moves.
    pub(crate) fn base_slope(&self) -> DMat3 {
        let mut slope = self.lattice.edges();
        let moves = |axis: usize| !self.is_displaced && self.lattice.axes()[axis].count() > 1;
        (0..3).filter(|&axis| moves(axis)).for_each(|axis| *slope.col_mut(axis) = DVec3::ZERO);
        slope
    }
}
