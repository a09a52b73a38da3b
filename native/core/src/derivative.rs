// SPDX-License-Identifier: GPL-3.0-or-later
//! The derivative of a shaped lattice by its parameters.

use std::ops::{Add, Mul};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::net::Net;

/// The spline's functions on an axis that act at a parameter: the first one's inner control point, their values and slopes.
type Acting = (usize, Vec<f64>, Vec<f64>);

/// A sum over control points, and its derivatives by s, t and u.
type Local<V> = (V, [V; 3]);

impl Lattice {
    /// Derivatives by s, t and u, as columns, of [`Lattice::evaluate`] at parameters. Where a basis has a kink, that of the
    /// cell that [`crate::AxisBasis::cell`] gives: the one above, at 1 the one below. Beyond the domain, where points follow
    /// the nearest one inside, the lattice's own edge on that axis (of Blender's bases, beyond what they reach).
    ///
    /// # Errors
    /// [`Error::Lattice`] for a control array of another length or with a non-finite entry, or non-finite parameters.
    pub fn derivative(&self, parameters: &[DVec3], control: &[DVec3]) -> Result<Vec<DMat3>> {
        let net = Net::of(self, control)?;
        if let Some(i) = parameters.iter().position(|p| !p.is_finite()) {
            return Err(Error::Lattice(format!(
                "parameters: found NaN or infinity at index {i}, expected finite numbers"
            )));
        }
        Ok(parameters.par_iter().map(|&p| self.slopes(&net, p)).collect())
    }

    /// Of `base + sum B values / sum B weights`.
    fn slopes(&self, net: &Net<'_>, parameter: DVec3) -> DMat3 {
        let acting = std::array::from_fn(|axis| self.acting(axis, parameter[axis]));
        let (mut value, mut slopes) = self.summed(&net.values, &acting);
        if let Some(weights) = net.weights {
            let (whole, of_whole) = self.summed(weights, &acting);
            value /= whole;
            slopes.iter_mut().zip(of_whole).for_each(|(slope, of)| *slope = (*slope - value * of) / whole);
        }
        let moves = |axis: usize| {
            let follows = self.axes()[axis].count() > 1 && (0.0..=1.0).contains(&parameter[axis]);
            if net.is_displaced || !follows { self.edges().col(axis) } else { DVec3::ZERO }
        };
        let [s, t, u] = std::array::from_fn(|axis| moves(axis) + slopes[axis]);
        DMat3::from_cols(s, t, u)
    }

    fn summed<V>(&self, values: &[V], [s, t, u]: &[Acting; 3]) -> Local<V>
    where
        V: Copy + Default + Add<Output = V> + Mul<f64, Output = V>,
    {
        let [_, nv, nw] = self.map().inner_shape();
        let (mut value, mut slopes) = (V::default(), [V::default(); 3]);
        for (i, (&a, &da)) in s.1.iter().zip(&s.2).enumerate() {
            for (j, (&b, &db)) in t.1.iter().zip(&t.2).enumerate() {
                let line = &values[((s.0 + i) * nv + t.0 + j) * nw + u.0..];
                let sum = |shares: &[f64]| {
                    line.iter().zip(shares).fold(V::default(), |sum, (&point, &share)| sum + point * share)
                };
                let (here, along) = (sum(&u.1), sum(&u.2));
                value = value + here * (a * b);
                slopes =
                    [slopes[0] + here * (da * b), slopes[1] + here * (a * db), slopes[2] + along * (a * b)];
            }
        }
        (value, slopes)
    }

    fn acting(&self, axis: usize, parameter: f64) -> Acting {
        let basis = &self.axes()[axis];
        let clamped = basis.clamped_to_reach(parameter);
        let (cell, taps) = (basis.cell(clamped), basis.degree() + 1);
        let (mut values, mut slopes) = (vec![0.0; taps], vec![0.0; taps]);
        basis.span(cell).evaluate_with_slopes(clamped, &mut values, &mut slopes);
        if clamped != parameter {
            slopes.fill(0.0);
        }
        (basis.first_point(cell), values, slopes)
    }
}
