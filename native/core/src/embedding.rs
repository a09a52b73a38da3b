// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the vertices stand in the lattice: parameters, sorted by cell into blocks of lanes.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::basis::Span;
use crate::bodies::Partition;
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
/// What stands in a lattice are nodes: the vertices, and one more for every further body that shares a vertex. A *slot* is a place in
/// the arrays sorted by cell, and within a cell by body; each starts a new block of [`LANES`] slots, so some are empty.
#[derive(Debug, Clone)]
pub(crate) struct Embedding {
    pub(crate) tasks: Vec<Task>,
    /// Slot of each node; those of the vertices come first.
    pub(crate) slot: Vec<u32>,
    /// Node in each slot, or `EMPTY`.
    pub(crate) node: Vec<u32>,
    /// First slot of each body; none where all triangles are one.
    pub(crate) first_slot: Vec<u32>,
    /// Number of vertices.
    vertices: usize,
    /// Vertices of the nodes beyond those.
    further: Vec<u32>,
    /// Number of vertices beyond the domain, or nowhere in a shaped lattice.
    pub(crate) outside: usize,
    /// Whether vertices lie beyond the lower and upper face of each axis.
    pub(crate) beyond: [[bool; 2]; 3],
    /// Largest extent of the vertices in parameters, along the axis where it is largest.
    pub(crate) extent: f64,
}

/// A run of blocks in one cell of the lattice, with nodes of one body.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// The knots around the cell along s, t, u.
    pub(crate) spans: [Span; 3],
    /// Inner control point with the smallest indices that acts in the cell.
    pub(crate) first_point: [usize; 3],
    pub(crate) blocks: Range<usize>,
    /// The body, or `NO_BODY`.
    pub(crate) body: u32,
}

impl Task {
    /// Number of inner control points that act in the cell, along each axis.
    pub(crate) fn taps(&self) -> [usize; 3] {
        self.spans.each_ref().map(|span| span.degree() + 1)
    }

    /// Indices of the cell's inner control points, `k` fastest; `shape`: how many inner ones the lattice has.
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
    /// Parameters s, t, u, in [0, 1] or as far beyond as the basis reaches.
    pub(crate) parameter: [f64; 3],
    /// How much of the deformation the vertex takes.
    pub(crate) influence: f64,
    /// The same of what inner control points give: divided by the denominator of rational functions.
    pub(crate) inner_influence: f64,
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
        let axes = lattice.axes();
        let parameter = std::array::from_fn(|axis| axes[axis].clamped_to_reach(raw[axis]));
        let influence = if kept { 0.0 } else { influence };
        Self {
            cell: std::array::from_fn(|axis| axes[axis].cell(parameter[axis]) as u16),
            parameter,
            influence,
            inner_influence: influence / lattice.denominator(DVec3::from_array(parameter)),
            beyond,
            is_outside,
        }
    }
}

impl Embedding {
    /// Embeds the nodes of vertices at the vertices' spots with one influence each, or 1. Gives what is located by node.
    pub(crate) fn new<T: Scalar>(
        lattice: &Lattice,
        (count, partition): (usize, &Partition),
        spot: impl Fn(usize) -> Spot + Sync,
        influence: Option<&[f64]>,
        outside: Outside,
    ) -> (Self, Vec<Located>) {
        let locate = |node: usize| {
            let v = partition.vertex(node, count);
            Located::new::<T>(lattice, spot(v), influence.map_or(1.0, |all| all[v]), outside)
        };
        let located: Vec<Located> = (0..partition.nodes(count)).into_par_iter().map(locate).collect();
        let (tasks, slot, slots) = match partition.of_triangle() {
            None => sort_by_cell(lattice, &located),
            Some(_) => sort_by_body(lattice, &located, partition),
        };
        let mut node = vec![EMPTY; slots];
        for (n, &s) in slot.iter().enumerate() {
            node[s as usize] = n as u32;
        }
        let extent = |axis: usize| {
            let range = located.iter().map(|l| l.parameter[axis]);
            range.clone().fold(0.0, f64::max) - range.fold(1.0, f64::min)
        };
        let embedding = Self {
            tasks,
            outside: located[..count].iter().filter(|l| l.is_outside).count(),
            beyond: std::array::from_fn(|axis| {
                std::array::from_fn(|side| located.iter().any(|l| l.beyond[axis][side]))
            }),
            extent: extent(0).max(extent(1)).max(extent(2)),
            first_slot: first_slots(&slot, partition),
            slot,
            node,
            vertices: count,
            further: partition.further().to_vec(),
        };
        (embedding, located)
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.node.len() / LANES
    }

