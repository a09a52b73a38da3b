// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers for all triples `a < b < c` of functions, laid out in lanes over `a`.

use crate::lanes::{F64x8, LANES, Lanes};

/// One number for each triple `a < b < c < functions`. For a pair `(b, c)` the numbers of all `a < b` stand side by side in whole
/// lanes; what the last lanes hold beyond `a < b` is not a triple.
#[derive(Debug, Clone)]
pub(crate) struct Triples {
    functions: usize,
    /// Start of each `b`.
    starts: Vec<usize>,
    numbers: Vec<F64x8>,
}

impl Triples {
    /// All zero.
    pub(crate) fn new(functions: usize) -> Self {
        let starts = starts(functions);
        let numbers = vec![F64x8::ZERO; starts[functions]];
        Self { functions, starts, numbers }
    }

    /// Bytes that triples of so many functions take.
    pub(crate) fn bytes(functions: usize) -> usize {
        starts(functions)[functions] * size_of::<F64x8>()
    }

    /// Number of functions.
    pub(crate) fn functions(&self) -> usize {
        self.functions
    }

    /// Lanes that hold the numbers of one pair `(b, c)`.
    #[inline(always)]
    pub(crate) fn layers(b: usize) -> usize {
        b.div_ceil(LANES)
    }

    /// The numbers of all `c > b`: [`Triples::layers`] of `b` for each, from `c = b + 1` up.
    #[inline(always)]
    pub(crate) fn of(&self, b: usize) -> &[F64x8] {
        &self.numbers[self.starts[b]..self.starts[b + 1]]
    }

    /// The same, to be changed.
    #[inline(always)]
    pub(crate) fn of_mut(&mut self, b: usize) -> &mut [F64x8] {
        &mut self.numbers[self.starts[b]..self.starts[b + 1]]
    }

    /// Adds `factor` times the triples of some of the functions, named in ascending order.
    pub(crate) fn add(&mut self, part: &Self, names: &[usize], factor: f64) {
        for b in 1..part.functions {
            let from = part.of(b).chunks_exact(Self::layers(b));
            for (c, from) in (b + 1..).zip(from) {
                let (to_b, layers) = (names[b], Self::layers(names[b]));
                let first = (names[c] - to_b - 1) * layers;
                let to = &mut self.of_mut(to_b)[first..first + layers];
                let to: &mut [f64] = bytemuck::cast_slice_mut(to);
                let from: &[f64] = bytemuck::cast_slice(from);
                for (&a, number) in names[..b].iter().zip(from) {
                    to[a] += factor * number;
                }
            }
        }
    }
}

fn starts(functions: usize) -> Vec<usize> {
    let lengths = (0..functions).map(|b| (functions - 1 - b) * Triples::layers(b));
    let mut starts = vec![0];
    starts.extend(lengths.scan(0, |end, length| {
        *end += length;
        Some(*end)
    }));
    starts
}
