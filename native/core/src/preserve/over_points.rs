// SPDX-License-Identifier: GPL-3.0-or-later
//! The passes where the volume is that of a surface over the points that the lattice moves: `x = S (p + B delta)`, with coefficients
//! `B' S' g`.

use glam::DVec3;

use crate::binding::Binding;
use crate::embedding::Embedding;
use crate::engine::{Engine, State, numbers};
use crate::error::{Error, Result};
use crate::lanes::Lanes;
use crate::over::Part;
use crate::preserve::frame::Frame;
use crate::preserve::passes::{Coefficients, Passes};
use crate::vertices::Scalar;

/// The passes on the CPU over points, and over the surface in float64.
pub(crate) struct OverPoints<'a, L: Lanes> {
    engine: &'a Engine<L>,
    embedding: &'a Embedding,
    parts: Result<&'a [Part]>,
    frame: &'a Frame,
    pub(crate) state: State<L>,
    /// Coordinates of each part's rows.
    places: Vec<[Vec<f64>; 3]>,
}

impl<'a, L: Lanes> OverPoints<'a, L> {
    pub(crate) fn new<T: Scalar>(
        binding: &'a Binding<T>,
        engine: &'a Engine<L>,
        frame: &'a Frame,
        displacement: &[DVec3],
    ) -> Self {
        let embedding = binding.embedding().as_ref();
        let state = engine.deformed(&embedding.tasks, displacement, frame.to_frame());
        let mut passes = Self { engine, embedding, parts: binding.parts(), frame, state, places: Vec::new() };
        passes.place_all();
        passes
    }

    fn place_all(&mut self) {
        let parts = self.parts.as_ref().map_or(&[][..], |parts| parts);
        self.places = parts.iter().map(|part| [0, 1, 2].map(|axis| self.placed(part, axis))).collect();
    }

    fn placed(&self, part: &Part, axis: usize) -> Vec<f64> {
        let (column, slot) = (numbers(&self.state)[axis], self.embedding.slot_of_vertex());
        part.column(|point| column[slot[point] as usize].to_f64())
    }
}

impl<L: Lanes> Passes for OverPoints<'_, L> {
    type Error = Error;

    fn epsilon(&self) -> f64 {
        L::Real::EPSILON
    }

    fn deform(&mut self, displacement: &[DVec3]) -> Result<()> {
        let fresh = self.engine.deformed(&self.embedding.tasks, displacement, self.frame.to_frame());
        self.engine.recycle(std::mem::replace(&mut self.state, fresh));
        self.place_all();
        Ok(())
    }

    fn shift(&mut self, axis: usize, delta: &[f64]) -> Result<()> {
        self.engine.shift(&self.embedding.tasks, &mut self.state[axis], delta);
        let parts = self.parts.as_ref().map_or(&[][..], |parts| parts);
        let moved: Vec<Vec<f64>> = parts.iter().map(|part| self.placed(part, axis)).collect();
        self.places.iter_mut().zip(moved).for_each(|(places, moved)| places[axis] = moved);
        Ok(())
    }

    fn coefficients(&mut self, axis: usize) -> Result<Coefficients> {
        let parts = self.parts.clone()?;
        let mut found = Coefficients { rows: Vec::new(), volumes: Vec::new() };
        let mut values = vec![L::ZERO; self.embedding.blocks()];
        for (part, places) in parts.iter().zip(&self.places) {
            let (volume, pulls) = part.flux(places, axis);
            values.fill(L::ZERO);
            let flat: &mut [L::Real] = bytemuck::cast_slice_mut(&mut values);
            let slots = self.embedding.slot_of_vertex();
            for (&point, pull) in part.points().iter().zip(pulls) {
                flat[slots[point as usize] as usize] = L::Real::from_f64(pull);
            }
            found.rows.push(self.engine.pulled(&self.embedding.tasks, &values));
            found.volumes.push(volume);
        }
        Ok(found)
    }
}
