// SPDX-License-Identifier: GPL-3.0-or-later
//! A correction that goes only as far as it folds nothing that was unfolded without it.

use glam::DVec3;

use crate::folds::FoldTest;
use crate::lattice::Lattice;
use crate::preserve::correction::Correction;
use crate::preserve::passes::Passes;

/// What the correction must not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Fold a cell of the lattice that is proved unfolded as asked for (with the pins on their targets): the correction goes as much
    /// of its way as leaves all those proved unfolded. Cells that fold already are not held.
    Unfolded,
}

/// Halvings of the way: the part gone is known to a thousandth, nearer than anyone sees.
const HALVINGS: u32 = 10;

/// What must stay unfolded.
#[derive(Debug, Clone)]
pub(crate) struct Unfolded {
    pub(crate) lattice: Lattice,
    /// The shape that folds are measured from, if it is not the lattice's own at rest.
    pub(crate) rest: Option<Vec<DVec3>>,
}

impl Unfolded {
    /// Takes a correction back as far as it must. Says how much volume is then missing, of all bodies together.
    pub(crate) fn hold<P: Passes>(
        &self,
        correction: &mut Correction<'_, P>,
        targets: &[f64],
    ) -> Result<f64, P::Error> {
        let (from, to) = (correction.plan.pinned(), correction.control.clone());
        let test = FoldTest::keeping(&self.lattice, self.rest.as_deref(), &from)?;
        if test.is_unfolded(&to)? {
            return Ok(0.0);
        }
        let at = |share: f64| -> Vec<DVec3> {
            from.iter().zip(&to).map(|(from, to)| *from + share * (*to - *from)).collect()
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if test.is_unfolded(&at(middle))? { low = middle } else { high = middle }
        }
        correction.go_to(if low == 0.0 { from } else { at(low) })?;
        if targets.is_empty() {
            return Ok(0.0);
        }
        let axis = (0..3).find(|&axis| correction.plan.shares[axis] > 0.0).unwrap_or_default();
        let volumes = correction.coefficients(axis)?.volumes;
        Ok(targets.iter().zip(volumes).map(|(target, volume)| target - volume).sum())
    }
}
