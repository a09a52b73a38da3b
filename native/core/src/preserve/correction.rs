// SPDX-License-Identifier: GPL-3.0-or-later
//! The correction under way: control points that move, and the mesh that moves with them.

use glam::DVec3;

use crate::binding::too_large;
use crate::error::Error;
use crate::preserve::passes::{Coefficients, Mapped, Passes};
use crate::preserve::plan::Plan;
use crate::preserve::scale::Scale;

/// Control points and deformed mesh of one correction. Volumes are in space, coefficients in the frame's coordinates.
pub(crate) struct Correction<'a, P> {
    pub(crate) plan: &'a Plan,
    pub(crate) passes: Mapped<'a, P>,
    pub(crate) control: Vec<DVec3>,
    /// `control - rest`.
    pub(crate) displacement: Vec<DVec3>,
    pub(crate) scale: Scale,
}

impl<'a, P: Passes> Correction<'a, P> {
    /// Starts at the control points asked for; `passes` must hold the mesh as those deform it.
    pub(crate) fn new(plan: &'a Plan, passes: &'a mut P) -> Self {
        let rest: Vec<DVec3> = plan.control.iter().zip(&plan.displacement).map(|(p, d)| p - d).collect();
        let scale = Scale::new(&plan.control, &rest, passes.epsilon());
        let passes = Mapped { passes, map: &plan.map };
        Self { plan, passes, control: plan.control.clone(), displacement: plan.displacement.clone(), scale }
    }

    /// Coefficients of an axis, and the bodies' volumes in space.
    pub(crate) fn coefficients(&mut self, axis: usize) -> Result<Coefficients, P::Error> {
        let mut found = self.passes.coefficients(axis)?;
        found.volumes.iter_mut().for_each(|volume| *volume *= self.plan.determinant);
        if let Some(volume) = found.volumes.iter().find(|volume| !volume.is_finite()) {
            return Err(too_large(*volume).into());
        }
        Ok(found)
    }

    /// Moves the control points along an axis of the frame, and the mesh with them.
    pub(crate) fn shift(&mut self, axis: usize, delta: &[f64]) -> Result<(), P::Error> {
        if let Some(i) = delta.iter().position(|d| !d.is_finite()) {
            return Err(Error::Volume(format!(
                "the correction would move control point {i} by {}: the target is out of reach",
                delta[i]
            ))
            .into());
        }
        self.passes.shift(axis, delta)?;
        for ((point, displacement), d) in self.control.iter_mut().zip(&mut self.displacement).zip(delta) {
            self.plan.frame.move_along(axis, *d, point);
            self.plan.frame.move_along(axis, *d, displacement);
        }
        Ok(())
    }

    /// Takes the control points elsewhere, and the mesh with them.
    pub(crate) fn go_to(&mut self, control: Vec<DVec3>) -> Result<(), P::Error> {
        if let Some(i) = control.iter().position(|p| !p.is_finite()) {
            return Err(Error::Volume(format!(
                "the correction would move control point {i} to {}: the target is out of reach",
                control[i]
            ))
            .into());
        }
        let asked = self.plan.control.iter().zip(&self.plan.displacement);
        self.displacement = control.iter().zip(asked).map(|(p, (asked, d))| d + (p - asked)).collect();
        self.control = control;
        self.passes.deform(&self.displacement)
    }

    /// Back to the control points asked for.
    pub(crate) fn restart(&mut self) -> Result<(), P::Error> {
        self.go_to(self.plan.control.clone())
    }

    /// How far each pin still has to go along an axis of the frame.
    pub(crate) fn residuals(&self, axis: usize) -> Vec<f64> {
        self.plan.pins.residuals(&self.displacement, &self.plan.frame, axis)
    }

    /// Brings the pins to their targets along one axis, by the smallest displacement, whatever the volume.
    pub(crate) fn pin(&mut self, axis: usize) -> Result<(), P::Error> {
        if self.plan.pins.is_empty() {
            return Ok(());
        }
        let residuals = self.residuals(axis);
        let delta = self.plan.pin_step(&residuals);
        self.plan.pins.refuse_wild(&delta, &residuals, self.scale.extent)?;
        self.shift(axis, &delta)
    }

    /// The size of a body and the rounding in it; of a single one, which fills the lattice, that of the lattice.
    pub(crate) fn scale_of(&self, body: usize) -> Scale {
        match self.plan.bound.as_slice() {
            [_] => self.scale.clone(),
            several => self.scale.of_body(2.0 * several[body].radius),
        }
    }

    /// Difference from a body's target that rounding explains, where nothing may move: 4 epsilon A R for each of two sums, and the
    /// rounding of coordinates where a small body stands far from the origin.
    pub(crate) fn slack(&self, body: usize, target: f64) -> f64 {
        let bound = &self.plan.bound[body];
        let sums = 8.0 * self.passes.epsilon() * (bound.area * bound.radius + target.abs());
        if self.plan.bound.len() == 1 { sums } else { sums + self.scale.rounding * bound.area }
    }
}
