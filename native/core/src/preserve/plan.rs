// SPDX-License-Identifier: GPL-3.0-or-later
//! A correction checked and prepared, for whichever backend carries it out.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::binding::Binding;
use crate::control_map::ControlMap;
use crate::error::{Error, Result};
use crate::preserve::constraints::{Basis, add_scaled, dot};
use crate::preserve::frame::{Frame, normalised_shares};
use crate::preserve::limit::{Limit, Unfolded};
use crate::preserve::metric::Metric;
use crate::preserve::pins::PinRows;
use crate::preserve::{Method, Preserve};
use crate::surface::Measure;
use crate::vertices::Scalar;
use crate::words::number;

/// Everything that a correction needs beside the binding's fixed data, in the lattice's space unless said otherwise.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Shares of the three axes as given.
    pub axes: [f64; 3],
    /// The same, made to sum to 1.
    pub shares: [f64; 3],
    /// The control points asked for, `k` fastest.
    pub control: Vec<DVec3>,
    /// `control - rest`, `k` fastest.
    pub displacement: Vec<DVec3>,
    /// To inner control points, which backends know.
    pub(crate) map: Arc<ControlMap>,
    /// Reciprocal weights of the control points, 0 for those that must not move, at most 1.
    pub mobility: Vec<f64>,
    /// Volume of each body to reach at amount 1.
    pub wanted: Vec<f64>,
    /// How much of the way to that.
    pub amount: f64,
    /// The method asked for.
    pub method: Method,
    /// Volume in space over volume in the frame's coordinates.
    pub determinant: f64,
    /// Mean of the control points, in the frame's coordinates.
    pub middle: DVec3,
    pub(crate) frame: Frame,
    pub(crate) metric: Metric,
    pub(crate) pins: PinRows,
    /// What must stay unfolded, where that is wanted.
    pub(crate) unfolded: Option<Unfolded>,
    /// The bodies as bound; none where pins alone are wanted of a mesh that encloses nothing.
    pub(crate) bound: Vec<Measure>,
    /// Whether caps are part of a body.
    capped: bool,
}

impl<T: Scalar> Binding<T> {
    /// Checks `control` and `options` and prepares the correction.
    ///
    /// # Errors
    /// As [`Binding::preserve`], but for a target out of reach, which only the correction itself finds.
    pub fn plan(&self, control: &[DVec3], options: &Preserve) -> Result<Plan> {
        let frame = Frame::new(options.frame)?;
        let shares = normalised_shares(options.axes)?;
        let mobility = self.mobility(options.weights.as_deref())?;
        let metric = self.metric(options.cost, &mobility)?;
        let (wanted, bound) = self.wanted_volumes(options)?;
        let displacement = self.displacement(control)?;
        Ok(Plan {
            axes: options.axes,
            shares,
            control: control.to_vec(),
            displacement,
            map: Arc::clone(self.lattice().shared_map()),
            wanted,
            amount: options.amount,
            method: options.method,
            determinant: frame.determinant,
            middle: frame.coordinates(control.iter().sum::<DVec3>() / control.len() as f64),
            pins: PinRows::new(self, &options.pins, &metric)?,
            mobility,
            frame,
            metric,
            capped: !bound.is_empty() && self.has_caps(),
            bound,
            unfolded: options.limit.map(|Limit::Unfolded| self.unfolded()),
        })
    }

    /// What a correction must leave unfolded.
    fn unfolded(&self) -> Unfolded {
        Unfolded { lattice: self.lattice().clone(), rest: self.shaped_rest().map(<[DVec3]>::to_vec) }
    }

