// SPDX-License-Identifier: GPL-3.0-or-later
//! The core's methods with their passes over the mesh on the device: for what one submission of closed forms cannot do, as pins,
//! many volumes, and methods that search.
//!
//! Each pass is a submission of its own; what comes back is one number a control point, and the host does the rest in float64.

use isochor_core::{Binding, Coefficients, DVec3, Passes, Plan, Scalar};

use crate::error::Failure;
use crate::frames::Frames;
use crate::kernels::{Kernel, Resource};
use crate::parts::{Found, Parts};
use crate::twins::two_float;
use crate::types::Frame;

/// A mesh on the device.
pub(crate) struct Uploaded<'a, T> {
    pub(crate) binding: &'a Binding<T>,
    pub(crate) frames: &'a Frames,
    /// Where there are several bodies.
    pub(crate) parts: Option<&'a Parts>,
    /// Length of a unit on the device.
    pub(crate) unit: f64,
}

/// The same while a correction goes on.
pub(crate) struct OnDevice<'a, T> {
    mesh: Uploaded<'a, T>,
    plan: &'a Plan,
    /// Of the correction, but that turn `axis` is the axis itself.
    frame: Frame,
    /// Of the inner control points as they stand; kept for caps only.
    displacement: Vec<DVec3>,
}

impl<'a, T: Scalar> OnDevice<'a, T> {
    /// Deforms the mesh as the plan asks. `frame`: of the correction.
    pub(crate) fn new(mesh: Uploaded<'a, T>, mut frame: Frame, plan: &'a Plan) -> Result<Self, Failure> {
        for (axis, turn) in frame.turns.iter_mut().enumerate() {
            turn.axis = axis as u32;
        }
        let mut passes = Self { mesh, plan, frame, displacement: Vec::new() };
        passes.deform(&plan.inner_displacement())?;
        Ok(passes)
    }

    /// How far every vertex has moved from where it was bound, in units, in the order bound.
    pub(crate) fn moved<R>(&self, read: impl FnOnce(&[[f32; 3]]) -> R) -> Result<R, Failure> {
        self.mesh.frames.dispatch(&[(Kernel::Write, 0)])?;
        Ok(self.mesh.frames.fetch(&[Resource::Moved], |parts| read(bytemuck::cast_slice(parts[0])))?)
    }

    /// Row and volume of the one body, and the volume's origin, in the device's units.
    fn whole(&self, axis: usize) -> Result<(Coefficients, Vec<f64>), Failure> {
        let six = |bytes: &[u8]| -> Vec<f64> {
            let pairs: &[two_float::TwoFloat] = bytemuck::cast_slice(bytes);
            pairs.iter().map(|&pair| two_float::to_f64(pair) / 6.0).collect()
        };
        let wanted = [Resource::Coefficients, Resource::Volumes];
        self.mesh.frames.dispatch(&[(Kernel::Gather, axis)])?;
        let [row, volumes] = self.mesh.frames.fetch(&wanted, |parts| [six(parts[0]), six(parts[1])])?;
        let found = Coefficients { rows: vec![row], volumes: vec![volumes.iter().sum()] };
        Ok((found, vec![f64::from(self.frame.middle[axis])]))
    }

    /// Rows and volumes of several bodies, and the volumes' origins, in the device's units.
    fn by_body(&self, parts: &Parts, axis: usize) -> Result<(Coefficients, Vec<f64>), Failure> {
        let wanted = [Resource::Partials, Resource::Pull, Resource::State];
        Ok(self.mesh.frames.fetch(&wanted, |bytes| {
            let [partials, pull, state] = [0, 1, 2].map(|i| bytemuck::cast_slice::<u8, f32>(bytes[i]));
            let slots = pull.len();
            parts.add_up(&Found { partials, pull, along: &state[axis * slots..(axis + 1) * slots] })
        })?)
    }
}

impl<T: Scalar> Passes for OnDevice<'_, T> {
    type Error = Failure;

    fn epsilon(&self) -> f64 {
        f64::from(f32::EPSILON)
    }

    fn deform(&mut self, displacement: &[DVec3]) -> Result<(), Failure> {
        let control = |d: &DVec3| {
            let [x, y, z] = (*d / self.mesh.unit).as_vec3().to_array();
            [x, y, z, 0.0]
        };
        let controls: Vec<[f32; 4]> = displacement.iter().map(control).collect();
        if self.mesh.binding.has_caps() {
            self.displacement = displacement.to_vec();
        }
        self.mesh.frames.upload(Resource::Frame, 0, bytemuck::bytes_of(&self.frame));
        self.mesh.frames.upload(Resource::Controls, 0, bytemuck::cast_slice(&controls));
        Ok(self.mesh.frames.dispatch(&[(Kernel::Deform, 0)])?)
    }

    fn shift(&mut self, axis: usize, delta: &[f64]) -> Result<(), Failure> {
        let row: Vec<f32> = delta.iter().map(|d| (d / self.mesh.unit) as f32).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&row);
        for (displacement, d) in self.displacement.iter_mut().zip(delta) {
            self.plan.move_along(axis, *d, displacement);
        }
        self.mesh.frames.upload(Resource::Delta, axis * bytes.len(), bytes);
        Ok(self.mesh.frames.dispatch(&[(Kernel::Shift, axis)])?)
    }

    fn coefficients(&mut self, axis: usize) -> Result<Coefficients, Failure> {
        self.mesh.frames.dispatch(&[(Kernel::Gradient, axis), (Kernel::Reduce, axis)])?;
        let (mut found, mut middles) = match self.mesh.parts {
            Some(parts) => self.by_body(parts, axis)?,
            None => self.whole(axis)?,
        };
        let (unit, binding) = (self.mesh.unit, self.mesh.binding);
        found.rows.iter_mut().flatten().for_each(|c| *c *= unit.powi(2));
        found.volumes.iter_mut().for_each(|volume| *volume *= unit.powi(3));
        if binding.has_caps() {
            let [to_frame, _] = self.plan.maps();
            let centre = (to_frame * binding.lattice().centre())[axis];
            middles.iter_mut().for_each(|middle| *middle = centre + unit * *middle);
            let positions = binding.cap_positions(&self.displacement, to_frame)?;
            binding.add_caps(axis, &positions, &middles, &mut found)?;
        }
        Ok(found)
    }
}
