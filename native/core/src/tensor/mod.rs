// SPDX-License-Identifier: GPL-3.0-or-later
//! Volume and coefficients from the control points alone, without a look at the mesh.
//!
//! The vertices are sums of fixed functions, one for each control point, times the control points; four more functions carry
//! what does not follow them ([`source::Source`]). The volume is trilinear in the x, y, z of the vertices and changes sign where two
//! are swapped, so it is `sum T_abc det[C_a, C_b, C_c]` over the triples `a < b < c` of functions, with `C` the vectors that go
//! with the functions. `T_abc` is the volume with functions a, b, c for the vertices' x, y, z, summed once over the mesh.

mod build;
mod choice;
mod contraction;
mod source;
mod triples;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::lanes::{F64x8, LANES, Lanes};
use crate::preserve::frame::Frame;
use crate::preserve::{Coefficients, Passes};
use crate::sum::CompensatedSum;

pub(crate) use choice::Chosen;
pub use choice::prepare_in_background;
use source::{FIXED, Source};
use triples::Triples;

/// The volume of a binding's mesh as a function of its control points.
pub(crate) struct Tensor {
    triples: Triples,
    /// Inner control points at rest, about the centre that the functions were made for, times their weights.
    rest: Vec<DVec3>,
    weights: Vec<f64>,
}

/// All functions' vectors along one axis, in whole lanes.
type Column = Vec<F64x8>;

impl Tensor {
    /// Sums up a mesh on `threads` threads, and gives up where `stop` says so. The same bits on any number of threads.
    fn new<L: Lanes>(source: Source<L>, threads: usize, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let triples = build::sum(&source, threads, stop)?;
        Some(Self { triples, rest: source.rest, weights: source.weights })
    }

    /// Bytes of memory.
    pub(crate) fn bytes(&self) -> usize {
        Triples::bytes(self.triples.functions()) + self.rest.len() * (size_of::<DVec3>() + size_of::<f64>())
    }

    /// The vectors that go with the functions for displaced inner control points, in the coordinates of a frame.
    fn columns(&self, displacement: &[DVec3], frame: &Frame) -> [Column; 3] {
        let control: Vec<DVec3> = self.rest.iter().zip(displacement).map(|(p, d)| p + d).collect();
        let mean = control.iter().sum::<DVec3>() / self.weights.iter().sum::<f64>();
        let points = control.iter().zip(&self.weights).map(|(p, &weight)| p - weight * mean);
        let all = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().chain(points).chain([mean]);
        let mut columns: [Column; 3] =
            std::array::from_fn(|_| vec![F64x8::ZERO; self.triples.functions().div_ceil(LANES)]);
        for (i, vector) in all.enumerate() {
            let vector = frame.coordinates(vector).to_array();
            for (column, coordinate) in columns.iter_mut().zip(vector) {
                column[i / LANES].0[i % LANES] = coordinate;
            }
        }
        columns
    }
}

/// The passes of a correction without the mesh: volume and coefficients from the control points alone.
pub(crate) struct OnTensor<'a> {
    tensor: &'a Tensor,
    frame: &'a Frame,
    columns: [Column; 3],
    /// Relative rounding error of the passes over the mesh in whose place these are.
    epsilon: f64,
}

impl<'a> OnTensor<'a> {
    pub(crate) fn new(tensor: &'a Tensor, frame: &'a Frame, displacement: &[DVec3], epsilon: f64) -> Self {
        Self { tensor, frame, columns: tensor.columns(displacement, frame), epsilon }
    }
}

impl Passes for OnTensor<'_> {
    type Error = Error;

    fn epsilon(&self) -> f64 {
        self.epsilon
    }

    fn deform(&mut self, displacement: &[DVec3]) -> Result<()> {
        self.columns = self.tensor.columns(displacement, self.frame);
        Ok(())
    }

    fn shift(&mut self, axis: usize, delta: &[f64]) -> Result<()> {
        let coordinates: &mut [f64] = bytemuck::cast_slice_mut(&mut self.columns[axis]);
        coordinates[FIXED..].iter_mut().zip(delta).for_each(|(coordinate, delta)| *coordinate += delta);
        Ok(())
    }

    fn coefficients(&mut self, axis: usize) -> Result<Coefficients> {
        let columns = &self.columns;
        let next = [&columns[(axis + 1) % 3], &columns[(axis + 2) % 3]].map(Vec::as_slice);
        let all = contraction::contract(&self.tensor.triples, next);
        let along: &[f64] = bytemuck::cast_slice(&columns[axis]);
        let volume: CompensatedSum = all.iter().zip(along).map(|(c, p)| c * p).collect();
        let row = all[FIXED..FIXED + self.tensor.rest.len()].to_vec();
        Ok(Coefficients { rows: vec![row], volumes: vec![volume.value()] })
    }
}
