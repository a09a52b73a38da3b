// SPDX-License-Identifier: GPL-3.0-or-later
//! Cholesky factors of costs: `P Q P' = L L'`, so that `R = L' P` is a square root of `Q`.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};

use crate::error::{Error, Result};
use crate::lattice::Lattice;
use crate::preserve::band::{Band, MOST_NUMBERS, too_large};

/// A factor by columns, the diagonal first in each.
#[derive(Debug)]
pub(crate) struct Factor {
    /// The control point in each place of the order that the factor has.
    order: Vec<usize>,
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Factor {
    /// Factorises a matrix, scaled so that its diagonal has the mean 1, with `regularisation` added to the diagonal. Points that are
    /// not `free` are left out: they are coupled with none.
    ///
    /// # Errors
    /// [`Error::Lattice`] where the factor would be too large.
    pub(crate) fn new(band: &Band, free: &[bool], regularisation: f64, lattice: &Lattice) -> Result<Self> {
        let count = band.count();
        let (starts, rows, values) = columns(band, free, regularisation);
        let pattern = SymbolicSparseColMatRef::new_checked(count, count, &starts, None, &rows);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, params)
            .map_err(|_| too_large(lattice, values.len()))?;
        if symbolic.len_val() > MOST_NUMBERS {
            return Err(too_large(lattice, symbolic.len_val()));
        }
        let mut numbers = vec![0.0f64; symbolic.len_val()];
        // One thread: the sums, and so the result, must not depend on the number of cores.
        let need = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        symbolic
            .factorize_numeric_llt(
                &mut numbers,
                SparseColMatRef::new(pattern, &values),
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut MemBuffer::new(need)),
                Default::default(),
            )
            .map_err(|error| {
                Error::Lattice(format!(
                    "cost: the matrix of the cost is not positive definite ({error}); use cost \"points\""
                ))
            })?;
        Self::unpacked(&symbolic, &numbers).ok_or_else(|| {
            Error::Lattice("cost: the matrix of the cost has no factor; use cost \"points\"".into())
        })
    }

    /// The library's dense blocks as plain columns.
    fn unpacked(symbolic: &SymbolicCholesky<usize>, numbers: &[f64]) -> Option<Self> {
        let SymbolicCholeskyRaw::Supernodal(blocks) = symbolic.raw() else { return None };
        let count = symbolic.nrows();
        let factor = SupernodalLltRef::new(blocks, numbers);
        let order = symbolic.perm().map_or_else(|| (0..count).collect(), |perm| perm.arrays().0.to_vec());
        let mut unpacked = Self { order, starts: vec![0], rows: Vec::new(), values: Vec::new() };
        for block in 0..blocks.n_supernodes() {
            let block = factor.supernode(block);
            let (matrix, start) = (block.val(), block.start());
            let inside = matrix.ncols();
            for column in 0..inside {
                unpacked.rows.extend((start + column..start + inside).map(|row| row as u32));
                unpacked.rows.extend(block.pattern().iter().map(|&row| row as u32));
                unpacked.values.extend((column..matrix.nrows()).map(|row| matrix[(row, column)]));
                unpacked.starts.push(unpacked.rows.len());
            }
        }
        Some(unpacked)
    }

    fn column(&self, column: usize) -> (f64, impl Iterator<Item = (usize, f64)>) {
        let range = self.starts[column]..self.starts[column + 1];
        let (rows, values) = (&self.rows[range.clone()], &self.values[range]);
        (values[0], rows[1..].iter().map(|&row| row as usize).zip(values[1..].iter().copied()))
    }

    /// `R'^-1 row = L^-1 P row`.
    pub(crate) fn whitened(&self, row: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut white: Vec<f64> = self.order.iter().map(|&point| row(point)).collect();
        for column in 0..white.len() {
            let (diagonal, below) = self.column(column);
            let solved = white[column] / diagonal;
            white[column] = solved;
            below.for_each(|(row, value)| white[row] -= value * solved);
        }
        white
    }

    /// `R^-1 y = P' L'^-1 y`.
    pub(crate) fn displacement(&self, y: &[f64]) -> Vec<f64> {
        let mut solved = y.to_vec();
        for column in (0..solved.len()).rev() {
            let (diagonal, below) = self.column(column);
            let known: f64 = below.map(|(row, value)| value * solved[row]).sum();
            solved[column] = (solved[column] - known) / diagonal;
        }
        let mut displacement = vec![0.0; solved.len()];
        self.order.iter().zip(solved).for_each(|(&point, value)| displacement[point] = value);
        displacement
    }

    /// `y = R delta = L' P delta`.
    pub(crate) fn coordinates(&self, delta: impl Fn(usize) -> f64) -> Vec<f64> {
        let moved: Vec<f64> = self.order.iter().map(|&point| delta(point)).collect();
        let of = |column: usize| {
            let (diagonal, below) = self.column(column);
            diagonal * moved[column] + below.map(|(row, value)| value * moved[row]).sum::<f64>()
        };
        (0..moved.len()).map(of).collect()
    }
}

