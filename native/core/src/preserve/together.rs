// SPDX-License-Identifier: GPL-3.0-or-later
//! The smallest displacement for many bodies at once, by the small matrix `M W M'` of their rows.
//!
//! An orthogonal basis of a hundred rows takes far longer than measuring the mesh; but each row of a small body touches few control
//! points, so that the matrix is quickly made, and bodies apart from each other are far from dependent. Where they are not, or where
//! anything else is out of the ordinary, there is no answer here: the basis, row by row, then tells which body it is.

use rayon::prelude::*;

use crate::preserve::constraints::{Basis, Solution, dot, norm, quick_dot};

/// Bodies below which an orthogonal basis takes no time either.
pub(crate) const MANY: usize = 16;

/// A row must keep this fraction of its length beside those before: the matrix has its square, so that the multipliers keep ten of
/// sixteen digits, and each refinement gives as many again.
const KEPT: f64 = 1e-3;

/// Refinements of the multipliers by what they leave: one repairs them to rounding, the other makes sure.
const REFINEMENTS: usize = 2;

/// The entries of a row that are not zero.
struct Sparse(Vec<(u32, f64)>);

impl Sparse {
    fn of(row: &[f64], length: f64) -> Self {
        let entries = row.iter().zip(0u32..).filter(|(value, _)| **value != 0.0);
        Self(entries.map(|(value, point)| (point, value / length)).collect())
    }

    fn dot(&self, dense: &[f64]) -> f64 {
        self.0.iter().map(|&(point, value)| value * dense[point as usize]).sum()
    }

    fn add_to(&self, dense: &mut [f64], factor: f64) {
        self.0.iter().for_each(|&(point, value)| dense[point as usize] += factor * value);
    }
}

/// The shortest vector that meets whitened rows, each with a length below which it is rounding and the value that its product must
/// have, and those of a basis as `start` does. `None` where a row is nothing beside the others, or nearly so.
pub(crate) fn shortest(
    basis: &Basis,
    start: &Solution,
    rows: &[(Vec<f64>, f64)],
    values: &[f64],
) -> Option<Vec<f64>> {
    let points = rows.first()?.0.len();
    let mut vector = start.vector.clone();
    vector.resize(points, 0.0);
    let (mut directions, mut wanted) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
    for ((row, least), value) in rows.iter().zip(values) {
        let mut rest = row.clone();
        basis.project_off(&mut rest);
        let independent = norm(&rest);
        // Written so that NaN has no answer either.
        let is_sound = independent > KEPT * norm(row) && independent > *least;
        if !is_sound {
            return None;
        }
        wanted.push((value - dot(row, &vector)) / independent);
        directions.push(Sparse::of(&rest, independent));
    }
    let factor = cholesky(products(&directions, points))?;
    let mut added = vec![0.0; points];
    for _ in 0..=REFINEMENTS {
        let left = directions.iter().zip(&wanted).map(|(direction, value)| value - direction.dot(&added));
        let multipliers = solved(&factor, left.collect());
        directions.iter().zip(multipliers).for_each(|(direction, along)| direction.add_to(&mut added, along));
    }
    vector.iter_mut().zip(added).for_each(|(value, added)| *value += added);
    Some(vector)
}

/// Products of all directions with one another: the lower triangle.
fn products(directions: &[Sparse], points: usize) -> Vec<Vec<f64>> {
    let row = |dense: &mut Vec<f64>, last: usize| -> Vec<f64> {
        directions[last].add_to(dense, 1.0);
        let row = directions[..=last].iter().map(|direction| direction.dot(dense)).collect();
        directions[last].0.iter().for_each(|&(point, _)| dense[point as usize] = 0.0);
        row
    };
    (0..directions.len()).into_par_iter().map_init(|| vec![0.0; points], row).collect()
}

/// The lower factor of a matrix with ones on its diagonal; `None` where a row is nearly dependent on those before.
fn cholesky(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    for i in 0..matrix.len() {
        let (done, rest) = matrix.split_at_mut(i);
        let row = &mut rest[0];
        for (j, above) in done.iter().enumerate() {
            row[j] = (row[j] - quick_dot(&row[..j], &above[..j])) / above[j];
        }
        let pivot = row[i] - quick_dot(&row[..i], &row[..i]);
        // Written so that NaN has no answer either.
        let is_sound = pivot > KEPT * KEPT;
        if !is_sound {
            return None;
        }
        row[i] = pivot.sqrt();
    }
    Some(matrix)
}

/// Solves by a lower factor and its transpose.
fn solved(factor: &[Vec<f64>], mut right: Vec<f64>) -> Vec<f64> {
    for (i, row) in factor.iter().enumerate() {
        right[i] = (right[i] - quick_dot(&row[..i], &right[..i])) / row[i];
    }
    for (i, row) in factor.iter().enumerate().rev() {
        let value = right[i] / row[i];
        right[i] = value;
        right[..i].iter_mut().zip(row).for_each(|(right, factor)| *right -= value * factor);
    }
    right
}

#[cfg(test)]
mod tests {
    use super::shortest;
    use crate::preserve::constraints::{Basis, dot};

    #[test]
    fn it_is_what_the_orthogonal_basis_gives() {
        let row = |i: usize| -> Vec<f64> {
            (0..40)
                .map(|p| if p / 2 % 20 == i || p % 20 == i { 1.0 + (p * i) as f64 * 0.01 } else { 0.0 })
                .collect()
        };
        let (mut basis, mut all) = (Basis::default(), Basis::default());
        basis.take(row(19), 0.0);
        all.take(row(19), 0.0);
        let values: Vec<f64> = (0..18).map(|i| (i as f64).sin()).collect();
        let rows: Vec<(Vec<f64>, f64)> = (0..18).map(|i| (row(i), 0.0)).collect();
        rows.iter().for_each(|(row, _)| drop(all.take(row.clone(), 0.0)));
        let start = basis.solve(&[0.7]);
        let found = shortest(&basis, &start, &rows, &values).unwrap_or_default();
        let expected = all.shortest(&[&[0.7], values.as_slice()].concat());
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-13);
        }
        assert!((dot(&found, &row(19)) - 0.7).abs() < 1e-13);
        let twice = [rows.clone(), vec![rows[3].clone()]].concat();
        assert!(shortest(&basis, &start, &twice, &[values, vec![0.0]].concat()).is_none());
    }
}
