// SPDX-License-Identifier: GPL-3.0-or-later
//! The methods that go from axis to axis: the paper's sweep, and its balanced form.
//!
//! The volume is linear in the x coordinates of the control points alone, likewise y and z; so an axis can take its share
//! exactly, by equation (17) in the weighted form of Remark 2, or with pins and other bodies by the form that equation (21) has
//! for one pin. Axes without a share come first, for they move pins only; then the volumes are measured, and the axes with a
//! share follow, pins and volumes together.

use crate::error::Error;
use crate::preserve::constraints::{Basis, Solution, Taken};
use crate::preserve::correction::Correction;
use crate::preserve::passes::{Coefficients, Passes};
use crate::preserve::together::{MANY, shortest};
use crate::preserve::{Method, Solved};
use crate::words::{bracketed, number};

/// Rounds over the axes at most: one, a second where an axis was flat, a third without those still flat.
const MAX_ROUNDS: u32 = 3;

/// A displacement longer than so many times the control points' box serves no shape: the axis counts as flat.
pub(crate) const WILD: f64 = 1e6;

/// The same where several bodies are to be changed: what takes a displacement this long is bodies that change almost alike, and none
/// of what it does to the mesh was asked for.
pub(crate) const WILD_OF_SEVERAL: f64 = 1e2;

/// What the volumes of the bodies are to be while axes take their shares.
struct Course {
    method: Method,
    before: Vec<f64>,
    targets: Vec<f64>,
    /// Shares that each body's volume has behind it; they sum to 1.
    done: Vec<f64>,
    /// Axes on which each body's volume can change.
    usable: Vec<[bool; 3]>,
}

/// Corrects from axis to axis.
pub(crate) fn sweep<P: Passes>(
    correction: &mut Correction<'_, P>,
    method: Method,
) -> Result<Solved, P::Error> {
    let shares = correction.plan.shares;
    let active: Vec<usize> = (0..3).filter(|&axis| shares[axis] > 0.0).collect();
    (0..3).filter(|axis| !active.contains(axis)).try_for_each(|axis| correction.pin(axis))?;
    if correction.plan.amount == 0.0 {
        active.iter().try_for_each(|&axis| correction.pin(axis))?;
        let encloses = !correction.plan.wanted.is_empty();
        let targets = if encloses { correction.coefficients(active[0])?.volumes } else { Vec::new() };
        let rounds = u32::from(!correction.plan.pins.is_empty());
        return Ok(Solved { targets, method, rounds });
    }
    let measured = correction.coefficients(active[0])?;
    let mut course = Course::new(correction, method, &measured, &active)?;
    if course.targets == course.before && correction.plan.pins.is_empty() {
        return Ok(course.solved(0));
    }
    let mut measured = Some(measured);
    let mut stuck = Vec::new();
    for round in 1..=MAX_ROUNDS {
        let flat = course.round(correction, &active, &mut measured)?;
        if flat.iter().all(|flat| *flat == [false; 3]) {
            return Ok(course.solved(round));
        }
        stuck = course.stuck(&flat);
        if !stuck.is_empty() {
            break;
        }
        if round > 1 {
            course.leave_out(&flat);
        }
    }
    let volumes = correction.coefficients(active[0])?.volumes;
    let off = |body: &usize| {
        (course.targets[*body] - volumes[*body]).abs() > correction.slack(*body, course.targets[*body])
    };
    match stuck.into_iter().chain(0..volumes.len()).find(off) {
        None => Ok(course.solved(0)),
        Some(body) => Err(unreachable(&course, body, volumes[body], correction.plan.axes).into()),
    }
}

impl Course {
    fn new<P: Passes>(
        correction: &mut Correction<'_, P>,
        method: Method,
        measured: &Coefficients,
        active: &[usize],
    ) -> Result<Self, P::Error> {
        let before = measured.volumes.clone();
        let targets = targets(correction, &before, active)?;
        let has_ratio = |body: usize| {
            before[body].abs() > correction.scale_of(body).no_volume() && targets[body] / before[body] > 0.0
        };
        let balanced = method == Method::Balanced && (0..before.len()).all(has_ratio);
        let usable = [0, 1, 2].map(|axis| active.contains(&axis));
        Ok(Self {
            method: if balanced { Method::Balanced } else { Method::Sweep },
            done: vec![0.0; before.len()],
            usable: vec![usable; before.len()],
            before,
            targets,
        })
    }

