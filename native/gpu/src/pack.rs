// SPDX-License-Identifier: GPL-3.0-or-later
//! A binding's fixed data in the form that the kernels read.

use isochor_core::layout::{BLOCK, Run};
use isochor_core::{Binding, DVec3, Scalar};
use rayon::prelude::*;

use crate::kernels::GROUP;
use crate::types::Tile;

/// Runs of the coefficients at most, beyond which they get longer instead: enough to fill the largest GPUs several times, few
/// enough that a control point adds up a few hundred of them at most.
const MANY_RUNS: usize = 8192;

/// Slots of a run for each of its taps at least: its sums are written and read once more, which costs as much as a few slots.
const SLOTS_PER_TAP: usize = 4;

/// Everything that stays fixed while the control points move, for the device. Coordinates are relative to `centre`, in
/// units of `unit`.
pub struct Packed<'a> {
    /// Degree + 1 along each axis.
    pub taps: [usize; 3],
    /// Inner control points along each axis.
    pub shape: [usize; 3],
    /// Middle of the lattice's domain.
    pub centre: DVec3,
    /// Power of two near the lattice's size: scaling by it is exact, and volumes and squares stay within float32.
    pub unit: f64,
    /// Longest edge of the lattice's domain.
    pub size: f64,
    /// Runs of at most [`GROUP`] slots in one cell.
    pub tiles: Vec<Tile>,
    /// Runs for the coefficients.
    pub runs: Vec<Tile>,
    /// The body of each run, `None` for vertices of no body.
    pub body_of_run: Vec<Option<usize>>,
    /// Steps (left, right, reciprocal, 0) of the basis recurrence of every cell, relative to the cell's lower knot and in
    /// units of its length: so float32 loses nothing where the cells are small.
    pub knots: Vec<[f32; 4]>,
    /// Parameters in the cell, in [0, 1], and influence of every slot.
    pub places: Vec<[f32; 4]>,
    /// Coordinates: all x, all y, all z.
    pub rest: Vec<f32>,
    /// Start of every block's steps; one more entry than blocks.
    pub offsets: Vec<u32>,
    /// Closed walks of neighbours, at the edge of a hole through the slot itself; one unused step where the triangles enclose no volume.
    pub steps: &'a [[u32; BLOCK]],
    /// Start of every control point's entries; one more than control points.
    pub starts: Vec<u32>,
    /// Indices into the partial sums, `run * taps + tap`.
    pub entries: Vec<u32>,
    /// Slot of every vertex.
    pub slot_of_vertex: &'a [u32],
}

const NO_STEPS: &[[u32; BLOCK]] = &[[0; BLOCK]];

impl<'a> Packed<'a> {
    /// Packs a binding. Without a closed surface there are no walks, and only the deformation can be computed.
    pub fn new<T: Scalar>(binding: &'a Binding<T>) -> Self {
        let (lattice, layout) = (binding.lattice(), binding.layout());
        let taps = lattice.axes().each_ref().map(|axis| axis.degree() + 1);
        let edges = lattice.edges();
        let size =
            [edges.x_axis, edges.y_axis, edges.z_axis].map(DVec3::length).into_iter().fold(0.0, f64::max);
        let (centre, unit) = (lattice.centre(), size.log2().ceil().exp2());
        let mut cells = Cells::new(taps, layout.shape());
        let slots = layout.slots();
        let (mut places, mut rest) = (vec![[0.0; 4]; slots], vec![0.0; 3 * slots]);
        for run in layout.runs() {
            cells.add(run);
        }
        let runs: Vec<Run<'_>> = layout.runs().flat_map(|run| run.slots().map(move |_| run)).collect();
        let placed: Vec<([f32; 4], [f32; 3])> = runs
            .par_iter()
            .enumerate()
            .map(|(slot, &run)| {
                let Some(place) = layout.place(slot) else { return Default::default() };
                let [s, t, u] = local_parameter(run, place.parameter);
                let at = DVec3::from_array(binding.vertices()[place.vertex].map(T::to_f64));
                ([s, t, u, place.influence as f32], ((at - centre) / unit).as_vec3().to_array())
            })
            .collect();
        for (slot, (place, at)) in placed.into_iter().enumerate() {
            places[slot] = place;
            (0..3).for_each(|axis| rest[axis * slots + slot] = at[axis]);
        }
        let (offsets, steps) = match binding.block_walks() {
            Ok(walks) => (walks.offsets.iter().map(|&start| start as u32).collect(), walks.steps),
            Err(_) => (vec![0; layout.slots() / BLOCK + 1], NO_STEPS),
        };
        let (tiles, runs) = cells.split(layout.slots());
        let (runs, body_of_run): (Vec<Tile>, Vec<Option<usize>>) = runs.into_iter().unzip();
        let (starts, entries) = entries_of_points(&runs, taps, layout.shape());
        Self {
            taps,
            shape: layout.shape(),
            centre,
            unit,
            size,
            tiles,
            runs,
            body_of_run,
            knots: cells.knots,
            places,
            rest,
            offsets,
            steps,
            starts,
            entries,
            slot_of_vertex: layout.slot_of_vertex(),
        }
    }

    /// Number of inner control points.
    pub fn points(&self) -> usize {
        self.shape.iter().product()
    }

    /// Number of slots.
    pub fn slots(&self) -> usize {
        self.places.len()
    }

    /// Control points that act on a cell.
    pub fn cell_taps(&self) -> usize {
        self.taps.iter().product()
    }

