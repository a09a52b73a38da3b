// SPDX-License-Identifier: GPL-3.0-or-later
//! The functions that a deformed mesh is made of: one for each control point, and what does not follow the control points.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;

use crate::basis::MAX_POINTS;
use crate::embedding::{EMPTY, Embedding, Task};
use crate::engine::Engine;
use crate::lanes::{LANES, Lanes};
use crate::walks::Walks;

/// Functions before those of the control points: x, y, z of what does not follow them. One more comes after them: the influence.
pub(crate) const FIXED: usize = 3;

/// The vertices of a binding as functions of its control points.
///
/// With `s` its influence, a vertex stands at `centre + e + s sum B (P - centre)`, where `e` is nothing but rounding if the lattice
/// at rest is the identity map and `s` is 1. That is `centre + e + sum s B (P - m) + s (m - centre)` for any `m`: functions `e`,
/// `s B` and `s`, times unit vectors, control points about `m`, and one vector that alone is large where the whole lattice
/// moved far away. A constant adds nothing to the volume of a closed surface, so neither does `s` where it is the same everywhere.
///
/// Control points are inner ones. With weights `w` the vectors are `w (P - m)` and the last function `s sum B w`, the influence on the
/// vertex: `s` is that over the denominator.
pub(crate) struct Source<L: Lanes> {
    pub(crate) engine: Arc<Engine<L>>,
    pub(crate) embedding: Arc<Embedding>,
    pub(crate) walks: Arc<Walks>,
    /// Inner control points at rest, about the centre, times their weights.
    pub(crate) rest: Vec<DVec3>,
    /// Those weights: 1 where the lattice has none.
    pub(crate) weights: Vec<f64>,
    pub(crate) is_weighted: bool,
    pub(crate) centre: DVec3,
    pub(crate) shape: [usize; 3],
}

/// A box of control points, that of the cells which a vertex and its neighbours stand in, and all vertices with that box.
pub(crate) struct Group {
    pub(crate) low: [usize; 3],
    pub(crate) size: [usize; 3],
    pub(crate) slots: Vec<u32>,
}

impl Group {
    /// Number of functions that the group's vertices and their neighbours are made of.
    pub(crate) fn functions(&self) -> usize {
        FIXED + self.size.iter().product::<usize>() + 1
    }

    /// Numbers of these functions in a lattice of `shape`, ascending.
    pub(crate) fn names(&self, shape: [usize; 3]) -> Vec<usize> {
        let ([i0, j0, k0], [nu, nv, nw]) = (self.low, self.size);
        let rows = (i0..i0 + nu).flat_map(|i| (j0..j0 + nv).map(move |j| (i * shape[1] + j) * shape[2] + k0));
        let points = rows.flat_map(|row| FIXED + row..FIXED + row + nw);
        let influence = FIXED + shape.iter().product::<usize>();
        (0..FIXED).chain(points).chain([influence]).collect()
    }
}

impl<L: Lanes> Source<L> {
    /// Number of functions altogether.
    pub(crate) fn functions(&self) -> usize {
        FIXED + self.rest.len() + 1
    }

    /// The vertices with triangles, by the functions that act on them and their neighbours.
    pub(crate) fn groups(&self) -> Vec<Group> {
        let mut groups: BTreeMap<[[usize; 3]; 2], Vec<u32>> = BTreeMap::new();
        for (slot, _) in self.embedding.node.iter().enumerate().filter(|(_, v)| **v != EMPTY) {
            let walk = self.walks.around_slot(slot);
            if walk.len() < 2 {
                continue;
            }
            let mut all = self.points_of(slot);
            for neighbour in walk {
                let [low, high] = self.points_of(neighbour as usize);
                for axis in 0..3 {
                    all[0][axis] = all[0][axis].min(low[axis]);
                    all[1][axis] = all[1][axis].max(high[axis]);
                }
            }
            groups.entry(all).or_default().push(slot as u32);
        }
        let group = |([low, high], slots): ([[usize; 3]; 2], _)| Group {
            low,
            size: std::array::from_fn(|axis| high[axis] - low[axis]),
            slots,
        };
        groups.into_iter().map(group).collect()
    }

    /// First control points that act on a slot, and one past the last.
    fn points_of(&self, slot: usize) -> [[usize; 3]; 2] {
        let task = self.task(slot);
        let taps = task.taps();
        [task.first_point, std::array::from_fn(|axis| task.first_point[axis] + taps[axis])]
    }

    fn task(&self, slot: usize) -> &Task {
        let block = slot / LANES;
        let tasks = &self.embedding.tasks;
        &tasks[tasks.partition_point(|task| task.blocks.end <= block)]
    }

    /// Values at a slot of a group's functions.
    pub(crate) fn evaluate(&self, group: &Group, slot: usize, row: &mut [f64]) {
        let task = self.task(slot);
        let (local, influence, position) = self.engine.slot(slot);
        let taps = task.taps();
        let mut basis = [[0.0; MAX_POINTS]; 3];
        for axis in 0..3 {
            let span = &task.spans[axis];
            span.evaluate(span.start() + local[axis], &mut basis[axis][..taps[axis]]);
        }
        row.fill(0.0);
        let (mut left, mut whole) = (position - self.centre, 0.0);
        for (i, wu) in basis[0][..taps[0]].iter().enumerate() {
            for (j, wv) in basis[1][..taps[1]].iter().enumerate() {
                let at = [task.first_point[0] + i, task.first_point[1] + j, task.first_point[2]];
                let [p, q, r]: [usize; 3] = std::array::from_fn(|axis| at[axis] - group.low[axis]);
                let first = (at[0] * self.shape[1] + at[1]) * self.shape[2] + at[2];
                let (rest, weights) = (&self.rest[first..], &self.weights[first..]);
                let row = &mut row[FIXED + (p * group.size[1] + q) * group.size[2] + r..];
                let plane = influence * wu * wv;
                let points = rest.iter().zip(weights);
                for ((value, ww), (rest, weight)) in row.iter_mut().zip(&basis[2][..taps[2]]).zip(points) {
                    *value = plane * ww;
                    left -= *value * rest;
                    whole += *value * weight;
                }
            }
        }
        row[..FIXED].copy_from_slice(&left.to_array());
        if let Some(last) = row.last_mut() {
            *last = if self.is_weighted { whole } else { influence };
        }
    }
}