    /// Reciprocal weights: 0 for control points that must not move.
    fn mobility(&self, weights: Option<&[f64]>) -> Result<Vec<f64>> {
        let count = self.lattice().len();
        if let Some(weights) = weights {
            if weights.len() != count {
                return Err(Error::Lattice(format!(
                    "weights: found {} values, expected {count} for a lattice of shape {:?}",
                    weights.len(),
                    self.lattice().shape()
                )));
            }
            if let Some(i) = weights.iter().position(|w| w.is_nan() || *w <= 0.0) {
                return Err(Error::Lattice(format!(
                    "weights: found {} at control point {i}, expected positive numbers (infinity freezes)",
                    number(weights[i])
                )));
            }
        }
        let free = self.correctable();
        let lightest = weights.map_or(1.0, |all| all.iter().copied().fold(f64::INFINITY, f64::min));
        // Only ratios of weights matter; scaled by the lightest, none under- or overflows.
        let mobility = |p: usize| match weights {
            _ if !free[p] => 0.0,
            Some(all) if all[p].is_finite() => lightest / all[p],
            Some(_) => 0.0,
            None => 1.0,
        };
        Ok((0..count).map(mobility).collect())
    }
}

impl Plan {
    /// Displacements of the inner control points for `displacement`.
    pub fn inner_displacement(&self) -> Cow<'_, [DVec3]> {
        self.map.displacement(&self.displacement)
    }

    /// The map to the frame's coordinates and the map back.
    pub fn maps(&self) -> [DMat3; 2] {
        self.frame.directions.map_or([DMat3::IDENTITY; 2], |(columns, inverse)| [inverse, columns])
    }

    /// Moves a control point along an axis of the frame.
    pub fn move_along(&self, axis: usize, distance: f64, point: &mut DVec3) {
        self.frame.move_along(axis, distance, point);
    }

    /// The smallest displacement along one axis that moves the pins by `ways`.
    pub(crate) fn pin_step(&self, ways: &[f64]) -> Vec<f64> {
        let mut delta = self.pins.basis.displacement(&self.metric, ways);
        self.refine(&self.pins.basis, &[], ways, &mut delta);
        delta
    }

    /// The control points asked for, brought to where the pins are on their targets, by the smallest displacement.
    pub(crate) fn pinned(&self) -> Vec<DVec3> {
        let mut control = self.control.clone();
        for axis in 0..3 {
            let delta = self.pin_step(&self.pins.residuals(&self.displacement, &self.frame, axis));
            control.iter_mut().zip(delta).for_each(|(point, d)| self.frame.move_along(axis, d, point));
        }
        control
    }

    /// Where the volumes are to go: `amount` of the way from those that the pins alone give.
    pub(crate) fn targets(&self, pinned: &[f64]) -> Vec<f64> {
        if self.amount == 1.0 {
            return self.wanted.clone();
        }
        let towards = |(pinned, wanted): (&f64, &f64)| pinned + self.amount * (wanted - pinned);
        pinned.iter().zip(&self.wanted).map(towards).collect()
    }

    /// Whether the correction may end before it has reached the volumes wanted.
    pub fn is_limited(&self) -> bool {
        self.unfolded.is_some()
    }

    /// Puts right what the roots of a cost that couples control points lose to rounding, of the smallest displacement along one axis by
    /// which the pins and some bodies' volumes, whose rows `basis` has taken in, are to change by `values`.
    pub(crate) fn refine(&self, basis: &Basis, bodies: &[&[f64]], values: &[f64], delta: &mut [f64]) {
        if self.metric.is_weighted() || delta.is_empty() {
            return;
        }
        let reached = self.pins.moved(delta).into_iter().chain(bodies.iter().map(|row| dot(row, delta)));
        let lost: Vec<f64> = values.iter().zip(reached).map(|(value, reached)| value - reached).collect();
        add_scaled(delta, &basis.displacement(&self.metric, &lost), 1.0);
    }

    /// Whether the volume of one body without caps is all that is wanted, by shares of the axes: nothing that a closed form without
    /// rows of constraints could not do.
    pub fn is_plain(&self) -> bool {
        self.pins.is_empty()
            && self.wanted.len() == 1
            && !self.capped
            && self.metric.is_weighted()
            && self.unfolded.is_none()
            && matches!(self.method, Method::Sweep | Method::Balanced)
    }

    /// The sum of the volumes wanted.
    pub fn wanted_in_all(&self) -> f64 {
        self.wanted.iter().sum()
    }
}