    /// Vertex of a node.
    #[inline]
    pub(crate) fn vertex(&self, node: u32) -> usize {
        let node = node as usize;
        if node < self.vertices { node } else { self.further[node - self.vertices] as usize }
    }

    /// Slot of each vertex.
    pub(crate) fn slot_of_vertex(&self) -> &[u32] {
        &self.slot[..self.vertices]
    }
}

/// A slot of each body, where not all triangles are one.
fn first_slots(slot: &[u32], partition: &Partition) -> Vec<u32> {
    if partition.of_triangle().is_none() {
        return Vec::new();
    }
    let mut first = vec![0; partition.count()];
    for (node, &slot) in slot.iter().enumerate().rev() {
        if let Some(first) = first.get_mut(partition.of_node(node) as usize) {
            *first = slot;
        }
    }
    first
}

/// Number of a cell among all.
fn flat(cells: [usize; 3], cell: [u16; 3]) -> usize {
    (cell[0] as usize * cells[1] + cell[1] as usize) * cells[2] + cell[2] as usize
}

/// Cuts groups of nodes, each in a cell and a body, into tasks of whole blocks.
struct Cutter<'a> {
    lattice: &'a Lattice,
    cells: [usize; 3],
    task_blocks: usize,
    tasks: Vec<Task>,
    /// End of the blocks so far.
    block: usize,
}

impl<'a> Cutter<'a> {
    fn new(lattice: &'a Lattice) -> Self {
        let taps: usize = lattice.axes().iter().map(|axis| axis.degree() + 1).product();
        Self {
            lattice,
            cells: lattice.axes().each_ref().map(|axis| axis.cells()),
            // A task's sums cost as much as a few vertices for each tap; more vertices keep that small.
            task_blocks: TASK_VERTICES.max(4 * taps).div_ceil(LANES),
            tasks: Vec::new(),
            block: 0,
        }
    }

    /// Adds a group of so many nodes; returns its first slot.
    fn add(&mut self, index: usize, body: u32, nodes: usize) -> usize {
        let start = self.block * LANES;
        let (cells, axes) = (self.cells, self.lattice.axes());
        let end = self.block + nodes.div_ceil(LANES);
        let cell = [index / (cells[1] * cells[2]), index / cells[2] % cells[1], index % cells[2]];
        while self.block < end {
            let next = end.min(self.block + self.task_blocks);
            self.tasks.push(Task {
                spans: std::array::from_fn(|axis| axes[axis].span(cell[axis])),
                first_point: std::array::from_fn(|axis| axes[axis].first_point(cell[axis])),
                blocks: self.block..next,
                body,
            });
            self.block = next;
        }
        start
    }
}

/// Counting sort of the vertices by cell: tasks, the slot of each vertex, and the number of slots.
fn sort_by_cell(lattice: &Lattice, located: &[Located]) -> (Vec<Task>, Vec<u32>, usize) {
    let mut cutter = Cutter::new(lattice);
    let cells = cutter.cells;
    let mut count = vec![0usize; cells.iter().product()];
    located.iter().for_each(|l| count[flat(cells, l.cell)] += 1);
    let mut start: Vec<usize> =
        count.iter().enumerate().map(|(index, &nodes)| cutter.add(index, 0, nodes)).collect();
    let slot = located.iter().map(|l| {
        let next = &mut start[flat(cells, l.cell)];
        *next += 1;
        (*next - 1) as u32
    });
    (cutter.tasks, slot.collect(), cutter.block * LANES)
}

/// The same by cell and body, for any number of bodies.
fn sort_by_body(
    lattice: &Lattice,
    located: &[Located],
    partition: &Partition,
) -> (Vec<Task>, Vec<u32>, usize) {
    let mut cutter = Cutter::new(lattice);
    let key = |node: usize| (flat(cutter.cells, located[node].cell), partition.of_node(node), node);
    let mut sorted: Vec<(usize, u32, usize)> = (0..located.len()).into_par_iter().map(key).collect();
    sorted.par_sort_unstable();
    let mut slot = vec![0; located.len()];
    for group in sorted.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let start = cutter.add(group[0].0, group[0].1, group.len());
        group.iter().zip(start..).for_each(|((.., node), at)| slot[*node] = at as u32);
    }
    (cutter.tasks, slot, cutter.block * LANES)
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
