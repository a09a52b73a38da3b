// SPDX-License-Identifier: GPL-3.0-or-later
//! The loops over vertices: basis, deformation, gradient and coefficients, one cell of the lattice at a time.
//!
//! All vertices of a [`Cell`] see the same `taps[0] x taps[1] x taps[2]` control points, so those are copied next to
//! each other once and every step is a small dense product with lanes over vertices.

use glam::DMat3;

use crate::basis::MAX_POINTS;
use crate::lanes::{F64x8, Kernel, Lanes};
use crate::vertices::Scalar;
use crate::walks::Walks;

/// The basis functions of one axis in one cell, of a parameter measured from the cell's start.
pub(crate) struct Basis<R> {
    /// Steps `(left knot, right knot, reciprocal of their difference)` of the Cox-de Boor recurrence.
    pub(crate) steps: Vec<[R; 3]>,
    /// Of a cubic, the four functions as polynomials: coefficients from the constant up.
    pub(crate) cubic: Option<[[R; 4]; 4]>,
}

/// What a run of vertices in one cell of the lattice shares, and their fixed data.
pub(crate) struct Cell<'a, L: Lanes> {
    /// Control points that act in the cell, along each axis.
    pub(crate) taps: [usize; 3],
    /// The basis along s, t, u.
    pub(crate) basis: &'a [Basis<L::Real>; 3],
    /// Parameters s, t, u of the vertices, measured from the cell's start.
    pub(crate) parameter: &'a [[L; 3]],
    /// Influence of the lattice on the vertices; 0 in empty lanes.
    pub(crate) influence: &'a [L],
}

impl<L: Lanes> Cell<'_, L> {
    /// Basis functions along the three axes for one block of vertices.
    #[inline(always)]
    fn weights<const FUSED: bool, const MAX: usize>(
        &self,
        taps: [usize; 3],
        block: usize,
        weights: &mut [[L; MAX]; 3],
    ) {
        for axis in 0..3 {
            let (t, basis) = (self.parameter[block][axis], &self.basis[axis]);
            match (&basis.cubic, weights[axis].first_chunk_mut::<4>()) {
                (Some(cubic), Some(weights)) => polynomials::<L, FUSED>(t, cubic, weights),
                _ => recurrence::<L, FUSED>(t, &basis.steps, &mut weights[axis][..taps[axis]]),
            }
        }
    }
}

/// Values of a cubic's basis functions at `t` by Horner's scheme, which takes less than half as long as the recurrence. At this
/// degree and within one cell its rounding is that of the recurrence.
#[inline(always)]
fn polynomials<L: Lanes, const FUSED: bool>(t: L, coefficients: &[[L::Real; 4]; 4], weights: &mut [L; 4]) {
    for i in 0..4 {
        let [a, b, c, d] = coefficients[i];
        let linear = L::splat(d).multiply_add::<FUSED>(t, L::splat(c));
        let quadratic = linear.multiply_add::<FUSED>(t, L::splat(b));
        weights[i] = quadratic.multiply_add::<FUSED>(t, L::splat(a));
    }
}

/// Values of all basis functions at `t` by the Cox-de Boor recurrence: sums of non-negative products, so stable at every
/// degree.
#[inline(always)]
fn recurrence<L: Lanes, const FUSED: bool>(t: L, steps: &[[L::Real; 3]], weights: &mut [L]) {
    weights[0] = L::splat(L::Real::from_f64(1.0));
    let mut step = 0;
    for order in 1..weights.len() {
        let mut carried = L::ZERO;
        for weight in &mut weights[..order] {
            let [left, right, inverse] = steps[step];
            let part = weight.times(L::splat(inverse));
            *weight = L::splat(right).minus(t).multiply_add::<FUSED>(part, carried);
            carried = t.minus(L::splat(left)).times(part);
            step += 1;
        }
        weights[order] = carried;
    }
}

/// Chooses a body compiled for the cubic, by far the commonest, or one for any degree.
macro_rules! by_taps {
    ($self:ident . $body:ident) => {
        match $self.cell.taps {
            [4, 4, 4] => $self.$body::<FUSED, 4>([4, 4, 4]),
            taps => $self.$body::<FUSED, MAX_POINTS>(taps),
        }
    };
}