    /// Whether the lattice leaves a vertex alone, in the order bound.
    pub fn is_still(&self) -> Vec<bool> {
        self.slot_of_vertex.iter().map(|&slot| self.places[slot as usize][3] == 0.0).collect()
    }

    /// Groups of the gradient's kernel, each with a share of the volume.
    pub fn groups(&self) -> usize {
        self.slots().div_ceil(GROUP)
    }

    /// Index of a cell's control point by its number among the cell's taps.
    pub fn point_of_tap(&self, tile: &Tile, tap: usize) -> usize {
        point_of_tap(tile, tap, self.taps, self.shape)
    }
}

/// Cells with vertices, in their order, and where several bodies share a cell one after the other.
struct Cells {
    taps: [usize; 3],
    shape: [usize; 3],
    cells: Vec<Tile>,
    /// The body of each.
    bodies: Vec<Option<usize>>,
    knots: Vec<[f32; 4]>,
    /// Start of the steps of the cell at each first point, along each axis.
    known: [Vec<Option<u32>>; 3],
}

impl Cells {
    fn new(taps: [usize; 3], shape: [usize; 3]) -> Self {
        // An axis of degree 0 has no steps; the array is bound all the same.
        Self {
            taps,
            shape,
            cells: Vec::new(),
            bodies: Vec::new(),
            knots: vec![[0.0; 4]],
            known: shape.map(|count| vec![None; count]),
        }
    }

    fn add(&mut self, run: Run<'_>) {
        let ([i, j, k], slots) = (run.first_point(), run.slots());
        let first_point = ((i * self.shape[1] + j) * self.shape[2] + k) as u32;
        match self.cells.last_mut() {
            Some(cell) if cell.first_point == first_point && self.bodies.last() == Some(&run.body()) => {
                cell.slots += slots.len() as u32;
            }
            _ => {
                self.bodies.push(run.body());
                let [knots_u, knots_v, knots_w] = [0, 1, 2].map(|axis| self.steps(run, axis));
                let (first_slot, slots) = (slots.start as u32, slots.len() as u32);
                self.cells.push(Tile { first_slot, slots, first_point, knots_u, knots_v, knots_w });
            }
        }
    }

    /// Start of the steps of a run's cell along an axis.
    fn steps(&mut self, run: Run<'_>, axis: usize) -> u32 {
        let (knots, known) = (&mut self.knots, &mut self.known[axis][run.first_point()[axis]]);
        *known.get_or_insert_with(|| {
            let start = knots.len() as u32;
            let steps = run.spans()[axis].steps();
            // The first step of the recurrence is the cell itself.
            let [low, _, inverse] = steps.first().copied().unwrap_or([0.0, 1.0, 1.0]);
            let local = |knot: f64| ((knot - low) * inverse) as f32;
            knots.extend(
                steps
                    .iter()
                    .map(|&[left, right, step]| [local(left), local(right), (step / inverse) as f32, 0.0]),
            );
            start
        })
    }

    /// Cuts the cells into tiles, and into runs with the body of each.
    fn split(&self, slots: usize) -> (Vec<Tile>, Vec<(Tile, Option<usize>)>) {
        let taps: usize = self.taps.iter().product();
        let run = GROUP.max(taps * SLOTS_PER_TAP).max(slots / MANY_RUNS).next_multiple_of(GROUP);
        let tiles = self.cells.iter().flat_map(|cell| cut(cell, GROUP)).collect();
        let runs = self.cells.iter().zip(&self.bodies);
        (tiles, runs.flat_map(|(cell, &body)| cut(cell, run).map(move |run| (run, body))).collect())
    }
}

fn cut(cell: &Tile, length: usize) -> impl Iterator<Item = Tile> {
    let (cell, length) = (*cell, length as u32);
    (0..cell.slots).step_by(length as usize).map(move |start| Tile {
        first_slot: cell.first_slot + start,
        slots: length.min(cell.slots - start),
        ..cell
    })
}

/// Parameters in the run's cell, in [0, 1].
fn local_parameter(run: Run<'_>, parameter: [f64; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| match run.spans()[axis].steps().first() {
        Some([low, _, inverse]) => ((parameter[axis] - low) * inverse) as f32,
        None => 0.0,
    })
}

fn point_of_tap(tile: &Tile, tap: usize, taps: [usize; 3], shape: [usize; 3]) -> usize {
    let (i, j, k) = (tap / (taps[1] * taps[2]), tap / taps[2] % taps[1], tap % taps[2]);
    tile.first_point as usize + (i * shape[1] + j) * shape[2] + k
}

/// For every control point the places of its partial sums, in the order of the runs.
fn entries_of_points(runs: &[Tile], taps: [usize; 3], shape: [usize; 3]) -> (Vec<u32>, Vec<u32>) {
    let (cell_taps, points): (usize, usize) = (taps.iter().product(), shape.iter().product());
    let mut starts = vec![0u32; points + 1];
    for run in runs {
        for tap in 0..cell_taps {
            starts[point_of_tap(run, tap, taps, shape) + 1] += 1;
        }
    }
    for point in 0..points {
        starts[point + 1] += starts[point];
    }
    let mut next = starts.clone();
    // One unused entry keeps the array from being empty.
    let mut entries = vec![0u32; (runs.len() * cell_taps).max(1)];
    for (number, run) in runs.iter().enumerate() {
        for tap in 0..cell_taps {
            let at = &mut next[point_of_tap(run, tap, taps, shape)];
            entries[*at as usize] = (number * cell_taps + tap) as u32;
            *at += 1;
        }
    }
    (starts, entries)
}
