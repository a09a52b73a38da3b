// SPDX-License-Identifier: GPL-3.0-or-later
//! The costs of a correction other than the control points' own distance, factorised once (the paper's Remark 1).

use std::sync::{Arc, Mutex, PoisonError};

use crate::binding::Binding;
use crate::error::Result;
use crate::preserve::bending::bending;
use crate::preserve::factor::Factor;
use crate::preserve::metric::Metric;
use crate::preserve::surface_cost::surface;
use crate::vertices::Scalar;

/// What the correction keeps small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cost {
    /// How far the control points move.
    #[default]
    Points,
    /// How far the vertices of the mesh move.
    Surface,
    /// How much space is bent: the energy of a thin plate in three dimensions, over the lattice at rest. Affine displacements cost
    /// nothing.
    Bending,
}

/// What moving a control point costs by itself, as a fraction of what it costs on average by moving the surface. Points that the mesh
/// hardly feels fly off without: a ball's in a lattice of 4 x 4 x 4 by 40 times its size at 1e-6, by 2 here, while the surface moves
/// 8 against 6 where the points' cost moves it 10.
const SURFACE_REGULARISATION: f64 = 1e-3;

/// What affine displacements cost, as a fraction of what single control points cost on average: less than the softest bend of a
/// lattice of 25 points an axis by a factor of thousands, and enough to leave float64 seven digits.
const BENDING_REGULARISATION: f64 = 1e-9;

/// Factors kept: both costs, each with two sets of frozen points.
const KEPT: usize = 4;

/// A cost, and the control points that may move.
type Key = (Cost, Vec<bool>);

/// The factors of a binding's costs, made when first used.
#[derive(Debug, Default)]
pub(crate) struct Costs(Mutex<Vec<(Key, Arc<Factor>)>>);

impl Costs {
    /// The factor, made at the first call for this cost and these points. Others who want one wait.
    fn factor<T: Scalar>(&self, binding: &Binding<T>, key: Key) -> Result<Arc<Factor>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, factor)) = kept.iter().find(|(known, _)| *known == key) {
            return Ok(Arc::clone(factor));
        }
        let (band, regularisation) = match key.0 {
            Cost::Surface => (surface(binding)?, SURFACE_REGULARISATION),
            _ => (bending(binding.lattice())?, BENDING_REGULARISATION),
        };
        let factor = Arc::new(Factor::new(&band, &key.1, regularisation, binding.lattice())?);
        kept.insert(0, (key, Arc::clone(&factor)));
        kept.truncate(KEPT);
        Ok(factor)
    }
}

impl<T: Scalar> Binding<T> {
    /// How corrections are measured, with control points of these reciprocal weights.
    pub(crate) fn metric(&self, cost: Cost, mobility: &[f64]) -> Result<Metric> {
        if cost == Cost::Points {
            return Ok(Metric::weighted(mobility));
        }
        let free = mobility.iter().map(|mobility| *mobility > 0.0).collect();
        Ok(Metric::factored(self.costs().factor(self, (cost, free))?, mobility))
    }
}
