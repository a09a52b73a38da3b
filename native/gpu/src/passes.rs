// SPDX-License-Identifier: GPL-3.0-or-later
//! The core's methods with their passes over the mesh on the device: for what one submission of closed forms cannot do, as pins,
//! many volumes, and methods that search.
//!
//! Each pass is a submission of its own; what comes back is one number a control point, and the host does the rest in float64.

use isochor_core::{Coefficients, DVec3, Passes, Plan};

use crate::error::Failure;
use crate::frames::Frames;
use crate::kernels::{Kernel, Resource};
use crate::twins::two_float;
use crate::types::Frame;

/// A mesh on the device while a correction goes on.
pub(crate) struct OnDevice<'a> {
    frames: &'a Frames,
    /// Of the correction, but that turn `axis` is the axis itself.
    frame: Frame,
    unit: f64,
}

impl<'a> OnDevice<'a> {
    /// Deforms the mesh as the plan asks. `frame`: of the correction; `unit`: length of a unit on the device.
    pub(crate) fn new(frames: &'a Frames, mut frame: Frame, unit: f64, plan: &Plan) -> Result<Self, Failure> {
        for (axis, turn) in frame.turns.iter_mut().enumerate() {
            turn.axis = axis as u32;
        }
        let mut passes = Self { frames, frame, unit };
        passes.deform(&plan.displacement)?;
        Ok(passes)
    }

    /// How far every vertex has moved from where it was bound, in units, in the order bound.
    pub(crate) fn moved<R>(&self, read: impl FnOnce(&[[f32; 3]]) -> R) -> Result<R, Failure> {
        self.frames.dispatch(&[(Kernel::Write, 0)])?;
        Ok(self.frames.fetch(&[Resource::Moved], |parts| read(bytemuck::cast_slice(parts[0])))?)
    }
}

impl Passes for OnDevice<'_> {
    type Error = Failure;

    fn epsilon(&self) -> f64 {
        f64::from(f32::EPSILON)
    }

    fn deform(&mut self, displacement: &[DVec3]) -> Result<(), Failure> {
        let control = |d: &DVec3| {
            let [x, y, z] = (*d / self.unit).as_vec3().to_array();
            [x, y, z, 0.0]
        };
        let controls: Vec<[f32; 4]> = displacement.iter().map(control).collect();
        self.frames.upload(Resource::Frame, 0, bytemuck::bytes_of(&self.frame));
        self.frames.upload(Resource::Controls, 0, bytemuck::cast_slice(&controls));
        Ok(self.frames.dispatch(&[(Kernel::Deform, 0)])?)
    }

    fn shift(&mut self, axis: usize, delta: &[f64]) -> Result<(), Failure> {
        let row: Vec<f32> = delta.iter().map(|d| (d / self.unit) as f32).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&row);
        self.frames.upload(Resource::Delta, axis * bytes.len(), bytes);
        Ok(self.frames.dispatch(&[(Kernel::Shift, axis)])?)
    }

    fn coefficients(&mut self, axis: usize) -> Result<Coefficients, Failure> {
        self.frames.dispatch(&[(Kernel::Gradient, axis), (Kernel::Reduce, axis), (Kernel::Gather, axis)])?;
        let six = |bytes: &[u8]| -> Vec<f64> {
            let pairs: &[two_float::TwoFloat] = bytemuck::cast_slice(bytes);
            pairs.iter().map(|&pair| two_float::to_f64(pair) / 6.0).collect()
        };
        let wanted = [Resource::Coefficients, Resource::Volumes];
        let [row, volumes] = self.frames.fetch(&wanted, |parts| [six(parts[0]), six(parts[1])])?;
        Ok(Coefficients {
            rows: vec![row.iter().map(|c| c * self.unit.powi(2)).collect()],
            volumes: vec![volumes.iter().sum::<f64>() * self.unit.powi(3)],
        })
    }
}
