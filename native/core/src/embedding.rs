// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the vertices stand in the lattice: parameters, sorted by cell into blocks of lanes.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::basis::Span;
use crate::inversion::Preimage;
use crate::lanes::LANES;
use crate::lattice::Lattice;
use crate::vertices::{Outside, Scalar};

/// Vertices of one task at least: enough work to hide what starting it costs, few enough that two hundred tasks share a
/// mesh of a hundred thousand vertices evenly between cores.
const TASK_VERTICES: usize = 512;

/// Marks a slot without a vertex.
pub(crate) const EMPTY: u32 = u32::MAX;

/// Vertices embedded in a lattice, fixed until the vertices or the lattice change.
///
/// A *slot* is a place in the arrays sorted by cell; each cell starts a new block of [`LANES`] slots, so some are empty.
#[derive(Debug, Clone)]
pub(crate) struct Embedding {
    pub(crate) tasks: Vec<Task>,
    /// Slot of each vertex.
    pub(crate) slot: Vec<u32>,
    /// Vertex in each slot, or `EMPTY`.
    pub(crate) vertex: Vec<u32>,
    /// Number of vertices beyond the domain, or nowhere in a shaped lattice.
    pub(crate) outside: usize,
    /// Whether vertices lie beyond the lower and upper face of each axis.
    pub(crate) beyond: [[bool; 2]; 3],
    /// Largest extent of the vertices in parameters, along the axis where it is largest.
    pub(crate) extent: f64,
}

/// A run of blocks in one cell of the lattice.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// The knots around the cell along s, t, u.
    pub(crate) spans: [Span; 3],
    /// Control point with the smallest indices that acts in the cell.
    pub(crate) first_point: [usize; 3],
    pub(crate) blocks: Range<usize>,
}

impl Task {
    /// Number of control points that act in the cell, along each axis.
    pub(crate) fn taps(&self) -> [usize; 3] {
        self.spans.each_ref().map(|span| span.degree() + 1)
    }

    /// Indices of the cell's control points in a lattice of `shape`, `k` fastest.
    pub(crate) fn points(&self, shape: [usize; 3]) -> impl Iterator<Item = usize> + use<> {
        let ([i0, j0, k0], [nu, nv, nw]) = (self.first_point, self.taps());
        (0..nu).flat_map(move |i| {
            (0..nv).flat_map(move |j| {
                let row = ((i0 + i) * shape[1] + j0 + j) * shape[2] + k0;
                row..row + nw
            })
        })
    }
}

/// Where a vertex stands before its parameters are made to lie in the domain.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Spot {
    /// Parameters by projection on the lattice's frame; they may lie beyond the domain.
    Projected(DVec3),
    /// Parameters through a shaped lattice.
    Inverted(Preimage),
}

/// One vertex in the lattice.
pub(crate) struct Located {
    cell: [u16; 3],
    /// Parameters s, t, u, in [0, 1].
    pub(crate) parameter: [f64; 3],
    /// How much of the deformation the vertex takes.
    pub(crate) influence: f64,
    beyond: [[bool; 2]; 3],
    /// Whether it lies beyond the domain, or nowhere in a shaped lattice.
    is_outside: bool,
}

impl Located {
    pub(crate) fn new<T: Scalar>(lattice: &Lattice, spot: Spot, influence: f64, outside: Outside) -> Self {
        let (raw, low, high) = match spot {
            Spot::Projected(raw) => (raw, -T::FACE_TOLERANCE, 1.0 + T::FACE_TOLERANCE),
            Spot::Inverted(Preimage { parameter, inside: true }) => {
                (parameter, f64::NEG_INFINITY, f64::INFINITY)
            }
            // Beyond the faces that the nearest parameters lie on.
            Spot::Inverted(Preimage { parameter, inside: false }) => {
                (parameter, 0.0f64.next_up(), 1.0f64.next_down())
            }
        };
        let beyond: [[bool; 2]; 3] = std::array::from_fn(|axis| {
            // An axis with one control point has no faces: nothing changes along it.
            let faces = lattice.axes()[axis].count() > 1;
            [faces && raw[axis] < low, faces && raw[axis] > high]
        });
        let lost = matches!(spot, Spot::Inverted(Preimage { inside: false, .. }));
        let is_outside = lost || beyond.as_flattened().contains(&true);
        let kept = outside == Outside::Keep && is_outside;
        let parameter = raw.to_array().map(|t| t.clamp(0.0, 1.0));
        Self {
            cell: std::array::from_fn(|axis| lattice.axes()[axis].cell(parameter[axis]) as u16),
            parameter,
            influence: if kept { 0.0 } else { influence },
            beyond,
            is_outside,
        }
    }
}

