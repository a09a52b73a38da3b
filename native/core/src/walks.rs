// SPDX-License-Identifier: GPL-3.0-or-later
//! The closed walks of neighbours around vertices, laid out for blocks of lanes.

use rayon::prelude::*;

use crate::embedding::{EMPTY, Embedding, split};
use crate::lanes::{F64x8, LANES, Lanes};
use crate::surface::ClosedSurface;
use crate::vertices::Scalar;

/// For every block the walks around its vertices side by side: step `i` holds neighbour `i` of each lane, as a slot. Shorter walks
/// repeat their last neighbour, and empty lanes walk on the spot: both enclose nothing more.
#[derive(Debug, Clone)]
pub(crate) struct Walks {
    /// Start of every block's steps; one more entry than blocks.
    offsets: Vec<usize>,
    /// Every entry is smaller than `slots`.
    steps: Vec<[u32; LANES]>,
    slots: usize,
}

impl Walks {
    /// The walks of a surface, by the slots of an embedding of the same nodes.
    pub(crate) fn new(embedding: &Embedding, surface: &ClosedSurface) -> Self {
        let around = |v: u32| if v == EMPTY { &[] } else { surface.around(v as usize) };
        let blocks = embedding.node.as_chunks::<LANES>().0;
        let longest = |block: &[u32; LANES]| block.iter().map(|&v| around(v).len()).max().unwrap_or_default();
        let lengths: Vec<usize> = blocks.par_iter().map(longest).collect();
        let mut offsets = Vec::with_capacity(blocks.len() + 1);
        offsets.push(0);
        offsets.extend(lengths.iter().scan(0, |end, length| {
            *end += length;
            Some(*end)
        }));
        let mut steps = vec![[0; LANES]; lengths.iter().sum()];
        let runs = split(&mut steps, lengths.iter().copied());
        blocks.par_iter().zip(runs).enumerate().for_each(|(block, (vertices, run))| {
            for (lane, &v) in vertices.iter().enumerate() {
                let walk = around(v);
                for (i, step) in run.iter_mut().enumerate() {
                    let neighbour = walk.get(i).or(walk.last());
                    step[lane] =
                        neighbour.map_or((block * LANES + lane) as u32, |&v| embedding.slot[v as usize]);
                }
            }
        });
        let slots = embedding.node.len();
        assert!(steps.as_flattened().iter().all(|&slot| (slot as usize) < slots));
        Self { offsets, steps, slots }
    }

    /// Steps of a block's walks.
    #[inline(always)]
    pub(crate) fn around(&self, block: usize) -> &[[u32; LANES]] {
        &self.steps[self.offsets[block]..self.offsets[block + 1]]
    }

    /// The walk around one slot, without the last neighbour's repetitions.
    pub(crate) fn around_slot(&self, slot: usize) -> impl ExactSizeIterator<Item = u32> {
        let (walk, lane) = (self.around(slot / LANES), slot % LANES);
        let repeated = walk.windows(2).rev().take_while(|two| two[0][lane] == two[1][lane]).count();
        walk[..walk.len() - repeated].iter().map(move |step| step[lane])
    }

    /// Start of every block's steps, one more entry than blocks, and all steps.
    pub(crate) fn parts(&self) -> (&[usize], &[[u32; LANES]]) {
        (&self.offsets, &self.steps)
    }

    /// One coordinate of the slots of a step of these walks, in float64.
    #[inline(always)]
    pub(crate) fn gather<L: Lanes>(&self, coordinate: &[L], step: &[u32; LANES]) -> F64x8 {
        let flat: &[L::Real] = bytemuck::cast_slice(coordinate);
        assert!(flat.len() == self.slots);
        let mut found = F64x8::ZERO;
        for (found, &slot) in found.0.iter_mut().zip(step) {
            // SAFETY: `new` checked that every entry of `steps` is smaller than `slots`, and `step` is one of them (it comes
            // from `around`); `flat` has `slots` entries, checked above.
            *found = unsafe { *flat.get_unchecked(slot as usize) }.to_f64();
        }
        found
    }
}
