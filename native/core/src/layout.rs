// SPDX-License-Identifier: GPL-3.0-or-later
//! A binding's fixed data as another backend needs it, read-only.
//!
//! Vertices are sorted by cell of the lattice, and within a cell by body, into *slots*, in blocks of [`BLOCK`]; each starts a new
//! block, so some slots are empty. A vertex that several bodies share has a slot for each of them.

use std::ops::Range;

use crate::basis::Span;
use crate::binding::Binding;
use crate::bodies::NO_BODY;
use crate::embedding::{EMPTY, Embedding, Task};
use crate::error::Result;
use crate::lanes::LANES;
use crate::vertices::Scalar;

/// Slots of one block.
pub const BLOCK: usize = LANES;

/// Where the vertices of a binding stand in its lattice.
pub struct Layout<'a, T> {
    binding: &'a Binding<T>,
    embedding: &'a Embedding,
}

/// A vertex in the lattice.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Number of the vertex, in the order bound.
    pub vertex: usize,
    /// Parameters (s, t, u) in the lattice's domain, in [0, 1], or as far beyond as the basis reaches.
    pub parameter: [f64; 3],
    /// How much of the deformation by inner control points the vertex takes; 0 where it is kept outside. Where weights are unequal it
    /// may exceed 1.
    pub influence: f64,
}

/// Consecutive blocks in one cell of the lattice and one body. The runs of a layout are sorted by cell, then by body, and cover every
/// block once.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    task: &'a Task,
}

/// The closed walks of neighbours around every slot, for blocks of slots side by side.
///
/// `steps[i][lane]` is a neighbour of the block's slot `lane`, as a slot, for `i` from `offsets[block]` to
/// `offsets[block + 1]`. Shorter walks repeat their last neighbour, and slots without triangles walk on the spot: both
/// enclose nothing more.
#[derive(Debug, Clone, Copy)]
pub struct BlockWalks<'a> {
    /// Start of every block's steps; one more entry than blocks.
    pub offsets: &'a [usize],
    /// All steps.
    pub steps: &'a [[u32; BLOCK]],
}

impl<T: Scalar> Binding<T> {
    /// Where the vertices stand in the lattice.
    pub fn layout(&self) -> Layout<'_, T> {
        Layout { binding: self, embedding: self.embedding() }
    }

    /// The walks of neighbours around every slot.
    ///
    /// # Errors
    /// [`crate::Error::Mesh`] where the triangles enclose no volume.
    pub fn block_walks(&self) -> Result<BlockWalks<'_>> {
        self.walks().map(|walks| walks.parts()).map(|(offsets, steps)| BlockWalks { offsets, steps })
    }
}

impl<'a, T: Scalar> Layout<'a, T> {
    /// Number of inner control points along each axis: those that act in the cells ([`crate::ControlMap`]).
    pub fn shape(&self) -> [usize; 3] {
        self.binding.lattice().map().inner_shape()
    }

    /// Number of slots, a multiple of [`BLOCK`].
    pub fn slots(&self) -> usize {
        self.embedding.node.len()
    }

    /// Runs of blocks in one cell each.
    pub fn runs(&self) -> impl Iterator<Item = Run<'a>> {
        self.embedding.tasks.iter().map(|task| Run { task })
    }

    /// What stands in a slot; `None` for an empty one. Computed anew at every call.
    pub fn place(&self, slot: usize) -> Option<Place> {
        let node = self.embedding.node[slot];
        (node != EMPTY).then(|| {
            let vertex = self.embedding.vertex(node);
            let located = self.binding.located(vertex);
            Place { vertex, parameter: located.parameter, influence: located.inner_influence }
        })
    }

    /// Slot of each vertex, in the order bound. Where several bodies share a vertex, it stands in more slots than this, and all of
    /// them move alike.
    pub fn slot_of_vertex(&self) -> &'a [u32] {
        self.embedding.slot_of_vertex()
    }
}

impl<'a> Run<'a> {
    /// The slots of the run; a multiple of [`BLOCK`].
    pub fn slots(self) -> Range<usize> {
        self.task.blocks.start * LANES..self.task.blocks.end * LANES
    }

    /// The body that the run's coefficients and volume belong to; `None` for vertices of no body, which deform along.
    pub fn body(self) -> Option<usize> {
        (self.task.body != NO_BODY).then_some(self.task.body as usize)
    }

    /// The cell's inner control point with the smallest indices; `degree + 1` act from there along each axis.
    pub fn first_point(self) -> [usize; 3] {
        self.task.first_point
    }

    /// The knots around the cell, along s, t, u.
    pub fn spans(self) -> [&'a Span; 3] {
        self.task.spans.each_ref()
    }
}
