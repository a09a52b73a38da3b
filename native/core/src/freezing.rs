// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of control points that hold still, so that what a lattice moves joins what lies beyond its faces.

use std::borrow::Cow;

use glam::DVec3;

use crate::binding::Binding;
use crate::error::Result;
use crate::lattice::Lattice;
use crate::vertices::{Outside, Scalar};

impl Lattice {
    /// The control points, `k` fastest, that must stay at rest where the moved part is to join what does not move beyond these faces
    /// (lower and upper of s, t, u) with derivatives up to an order: [`crate::AxisBasis::end_layers`] layers at each.
    pub fn frozen(&self, continuity: usize, faces: [[bool; 2]; 3]) -> Vec<bool> {
        let shape = self.shape();
        let along = |axis: usize| -> Vec<bool> {
            let (basis, [lower, upper]) = (&self.axes()[axis], faces[axis]);
            let below = if lower { basis.end_layers(false, continuity) } else { 0 };
            let above = if upper { basis.end_layers(true, continuity) } else { 0 };
            (0..basis.count()).map(|i| i < below || i >= basis.count() - above).collect()
        };
        let [s, t, u] = [along(0), along(1), along(2)];
        let is_frozen =
            |p: usize| s[p / (shape[1] * shape[2])] || t[p / shape[2] % shape[1]] || u[p % shape[2]];
        (0..self.len()).map(is_frozen).collect()
    }
}

impl<T: Scalar> Binding<T> {
    /// Control points that neither the correction nor, where a continuity is wanted, anyone may move: with vertices kept beyond a face, the
    /// layers acting on that face, or the mesh would tear there.
    pub(crate) fn frozen(&self) -> Vec<bool> {
        let faces = match self.outside() {
            Outside::Keep => self.embedding().beyond,
            Outside::Extend => Default::default(),
        };
        self.lattice().frozen(self.continuity.unwrap_or(0), faces)
    }

    /// The control points that count of those given: frozen ones are at rest, where a continuity is wanted.
    ///
    /// # Errors
    /// As [`Binding::deform`].
    pub fn held<'a>(&self, control: &'a [DVec3]) -> Result<Cow<'a, [DVec3]>> {
        self.check_control(control)?;
        if self.continuity.is_none() {
            return Ok(Cow::Borrowed(control));
        }
        let at = |((point, rest), is_frozen): ((&DVec3, DVec3), bool)| if is_frozen { rest } else { *point };
        Ok(control.iter().zip(self.rest()).zip(self.frozen()).map(at).collect())
    }
}
