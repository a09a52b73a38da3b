// SPDX-License-Identifier: GPL-3.0-or-later
//! The passes over all vertices, in lanes of float32 or float64.

use std::sync::{Mutex, PoisonError};

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::basis::Span;
use crate::embedding::{EMPTY, Embedding, Located, Task, split};
use crate::kernels::{Basis, Cell, Deform, Pull, Reduce, Reduced, Shift};
use crate::lanes::{LANES, Lanes, dispatch};
use crate::preserve::Coefficients;
use crate::sum::CompensatedSum;
use crate::vertices::Scalar;
use crate::walks::Walks;

/// Coordinates x, y, z of all slots.
pub(crate) type State<L> = [Vec<L>; 3];

/// A binding's vertices in lanes.
pub(crate) struct Engine<L: Lanes> {
    shape: [usize; 3],
    cells: Vec<CellData<L::Real>>,
    parameter: Vec<[L; 3]>,
    influence: Vec<L>,
    rest: State<L>,
    /// Coordinate arrays of finished calls, kept for the next.
    spare: Mutex<Vec<State<L>>>,
}

/// The basis and the control points of one task's cell.
struct CellData<R> {
    basis: [Basis<R>; 3],
    taps: [usize; 3],
    points: Vec<u32>,
}

impl<L: Lanes> Engine<L> {
    /// Puts located nodes into lanes, in slot order. `shape`: inner control points of the lattice, which `displacement`, `delta` and
    /// coefficients are of.
    pub(crate) fn new<T: Scalar>(
        embedding: &Embedding,
        located: &[Located],
        vertices: &[[T; 3]],
        shape: [usize; 3],
    ) -> Self {
        let cells = embedding.tasks.iter().map(|task| CellData::new(task, shape)).collect();
        let blocks = embedding.node.as_chunks::<LANES>().0;
        let mut starts = vec![[0.0; 3]; embedding.blocks()];
        for task in &embedding.tasks {
            starts[task.blocks.clone()].fill(task.spans.each_ref().map(Span::start));
        }
        let lanes = |pick: &(dyn Fn(usize) -> f64 + Sync)| -> Vec<L> {
            let number = |n: u32| L::Real::from_f64(if n == EMPTY { 0.0 } else { pick(n as usize) });
            blocks.par_iter().map(|block| L::of(block.map(number))).collect()
        };
        let parameter = blocks.par_iter().zip(&starts).map(|(block, start)| {
            // Empty lanes repeat the block's first node, whose parameters suit the cell.
            let of = |n: u32| &located[(if n == EMPTY { block[0] } else { n }) as usize].parameter;
            std::array::from_fn(|axis| L::of(block.map(|n| L::Real::from_f64(of(n)[axis] - start[axis]))))
        });
        Self {
            shape,
            cells,
            parameter: parameter.collect(),
            influence: lanes(&|n| located[n].inner_influence),
            rest: std::array::from_fn(|axis| lanes(&|n| vertices[embedding.vertex(n as u32)][axis].to_f64())),
            spare: Mutex::default(),
        }
    }

    /// All slots deformed by control displacements, then mapped linearly.
    pub(crate) fn deformed(&self, tasks: &[Task], displacement: &[DVec3], map: Option<DMat3>) -> State<L> {
        let mut state = self.take_state();
        let [x, y, z] = state.each_mut().map(|column| split(column, lengths(tasks)));
        tasks.par_iter().zip(&self.cells).zip(x).zip(y).zip(z).for_each(|((((task, data), x), y), z)| {
            let to_real = |p: &u32| displacement[*p as usize].to_array().map(L::Real::from_f64);
            let local: Vec<[L::Real; 3]> = data.points.iter().map(to_real).collect();
            dispatch(Deform {
                cell: self.cell(task, data),
                displacement: local.as_flattened(),
                rest: self.rest.each_ref().map(|column| &column[task.blocks.clone()]),
                map,
                out: [x, y, z],
            });
        });
        state
    }

    /// Adds `influence * B delta` to one coordinate of all slots.
    pub(crate) fn shift(&self, tasks: &[Task], coordinate: &mut [L], delta: &[f64]) {
        let runs = split(coordinate, lengths(tasks));
        tasks.par_iter().zip(&self.cells).zip(runs).for_each(|((task, data), run)| {
            let local: Vec<L::Real> =
                data.points.iter().map(|&p| L::Real::from_f64(delta[p as usize])).collect();
            dispatch(Shift { cell: self.cell(task, data), delta: &local, coordinate: run });
        });
    }

