// SPDX-License-Identifier: GPL-3.0-or-later
//! The tensor times two columns of vectors: what the volume's gradient along the third axis is.

use std::ops::Range;

use rayon::prelude::*;

use crate::lanes::{F64x8, Kernel, LANES, Lanes, dispatch};
use crate::tensor::triples::Triples;

/// Lanes of triples that one thread goes through at least: twenty microseconds, against five that it takes to share work.
const PIECE: usize = 8192;

/// `sum_bc T_abc (y_b z_c - y_c z_b)` for every function `a`, `b < c`; the sign follows the order of the three. The same bits on
/// any number of threads.
pub(crate) fn contract(triples: &Triples, [y, z]: [&[F64x8]; 2]) -> Vec<f64> {
    let piece = |range: Range<usize>| dispatch(Contract { triples, y, z, range });
    let pieces = pieces(triples);
    let parts: Vec<Vec<f64>> = match pieces.len() {
        1 => pieces.into_iter().map(piece).collect(),
        _ => pieces.into_par_iter().map(piece).collect(),
    };
    let mut sums = vec![0.0; triples.functions()];
    for part in parts {
        sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    sums
}

/// All functions `b` but the first, which has no `a`, and the last, which has no `c`, in pieces of about the same work.
fn pieces(triples: &Triples) -> Vec<Range<usize>> {
    let last = triples.functions() - 1;
    let (mut pieces, mut start, mut lanes) = (Vec::new(), 1, 0);
    for b in 1..last {
        lanes += triples.of(b).len();
        if lanes > PIECE || b + 1 == last {
            pieces.push(start..b + 1);
            (start, lanes) = (b + 1, 0);
        }
    }
    pieces
}

/// The same over some functions `b`.
struct Contract<'a> {
    triples: &'a Triples,
    y: &'a [F64x8],
    z: &'a [F64x8],
    range: Range<usize>,
}

/// Sums under way: of the functions as `a`, in lanes; as `b`; as `c`, over lanes of `a`.
struct Sums {
    first: Vec<F64x8>,
    middle: Vec<f64>,
    last: Vec<F64x8>,
    /// For lanes of `a`: `y_a z_b - z_a y_b`, and the sums over `c` of `T y_c` and `T z_c`.
    work: Vec<[F64x8; 3]>,
}

impl Contract<'_> {
    #[inline(always)]
    fn of<const FUSED: bool>(&self, b: usize, sums: &mut Sums) {
        let [flat_y, flat_z]: [&[f64]; 2] = [bytemuck::cast_slice(self.y), bytemuck::cast_slice(self.z)];
        let (y_b, z_b) = (F64x8::splat(flat_y[b]), F64x8::splat(flat_z[b]));
        let layers = Triples::layers(b);
        let work = &mut sums.work[..layers];
        for ((work, y), z) in work.iter_mut().zip(self.y).zip(self.z) {
            *work = [y.times(z_b).minus(z.times(y_b)), F64x8::ZERO, F64x8::ZERO];
        }
        for (c, numbers) in (b + 1..).zip(self.triples.of(b).chunks_exact(layers)) {
            let (y_c, z_c) = (F64x8::splat(flat_y[c]), F64x8::splat(flat_z[c]));
            let mut last = sums.last[c];
            for ([across, by_y, by_z], number) in work.iter_mut().zip(numbers) {
                last = number.multiply_add::<FUSED>(*across, last);
                *by_y = number.multiply_add::<FUSED>(y_c, *by_y);
                *by_z = number.multiply_add::<FUSED>(z_c, *by_z);
            }
            sums.last[c] = last;
        }
        let mut middle = F64x8::ZERO;
        for (layer, [_, by_y, by_z]) in work.iter().enumerate() {
            let pull = by_z.times(y_b).minus(by_y.times(z_b));
            sums.first[layer] = pull.multiply_add::<FUSED>(F64x8::splat(1.0), sums.first[layer]);
            middle = by_y.multiply_add::<FUSED>(self.z[layer], middle);
            middle = middle.minus(by_z.times(self.y[layer]));
        }
        sums.middle[b] = middle.sum();
    }
}

impl Kernel for Contract<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Vec<f64> {
        let functions = self.triples.functions();
        let lanes = functions.div_ceil(LANES);
        let mut sums = Sums {
            first: vec![F64x8::ZERO; lanes],
            middle: vec![0.0; functions],
            last: vec![F64x8::ZERO; functions],
            work: vec![[F64x8::ZERO; 3]; lanes],
        };
        for b in self.range.clone() {
            self.of::<FUSED>(b, &mut sums);
        }
        let first: &[f64] = bytemuck::cast_slice(&sums.first);
        let mut all = sums.middle;
        for i in 0..functions {
            all[i] += first[i] + sums.last[i].sum();
        }
        all
    }
}
