// SPDX-License-Identifier: GPL-3.0-or-later
//! How far a displacement of the control points moves the surface: `Q = B' B`, the squared distances of all vertices together (the
//! paper's Remark 1).

use rayon::prelude::*;

use crate::binding::Binding;
use crate::error::Result;
use crate::preserve::band::Band;
use crate::vertices::Scalar;
use glam::DVec3;

/// Vertices of one cell summed at once: few enough that a mesh in a single cell still keeps all cores busy.
const RUN: usize = 4096;

/// Runs between two additions to the matrix: so many small matrices are held in memory.
const BATCH: usize = 64;

/// The matrix of the vertices' squared distances, influence included.
pub(crate) fn surface<T: Scalar>(binding: &Binding<T>) -> Result<Band> {
    let lattice = binding.lattice();
    let mut band = Band::new(lattice, lattice.axes().each_ref().map(|axis| axis.window() - 1))?;
    let taps = |vertex: usize| {
        let located = binding.located(vertex);
        (located.influence, lattice.taps(DVec3::from_array(located.parameter)))
    };
    let first = |vertex: usize| taps(vertex).1.next().map_or(0, |(point, _)| point);
    let mut cells: Vec<(usize, usize)> =
        (0..binding.vertices().len()).into_par_iter().map(|vertex| (first(vertex), vertex)).collect();
    cells.par_sort_unstable();
    let runs: Vec<&[(usize, usize)]> =
        cells.chunk_by(|a, b| a.0 == b.0).flat_map(|cell| cell.chunks(RUN)).collect();
    let sum = |run: &&[(usize, usize)]| {
        let points: Vec<usize> = taps(run[0].1).1.map(|(point, _)| point).collect();
        let mut sums = vec![0.0; points.len() * points.len()];
        for &(_, vertex) in *run {
            let (influence, taps) = taps(vertex);
            let row: Vec<f64> = taps.map(|(_, weight)| influence * weight).collect();
            for (b, (sums, factor)) in sums.chunks_exact_mut(row.len()).zip(&row).enumerate() {
                sums[b..].iter_mut().zip(&row[b..]).for_each(|(sum, weight)| *sum += factor * weight);
            }
        }
        (points, sums)
    };
    for batch in runs.chunks(BATCH) {
        let summed: Vec<(Vec<usize>, Vec<f64>)> = batch.par_iter().map(sum).collect();
        for (points, sums) in summed {
            for (b, sums) in sums.chunks_exact(points.len()).enumerate() {
                (b..points.len()).for_each(|a| band.add(points[a], points[b], sums[a]));
            }
        }
    }
    Ok(band)
}