    /// All axes once; tells on which axes each body was flat.
    fn round<P: Passes>(
        &mut self,
        correction: &mut Correction<'_, P>,
        active: &[usize],
        measured: &mut Option<Coefficients>,
    ) -> Result<Vec<[bool; 3]>, P::Error> {
        let shares = correction.plan.shares;
        let steps: Vec<f64> = self
            .usable
            .iter()
            .zip(&self.done)
            .map(|(usable, done)| {
                let total: f64 = active.iter().filter(|&&axis| usable[axis]).map(|&axis| shares[axis]).sum();
                (1.0 - done) / total
            })
            .collect();
        let mut flat = vec![[false; 3]; self.done.len()];
        for &axis in active {
            if !self.usable.iter().any(|usable| usable[axis]) {
                correction.pin(axis)?;
                continue;
            }
            let now = match measured.take() {
                Some(measured) => measured,
                None => correction.coefficients(axis)?,
            };
            let next: Vec<f64> = (0..flat.len())
                .map(|body| {
                    let step = if self.usable[body][axis] { steps[body] * shares[axis] } else { 0.0 };
                    self.done[body] + step
                })
                .collect();
            let changes: Vec<f64> =
                (0..flat.len()).map(|body| self.volume_at(body, next[body]) - now.volumes[body]).collect();
            let moved = step(correction, axis, &now, &changes)?;
            for body in 0..flat.len() {
                match moved[body] {
                    true => self.done[body] = next[body],
                    false => flat[body][axis] = self.usable[body][axis],
                }
            }
        }
        Ok(flat)
    }

    /// Volume of a body after so many shares.
    fn volume_at(&self, body: usize, done: f64) -> f64 {
        let (before, target) = (self.before[body], self.targets[body]);
        match self.method {
            // The last step aims at the target itself: shares add up to 1 only to rounding.
            _ if done > 1.0 - 1e-9 => target,
            Method::Balanced => before * (target / before).powf(done),
            _ => before + done * (target - before),
        }
    }

    /// The bodies that were flat on every axis that they could use.
    fn stuck(&self, flat: &[[bool; 3]]) -> Vec<usize> {
        (0..flat.len()).filter(|&body| self.usable[body] == flat[body]).collect()
    }

    fn leave_out(&mut self, flat: &[[bool; 3]]) {
        for (usable, flat) in self.usable.iter_mut().zip(flat) {
            (0..3).for_each(|axis| usable[axis] &= !flat[axis]);
        }
    }

    fn solved(self, rounds: u32) -> Solved {
        Solved { targets: self.targets, method: self.method, rounds }
    }
}

/// Where the volumes are to go: `amount` of the way from those that the pins alone give.
fn targets<P: Passes>(
    correction: &mut Correction<'_, P>,
    before: &[f64],
    active: &[usize],
) -> Result<Vec<f64>, P::Error> {
    let plan = correction.plan;
    // What the pins alone give takes passes to find, and does not matter where the whole way is to be gone.
    if plan.pins.is_empty() || plan.amount == 1.0 {
        return Ok(plan.targets(before));
    }
    Ok(plan.targets(&pinned_volumes(correction, active)?))
}

/// Volumes with the pins on their targets and nothing else done; leaves everything as it was.
fn pinned_volumes<P: Passes>(
    correction: &mut Correction<'_, P>,
    active: &[usize],
) -> Result<Vec<f64>, P::Error> {
    let (control, displacement) = (correction.control.clone(), correction.displacement.clone());
    active.iter().try_for_each(|&axis| correction.pin(axis))?;
    let volumes = correction.coefficients(active[0])?.volumes;
    (correction.control, correction.displacement) = (control, displacement);
    correction.passes.deform(&correction.displacement)?;
    Ok(volumes)
}

