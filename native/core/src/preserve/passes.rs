// SPDX-License-Identifier: GPL-3.0-or-later
//! What a correction does with the mesh, so that one set of methods serves every backend.

use glam::DVec3;

use crate::binding::Binding;
use crate::control_map::ControlMap;
use crate::engine::{Engine, State, numbers};
use crate::error::{Error, Result};
use crate::lanes::Lanes;
use crate::preserve::frame::Frame;
use crate::preserve::plan::Plan;
use crate::vertices::Scalar;

/// The paper's coefficients (10)-(12) of one axis, for every body.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficients {
    /// Change of each body's volume with the coordinate of each control point along the axis: bodies x control points.
    pub rows: Vec<Vec<f64>>,
    /// Volume of each body.
    pub volumes: Vec<f64>,
}

/// The passes over a bound mesh that corrections are made of.
///
/// Coordinates, areas and volumes are those of the correction's frame: the columns of [`crate::Plan::maps`] are its directions. A
/// backend keeps the deformed vertices; nothing else looks at them. Control points are *inner* ones here ([`crate::ControlMap`]): a
/// backend need not know of weights, nor of bases that are no B-splines.
pub trait Passes {
    /// What can go wrong: the core's errors, and the backend's own.
    type Error: From<Error>;

    /// Relative rounding error of one number in the passes.
    fn epsilon(&self) -> f64;

    /// Deforms all vertices anew: equation (1), by displacements of the inner control points, in space.
    ///
    /// # Errors
    /// The backend's own.
    fn deform(&mut self, displacement: &[DVec3]) -> std::result::Result<(), Self::Error>;

    /// Adds `influence * B delta` to one coordinate of all vertices; `delta` of the inner control points.
    ///
    /// # Errors
    /// The backend's own.
    fn shift(&mut self, axis: usize, delta: &[f64]) -> std::result::Result<(), Self::Error>;

    /// The coefficients of one axis, for the vertices as they stand and inner control points.
    ///
    /// # Errors
    /// [`Error::Mesh`] where the triangles enclose no volume, and the backend's own.
    fn coefficients(&mut self, axis: usize) -> std::result::Result<Coefficients, Self::Error>;
}

/// Passes of a backend in terms of the lattice's own control points: the one place where corrections meet inner ones.
pub(crate) struct Mapped<'a, P> {
    pub(crate) passes: &'a mut P,
    pub(crate) map: &'a ControlMap,
}

impl<P: Passes> Passes for Mapped<'_, P> {
    type Error = P::Error;

    fn epsilon(&self) -> f64 {
        self.passes.epsilon()
    }

    fn deform(&mut self, displacement: &[DVec3]) -> std::result::Result<(), P::Error> {
        self.passes.deform(&self.map.displacement(displacement))
    }

    fn shift(&mut self, axis: usize, delta: &[f64]) -> std::result::Result<(), P::Error> {
        self.passes.shift(axis, &self.map.delta(delta))
    }

    fn coefficients(&mut self, axis: usize) -> std::result::Result<Coefficients, P::Error> {
        self.passes.coefficients(axis).map(|found| self.map.coefficients(found))
    }
}

/// The passes on the CPU.
pub(crate) struct OnEngine<'a, T, L: Lanes> {
    binding: &'a Binding<T>,
    engine: &'a Engine<L>,
    frame: &'a Frame,
    /// Origin of the volume's sums, in the frame's coordinates.
    middle: DVec3,
    pub(crate) state: State<L>,
    /// Passes over the mesh after the first deformation.
    pub(crate) count: u32,
}

impl<'a, T: Scalar, L: Lanes> OnEngine<'a, T, L> {
    pub(crate) fn new(binding: &'a Binding<T>, engine: &'a Engine<L>, plan: &'a Plan) -> Self {
        let (tasks, frame) = (&binding.embedding().tasks, &plan.frame);
        let state = engine.deformed(tasks, &plan.inner_displacement(), frame.to_frame());
        Self { binding, engine, frame, middle: plan.middle, state, count: 0 }
    }

    /// Origin of each body's volume along an axis. With several it lies in the body, or sums over a small one would lose the digits
    /// that its distance takes.
    fn middles(&self, axis: usize) -> Vec<f64> {
        match self.binding.embedding().first_slot.as_slice() {
            [] | [_] => vec![self.middle[axis]],
            several => {
                let column = numbers(&self.state)[axis];
                several.iter().map(|&slot| column[slot as usize].to_f64()).collect()
            }
        }
    }
}

impl<T: Scalar, L: Lanes> Passes for OnEngine<'_, T, L> {
    type Error = Error;

    fn epsilon(&self) -> f64 {
        L::Real::EPSILON
    }

    fn deform(&mut self, displacement: &[DVec3]) -> Result<()> {
        self.count += 1;
        let tasks = &self.binding.embedding().tasks;
        let fresh = self.engine.deformed(tasks, displacement, self.frame.to_frame());
        self.engine.recycle(std::mem::replace(&mut self.state, fresh));
        Ok(())
    }

    fn shift(&mut self, axis: usize, delta: &[f64]) -> Result<()> {
        self.count += 1;
        self.engine.shift(&self.binding.embedding().tasks, &mut self.state[axis], delta);
        Ok(())
    }

    fn coefficients(&mut self, axis: usize) -> Result<Coefficients> {
        self.count += 1;
        let (tasks, walks) = (&self.binding.embedding().tasks, self.binding.walks()?);
        let middles = self.middles(axis);
        let mut found = self.engine.coefficients(tasks, walks, &self.state, axis, &middles);
        let caps = self.binding.caps()?;
        if !caps.nodes.is_empty() {
            let (columns, slot) = (numbers(&self.state), &self.binding.embedding().slot);
            let at = |&node: &u32| columns.map(|column| column[slot[node as usize] as usize].to_f64());
            let positions: Vec<DVec3> = caps.nodes.iter().map(at).map(DVec3::from_array).collect();
            caps.add(axis, self.binding.lattice().map().inner_shape(), &positions, &middles, &mut found);
        }
        Ok(found)
    }
}
