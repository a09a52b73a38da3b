// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the search for the nearest correction goes next, by what its last steps taught.

use std::collections::VecDeque;

use crate::preserve::constraints::{add_scaled, dot, norm};
use crate::preserve::nearest::Conditions;
use crate::preserve::search::Place;

/// Steps remembered: more made no measurable difference.
const MEMORY: usize = 8;

/// Curvature, as a fraction of the weights' own, below which a step teaches nothing but that one may go farther.
const FLAT: f64 = 0.05;

/// How far one may then go at most, times the way to where the weights alone would have the minimum.
const MAX_UNIT: f64 = 4.0;

/// What the last steps taught of the Lagrangian's second derivatives (L-BFGS; Nocedal and Wright, *Numerical Optimization*, 7.2).
pub(crate) struct Memory {
    /// Steps along the tangents, changes of the Lagrangian's gradient there, and the reciprocal of their product.
    steps: VecDeque<(Vec<f64>, Vec<f64>, f64)>,
    /// How far to go where nothing is known.
    unit: f64,
}

impl Default for Memory {
    fn default() -> Self {
        Self { steps: VecDeque::new(), unit: 1.0 }
    }
}

impl Memory {
    pub(crate) fn learn(&mut self, there: &Conditions, from: &Place, to: &Place) {
        let difference =
            |new: &[f64], old: &[f64]| -> Vec<f64> { new.iter().zip(old).map(|(n, o)| n - o).collect() };
        let mut step = difference(&to.q, &from.q);
        let mut change = difference(&there.lagrangian(to), &there.lagrangian(from));
        there.basis.project_off(&mut step);
        there.basis.project_off(&mut change);
        let product = dot(&step, &change);
        if product <= FLAT * dot(&step, &step) {
            self.unit = (2.0 * self.unit).min(MAX_UNIT);
            return;
        }
        self.unit = (product / dot(&change, &change)).min(MAX_UNIT);
        self.steps.push_front((step, change, 1.0 / product));
        self.steps.truncate(MEMORY);
    }

    /// Where to go along the tangent space.
    pub(crate) fn direction(&self, here: &Conditions) -> Vec<f64> {
        let mut way = here.tangent.clone();
        let mut shares = Vec::with_capacity(self.steps.len());
        for (step, change, reciprocal) in &self.steps {
            let share = reciprocal * dot(step, &way);
            add_scaled(&mut way, change, -share);
            shares.push(share);
        }
        way.iter_mut().for_each(|value| *value *= self.unit);
        for ((step, change, reciprocal), share) in self.steps.iter().zip(shares).rev() {
            let back = reciprocal * dot(change, &way);
            add_scaled(&mut way, step, share - back);
        }
        here.basis.project_off(&mut way);
        if dot(&way, &here.tangent) < 0.1 * norm(&way) * norm(&here.tangent) {
            here.tangent.clone()
        } else {
            way
        }
    }
}