/// Brings the pins to their targets and changes the bodies' volumes along one axis, by the smallest displacement: equations (17)
/// and (21). Tells which bodies it could change so.
pub(crate) fn step<P: Passes>(
    correction: &mut Correction<'_, P>,
    axis: usize,
    now: &Coefficients,
    changes: &[f64],
) -> Result<Vec<bool>, P::Error> {
    let plan = correction.plan;
    let wild = if changes.len() == 1 { WILD } else { WILD_OF_SEVERAL } * correction.scale.extent;
    let mut basis = plan.pins.basis.clone();
    let residuals = correction.residuals(axis);
    let mut solution = basis.solve(&residuals);
    let mut delta = plan.metric.displacement(&solution.vector);
    plan.pins.refuse_wild(&delta, &residuals, correction.scale.extent)?;
    if let Some(delta) = all_together(correction, &basis, &solution, now, changes, wild) {
        correction.shift(axis, &delta)?;
        return Ok(vec![true; changes.len()]);
    }
    let mut moved = vec![false; changes.len()];
    let (mut rows, mut values): (Vec<&[f64]>, _) = (Vec::new(), residuals.clone());
    for (body, row) in now.rows.iter().enumerate() {
        let change = changes[body] / plan.determinant;
        match basis.take(plan.metric.whitened(row), correction.scale_of(body).no_area()) {
            Taken::Independent(_) => {
                let mut longer = solution.clone();
                basis.meet(&mut longer, change);
                let longest = plan.metric.displacement(&longer.vector);
                if longest.iter().any(|d| d.abs() > wild) {
                    basis.drop_last();
                } else {
                    (solution, delta, moved[body]) = (longer, longest, true);
                    rows.push(row);
                    values.push(change);
                }
            }
            // Bodies in one place change alike; that is well if they are to.
            Taken::Dependent(coordinates) => {
                let allowed = correction.slack(body, now.volumes[body]) / plan.determinant.abs();
                moved[body] = (solution.product(&coordinates) - change).abs() <= allowed;
            }
            Taken::Zero => {}
        }
    }
    plan.refine(&basis, &rows, &values, &mut delta);
    if !delta.is_empty() {
        correction.shift(axis, &delta)?;
    }
    Ok(moved)
}

/// The displacement for many bodies at once, if there is nothing about any of them that the longer way must tell.
fn all_together<P: Passes>(
    correction: &Correction<'_, P>,
    pins: &Basis,
    solution: &Solution,
    now: &Coefficients,
    changes: &[f64],
    wild: f64,
) -> Option<Vec<f64>> {
    let plan = correction.plan;
    // A cost that couples control points leaves no row short, and what rounding takes of its solutions is put right elsewhere.
    if changes.len() < MANY || !plan.metric.is_weighted() {
        return None;
    }
    let row =
        |(body, row): (usize, &Vec<f64>)| (plan.metric.whitened(row), correction.scale_of(body).no_area());
    let rows: Vec<(Vec<f64>, f64)> = now.rows.iter().enumerate().map(row).collect();
    let values: Vec<f64> = changes.iter().map(|change| change / plan.determinant).collect();
    let delta = plan.metric.displacement(&shortest(pins, solution, &rows, &values)?);
    delta.iter().all(|d| d.abs() <= wild).then_some(delta)
}

fn unreachable(course: &Course, body: usize, volume: f64, axes: [f64; 3]) -> Error {
    let (target, axes) = (number(course.targets[body]), bracketed(axes));
    let volume = number(volume);
    Error::Volume(match course.targets.len() {
        1 => format!(
            "the target volume {target} cannot be reached, only {volume} can: no displacement that axes {axes}, weights, pins and frozen layers allow changes the volume further; allow another axis or free control points"
        ),
        _ => format!(
            "body {body}: the target volume {target} cannot be reached, only {volume} can: no displacement that axes {axes}, weights, pins and frozen layers allow changes it further without changing the other bodies; allow another axis, free control points, or use a lattice with more points"
        ),
    })
}
