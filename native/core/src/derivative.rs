// SPDX-License-Identifier: GPL-3.0-or-later
//! The derivative of a shaped lattice by its parameters.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::lattice::Lattice;

/// The basis functions of an axis that act at a parameter: the first one's control point, their values and slopes.
type Acting = (usize, Vec<f64>, Vec<f64>);

impl Lattice {
    /// Derivatives by s, t and u, as columns, of [`Lattice::evaluate`] at parameters. Where a basis has a kink, that of the
    /// cell that [`crate::AxisBasis::cell`] gives: the one above, at 1 the one below. Beyond the domain, where points follow
    /// the nearest one inside, the lattice's own edge on that axis.
    ///
    /// # Errors
    /// [`Error::Lattice`] for a control array of another length or with a non-finite entry, or non-finite parameters.
    pub fn derivative(&self, parameters: &[DVec3], control: &[DVec3]) -> Result<Vec<DMat3>> {
        let displacement = self.displacement(control)?;
        if let Some(i) = parameters.iter().position(|p| !p.is_finite()) {
            return Err(Error::Lattice(format!(
                "parameters: found NaN or infinity at index {i}, expected finite numbers"
            )));
        }
        Ok(parameters.par_iter().map(|&p| self.edges() + self.slopes(&displacement, p)).collect())
    }

    /// Derivatives of `sum B(clamp p) values`, as columns.
    fn slopes(&self, values: &[DVec3], parameter: DVec3) -> DMat3 {
        let [_, nv, nw] = self.shape();
        let [s, t, u] = std::array::from_fn(|axis| self.acting(axis, parameter[axis]));
        let mut sum = DMat3::ZERO;
        for (i, (a, da)) in s.1.iter().zip(&s.2).enumerate() {
            for (j, (b, db)) in t.1.iter().zip(&t.2).enumerate() {
                let row = &values[((s.0 + i) * nv + t.0 + j) * nw + u.0..];
                let (mut value, mut slope) = (DVec3::ZERO, DVec3::ZERO);
                for (&point, (c, dc)) in row.iter().zip(u.1.iter().zip(&u.2)) {
                    value += point * *c;
                    slope += point * *dc;
                }
                sum.x_axis += value * (da * b);
                sum.y_axis += value * (a * db);
                sum.z_axis += slope * (a * b);
            }
        }
        sum
    }

    fn acting(&self, axis: usize, parameter: f64) -> Acting {
        let basis = &self.axes()[axis];
        let clamped = parameter.clamp(0.0, 1.0);
        let (cell, taps) = (basis.cell(clamped), basis.degree() + 1);
        let (mut values, mut slopes) = (vec![0.0; taps], vec![0.0; taps]);
        basis.span(cell).evaluate_with_slopes(clamped, &mut values, &mut slopes);
        if clamped != parameter {
            slopes.fill(0.0);
        }
        (basis.first_point(cell), values, slopes)
    }
}
