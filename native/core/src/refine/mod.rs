// SPDX-License-Identifier: GPL-3.0-or-later
//! More control points for the same shape: degrees raised and knots inserted, without any change of the map.

mod axis;
mod rows;

use std::ops::{Add, Mul};

use glam::DVec3;

pub use crate::refine::axis::RefineAxis;

use crate::error::Result;
use crate::lattice::Lattice;
use crate::refine::axis::refined;
use crate::refine::rows::Rows;

/// A lattice and the same with more control points.
#[derive(Debug, Clone)]
pub struct Refinement {
    coarse: Lattice,
    fine: Lattice,
    /// Of each axis, from old control points to new; `None` where the axis stays.
    rows: [Option<Rows>; 3],
}

impl Lattice {
    /// The lattice with higher degrees and more knots. Its domain and its rest shape are the same; [`Refinement::control`] takes
    /// any shape over. An axis with one control point stays as it is. Weights are refined with the control points, in
    /// homogeneous coordinates.
    ///
    /// A uniform axis whose spans are all divided alike is uniform again (a clamped one evenly clamped); otherwise the knots beyond the domain stay where they are.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for a lower degree, fewer control points than there are, knots outside (0, 1) or repeated more
    /// often than the degree, more than [`crate::MAX_POINTS`] control points on an axis, and for an axis of Blender's that is not
    /// linear.
    pub fn refine(&self, to: &[RefineAxis; 3]) -> Result<Refinement> {
        let along = |axis: usize| refined(&self.axes()[axis], &to[axis], ["s", "t", "u"][axis]);
        let ((s, of_s), (t, of_t), (u, of_u)) = (along(0)?, along(1)?, along(2)?);
        let mut fine = Self::new([s, t, u], self.origin(), self.edges())?;
        let rows = [of_s, of_t, of_u];
        if let Some(weights) = self.weights() {
            fine = fine.with_weights(refined_values(weights.to_vec(), self.shape(), &rows))?;
        }
        Ok(Refinement { coarse: self.clone(), fine, rows })
    }
}

impl Refinement {
    /// The lattice with more control points.
    pub fn lattice(&self) -> &Lattice {
        &self.fine
    }

    /// Its control points, `k` fastest, for the shape that `control` gives to the coarse lattice: what is bound to the one moves as what
    /// is bound to the other, to rounding. The rest shape goes to the rest shape to the bit.
    ///
    /// Where weights are equal, or none, [`Lattice::evaluate`] stays too. With unequal ones it does not, for a rational lattice at rest is
    /// not the identity, and no finer one is at rest where it would be.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for a wrong number of control points or non-finite ones.
    pub fn control(&self, control: &[DVec3]) -> Result<Vec<DVec3>> {
        let mut moved = self.coarse.displacement(control)?;
        if let Some(weights) = self.coarse.weights() {
            moved.iter_mut().zip(weights).for_each(|(moved, weight)| *moved *= *weight);
        }
        let mut moved = refined_values(moved, self.coarse.shape(), &self.rows);
        if let Some(weights) = self.fine.weights() {
            moved.iter_mut().zip(weights).for_each(|(moved, weight)| *moved /= *weight);
        }
        Ok(self.fine.rest().into_iter().zip(moved).map(|(rest, moved)| rest + moved).collect())
    }
}

/// What control points carry, taken to those of the refined lattice.
fn refined_values<V>(mut values: Vec<V>, mut shape: [usize; 3], rows: &[Option<Rows>; 3]) -> Vec<V>
where
    V: Copy + Default + Add<Output = V> + Mul<f64, Output = V>,
{
    for (axis, rows) in rows.iter().enumerate() {
        let Some(rows) = rows else { continue };
        let stride: usize = shape[axis + 1..].iter().product();
        let mut out = Vec::with_capacity(values.len() / shape[axis] * rows.len());
        for block in values.chunks(shape[axis] * stride) {
            for row in rows {
                let mut line = vec![V::default(); stride];
                for (input, &share) in block.chunks(stride).zip(row).filter(|(_, share)| **share != 0.0) {
                    line.iter_mut().zip(input).for_each(|(sum, &value)| *sum = *sum + value * share);
                }
                out.append(&mut line);
            }
        }
        values = out;
        shape[axis] = rows.len();
    }
    values
}