impl Embedding {
    /// Embeds vertices at their spots with one influence each, or 1.
    pub(crate) fn new<T: Scalar>(
        lattice: &Lattice,
        count: usize,
        spot: impl Fn(usize) -> Spot + Sync,
        influence: Option<&[f64]>,
        outside: Outside,
    ) -> (Self, Vec<Located>) {
        let located: Vec<Located> = (0..count)
            .into_par_iter()
            .map(|v| Located::new::<T>(lattice, spot(v), influence.map_or(1.0, |all| all[v]), outside))
            .collect();
        let (tasks, slot, slots) = sort_by_cell(lattice, &located);
        let mut vertex = vec![EMPTY; slots];
        for (v, &s) in slot.iter().enumerate() {
            vertex[s as usize] = v as u32;
        }
        let extent = |axis: usize| {
            let range = located.iter().map(|l| l.parameter[axis]);
            range.clone().fold(0.0, f64::max) - range.fold(1.0, f64::min)
        };
        let embedding = Self {
            tasks,
            outside: located.iter().filter(|l| l.is_outside).count(),
            beyond: std::array::from_fn(|axis| {
                std::array::from_fn(|side| located.iter().any(|l| l.beyond[axis][side]))
            }),
            extent: extent(0).max(extent(1)).max(extent(2)),
            slot,
            vertex,
        };
        (embedding, located)
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.vertex.len() / LANES
    }
}

/// Counting sort of the vertices by cell: tasks, the slot of each vertex, and the number of slots.
fn sort_by_cell(lattice: &Lattice, located: &[Located]) -> (Vec<Task>, Vec<u32>, usize) {
    let cells = lattice.axes().each_ref().map(|axis| axis.cells());
    let flat =
        |cell: [u16; 3]| (cell[0] as usize * cells[1] + cell[1] as usize) * cells[2] + cell[2] as usize;
    let mut count = vec![0usize; cells.iter().product()];
    located.iter().for_each(|l| count[flat(l.cell)] += 1);

    let taps: usize = lattice.axes().iter().map(|axis| axis.degree() + 1).product();
    // A task's sums cost as much as a few vertices for each tap; more vertices keep that small.
    let task_blocks = TASK_VERTICES.max(4 * taps).div_ceil(LANES);
    let (mut tasks, mut start, mut block) = (Vec::new(), vec![0usize; count.len()], 0);
    for (index, &vertices) in count.iter().enumerate() {
        start[index] = block * LANES;
        let end = block + vertices.div_ceil(LANES);
        let cell = [index / (cells[1] * cells[2]), index / cells[2] % cells[1], index % cells[2]];
        while block < end {
            let next = end.min(block + task_blocks);
            tasks.push(Task {
                spans: std::array::from_fn(|axis| lattice.axes()[axis].span(cell[axis])),
                first_point: std::array::from_fn(|axis| lattice.axes()[axis].first_point(cell[axis])),
                blocks: block..next,
            });
            block = next;
        }
    }
    let slot = located.iter().map(|l| {
        let next = &mut start[flat(l.cell)];
        *next += 1;
        (*next - 1) as u32
    });
    (tasks, slot.collect(), block * LANES)
}

/// Cuts a slice into consecutive runs of the given lengths.
pub(crate) fn split<T>(mut whole: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    lengths
        .map(|length| {
            let (run, rest) = std::mem::take(&mut whole).split_at_mut(length);
            whole = rest;
            run
        })
        .collect()
}
