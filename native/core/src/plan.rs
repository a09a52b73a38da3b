// SPDX-License-Identifier: GPL-3.0-or-later
//! A correction checked and prepared, for another backend to carry out.

use glam::{DMat3, DVec3};

use crate::binding::Binding;
use crate::error::Result;
use crate::preserve::{Frame, Preserve, normalised_shares};
use crate::vertices::Scalar;

/// Everything that a correction needs beside the binding's fixed data, in the lattice's space unless said otherwise.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Shares of the three axes of the frame, not negative; they sum to 1.
    pub shares: [f64; 3],
    /// `control - rest`, `k` fastest.
    pub displacement: Vec<DVec3>,
    /// Reciprocal weights of the control points, 0 for those that must not move, at most 1.
    pub mobility: Vec<f64>,
    /// Volume to reach at amount 1.
    pub wanted: f64,
    /// Volume in space over volume in the frame's coordinates.
    pub determinant: f64,
    /// Mean of the control points, in the frame's coordinates.
    pub middle: DVec3,
    frame: Frame,
}

impl<T: Scalar> Binding<T> {
    /// Checks `control` and `options` as [`Binding::preserve`] does, and prepares the correction.
    ///
    /// # Errors
    /// As [`Binding::preserve`], but for a target out of reach, which only the correction itself finds.
    pub fn plan(&self, control: &[DVec3], options: &Preserve) -> Result<Plan> {
        let frame = Frame::new(options.frame)?;
        Ok(Plan {
            shares: normalised_shares(options.axes)?,
            mobility: self.mobility(options.weights.as_deref())?,
            wanted: self.wanted_volume(options)?,
            displacement: self.displacement(control)?,
            determinant: frame.determinant,
            middle: frame.coordinates(control.iter().sum::<DVec3>() / control.len() as f64),
            frame,
        })
    }
}

impl Plan {
    /// The map to the frame's coordinates and the map back.
    pub fn maps(&self) -> [DMat3; 2] {
        self.frame.directions.map_or([DMat3::IDENTITY; 2], |(columns, inverse)| [inverse, columns])
    }

    /// Moves a control point along an axis of the frame.
    pub fn move_along(&self, axis: usize, distance: f64, point: &mut DVec3) {
        self.frame.move_along(axis, distance, point);
    }
}