/// `out = M (rest + influence * B displacement)`: the deformation, equation (1), in displacement form.
pub(crate) struct Deform<'a, L: Lanes> {
    pub(crate) cell: Cell<'a, L>,
    /// The cell's control displacements, x y z interleaved.
    pub(crate) displacement: &'a [L::Real],
    pub(crate) rest: [&'a [L]; 3],
    /// Linear map to apply to the result, if any.
    pub(crate) map: Option<DMat3>,
    pub(crate) out: [&'a mut [L]; 3],
}

impl<L: Lanes> Deform<'_, L> {
    #[inline(always)]
    fn body<const FUSED: bool, const MAX: usize>(self, taps: [usize; 3]) {
        let [x, y, z] = self.out;
        let mut weights = [[L::ZERO; MAX]; 3];
        for block in 0..self.cell.parameter.len() {
            self.cell.weights::<FUSED, MAX>(taps, block, &mut weights);
            let mut moved = [L::ZERO; 3];
            let mut rows = self.displacement.chunks_exact(3 * taps[2]);
            for wu in &weights[0][..taps[0]] {
                let mut plane = [L::ZERO; 3];
                for wv in &weights[1][..taps[1]] {
                    let Some(points) = rows.next() else { break };
                    let mut row = [L::ZERO; 3];
                    for (ww, point) in weights[2][..taps[2]].iter().zip(points.as_chunks::<3>().0) {
                        for c in 0..3 {
                            row[c] = ww.multiply_add::<FUSED>(L::splat(point[c]), row[c]);
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
                moved = transform::<L, FUSED>(map, moved);
            }
            [x[block], y[block], z[block]] = moved;
        }
    }
}

impl<L: Lanes> Kernel for Deform<'_, L> {
    type Output = ();
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        by_taps!(self.body);
    }
}

#[inline(always)]
fn transform<L: Lanes, const FUSED: bool>(map: DMat3, point: [L; 3]) -> [L; 3] {
    let columns = [map.x_axis.to_array(), map.y_axis.to_array(), map.z_axis.to_array()];
    let mut mapped = [F64x8::ZERO; 3];
    for row in 0..3 {
        for (column, part) in columns.iter().zip(&point) {
            mapped[row] = part.exact().multiply_add::<FUSED>(F64x8::splat(column[row]), mapped[row]);
        }
    }
    let [x, y, z] = mapped;
    [L::rounded(x), L::rounded(y), L::rounded(z)]
}

/// `coordinate += influence * B delta` for one coordinate: a step of the correction.
pub(crate) struct Shift<'a, L: Lanes> {
    pub(crate) cell: Cell<'a, L>,
    /// The cell's part of the step, one number per control point.
    pub(crate) delta: &'a [L::Real],
    pub(crate) coordinate: &'a mut [L],
}

impl<L: Lanes> Shift<'_, L> {
    #[inline(always)]
    fn body<const FUSED: bool, const MAX: usize>(self, taps: [usize; 3]) {
        let mut weights = [[L::ZERO; MAX]; 3];
        for (block, coordinate) in self.coordinate.iter_mut().enumerate() {
            self.cell.weights::<FUSED, MAX>(taps, block, &mut weights);
            let mut moved = L::ZERO;
            let mut rows = self.delta.chunks_exact(taps[2]);
            for wu in &weights[0][..taps[0]] {
                let mut plane = L::ZERO;
                for wv in &weights[1][..taps[1]] {
                    let Some(points) = rows.next() else { break };
                    let mut row = L::ZERO;
                    for (ww, point) in weights[2][..taps[2]].iter().zip(points) {
                        row = ww.multiply_add::<FUSED>(L::splat(*point), row);
                    }
                    plane = wv.multiply_add::<FUSED>(row, plane);
                }
                moved = wu.multiply_add::<FUSED>(plane, moved);
            }
            *coordinate = self.cell.influence[block].multiply_add::<FUSED>(moved, *coordinate);
        }
    }
}

