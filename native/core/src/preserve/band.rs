// SPDX-License-Identifier: GPL-3.0-or-later
//! Symmetric matrices over a lattice's control points that couple only points near each other, column by column, lower halves.

use crate::error::{Error, Result};
use crate::lattice::Lattice;

/// Most numbers of a matrix or its factor: 240 MB, and seconds to factorise. A uniform cubic lattice of 25 points an axis has about
/// so many, and one of Bernstein polynomials of 19.
pub(crate) const MOST_NUMBERS: usize = 30_000_000;

/// The lower half: of every control point the later ones within reach of it.
pub(crate) struct Band {
    shape: [usize; 3],
    /// How far apart along each axis coupled points lie at most.
    reach: [usize; 3],
    /// Where each column starts.
    starts: Vec<usize>,
    values: Vec<f64>,
}

impl Band {
    /// All zero. `reach`: the degrees, where points of a common cell are coupled.
    ///
    /// # Errors
    /// [`Error::Lattice`] where it would be too large to factorise.
    pub(crate) fn new(lattice: &Lattice, reach: [usize; 3]) -> Result<Self> {
        let shape = lattice.shape();
        let mut band = Self { shape, reach, starts: vec![0], values: Vec::new() };
        let mut count = 0usize;
        for q in 0..lattice.len() {
            count += band.height(band.index(q));
            band.starts.push(count);
        }
        if count > MOST_NUMBERS {
            return Err(too_large(lattice, count));
        }
        band.values = vec![0.0; count];
        Ok(band)
    }

    /// Indices along the axes.
    pub(crate) fn index(&self, point: usize) -> [usize; 3] {
        let [_, nv, nw] = self.shape;
        [point / (nv * nw), point / nw % nv, point % nw]
    }

    /// How many steps back and on along an axis there are partners.
    fn sides(&self, axis: usize, at: usize) -> [usize; 2] {
        [self.reach[axis].min(at), self.reach[axis].min(self.shape[axis] - 1 - at)]
    }

    /// Numbers in a column.
    fn height(&self, at: [usize; 3]) -> usize {
        let [[_, on_i], [back_j, on_j], [back_k, on_k]] = [0, 1, 2].map(|axis| self.sides(axis, at[axis]));
        let wide = back_k + on_k + 1;
        (on_k + 1) + on_j * wide + on_i * (back_j + on_j + 1) * wide
    }

    /// Place of an entry; the row must not come before the column, and must be within reach of it.
    fn place(&self, row: [usize; 3], column: [usize; 3], start: usize) -> usize {
        let [back_j, on_j] = self.sides(1, column[1]);
        let [back_k, on_k] = self.sides(2, column[2]);
        let wide = back_k + on_k + 1;
        let in_plane = || row[2] + back_k - column[2];
        start
            + if row[0] > column[0] {
                let planes = (row[0] - column[0] - 1) * (back_j + on_j + 1) + (row[1] + back_j - column[1]);
                (on_k + 1) + (on_j + planes) * wide + in_plane()
            } else if row[1] > column[1] {
                (on_k + 1) + (row[1] - column[1] - 1) * wide + in_plane()
            } else {
                row[2] - column[2]
            }
    }

    /// Adds to an entry. The order of the two points does not matter.
    pub(crate) fn add(&mut self, a: usize, b: usize, value: f64) {
        let (row, column) = (a.max(b), a.min(b));
        let place = self.place(self.index(row), self.index(column), self.starts[column]);
        self.values[place] += value;
    }

    /// Does something with every entry of a column: the row, and the number.
    pub(crate) fn for_column(&self, column: usize, mut f: impl FnMut(usize, f64)) {
        let at = self.index(column);
        let mut place = self.starts[column];
        let [[_, on_i], [back_j, on_j], [back_k, on_k]] = [0, 1, 2].map(|axis| self.sides(axis, at[axis]));
        for i in at[0]..=at[0] + on_i {
            let first_j = if i == at[0] { at[1] } else { at[1] - back_j };
            for j in first_j..=at[1] + on_j {
                let first_k = if i == at[0] && j == at[1] { at[2] } else { at[2] - back_k };
                for k in first_k..=at[2] + on_k {
                    f((i * self.shape[1] + j) * self.shape[2] + k, self.values[place]);
                    place += 1;
                }
            }
        }
    }

    /// Number of control points.
    pub(crate) fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// An entry of the diagonal.
    pub(crate) fn diagonal(&self, point: usize) -> f64 {
        self.values[self.starts[point]]
    }
}

/// What to say of a lattice with too many control points for a cost that couples them.
pub(crate) fn too_large(lattice: &Lattice, count: usize) -> Error {
    Error::Lattice(format!(
        "cost: a lattice of shape {:?} would take {count} numbers to factorise, expected at most {MOST_NUMBERS}; use fewer control points, or cost \"points\"",
        lattice.shape()
    ))
}
