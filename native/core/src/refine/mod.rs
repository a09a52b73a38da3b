// SPDX-License-Identifier: GPL-3.0-or-later
//! More control points for the same shape: degrees raised and knots inserted, without any change of the map.

mod axis;
mod rows;

use glam::DVec3;

pub use crate::refine::axis::RefineAxis;

use crate::error::Result;
use crate::lattice::Lattice;
use crate::pieces::contracted;
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
    /// any shape over. An axis with one control point stays as it is.
    ///
    /// A uniform axis whose spans are all divided alike is uniform again; otherwise the knots beyond the domain stay where they are.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for a lower degree, fewer control points than there are, knots outside (0, 1) or repeated more
    /// often than the degree, or more than [`crate::MAX_POINTS`] control points on an axis.
    pub fn refine(&self, to: &[RefineAxis; 3]) -> Result<Refinement> {
        let along = |axis: usize| refined(&self.axes()[axis], &to[axis], ["s", "t", "u"][axis]);
        let ((s, of_s), (t, of_t), (u, of_u)) = (along(0)?, along(1)?, along(2)?);
        let fine = Self::new([s, t, u], self.origin(), self.edges())?;
        Ok(Refinement { coarse: self.clone(), fine, rows: [of_s, of_t, of_u] })
    }
}

impl Refinement {
    /// The lattice with more control points.
    pub fn lattice(&self) -> &Lattice {
        &self.fine
    }

    /// Its control points, `k` fastest, for the shape that `control` gives to the coarse lattice: every parameter is taken where it
    /// was, to rounding. The rest shape goes to the rest shape to the bit.
    ///
    /// # Errors
    /// [`crate::Error::Lattice`] for a wrong number of control points or non-finite ones.
    pub fn control(&self, control: &[DVec3]) -> Result<Vec<DVec3>> {
        let mut values = self.coarse.displacement(control)?;
        let mut shape = self.coarse.shape();
        for (axis, rows) in self.rows.iter().enumerate() {
            if let Some(rows) = rows {
                values = contracted(&values, shape, axis, rows);
                shape[axis] = rows.len();
            }
        }
        Ok(self.fine.rest().into_iter().zip(values).map(|(rest, moved)| rest + moved).collect())
    }
}
