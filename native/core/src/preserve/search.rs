// SPDX-License-Identifier: GPL-3.0-or-later
//! What the methods without an order of axes share: all allowed directions at once, as one space to search for the volumes.
//!
//! A correction is a vector `q` in the metric's coordinates, one stretch of control points for each of the orthonormal directions
//! that span the axes with a share. The pins stand on their targets before the search, by the smallest displacement, and every
//! `q` is orthogonal to their rows; so the whole correction's square is that of the pins' part and that of `q` together.

use glam::DVec3;

use crate::preserve::constraints::{add_scaled, norm};
use crate::preserve::correction::Correction;
use crate::preserve::passes::Passes;
use crate::preserve::sweep::{WILD, WILD_OF_SEVERAL, step};

/// A volume this near to its target, relative to the volumes on the way, is a step along one axis away from it that is too short
/// to be seen: what the last step adds to a displacement is of the same relative size.
const SETTLED: f64 = 1e-11;

/// So is a last step this much shorter than the correction, whatever the volumes: pins that hardly differ take digits of the
/// displacement, and a mesh far from the origin takes digits of its volume, but neither shows in the shape.
const UNSEEN: f64 = 1e-7;

/// A correction's search space, at the place where pins alone have brought the mesh.
pub(crate) struct Search<'c, 'a, P> {
    pub(crate) correction: &'c mut Correction<'a, P>,
    /// Axes of the frame with a share.
    axes: Vec<usize>,
    /// Orthonormal directions that span them, in space, and by their coordinates along those axes.
    directions: Vec<(DVec3, Vec<f64>)>,
    /// Control points with the pins on their targets.
    base: Vec<DVec3>,
    /// Volumes there.
    before: Vec<f64>,
    pub(crate) targets: Vec<f64>,
}

/// A place in the search space, and what the mesh measures there.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub(crate) q: Vec<f64>,
    /// Volume of each body, in space.
    pub(crate) volumes: Vec<f64>,
    /// Its gradient, without what would move pins.
    pub(crate) gradients: Vec<Vec<f64>>,
}

impl<'c, 'a, P: Passes> Search<'c, 'a, P> {
    /// Brings the pins to their targets and measures there: the search, and the place `q = 0`.
    pub(crate) fn new(correction: &'c mut Correction<'a, P>) -> Result<(Self, Place), P::Error> {
        (0..3).try_for_each(|axis| correction.pin(axis))?;
        let plan = correction.plan;
        let axes: Vec<usize> = (0..3).filter(|&axis| plan.shares[axis] > 0.0).collect();
        let directions = orthonormal(&axes, &plan.maps()[1].to_cols_array_2d().map(DVec3::from_array));
        let base = correction.control.clone();
        let mut search = Self { correction, axes, directions, base, before: Vec::new(), targets: Vec::new() };
        let start = search.measured(vec![0.0; search.directions.len() * search.base.len()])?;
        search.before.clone_from(&start.volumes);
        search.targets = plan.targets(&start.volumes);
        Ok((search, start))
    }

    /// Goes to `q` and measures there.
    pub(crate) fn evaluate(&mut self, q: Vec<f64>) -> Result<Place, P::Error> {
        self.go(&q)?;
        self.measured(q)
    }

    /// Goes to `q`.
    pub(crate) fn go(&mut self, q: &[f64]) -> Result<(), P::Error> {
        let plan = self.correction.plan;
        let mut along = vec![vec![0.0; self.base.len()]; self.axes.len()];
        for ((_, coordinates), q) in self.directions.iter().zip(q.chunks(self.base.len())) {
            let delta = plan.metric.displacement(q);
            for (along, share) in along.iter_mut().zip(coordinates).filter(|(_, share)| **share != 0.0) {
                add_scaled(along, &delta, *share);
            }
        }
        let mut control = self.base.clone();
        for (&axis, along) in self.axes.iter().zip(&along) {
            control.iter_mut().zip(along).for_each(|(p, d)| plan.frame.move_along(axis, *d, p));
        }
        self.correction.go_to(control)
    }

    /// The `q` that leads to these control points, which have the pins on their targets.
    pub(crate) fn found(&self, control: &[DVec3]) -> Vec<f64> {
        let metric = &self.correction.plan.metric;
        let along = |direction: DVec3| -> Vec<f64> {
            control.iter().zip(&self.base).map(|(p, base)| (*p - *base).dot(direction)).collect()
        };
        self.directions.iter().flat_map(|(direction, _)| metric.coordinates(&along(*direction))).collect()
    }

