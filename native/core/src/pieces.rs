// SPDX-License-Identifier: GPL-3.0-or-later
//! Small pieces of a shaped lattice with boxes around them, to find which may hold a point.

use glam::{DMat3, DVec3};

use crate::basis::AxisBasis;
use crate::lattice::{Lattice, bounds};

/// Pieces along an axis for each of its control points but one, and the most and least of them.
const PIECES_PER_POINT: usize = 2;
const MOST_PIECES: usize = 32;
const LEAST_PIECES: usize = 4;
/// Pieces along an axis that share one box, so that most are never looked at.
const GROUPED: usize = 4;
/// Places from which the nearest is looked for, at most.
pub(crate) const NEAREST: usize = 2;
/// Room on each side of a piece's box, as a fraction of its size: between its corners the lattice is curved.
const ROOM: f64 = 0.5;

/// Boxes, around small pieces of the lattice, and around groups of them.
pub(crate) struct Pieces {
    /// Axes with more than one control point; along others the lattice has no end.
    solid: [bool; 3],
    groups: Vec<([DVec3; 2], Vec<Piece>)>,
}

struct Piece {
    bounds: [DVec3; 2],
    /// Middle of the piece in parameters, and where the lattice takes it.
    middle: DVec3,
    at: DVec3,
}

impl Pieces {
    /// Pieces of the lattice `base(s) + sum B(s) bend`, or, with weights, of `base(s) + sum B(s) bend / sum B(s) weights`, over inner
    /// control points.
    pub(crate) fn new(
        lattice: &Lattice,
        bend: &[DVec3],
        weights: Option<&[f64]>,
        base: impl Fn(DVec3) -> DVec3,
    ) -> Self {
        let count = lattice.axes().each_ref().map(|axis| match axis.count() {
            1 => 1,
            points => (PIECES_PER_POINT * (points - 1)).clamp(LEAST_PIECES, MOST_PIECES),
        });
        let mut samples = samples(lattice, bend, count);
        if let Some(weights) = weights {
            let weights: Vec<DVec3> = weights.iter().map(|&weight| DVec3::splat(weight)).collect();
            let wholes = self::samples(lattice, &weights, count);
            samples.iter_mut().zip(wholes).for_each(|(sample, whole)| *sample /= whole);
        }
        let [_, nt, nu] = count.map(|n| 2 * n + 1);
        let parameter =
            |at: [usize; 3]| DVec3::from_array(std::array::from_fn(|a| at[a] as f64 / (2 * count[a]) as f64));
        let sample = |at: [usize; 3]| base(parameter(at)) + samples[(at[0] * nt + at[1]) * nu + at[2]];
        let piece = |index: [usize; 3]| {
            let middle = index.map(|i| 2 * i + 1);
            let corners = (0..8).map(|c| sample(std::array::from_fn(|a| 2 * index[a] + 2 * (c >> a & 1))));
            let all: Vec<DVec3> = corners.chain([sample(middle)]).collect();
            let (low, high) = bounds(&all);
            let room = (high - low) * ROOM;
            Piece { bounds: [low - room, high + room], middle: parameter(middle), at: sample(middle) }
        };
        let solid = lattice.axes().each_ref().map(|axis| axis.count() > 1);
        let mut pieces = Self { solid, groups: Vec::new() };
        for start in indices(count.map(|n| n.div_ceil(GROUPED))) {
            let ends: [usize; 3] = std::array::from_fn(|a| (count[a] - GROUPED * start[a]).min(GROUPED));
            let members: Vec<Piece> = indices(ends)
                .map(|within| piece(std::array::from_fn(|a| GROUPED * start[a] + within[a])))
                .collect();
            let all = members.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], piece| {
                [low.min(piece.bounds[0]), high.max(piece.bounds[1])]
            });
            pieces.groups.push((all, members));
        }
        pieces
    }

    /// Middles of the pieces that may hold the point, each with its squared distance; none where no piece can.
    pub(crate) fn holding(&self, local: DVec3, metric: DMat3) -> Vec<(f64, DVec3)> {
        let holds = |[low, high]: &[DVec3; 2]| {
            (0..3).all(|axis| !self.solid[axis] || (low[axis]..=high[axis]).contains(&local[axis]))
        };
        let groups = self.groups.iter().filter(|(bounds, _)| holds(bounds));
        let found = groups.flat_map(|(_, group)| group.iter().filter(|piece| holds(&piece.bounds)));
        found.map(|piece| self.start(piece, local, metric)).collect()
    }

    /// A piece's middle, at the point's own place along axes without faces.
    fn start(&self, piece: &Piece, local: DVec3, metric: DMat3) -> (f64, DVec3) {
        let (mut middle, mut way) = (piece.middle, piece.at - local);
        for axis in (0..3).filter(|&axis| !self.solid[axis]) {
            (middle[axis], way[axis]) = (local[axis], 0.0);
        }
        (way.dot(metric * way), middle)
    }

    /// Middles of the pieces nearest to the point, of the best groups one each, in the distance of a `metric` that is at least
    /// `least` times the plain one.
    pub(crate) fn nearest(&self, local: DVec3, metric: DMat3, least: f64) -> Vec<(f64, DVec3)> {
        let mut best: Vec<(f64, DVec3)> = Vec::with_capacity(NEAREST + 1);
        for ([low, high], group) in &self.groups {
            let mut way = local - local.clamp(*low, *high);
            (0..3).filter(|&axis| !self.solid[axis]).for_each(|axis| way[axis] = 0.0);
            let worst = if best.len() < NEAREST { f64::INFINITY } else { best[NEAREST - 1].0 };
            if least * way.length_squared() >= worst {
                continue;
            }
            let starts = group.iter().map(|piece| self.start(piece, local, metric));
            if let Some(start) = starts.min_by(|a, b| a.0.total_cmp(&b.0)) {
                let place = best.partition_point(|other| other.0 <= start.0);
                best.insert(place, start);
                best.truncate(NEAREST);
            }
        }
        best
    }
}