/// The matrix in compressed columns, scaled and regularised.
fn columns(band: &Band, free: &[bool], regularisation: f64) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let positive = (0..band.count()).map(|point| band.diagonal(point)).filter(|entry| *entry > 0.0);
    let (sum, number) = positive.fold((0.0, 0), |(sum, number), entry| (sum + entry, number + 1));
    let scale = if number == 0 { 1.0 } else { f64::from(number) / sum };
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in 0..band.count() {
        band.for_column(column, |row, entry| {
            let entry = match (row == column, free[row] && free[column]) {
                (true, true) => scale * entry + regularisation,
                (true, false) => 1.0,
                (false, true) => scale * entry,
                (false, false) => 0.0,
            };
            if entry != 0.0 {
                rows.push(row);
                values.push(entry);
            }
        });
        starts.push(rows.len());
    }
    (starts, rows, values)
}

#[cfg(test)]
mod tests {
    use super::Factor;
    use crate::basis::AxisBasis;
    use crate::lattice::Lattice;
    use crate::preserve::band::Band;
    use glam::{DMat3, DVec3};

    #[test]
    fn the_root_squared_is_the_matrix() {
        let axis = |n, d| AxisBasis::uniform(n, d).unwrap_or_else(|error| unreachable!("{error}"));
        let lattice = Lattice::new([axis(5, 2), axis(3, 1), axis(4, 3)], DVec3::ZERO, DMat3::IDENTITY)
            .unwrap_or_else(|error| unreachable!("{error}"));
        let mut band = Band::new(&lattice, [2, 1, 3]).unwrap_or_else(|error| unreachable!("{error}"));
        let mut dense = vec![0.0; 60 * 60];
        for column in 0..60 {
            let mut rows = Vec::new();
            band.for_column(column, |row, _| rows.push(row));
            for row in rows {
                let value =
                    if row == column { 80.0 + row as f64 } else { ((row * 7 + column * 3) % 5) as f64 - 2.0 };
                band.add(row, column, value);
                (dense[60 * row + column], dense[60 * column + row]) = (value, value);
            }
        }
        let mut free = vec![true; 60];
        (free[3], free[31]) = (false, false);
        let factor = Factor::new(&band, &free, 0.5, &lattice).unwrap_or_else(|error| unreachable!("{error}"));
        let scale = 60.0 / dense.iter().step_by(61).sum::<f64>();
        let delta: Vec<f64> = (0..60).map(|p| ((p * p) % 11) as f64 - 5.0).collect();
        let product: Vec<f64> = (0..60)
            .map(|p| {
                if !free[p] {
                    return delta[p];
                }
                let others = (0..60).filter(|&q| free[q]).map(|q| scale * dense[60 * p + q] * delta[q]);
                others.sum::<f64>() + 0.5 * delta[p]
            })
            .collect();
        let y = factor.coordinates(|p| delta[p]);
        let white = factor.whitened(|p| product[p]);
        let back = factor.displacement(&y);
        for p in 0..60 {
            assert!((y[p] - white[p]).abs() < 1e-12, "R delta = R'^-1 Q delta");
            assert!((back[p] - delta[p]).abs() < 1e-12);
        }
    }
}