impl<L: Lanes> Kernel for Shift<'_, L> {
    type Output = ();
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        by_taps!(self.body);
    }
}

/// For one axis the gradient of the volume at the cell's vertices, taken through the basis to its control points: the
/// cell's share of the paper's alpha, beta or gamma (10)-(12); and the cell's share of the volume.
pub(crate) struct Reduce<'a, L: Lanes> {
    pub(crate) cell: Cell<'a, L>,
    /// First block of the run.
    pub(crate) first_block: usize,
    /// Walks of neighbours around all slots.
    pub(crate) walks: &'a Walks,
    /// All slots' coordinates along the axis, and along the next two in cyclic order.
    pub(crate) along: &'a [L],
    pub(crate) next: [&'a [L]; 2],
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

impl<L: Lanes> Reduce<'_, L> {
    /// Six times `dV / d coordinate` of a block's vertices: twice the area that each walk of neighbours encloses in the
    /// plane across the axis, `sum (p_i - p) (q_i+1 - q_i-1)`, in float64. Taking `p` off the first factor changes nothing
    /// and spares rounding.
    #[inline(always)]
    fn gradient<const FUSED: bool>(&self, block: usize) -> F64x8 {
        let walk = self.walks.around(block);
        let [p, q] = self.next;
        let (Some(first), Some(last)) = (walk.first(), walk.last()) else { return F64x8::ZERO };
        let own = p[block].exact();
        let start = self.walks.gather(q, first);
        let (mut before, mut here) = (self.walks.gather(q, last), start);
        let mut arm = self.walks.gather(p, first).minus(own);
        let mut sum = F64x8::ZERO;
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
        let mut weights = [[L::ZERO; MAX]; 3];
        let mut sums = vec![L::ZERO; taps[0] * taps[1] * taps[2]];
        let mut volume = F64x8::ZERO;
        for local in 0..self.cell.parameter.len() {
            let block = self.first_block + local;
            let gradient = self.gradient::<FUSED>(block);
            let along = self.along[block].exact().minus(F64x8::splat(self.middle));
            volume = along.multiply_add::<FUSED>(gradient, volume);
            self.cell.weights::<FUSED, MAX>(taps, local, &mut weights);
            let pull = L::rounded(gradient).times(self.cell.influence[local]);
            spread::<L, FUSED, MAX>(pull, &weights, taps, &mut sums);
        }
        Reduced { coefficients: sums.iter().map(|sum| sum.sum() / 6.0).collect(), volume: volume.sum() / 6.0 }
    }
}

/// Adds `pull * B` to the sums of the cell's control points.
#[inline(always)]
fn spread<L: Lanes, const FUSED: bool, const MAX: usize>(
    pull: L,
    weights: &[[L; MAX]; 3],
    taps: [usize; 3],
    sums: &mut [L],
) {
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

impl<L: Lanes> Kernel for Reduce<'_, L> {
    type Output = Reduced;
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Reduced {
        by_taps!(self.body)
    }
}

/// `sum influence * B * value`, one number per control point of the cell: what the values at its vertices come to there.
pub(crate) struct Pull<'a, L: Lanes> {
    pub(crate) cell: Cell<'a, L>,
    /// Values of the run's vertices.
    pub(crate) values: &'a [L],
}

impl<L: Lanes> Pull<'_, L> {
    #[inline(always)]
    fn body<const FUSED: bool, const MAX: usize>(self, taps: [usize; 3]) -> Vec<f64> {
        let mut weights = [[L::ZERO; MAX]; 3];
        let mut sums = vec![L::ZERO; taps[0] * taps[1] * taps[2]];
        for local in 0..self.cell.parameter.len() {
            self.cell.weights::<FUSED, MAX>(taps, local, &mut weights);
            let pull = self.values[local].times(self.cell.influence[local]);
            spread::<L, FUSED, MAX>(pull, &weights, taps, &mut sums);
        }
        sums.iter().map(|sum| sum.sum()).collect()
    }
}

impl<L: Lanes> Kernel for Pull<'_, L> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Vec<f64> {
        by_taps!(self.body)
    }
}