/// `sum B bend` at all corners and middles of the pieces: `2 count + 1` values along each axis, u fastest.
fn samples(lattice: &Lattice, bend: &[DVec3], count: [usize; 3]) -> Vec<DVec3> {
    let mut shape = lattice.map().inner_shape();
    let mut values = bend.to_vec();
    for axis in 0..3 {
        let rows = sampled_basis(&lattice.axes()[axis], 2 * count[axis] + 1);
        values = contracted(&values, shape, axis, &rows);
        shape[axis] = rows.len();
    }
    values
}

/// All indices below `count` along three axes.
pub(crate) fn indices(count: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [a, b, c] = count;
    (0..a).flat_map(move |i| (0..b).flat_map(move |j| (0..c).map(move |k| [i, j, k])))
}

/// All basis functions of an axis at `count` evenly spaced parameters.
fn sampled_basis(basis: &AxisBasis, count: usize) -> Vec<Vec<f64>> {
    (0..count)
        .map(|i| {
            let t = i as f64 / (count - 1) as f64;
            let cell = basis.cell(t);
            let (first, mut row) = (basis.first_point(cell), vec![0.0; basis.inner_count()]);
            basis.span(cell).evaluate(t, &mut row[first..=first + basis.degree()]);
            row
        })
        .collect()
}

/// A tensor of `shape` with one axis replaced by its products with `rows`.
pub(crate) fn contracted(values: &[DVec3], shape: [usize; 3], axis: usize, rows: &[Vec<f64>]) -> Vec<DVec3> {
    let stride: usize = shape[axis + 1..].iter().product();
    let outer: usize = shape[..axis].iter().product();
    let mut out = vec![DVec3::ZERO; outer * rows.len() * stride];
    let lines = out.chunks_mut(stride);
    for (line, (block, row)) in
        lines.zip((0..outer).flat_map(|block| rows.iter().map(move |row| (block, row))))
    {
        let values = &values[block * shape[axis] * stride..];
        if let [sum] = line {
            *sum = values.iter().zip(row).map(|(&value, &weight)| weight * value).sum();
            continue;
        }
        let inputs = values.chunks(stride);
        for (input, &weight) in inputs.zip(row).filter(|(_, weight)| **weight != 0.0) {
            line.iter_mut().zip(input).for_each(|(sum, &value)| *sum += weight * value);
        }
    }
    out
}
