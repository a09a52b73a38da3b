// SPDX-License-Identifier: GPL-3.0-or-later
//! Coefficients and volumes of several bodies, from what the device found for each run of slots.

use isochor_core::Coefficients;

use crate::pack::Packed;

/// The runs of a mesh with several bodies.
pub(crate) struct Parts {
    bodies: usize,
    points: usize,
    runs: Vec<Run>,
}

/// Slots in one cell, of vertices of one body or none.
struct Run {
    body: Option<usize>,
    slots: std::ops::Range<usize>,
    /// The cell's control points.
    taps: Vec<u32>,
}

/// What the device found along one axis, times six, in its units.
pub(crate) struct Found<'a> {
    /// Coefficients of each run for its taps.
    pub(crate) partials: &'a [f32],
    /// Gradient of the volume at every slot.
    pub(crate) pull: &'a [f32],
    /// Coordinate of every slot.
    pub(crate) along: &'a [f32],
}

impl Parts {
    /// The runs of a packed binding of so many bodies.
    pub(crate) fn new(packed: &Packed<'_>, bodies: usize) -> Self {
        let run = |(tile, &body): (&crate::types::Tile, &Option<usize>)| {
            let first = tile.first_slot as usize;
            let taps = 0..packed.cell_taps();
            Run {
                body,
                slots: first..first + tile.slots as usize,
                taps: taps.map(|tap| packed.point_of_tap(tile, tap) as u32).collect(),
            }
        };
        let runs = packed.runs.iter().zip(&packed.body_of_run).map(run).collect();
        Self { bodies, points: packed.points(), runs }
    }

    /// Adds the runs up by body, in float64: coefficients and volumes in the device's units, and the origin of each body's volume, one
    /// of its own coordinates, or sums over a small body far away would lose its digits.
    pub(crate) fn add_up(&self, found: &Found<'_>) -> (Coefficients, Vec<f64>) {
        let mut middles = vec![None; self.bodies];
        let mut sums =
            Coefficients { rows: vec![vec![0.0; self.points]; self.bodies], volumes: vec![0.0; self.bodies] };
        for (run, partials) in self.runs.iter().zip(found.partials.chunks_exact(self.taps())) {
            let Some(body) = run.body else { continue };
            let middle = *middles[body].get_or_insert(f64::from(found.along[run.slots.start]));
            for (&point, &part) in run.taps.iter().zip(partials) {
                sums.rows[body][point as usize] += f64::from(part) / 6.0;
            }
            let slots = run.slots.clone();
            let parts = found.along[slots.clone()].iter().zip(&found.pull[slots]);
            let six: f64 = parts.map(|(&x, &pull)| (f64::from(x) - middle) * f64::from(pull)).sum();
            sums.volumes[body] += six / 6.0;
        }
        (sums, middles.into_iter().map(Option::unwrap_or_default).collect())
    }

    fn taps(&self) -> usize {
        self.runs.first().map_or(1, |run| run.taps.len())
    }
}
