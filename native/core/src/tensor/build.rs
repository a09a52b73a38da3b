// SPDX-License-Identifier: GPL-3.0-or-later
//! Sums the tensor over a mesh: for every vertex all triples of functions, as products of small dense matrices.

use rayon::prelude::*;

use crate::lanes::{F64x8, Kernel, LANES, Lanes, dispatch};
use crate::tensor::source::{Group, Source};
use crate::tensor::triples::Triples;

/// Vertices whose sums are added up on their own. Sums of sums round less, and a run is enough work for a thread.
const RUN: usize = 4096;

/// Functions `b`, and functions `c`, taken at once: that many sums stay in registers, with two lanes each where vectors are of 256
/// bits, beside what is added to them.
const TILE: usize = 6;

/// Vertices of a chunk. More of them share one pass over the sums; with fewer their differences stay nearer to the core.
const CHUNK: usize = 64;

/// Neighbours of a vertex, in the estimate of the work: the mean of a closed triangle mesh.
const USUAL_WALK: usize = 6;

/// `sum_v f_a(v) g_v(f_b, f_c) / 6` for all triples, `g_v(p, q) = sum (p_i - p) (q_i+1 - q_i-1)` over the walk around `v`: the
/// volume with `f_a`, `f_b`, `f_c` for the vertices' x, y, z. `None` where `stop` says so.
///
/// `threads` runs are in memory at a time; their order, and so every bit of the sum, is always the same.
pub(crate) fn sum<L: Lanes>(
    source: &Source<L>,
    threads: usize,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Triples> {
    let groups = source.groups();
    let runs: Vec<(&Group, &[u32])> =
        groups.iter().flat_map(|group| group.slots.chunks(RUN).map(move |slots| (group, slots))).collect();
    let mut total = Triples::new(source.functions());
    let one = |run: &(&Group, &[u32])| sum_run(source, run.0, run.1, stop);
    for batch in runs.chunks(threads.max(1)) {
        let parts: Vec<Option<Triples>> =
            if threads > 1 { batch.par_iter().map(one).collect() } else { batch.iter().map(one).collect() };
        for ((group, _), part) in batch.iter().zip(parts) {
            total.add(&part?, &group.names(source.shape), 1.0 / 6.0);
        }
    }
    Some(total)
}

fn sum_run<L: Lanes>(
    source: &Source<L>,
    group: &Group,
    slots: &[u32],
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Triples> {
    let mut sums = Triples::new(group.functions());
    for slots in slots.chunks(CHUNK) {
        if stop() {
            return None;
        }
        let chunk = Chunk::new(source, group, slots);
        let gradients = vec![F64x8::ZERO; TILE * slots.len() * chunk.stride];
        dispatch(Accumulate { chunk: &chunk, gradients, arms: Vec::new(), sums: &mut sums });
    }
    Some(sums)
}

/// A few vertices and their neighbours, in the functions of their group.
struct Chunk {
    functions: usize,
    /// Vectors of a row of functions, with one of zeros at the end so that tiles may reach over.
    stride: usize,
    /// Rows of functions, one a slot that occurs.
    rows: Vec<F64x8>,
    /// For each vertex its row, and where its walk starts and ends in `steps`.
    vertices: Vec<(usize, std::ops::Range<usize>)>,
    /// Rows of the neighbours.
    steps: Vec<usize>,
    /// For each step the row of the next neighbour minus that of the one before.
    differences: Vec<F64x8>,
    /// Functions of the vertices, vertices side by side: `own[vector * vertices + vertex]`.
    own: Vec<F64x8>,
}

impl Chunk {
    fn new<L: Lanes>(source: &Source<L>, group: &Group, slots: &[u32]) -> Self {
        let functions = group.functions();
        let stride = functions.div_ceil(LANES) + 1;
        let walks: Vec<Vec<u32>> =
            slots.iter().map(|&slot| source.walks.around_slot(slot as usize).collect()).collect();
        let mut needed: Vec<u32> = walks.iter().flatten().chain(slots).copied().collect();
        needed.sort_unstable();
        needed.dedup();
        let mut rows = vec![F64x8::ZERO; needed.len() * stride];
        for (row, &slot) in rows.chunks_exact_mut(stride).zip(&needed) {
            let row: &mut [f64] = bytemuck::cast_slice_mut(row);
            source.evaluate(group, slot as usize, &mut row[..functions]);
        }
        let row_of = |slot: &u32| needed.partition_point(|other| other < slot);
        let (mut vertices, mut steps) = (Vec::with_capacity(slots.len()), Vec::new());
        for (slot, walk) in slots.iter().zip(&walks) {
            let first = steps.len();
            steps.extend(walk.iter().map(row_of));
            vertices.push((row_of(slot), first..steps.len()));
        }
        let mut chunk =
            Self { functions, stride, rows, vertices, steps, differences: Vec::new(), own: Vec::new() };
        chunk.differ();
        chunk.own = (0..stride - 1)
            .flat_map(|vector| chunk.vertices.iter().map(move |(row, _)| (row, vector)))
            .map(|(row, vector)| chunk.rows[row * stride + vector])
            .collect();
        chunk
    }

    fn differ(&mut self) {
        let row = |row: usize| &self.rows[row * self.stride..(row + 1) * self.stride];
        self.differences.reserve_exact(self.steps.len() * self.stride);
        for (_, range) in &self.vertices {
            let walk = &self.steps[range.clone()];
            for i in 0..walk.len() {
                let (next, before) = (walk[(i + 1) % walk.len()], walk[(i + walk.len() - 1) % walk.len()]);
                self.differences.extend(row(next).iter().zip(row(before)).map(|(n, b)| n.minus(*b)));
            }
        }
    }
}

/// Adds a chunk's vertices to the sums of all triples.
struct Accumulate<'a> {
    chunk: &'a Chunk,
    /// Of [`TILE`] functions `b`, for each vertex: the gradients with all `c`.
    gradients: Vec<F64x8>,
    arms: Vec<[f64; TILE]>,
    sums: &'a mut Triples,
}

impl Accumulate<'_> {
    /// `gradients[b - first]` for [`TILE`] functions `b` and all `c` after the first of them.
    #[inline(always)]
    fn pairs<const FUSED: bool>(&mut self, first: usize) {
        let Chunk { stride, rows, vertices, steps, differences, .. } = self.chunk;
        let flat: &[f64] = bytemuck::cast_slice(rows);
        let plane = vertices.len() * stride;
        for (vertex, (own, range)) in vertices.iter().enumerate() {
            let own = &flat[own * stride * LANES + first..][..TILE];
            self.arms.clear();
            for step in &steps[range.clone()] {
                let there = &flat[step * stride * LANES + first..][..TILE];
                let mut arm = [0.0; TILE];
                for b in 0..TILE {
                    arm[b] = there[b] - own[b];
                }
                self.arms.push(arm);
            }
            let differences = &differences[range.start * stride..range.end * stride];
            for c in (first + 1) / LANES..stride - 1 {
                let mut sums = [F64x8::ZERO; TILE];
                for (arm, difference) in self.arms.iter().zip(differences.chunks_exact(*stride)) {
                    let difference = difference[c];
                    for b in 0..TILE {
                        sums[b] = difference.multiply_add::<FUSED>(F64x8::splat(arm[b]), sums[b]);
                    }
                }
                for (b, sum) in sums.iter().enumerate() {
                    self.gradients[b * plane + vertex * stride + c] = *sum;
                }
            }
        }
    }

    /// Adds all triples with this `b`, the function `place` of its tile.
    #[inline(always)]
    fn triples<const FUSED: bool>(&mut self, b: usize, place: usize) {
        let Chunk { functions, stride, vertices, own, .. } = self.chunk;
        let (layers, plane) = (Triples::layers(b), vertices.len() * stride);
        let gradients: &[f64] = bytemuck::cast_slice(&self.gradients[place * plane..(place + 1) * plane]);
        let totals = self.sums.of_mut(b);
        for (layer, own) in own.chunks_exact(vertices.len()).take(layers).enumerate() {
            for c in (b + 1..*functions).step_by(TILE) {
                let mut sums = [F64x8::ZERO; TILE];
                for (function, gradient) in own.iter().zip(gradients.chunks_exact(stride * LANES)) {
                    let gradient = &gradient[c..c + TILE];
                    for i in 0..TILE {
                        sums[i] = function.multiply_add::<FUSED>(F64x8::splat(gradient[i]), sums[i]);
                    }
                }
                for i in 0..TILE.min(functions - c) {
                    let total = &mut totals[(c + i - b - 1) * layers + layer];
                    *total = sums[i].multiply_add::<FUSED>(F64x8::splat(1.0), *total);
                }
            }
        }
    }
}

impl Kernel for Accumulate<'_> {
    type Output = ();
    #[inline(always)]
    fn run<const FUSED: bool>(mut self) {
        // The first function is nobody's `b`, the last one has no `c`.
        let last = self.chunk.functions - 1;
        for first in (1..last).step_by(TILE) {
            self.pairs::<FUSED>(first);
            for b in first..last.min(first + TILE) {
                self.triples::<FUSED>(b, b - first);
            }
        }
    }
}

/// Multiply-adds for a vertex with so many functions.
pub(crate) fn operations(functions: usize) -> usize {
    let pairs = functions * (functions - 1) / 2;
    pairs * USUAL_WALK + pairs * (functions - 2) / 3
}
