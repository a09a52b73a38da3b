// SPDX-License-Identifier: GPL-3.0-or-later
//! What an elastic lattice is made of.

use glam::DVec3;

use super::ground::Ground;
use crate::error::{Error, Result};
use crate::words::{bracketed, number};

/// What the body is made of and where it is.
#[derive(Debug, Clone)]
pub struct Material {
    /// Oscillations a second of the free lattice's slowest stretch along its longest side `L`. It is stiffness without a
    /// size or a mass: the wave speed is `2 L frequency`, Young's modulus `density (2 L frequency)²`.
    pub frequency: f64,
    /// Damping ratio of that oscillation: 0 for none, 1 for critical.
    pub damping: f64,
    /// Acceleration of everything.
    pub gravity: DVec3,
    /// The ground, if there is any.
    pub ground: Option<Ground>,
    /// Factor of the volume that the surface has at rest.
    pub volume: f64,
    /// Substeps of a call to [`Elastic::step`] at least; stiff material takes more.
    pub substeps: u32,
}

/// The material with its ground's normal at length one, refused where it is none.
pub(super) fn checked(mut material: Material) -> Result<Material> {
    let wrong = |what: &str, found: String, expected: &str| {
        Err(Error::Elastic(format!("{what}: found {found}, expected {expected}")))
    };
    if !(material.frequency.is_finite() && material.frequency > 0.0) {
        return wrong("frequency", number(material.frequency), "a positive number of oscillations a second");
    }
    if !(material.damping.is_finite() && material.damping >= 0.0) {
        return wrong("damping", number(material.damping), "a damping ratio of 0 or more");
    }
    if !material.gravity.is_finite() {
        return wrong("gravity", bracketed(material.gravity.to_array()), "three finite numbers");
    }
    if !(material.volume.is_finite() && material.volume > 0.0) {
        return wrong("volume", number(material.volume), "a positive factor of the volume at rest");
    }
    if material.substeps == 0 {
        return wrong("substeps", material.substeps.to_string(), "at least 1");
    }
    if let Some(ground) = &mut material.ground {
        let length = ground.normal.length();
        if !(ground.point.is_finite() && ground.normal.is_finite() && length > 0.0 && length.is_finite()) {
            let plane = [ground.point, ground.normal].map(|part| bracketed(part.to_array())).join(" and ");
            return wrong("ground", plane, "a point and a normal of length above 0, all finite");
        }
        if !(ground.friction.is_finite() && ground.friction >= 0.0) {
            return wrong("friction", number(ground.friction), "a coefficient of 0 or more");
        }
        ground.normal /= length;
    }
    Ok(material)
}
