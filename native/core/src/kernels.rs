// SPDX-License-Identifier: GPL-3.0-or-later
//! The loops over vertices: basis, deformation, gradient and coefficients, one cell of the lattice at a time.
//!
//! All vertices of a [`Cell`] see the same `taps[0] x taps[1] x taps[2]` control points, so those are copied next to
//! each other once and every step is a small dense product with lanes over vertices.

use glam::DMat3;

use crate::basis::{MAX_POINTS, Span};
use crate::lanes::{Kernel, Lanes};
use crate::walks::Walks;

/// Coordinate arrays x, y, z of vertices in slot order.
pub(crate) type Columns<'a> = [&'a [Lanes]; 3];

/// What a run of vertices in one cell of the lattice shares, and their fixed data.
#[derive(Clone, Copy)]
pub(crate) struct Cell<'a> {
    /// The knots around the cell along s, t, u.
    pub(crate) spans: [&'a Span; 3],
    /// Parameters s, t, u of the vertices.
    pub(crate) parameter: &'a [[Lanes; 3]],
    /// Influence of the lattice on the vertices; 0 in empty lanes.
    pub(crate) influence: &'a [Lanes],
}

impl Cell<'_> {
    /// Control points that act in the cell, along each axis.
    pub(crate) fn taps(&self) -> [usize; 3] {
        self.spans.map(|span| span.degree() + 1)
    }

    /// Basis functions along the three axes for one block of vertices, by the Cox-de Boor recurrence.
    #[inline(always)]
    fn weights<const FUSED: bool, const MAX: usize>(
        &self,
        taps: [usize; 3],
        block: usize,
        weights: &mut [[Lanes; MAX]; 3],
    ) {
        for axis in 0..3 {
            let t = self.parameter[block][axis];
            let steps = self.spans[axis].steps();
            let weights = &mut weights[axis];
            weights[0] = Lanes::splat(1.0);
            let mut step = 0;
            for order in 1..taps[axis] {
                let mut carried = Lanes::ZERO;
                for weight in weights[..order].iter_mut() {
                    let [left, right, inverse] = steps[step];
                    let part = weight.times(Lanes::splat(inverse));
                    *weight = Lanes::splat(right).minus(t).multiply_add::<FUSED>(part, carried);
                    carried = t.minus(Lanes::splat(left)).times(part);
                    step += 1;
                }
                weights[order] = carried;
            }
        }
    }
}

/// Chooses a body compiled for the cubic, by far the commonest, or one for any degree.
macro_rules! by_taps {
    ($self:ident . $body:ident) => {
        match $self.cell.taps() {
            [4, 4, 4] => $self.$body::<FUSED, 4>([4, 4, 4]),
            taps => $self.$body::<FUSED, MAX_POINTS>(taps),
        }
    };
}

/// `out = M (rest + influence * B displacement)`: the deformation, equation (1), in displacement form.
pub(crate) struct Deform<'a> {
    pub(crate) cell: Cell<'a>,
    /// The cell's control displacements, x y z interleaved.
    pub(crate) displacement: &'a [f64],
    pub(crate) rest: Columns<'a>,
    /// Linear map to apply to the result, if any.
    pub(crate) map: Option<DMat3>,
    pub(crate) out: [&'a mut [Lanes]; 3],
}

impl Deform<'_> {
    #[inline(always)]
    fn body<const FUSED: bool, const MAX: usize>(self, taps: [usize; 3]) {
        let [x, y, z] = self.out;
        let mut weights = [[Lanes::ZERO; MAX]; 3];
        for block in 0..self.cell.parameter.len() {
            self.cell.weights::<FUSED, MAX>(taps, block, &mut weights);
            let mut moved = [Lanes::ZERO; 3];
            let mut rows = self.displacement.chunks_exact(3 * taps[2]);
            for wu in &weights[0][..taps[0]] {
                let mut plane = [Lanes::ZERO; 3];
                for wv in &weights[1][..taps[1]] {
                    let Some(points) = rows.next() else { break };
                    let mut row = [Lanes::ZERO; 3];
                    for (ww, point) in weights[2][..taps[2]].iter().zip(points.as_chunks::<3>().0) {
                        for c in 0..3 {
                            row[c] = ww.multiply_add::<FUSED>(Lanes::splat(point[c]), row[c]);
                        }
                    }
                    for c in 0..3 {
                        plane[c] = wv.multiply_add::<FUSED>(row[c], plane[c]);
                    }
                }
                for c in 0..3 {
                    moved[c] = wu.multiply_add::<FUSED>(plane[c], moved[c]);
                }
            }
            let influence = self.cell.influence[block];
            for (moved, rest) in moved.iter_mut().zip(&self.rest) {
                *moved = influence.multiply_add::<FUSED>(*moved, rest[block]);
            }
            if let Some(map) = self.map {
                moved = transform::<FUSED>(map, moved);
            }
            [x[block], y[block], z[block]] = moved;
        }
    }
}

impl Kernel for Deform<'_> {
    type Output = ();
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        by_taps!(self.body);
    }
}

#[inline(always)]
fn transform<const FUSED: bool>(map: DMat3, point: [Lanes; 3]) -> [Lanes; 3] {
    let columns = [map.x_axis.to_array(), map.y_axis.to_array(), map.z_axis.to_array()];
    let mut mapped = [Lanes::ZERO; 3];
    for row in 0..3 {
        for (column, part) in columns.iter().zip(&point) {
            mapped[row] = part.multiply_add::<FUSED>(Lanes::splat(column[row]), mapped[row]);
        }
    }
    mapped
}