    fn measured(&mut self, q: Vec<f64>) -> Result<Place, P::Error> {
        let (plan, count) = (self.correction.plan, self.base.len());
        let (mut volumes, mut gradients) = (Vec::new(), Vec::new());
        for (k, &axis) in self.axes.iter().enumerate() {
            let found = self.correction.coefficients(axis)?;
            gradients.resize_with(found.rows.len(), || vec![0.0; q.len()]);
            for (row, gradient) in found.rows.iter().zip(&mut gradients) {
                for ((_, coordinates), part) in self.directions.iter().zip(gradient.chunks_mut(count)) {
                    add_scaled(part, row, coordinates[k] * plan.determinant);
                }
            }
            volumes = found.volumes;
        }
        for part in gradients.iter_mut().flat_map(|gradient| gradient.chunks_mut(count)) {
            let white = plan.metric.whitened(part);
            part.copy_from_slice(&white);
        }
        gradients.iter_mut().for_each(|gradient| self.keep_pins(gradient));
        Ok(Place { q, volumes, gradients })
    }

    /// Takes from `q` what would move pins.
    pub(crate) fn keep_pins(&self, q: &mut [f64]) {
        q.chunks_mut(self.base.len()).for_each(|part| self.correction.plan.pins.basis.project_off(part));
    }

    /// How far each body's volume is from its target.
    pub(crate) fn missing(&self, volumes: &[f64]) -> Vec<f64> {
        self.targets.iter().zip(volumes).map(|(target, volume)| target - volume).collect()
    }

    /// Whether volumes differ from their targets by so little that [`Search::close`] may end the correction.
    pub(crate) fn is_settled(&self, volumes: &[f64]) -> bool {
        self.missing(volumes).iter().enumerate().all(|(body, missing)| {
            let size = self.targets[body].abs() + self.before[body].abs();
            missing.abs() <= SETTLED * size + self.correction.slack(body, self.targets[body])
        })
    }

    /// Whether the shortest step from a place to the targets is nothing beside the correction that led there.
    fn is_unseen(&self, volumes: &[f64], place: &Place) -> bool {
        let mut steps = self.missing(volumes).into_iter().zip(&place.gradients);
        steps.all(|(missing, gradient)| missing.abs() <= UNSEEN * norm(gradient) * norm(&place.q))
    }

    /// Whether the way from here to `q` is too long for any shape.
    pub(crate) fn is_wild(&self, q: &[f64]) -> bool {
        let wild =
            if self.targets.len() == 1 { WILD } else { WILD_OF_SEVERAL } * self.correction.scale.extent;
        let metric = &self.correction.plan.metric;
        q.chunks(self.base.len()).any(|q| metric.displacement(q).iter().any(|d| d.is_nan() || d.abs() > wild))
    }

    /// Makes volumes that are settled exact, where the mesh stands: the pins once more, and one step along an axis, in which the
    /// volume is linear. `like` tells which axis has most to say. Tells whether it could.
    pub(crate) fn close(&mut self, like: &Place) -> Result<bool, P::Error> {
        let order = self.by_strength(like);
        for &axis in &order[1..] {
            self.correction.pin(axis)?;
        }
        for axis in order {
            let now = self.correction.coefficients(axis)?;
            if !self.is_settled(&now.volumes) && !self.is_unseen(&now.volumes, like) {
                return Ok(false);
            }
            let moved = step(self.correction, axis, &now, &self.missing(&now.volumes))?;
            if !moved.contains(&false) {
                return Ok(true);
            }
        }
        let last = self.correction.coefficients(self.axes[0])?;
        Ok((0..self.targets.len()).all(|body| {
            (self.targets[body] - last.volumes[body]).abs() <= self.correction.slack(body, self.targets[body])
        }))
    }

    /// The axes, first the one along which the body that is hardest to change is easiest to change.
    fn by_strength(&self, like: &Place) -> Vec<usize> {
        let count = self.base.len();
        let weakest = |k: usize| {
            let of = |gradient: &Vec<f64>| norm(&gradient[k * count..(k + 1) * count]);
            like.gradients.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        let mut order: Vec<usize> = (0..self.axes.len()).collect();
        order.sort_by(|&a, &b| weakest(b).total_cmp(&weakest(a)));
        order.into_iter().map(|k| self.axes[k]).collect()
    }
}

/// Orthonormal directions with the span of some of three (Gram and Schmidt, twice), and their coordinates along those.
fn orthonormal(axes: &[usize], columns: &[DVec3; 3]) -> Vec<(DVec3, Vec<f64>)> {
    let mut found: Vec<(DVec3, Vec<f64>)> = Vec::with_capacity(axes.len());
    for (k, &axis) in axes.iter().enumerate() {
        let (mut direction, mut coordinates) = (columns[axis], vec![0.0; axes.len()]);
        coordinates[k] = 1.0;
        for _ in 0..2 {
            for (earlier, its_own) in &found {
                let along = direction.dot(*earlier);
                direction -= along * *earlier;
                add_scaled(&mut coordinates, its_own, -along);
            }
        }
        let length = direction.length();
        coordinates.iter_mut().for_each(|coordinate| *coordinate /= length);
        found.push((direction / length, coordinates));
    }
    found
}
