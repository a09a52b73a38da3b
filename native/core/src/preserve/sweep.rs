// SPDX-License-Identifier: GPL-3.0-or-later
//! The methods that go from axis to axis: the paper's sweep, and its balanced form.
//!
//! The volume is linear in the x coordinates of the control points alone, likewise y and z; so an axis can take its share
//! exactly, by equation (17) in the weighted form of Remark 2, or with pins and other bodies by the form that equation (21) has
//! for one pin. Axes without a share come first, for they move pins only; then the volumes are measured, and the axes with a
//! share follow, pins and volumes together.

use crate::error::Error;
use crate::preserve::constraints::Taken;
use crate::preserve::correction::Correction;
use crate::preserve::passes::{Coefficients, Passes};
use crate::preserve::{Method, Solved};
use crate::words::{bracketed, number};

/// Rounds over the axes at most: one, a second where an axis was flat, a third without those still flat.
const MAX_ROUNDS: u32 = 3;

/// A displacement longer than so many times the control points' box serves no shape: the axis counts as flat.
const WILD: f64 = 1e6;

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
    for round in 1..=MAX_ROUNDS {
        let flat = course.round(correction, &active, &mut measured)?;
        if flat.iter().all(|flat| *flat == [false; 3]) {
            return Ok(course.solved(round));
        }
        if course.is_stuck(&flat) {
            break;
        }
        if round > 1 {
            course.leave_out(&flat);
        }
    }
    let volumes = correction.coefficients(active[0])?.volumes;
    let off = |&body: &usize| {
        (course.targets[body] - volumes[body]).abs() > correction.slack(body, course.targets[body])
    };
    match (0..volumes.len()).find(off) {
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
        let no_volume = correction.scale.no_volume();
        let has_ratio = |(before, target): (&f64, &f64)| before.abs() > no_volume && target / before > 0.0;
        let balanced = method == Method::Balanced && before.iter().zip(&targets).all(has_ratio);
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

    /// Whether some body was flat on every axis that it could use.
    fn is_stuck(&self, flat: &[[bool; 3]]) -> bool {
        self.usable.iter().zip(flat).any(|(usable, flat)| usable == flat)
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
    if plan.amount == 1.0 {
        return Ok(plan.wanted.clone());
    }
    let pinned = if plan.pins.is_empty() { before.to_vec() } else { pinned_volumes(correction, active)? };
    Ok(pinned
        .iter()
        .zip(&plan.wanted)
        .map(|(pinned, wanted)| pinned + plan.amount * (wanted - pinned))
        .collect())
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
/// and (21). Tells which bodies it could change.
fn step<P: Passes>(
    correction: &mut Correction<'_, P>,
    axis: usize,
    now: &Coefficients,
    changes: &[f64],
) -> Result<Vec<bool>, P::Error> {
    let plan = correction.plan;
    let (no_area, wild) = (correction.scale.no_area(), WILD * correction.scale.extent);
    let mut basis = plan.pins.basis.clone();
    let residuals = correction.residuals(axis);
    let mut values = residuals.clone();
    let mut delta = basis.displacement(&plan.metric, &values);
    plan.pins.refuse_wild(&delta, &residuals, correction.scale.extent)?;
    let mut moved = vec![false; changes.len()];
    for (body, row) in now.rows.iter().enumerate() {
        let Taken::Independent(_) = basis.take(plan.metric.whitened(row), no_area) else { continue };
        values.push(changes[body] / plan.determinant);
        let longer = basis.displacement(&plan.metric, &values);
        if longer.iter().any(|d| d.abs() > wild) {
            basis.drop_last();
            values.pop();
        } else {
            (delta, moved[body]) = (longer, true);
        }
    }
    if !delta.is_empty() {
        correction.shift(axis, &delta)?;
    }
    Ok(moved)
}

fn unreachable(course: &Course, body: usize, volume: f64, axes: [f64; 3]) -> Error {
    let what = if course.targets.len() == 1 {
        "the target volume".into()
    } else {
        format!("body {body}: the target volume")
    };
    Error::Volume(format!(
        "{what} {} cannot be reached, only {} can: no displacement that axes {}, weights, pins and frozen layers allow changes the volume further; allow another axis or free control points",
        number(course.targets[body]),
        number(volume),
        bracketed(axes)
    ))
}