/// `coordinate += influence * B delta` for one coordinate: a step of the correction.
pub(crate) struct Shift<'a> {
    pub(crate) cell: Cell<'a>,
    /// The cell's part of the step, one number per control point.
    pub(crate) delta: &'a [f64],
    pub(crate) coordinate: &'a mut [Lanes],
}

impl Shift<'_> {
    #[inline(always)]
    fn body<const FUSED: bool, const MAX: usize>(self, taps: [usize; 3]) {
        let mut weights = [[Lanes::ZERO; MAX]; 3];
        for (block, coordinate) in self.coordinate.iter_mut().enumerate() {
            self.cell.weights::<FUSED, MAX>(taps, block, &mut weights);
            let mut moved = Lanes::ZERO;
            let mut rows = self.delta.chunks_exact(taps[2]);
            for wu in &weights[0][..taps[0]] {
                let mut plane = Lanes::ZERO;
                for wv in &weights[1][..taps[1]] {
                    let Some(points) = rows.next() else { break };
                    let mut row = Lanes::ZERO;
                    for (ww, point) in weights[2][..taps[2]].iter().zip(points) {
                        row = ww.multiply_add::<FUSED>(Lanes::splat(*point), row);
                    }
                    plane = wv.multiply_add::<FUSED>(row, plane);
                }
                moved = wu.multiply_add::<FUSED>(plane, moved);
            }
            *coordinate = self.cell.influence[block].multiply_add::<FUSED>(moved, *coordinate);
        }
    }
}

impl Kernel for Shift<'_> {
    type Output = ();
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        by_taps!(self.body);
    }
}

/// For one axis the gradient of the volume at the cell's vertices, taken through the basis to its control points: the
/// cell's share of the paper's alpha, beta or gamma (10)-(12); and the cell's share of the volume.
pub(crate) struct Reduce<'a> {
    pub(crate) cell: Cell<'a>,
    /// First block of the run.
    pub(crate) first_block: usize,
    /// Walks of neighbours around all slots.
    pub(crate) walks: &'a Walks,
    /// All slots' coordinates along the axis, and along the next two in cyclic order.
    pub(crate) along: &'a [Lanes],
    pub(crate) next: [&'a [Lanes]; 2],
    /// Origin for the volume's sum along the axis.
    pub(crate) middle: f64,
}

/// One cell's sums.
pub(crate) struct Reduced {
    /// `sum influence * B * gradient`, one number per control point of the cell.
    pub(crate) coefficients: Vec<f64>,
    /// `sum (coordinate - middle) * gradient`.
    pub(crate) volume: f64,
}

impl Reduce<'_> {
    /// Six times `dV / d coordinate` of a block's vertices: twice the area that each walk of neighbours encloses in the
    /// plane across the axis, `sum (p_i - p) (q_i+1 - q_i-1)`. Taking `p` off the first factor changes nothing and spares
    /// rounding.
    #[inline(always)]
    fn gradient<const FUSED: bool>(&self, block: usize) -> Lanes {
        let walk = self.walks.around(block);
        let [p, q] = self.next;
        let (Some(first), Some(last)) = (walk.first(), walk.last()) else { return Lanes::ZERO };
        let own = p[block];
        let start = self.walks.gather(q, first);
        let (mut before, mut here) = (self.walks.gather(q, last), start);
        let mut arm = self.walks.gather(p, first).minus(own);
        let mut sum = Lanes::ZERO;
        for step in &walk[1..] {
            let after = self.walks.gather(q, step);
            sum = arm.multiply_add::<FUSED>(after.minus(before), sum);
            (before, here) = (here, after);
            arm = self.walks.gather(p, step).minus(own);
        }
        arm.multiply_add::<FUSED>(start.minus(before), sum)
    }

    #[inline(always)]
    fn body<const FUSED: bool, const MAX: usize>(self, taps: [usize; 3]) -> Reduced {
        let mut weights = [[Lanes::ZERO; MAX]; 3];
        let mut sums = vec![Lanes::ZERO; taps[0] * taps[1] * taps[2]];
        let mut volume = Lanes::ZERO;
        for local in 0..self.cell.parameter.len() {
            let block = self.first_block + local;
            let gradient = self.gradient::<FUSED>(block);
            let along = self.along[block].minus(Lanes::splat(self.middle));
            volume = along.multiply_add::<FUSED>(gradient, volume);
            self.cell.weights::<FUSED, MAX>(taps, local, &mut weights);
            let pull = gradient.times(self.cell.influence[local]);
            let mut rows = sums.chunks_exact_mut(taps[2]);
            for wu in &weights[0][..taps[0]] {
                let plane = pull.times(*wu);
                for wv in &weights[1][..taps[1]] {
                    let Some(sums) = rows.next() else { break };
                    let row = plane.times(*wv);
                    for (ww, sum) in weights[2][..taps[2]].iter().zip(sums) {
                        *sum = row.multiply_add::<FUSED>(*ww, *sum);
                    }
                }
            }
        }
        Reduced { coefficients: sums.iter().map(|sum| sum.sum() / 6.0).collect(), volume: volume.sum() / 6.0 }
    }
}

impl Kernel for Reduce<'_> {
    type Output = Reduced;
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Reduced {
        by_taps!(self.body)
    }
}
