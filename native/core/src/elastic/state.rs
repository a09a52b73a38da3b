// SPDX-License-Identifier: GPL-3.0-or-later
//! How an elastic lattice starts, what it carries, and what it adds up to.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::vertices::Outside;

/// A surface that the lattice carries.
#[derive(Debug, Clone, Copy)]
pub struct Carried<'a> {
    /// Its vertices, where the lattice is at rest.
    pub vertices: &'a [[f64; 3]],
    /// Its triangles, closed; without any, no volume is kept.
    pub triangles: &'a [[u32; 3]],
    /// How much of the deformation each vertex takes.
    pub influence: Option<&'a [f64]>,
    /// What vertices outside the domain do.
    pub outside: Outside,
}

/// Where the control points start.
#[derive(Debug, Clone)]
pub struct Start {
    /// Their places.
    pub control: Vec<DVec3>,
    /// Their velocities.
    pub velocity: Vec<DVec3>,
    /// Which of them are led by the caller instead of by forces.
    pub pinned: Vec<bool>,
}

/// Sums over the whole body, for a density of one.
#[derive(Debug, Clone, Copy)]
pub struct Totals {
    /// Mass.
    pub mass: f64,
    /// Centre of mass.
    pub centre: DVec3,
    /// Momentum.
    pub momentum: DVec3,
    /// Angular momentum about the centre of mass.
    pub angular_momentum: DVec3,
    /// Kinetic, elastic and potential energy; the potential is that of height above the origin.
    pub energy: [f64; 3],
}

pub(super) fn check_velocity(velocity: &[DVec3], count: usize) -> Result<()> {
    if velocity.len() != count {
        return Err(Error::Lattice(format!("velocity: found {}, expected {count}", velocity.len())));
    }
    match velocity.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(Error::Lattice(format!("velocity: found NaN or infinity at control point {i}"))),
        None => Ok(()),
    }
}

pub(super) fn check_targets(targets: &[DVec3], inverse_mass: &[f64]) -> Result<()> {
    if targets.len() != inverse_mass.len() {
        return Err(Error::Lattice(format!(
            "targets: found {}, expected {}",
            targets.len(),
            inverse_mass.len()
        )));
    }
    let bad =
        targets.iter().zip(inverse_mass).position(|(target, &weight)| weight == 0.0 && !target.is_finite());
    match bad {
        Some(i) => {
            Err(Error::Lattice(format!("targets: found NaN or infinity at the pinned control point {i}")))
        }
        None => Ok(()),
    }
}