    /// The paper's coefficients (10)-(12) for one axis of the state, and the state's volume, both through the gradient
    /// at the vertices, of every body. Tasks are added in their order. `middles`: origin of each body's volume along the axis.
    pub(crate) fn coefficients(
        &self,
        tasks: &[Task],
        walks: &Walks,
        state: &State<L>,
        axis: usize,
        middles: &[f64],
    ) -> Coefficients {
        let reduce = |(task, data): (&Task, &CellData<L::Real>)| {
            middles.get(task.body as usize).map(|&middle| {
                dispatch(Reduce {
                    cell: self.cell(task, data),
                    first_block: task.blocks.start,
                    walks,
                    along: &state[axis],
                    next: [&state[(axis + 1) % 3], &state[(axis + 2) % 3]],
                    middle,
                })
            })
        };
        let parts: Vec<Option<Reduced>> = tasks.par_iter().zip(&self.cells).map(reduce).collect();
        let mut rows = vec![vec![0.0; self.shape.iter().product()]; middles.len()];
        let mut volumes = vec![CompensatedSum::default(); middles.len()];
        for ((task, data), part) in tasks.iter().zip(&self.cells).zip(&parts) {
            let Some(part) = part else { continue };
            let row = &mut rows[task.body as usize];
            for (&point, c) in data.points.iter().zip(&part.coefficients) {
                row[point as usize] += c;
            }
            volumes[task.body as usize].add(part.volume);
        }
        Coefficients { rows, volumes: volumes.into_iter().map(CompensatedSum::value).collect() }
    }

    /// `sum influence * B * value` over all slots, one number per control point. Cells without values cost nothing.
    pub(crate) fn pulled(&self, tasks: &[Task], values: &[L]) -> Vec<f64> {
        let pull = |(task, data): (&Task, &CellData<L::Real>)| {
            let values = &values[task.blocks.clone()];
            let is_empty = values.iter().all(|lanes| lanes.exact().0 == [0.0; LANES]);
            (!is_empty).then(|| dispatch(Pull { cell: self.cell(task, data), values }))
        };
        let parts: Vec<Option<Vec<f64>>> = tasks.par_iter().zip(&self.cells).map(pull).collect();
        let mut row = vec![0.0; self.shape.iter().product()];
        for (data, part) in self.cells.iter().zip(&parts) {
            let Some(part) = part else { continue };
            data.points.iter().zip(part).for_each(|(&point, sum)| row[point as usize] += sum);
        }
        row
    }

    /// One slot's parameters from its cell's start, influence, and position at rest.
    pub(crate) fn slot(&self, slot: usize) -> ([f64; 3], f64, DVec3) {
        let (block, lane) = (slot / LANES, slot % LANES);
        let at = |lanes: &L| lanes.exact().0[lane];
        let rest = self.rest.each_ref().map(|column| at(&column[block]));
        (self.parameter[block].each_ref().map(at), at(&self.influence[block]), DVec3::from_array(rest))
    }

    /// Returns a state's memory for the next call.
    pub(crate) fn recycle(&self, state: State<L>) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(state);
    }

    fn take_state(&self) -> State<L> {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.unwrap_or_else(|| std::array::from_fn(|_| vec![L::ZERO; self.influence.len()]))
    }

    fn cell<'a>(&'a self, task: &Task, data: &'a CellData<L::Real>) -> Cell<'a, L> {
        Cell {
            taps: data.taps,
            basis: &data.basis,
            parameter: &self.parameter[task.blocks.clone()],
            influence: &self.influence[task.blocks.clone()],
        }
    }
}

impl<R: Scalar> CellData<R> {
    fn new(task: &Task, shape: [usize; 3]) -> Self {
        Self {
            basis: task.spans.each_ref().map(Basis::new),
            taps: task.taps(),
            points: task.points(shape).map(|p| p as u32).collect(),
        }
    }
}

impl<R: Scalar> Basis<R> {
    fn new(span: &Span) -> Self {
        let local = |[left, right, _]: &[f64; 3]| {
            let [left, right] = [left, right].map(|knot| R::from_f64(knot - span.start()));
            [left, right, R::from_f64(1.0 / (right.to_f64() - left.to_f64()))]
        };
        Self {
            steps: span.steps().iter().map(local).collect(),
            cubic: span.cubic().map(|functions| functions.map(|function| function.map(R::from_f64))),
        }
    }
}

/// A state's coordinates as plain numbers.
pub(crate) fn numbers<L: Lanes>(state: &State<L>) -> [&[L::Real]; 3] {
    state.each_ref().map(|column| bytemuck::cast_slice(column))
}

fn lengths(tasks: &[Task]) -> impl Iterator<Item = usize> {
    tasks.iter().map(|task| task.blocks.len())
}
